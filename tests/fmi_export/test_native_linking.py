"""Sources of two FMUs in one program: names of their own (FMI 2.0.5, section 2.1.1), the results of the libraries."""

import subprocess
from importlib.resources import files
from pathlib import Path

import fmpy
import numpy as np
import pytest
from native_builds import GENERATED, HERE, STRICT, built_once, require_command, unpacked_sources

from maglev.cosim.master import FmuSetup, Master

STEP = 2e-4   # s
STEPS = 1000
COMPILED = ("Plant3DOF", "Regulator3DOF", "ScheduledRegulator3DOF", "PID2DOF", "Estimator3DOF", "ClosedLoop2DOF")
# The header of the standard prepends the prefix; that of fmpy, which makes shared libraries alone, does not.
WITHOUT_PREFIX = "#define fmi2FullName(name) name\n"
WITH_PREFIX = """\
#define PASTED(a, b) a ## b
#define PASTED_VALUES(a, b) PASTED(a, b)
#define fmi2FullName(name) PASTED_VALUES(FMI2_FUNCTION_PREFIX, name)
"""


@pytest.fixture(scope="session")
def headers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with FMI headers that heed FMI2_FUNCTION_PREFIX."""
    folder = tmp_path_factory.mktemp("headers")
    for header in files("fmpy").joinpath("c-code").iterdir():
        if header.name.startswith("fmi2") and header.name.endswith(".h"):
            (folder / header.name).write_text(header.read_text().replace(WITHOUT_PREFIX, WITH_PREFIX))
    assert "PASTED" in (folder / "fmi2Functions.h").read_text()
    return folder


@pytest.fixture(scope="session")
def objects(native_fmus: Path, headers: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the sources of FMUs, compiled for static linking."""
    compiler = require_command("gcc")

    def make(folder: Path) -> None:
        for name in COMPILED:
            sources = unpacked_sources(native_fmus / f"{name}.fmu", folder / name)
            done = subprocess.run([compiler, *STRICT, *GENERATED, "-O1", "-I", headers, "-c",
                                   *sorted(path.name for path in sources.glob("*.c"))],
                                  cwd=sources, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr[-3000:]

    return built_once(tmp_path_factory, "objects", make)


@pytest.mark.parametrize("name", COMPILED)
def test_every_name_that_the_linker_sees_is_the_fmus_own(objects: Path, name: str) -> None:
    listing = subprocess.run([require_command("nm"), "--defined-only", "--extern-only", "--format=posix",
                              *sorted((objects / name / "sources").glob("*.o"))],
                             check=True, capture_output=True, text=True).stdout
    names = {line.split()[0] for line in listing.splitlines() if len(line.split()) > 2}
    assert f"{name}_fmi2DoStep" in names and len(names) > 50
    assert {each for each in names if not each.startswith(f"{name}_")} == set()


def test_two_fmus_in_one_program(objects: Path, headers: Path, native_fmus: Path, tmp_path: Path) -> None:
    """Plant and regulator fly as they do as shared libraries, bit for bit."""
    program = tmp_path / "two_fmus"
    subprocess.run([require_command("gcc"), *STRICT, "-I", headers, HERE / "two_fmus.c",
                    *(objects / "Plant3DOF" / "sources").glob("*.o"),
                    *(objects / "Regulator3DOF" / "sources").glob("*.o"), "-lm", "-o", program], check=True)
    plant, controller = (fmpy.read_model_description(str(native_fmus / f"{name}.fmu"))
                         for name in ("Plant3DOF", "Regulator3DOF"))
    of_plant, of_controller = ({v.name: v.valueReference for v in each.modelVariables} for each in (plant, controller))
    measured = [(f"{axis}.encoder", f"{axis}.measured") for axis in "yxz"]
    commanded = [f"{pair}.i_{phase}_cmd" for pair in ("alpha", "beta") for phase in "abc"]
    text = f"{len(measured)} {len(commanded)}\n" + "\n".join(
        [*(f"{of_plant[a]} {of_controller[b]}" for a, b in measured),
         *(f"{of_controller[each]} {of_plant[each]}" for each in commanded)])
    done = subprocess.run([program, repr(STEP), str(STEPS), plant.guid, controller.guid], input=text,
                          check=True, capture_output=True, text=True)
    there = np.array([[int(each, 16) for each in line.split()] for line in done.stdout.splitlines()], dtype=np.uint64)
    connections = [*((f"plant.{a}", f"controller.{b}") for a, b in measured),
                   *((f"controller.{each}", f"plant.{each}") for each in commanded)]
    with Master([FmuSetup("controller", native_fmus / "Regulator3DOF.fmu"),
                 FmuSetup("plant", native_fmus / "Plant3DOF.fmu")], connections, STEP) as master:
        columns = master.run(STEPS * STEP, {}).columns
    here = np.stack([columns[f"plant.{a}"][:-1] for a, _ in measured], axis=1)
    assert there.shape == here.shape == (STEPS, 3)
    assert np.array_equal(there, here.view(np.uint64))
    assert np.ptp(here, axis=0)[0] > 0.0
