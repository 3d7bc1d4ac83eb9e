"""FMUs and systems in a folder whose name has spaces and letters that are not ASCII."""

import shutil
from collections.abc import Iterable
from pathlib import Path

import fmpy
import numpy as np
import pytest
from command_line import maglev
from fmpy.ssp.simulation import simulate_ssp

from maglev.cosim.fmu import Fmu, read_description
from maglev.descriptions.own_fmus import DEFINITIONS
from maglev.runs.preparation import prepare
from maglev.scenario.catalogue import build_systems
from maglev.scenario.layers import PACKAGED, packaged_files
from maglev.scenario.loading import load_plan
from maglev.user.source import FmuFile

FOLDER = "mit Leerzeichen ünïcödé"


@pytest.fixture
def elsewhere(either_kind: Path, tmp_path: Path) -> Path:
    """Copies of them in a folder with an unusual name."""
    return Path(shutil.copytree(either_kind, tmp_path / FOLDER))


@pytest.mark.parametrize("names", [("Plant3DOF", "Regulator3DOF", "Estimator2DOF", "Measurement2DOF"),
                                   pytest.param(DEFINITIONS, marks=pytest.mark.thorough)], ids=["of each kind", "all"])
def test_every_fmu(elsewhere: Path, names: Iterable[str]) -> None:
    """In our master and in fmpy's simulation."""
    for name in names:
        path = elsewhere / f"{name}.fmu"
        description = read_description(name, path)
        with Fmu(name, FmuFile(path), description) as component:
            component.initialise({}, 0.0, 1.0)
        step = float(description.defaultExperiment.stepSize)
        result = fmpy.simulate_fmu(str(path), stop_time=20.0 * step, step_size=step, output_interval=step)
        assert result["time"][-1] == pytest.approx(20.0 * step)


def test_our_master(either_kind: Path, elsewhere: Path) -> None:
    """Also the same numbers."""
    plan = load_plan("3dof-setpoints").model_copy(update={"stop_time": 0.1})
    runs = [prepare(plan, folder, {}, {}).run().columns for folder in (either_kind, elsewhere)]
    for name, column in runs[0].items():
        assert np.array_equal(column, runs[1][name]), name


def test_replacement_and_results(elsewhere: Path) -> None:
    """Options with such paths, and results in such a folder."""
    plan = elsewhere / "kürzer.toml"
    plan.write_text('extends = "2dof-setpoints.toml"\nname = "kurz"\nstop_time = "10 ms"\nclaims = []\n')
    shutil.copy(packaged_files()["2dof-setpoints"], elsewhere)
    for folder in ("loops", "gains", "references"):
        shutil.copytree(PACKAGED / folder, elsewhere / folder)
    done = maglev("run", plan, "--fmus", elsewhere, "--controller", elsewhere / "PID2DOF.fmu",
                  "--out", elsewhere / "résultats")
    assert done.exit_code == 0, done.output
    assert (elsewhere / "résultats" / "kurz.csv").is_file()


def test_system(elsewhere: Path) -> None:
    build_systems(["Stage2DOF"], elsewhere, elsewhere)
    result = simulate_ssp(str(elsewhere / "Stage2DOF.ssp"), stop_time=0.01, step_size=5e-4)
    assert np.isfinite(result["plant.v.position"]).all() and result["plant.v.position"][-1] > 0.015
