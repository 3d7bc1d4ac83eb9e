"""Sources of two FMUs in one program: names of their own (FMI 2.0.5, section 2.1.1), the results of the libraries."""

import subprocess
from pathlib import Path

import numpy as np
import pytest
from native_builds import (
    HERE,
    STRICT,
    built_once,
    prefixing_headers,
    require_command,
    two_fmus_simulated,
    unpacked_sources,
)

from maglev.cosim.master import FmuSetup, Master

STEP = 2e-4   # s
STEPS = 1000
COMPILED = ("Plant3DOF", "Regulator3DOF", "Estimator3DOF")


@pytest.fixture(scope="session")
def headers(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with FMI headers that heed FMI2_FUNCTION_PREFIX."""
    return prefixing_headers(tmp_path_factory.mktemp("headers"))


@pytest.fixture(scope="session")
def objects(native_fmus: Path, headers: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with the sources of FMUs, compiled for static linking."""
    compiler = require_command("gcc")

    def make(folder: Path) -> None:
        for name in COMPILED:
            sources = unpacked_sources(native_fmus / f"{name}.fmu", folder / name)
            done = subprocess.run([compiler, *STRICT, *"-O1", "-I", headers, "-c",
                                   *sorted(path.name for path in sources.glob("*.c"))],
                                  cwd=sources, capture_output=True, text=True)
            assert done.returncode == 0, done.stderr[-3000:]

    return built_once(tmp_path_factory, "objects", make)


@pytest.mark.thorough
@pytest.mark.parametrize("name", COMPILED)
def test_every_name_that_the_linker_sees_is_the_fmus_own(objects: Path, name: str) -> None:
    listing = subprocess.run([require_command("nm"), "--defined-only", "--extern-only", "--format=posix",
                              *sorted((objects / name / "sources").glob("*.o"))],
                             check=True, capture_output=True, text=True).stdout
    names = {line.split()[0] for line in listing.splitlines() if len(line.split()) > 2}
    assert f"{name}_fmi2DoStep" in names and len(names) > 50
    assert {each for each in names if not each.startswith(f"{name}_")} == set()


@pytest.mark.thorough
def test_two_fmus_in_one_program(objects: Path, headers: Path, native_fmus: Path, tmp_path: Path) -> None:
    """Plant and regulator run as they do as shared libraries, bit for bit."""
    program = tmp_path / "two_fmus"
    subprocess.run([require_command("gcc"), *STRICT, "-I", headers, HERE / "two_fmus.c",
                    *(objects / "Plant3DOF" / "sources").glob("*.o"),
                    *(objects / "Regulator3DOF" / "sources").glob("*.o"), "-lm", "-o", program], check=True)
    measured = [(f"{axis}.encoder", f"{axis}.measured") for axis in "yxz"]
    commanded = [f"{pair}.i_{phase}_cmd" for pair in ("alpha", "beta") for phase in "abc"]
    there = two_fmus_simulated(program, native_fmus, measured, STEP, STEPS)
    connections = [*((f"plant.{a}", f"controller.{b}") for a, b in measured),
                   *((f"controller.{each}", f"plant.{each}") for each in commanded)]
    with Master([FmuSetup("controller", native_fmus / "Regulator3DOF.fmu"),
                 FmuSetup("plant", native_fmus / "Plant3DOF.fmu")], connections, STEP) as master:
        columns = master.run(STEPS * STEP, {}).columns
    here = np.stack([columns[f"plant.{a}"][:-1] for a, _ in measured], axis=1)
    assert there.shape == here.shape == (STEPS, 3)
    assert np.array_equal(there, here)
    assert np.ptp(here, axis=0)[0] > 0.0
