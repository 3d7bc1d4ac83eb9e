"""What an FMU in Python leaves behind in the importer's process, and what it says that it needs."""

import re
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest
from native_builds import require_command

from maglev.descriptions.own_fmus import DEFINITIONS

# Objects, search path and classes after instances that were freed, less what was there before; the first ones import.
COUNT = """
import gc, sys
import fmpy
from fmpy.fmi2 import FMU2Slave
path = sys.argv[1]
description, folder = fmpy.read_model_description(path), fmpy.extract(path)
fmu = FMU2Slave(guid=description.guid, unzipDirectory=folder, instanceName="one",
                modelIdentifier=description.coSimulation.modelIdentifier)
def run(count):
    for _ in range(count):
        fmu.instantiate()
        fmu.setupExperiment()
        fmu.enterInitializationMode()
        fmu.exitInitializationMode()
        fmu.doStep(0.0, 5e-4)
        fmu.fmi2FreeInstance(fmu.component)
    gc.collect()
    return len(gc.get_objects()), len(sys.path), len([each for each in gc.get_objects() if isinstance(each, type)])
first, then = run(10), run(200)
print(*(b - a for a, b in zip(first, then)))
print(str(folder) in str(sys.path))
"""


@pytest.mark.parametrize("name", ["Plant2DOF", "Regulator2DOF"])
def test_what_instances_leave(fmus: Path, name: str) -> None:
    """pythonfmu's library keeps one object for each, a list; no class, no entry of the search path."""
    done = subprocess.run([sys.executable, "-c", COUNT, fmus / f"{name}.fmu"], check=True, capture_output=True,
                          text=True)
    counts, in_path = done.stdout.splitlines()
    objects, entries, classes = map(int, counts.split())
    assert (entries, classes, in_path) == (0, 0, "False")
    assert objects <= 205


@pytest.mark.parametrize("name", DEFINITIONS)
def test_external_dependencies(fmus: Path, native_fmus: Path, name: str) -> None:
    """FMI 2.0.5, section 2.3; a native FMU has none."""
    file = "documentation/externalDependencies.txt"
    with zipfile.ZipFile(fmus / f"{name}.fmu") as archive:
        assert "Python 3.11 or newer" in archive.read(file).decode()
    with zipfile.ZipFile(native_fmus / f"{name}.fmu") as archive:
        assert file not in archive.namelist()


def test_external_dependencies_are_what_the_binaries_need(fmus: Path, tmp_path: Path) -> None:
    with zipfile.ZipFile(fmus / "Plant2DOF.fmu") as archive:
        archive.extractall(tmp_path)
    text = (tmp_path / "documentation/externalDependencies.txt").read_text()
    listing = subprocess.run([require_command("readelf"), "-W", "-V", tmp_path / "binaries/linux64/Plant2DOF.so"],
                             check=True, capture_output=True, text=True).stdout
    newest = max(tuple(map(int, found.split("."))) for found in re.findall(r"\bGLIBC_([\d.]+)", listing))
    assert f"GNU C library {'.'.join(map(str, newest))} or newer" in text
    imported = set(re.findall(rb"[\w.-]+\.dll", (tmp_path / "binaries/win64/Plant2DOF.dll").read_bytes()))
    for library in imported - {b"KERNEL32.dll", b"pythonfmu-export.dll"}:
        assert library.startswith(b"api-ms-win-crt-") or library.decode() in text, library
