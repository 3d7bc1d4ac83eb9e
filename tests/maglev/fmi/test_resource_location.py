"""The location of an FMU's resources, in the forms that importers give it (RFC 8089; FMI 2.0.5, section 2.1.5)."""

import json
import subprocess
import sys
from pathlib import Path
from urllib.parse import quote
from zipfile import ZipFile

import pytest

# An instance for each location, stepped once; a crash would take the tests with it, hence the process of its own.
INSTANTIATE = """
import ctypes, json, sys
import fmpy
from fmpy.fmi2 import FMU2Slave, defaultCallbacks
folder, locations = sys.argv[1], json.loads(sys.argv[2])
description = fmpy.read_model_description(folder)
fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="one",
                modelIdentifier=description.coSimulation.modelIdentifier)
for location in locations:
    fmu.component = fmu.fmi2Instantiate(b"one", 1, description.guid.encode(), location.encode(),
                                        ctypes.byref(defaultCallbacks), 0, 1)
    assert fmu.component, location
    fmu.setupExperiment()
    fmu.enterInitializationMode()
    fmu.exitInitializationMode()
    fmu.doStep(0.0, 2e-4)
    fmu.fmi2FreeInstance(fmu.component)
print("done")
"""


def instantiate(fmu: Path, folder: Path, locations: list[str]) -> None:
    with ZipFile(fmu) as archive:
        archive.extractall(folder)
    done = subprocess.run([sys.executable, "-c", INSTANTIATE, str(folder), json.dumps(locations)],
                          capture_output=True, text=True)
    assert (done.returncode, done.stdout.strip()) == (0, "done"), done.stderr[-2000:]


@pytest.mark.parametrize("name", ["unpacked", "two words"])
@pytest.mark.parametrize("form", ["file://{path}/resources", "file:{path}/resources"])
def test_python_kind(fmus: Path, tmp_path: Path, form: str, name: str) -> None:
    """One slash is what Java's File.toURI() makes, and none of it before the path."""
    instantiate(fmus / "Plant3DOF.fmu", tmp_path / name, [form.format(path=quote(str(tmp_path / name)))])


def test_native_kind(native_fmus: Path, tmp_path: Path) -> None:
    """It has no resources and takes any location."""
    path = tmp_path / "mit Leerzeichen, ünïcödé + #1 100%"
    place = quote(str(path))
    instantiate(native_fmus / "Plant3DOF.fmu", path, [
        f"file://{place}/resources", f"file:{place}/resources", f"file://localhost{place}/resources",
        f"file://{place}/resources/", f"file:///C:{place}/resources", str(path), ""])
