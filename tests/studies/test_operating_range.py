"""Maps of the operating range: one outcome for each sample, in its place."""

from math import inf
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from tiny_study import UNCHANGED, planned

from maglev.many.study_design import tried_values
from maglev.many.study_file import load_study
from maglev.many.study_plan import plan_study
from maglev.many.study_run import run_study
from maglev.pages.grids import Grid, Origin, StageGrids, read_grids, write_grids
from maglev.pages.operating_range import (
    ASTRAY,
    FILE,
    LIMITED,
    OUTCOMES,
    RECOVERED,
    SETTLED,
    SETTLED_ALWAYS,
    SETTLED_NOMINAL,
    STEPS,
    STOPPED,
    TRIPPED,
    maps_of,
    table,
)
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan
from studies.laws import origin_of, shares_markdown, write_picture
from studies.operating_range import COLOURS, outcomes, read_outcomes


@pytest.mark.parametrize(("tripped", "touched", "error", "at_limit", "outcome"), [
    (inf, inf, 0.9e-4, False, SETTLED), (inf, inf, 0.9e-4, True, SETTLED), (inf, 0.6, 0.9e-4, False, RECOVERED),
    (inf, 0.6, 1.1e-4, False, STOPPED), (inf, 0.6, 1.1e-4, True, STOPPED), (0.7, 0.6, 1.1e-4, False, TRIPPED),
    (inf, inf, 1.1e-4, True, LIMITED), (inf, inf, 1.1e-4, False, ASTRAY)])
def test_the_first_cause_counts(tripped: float, touched: float, error: float, at_limit: bool, outcome: int) -> None:
    columns = {"trip time": [tripped], "stop contact time": [touched], "end error of y": [error],
               "end error of x": [0.0]}
    found = outcomes({name: np.array(values) for name, values in columns.items()}, np.array([at_limit]))
    assert found.tolist() == [outcome]


def test_shares_are_of_the_map_with_nominal_constants(tmp_path: Path) -> None:
    gaps, ends = np.array([0.01, 0.02]), np.full((1, 2, 2, 2), STOPPED, np.uint8)
    ends[0, :, :, 0] = SETTLED
    ends[0, 1, 0, 0] = TRIPPED   # with other constants
    found = StageGrids({"moves": Grid({"horizontal step": np.array([0.0]), "constants": np.array([1.0, 1.05]),
                                     "initial gap": gaps, "target gap": gaps}, {"nonlinear": ends, "PID": ends})},
                     Origin("0.0", None))
    assert table(found) == [("controller", "horizontal step", OUTCOMES[SETTLED], OUTCOMES[STOPPED], SETTLED_ALWAYS),
                            *((law, "0 mm", "50 %", "50 %", "25 %") for law in ("nonlinear", "PID"))]
    assert "| nonlinear | 0 mm | 50 % |" in shares_markdown(table(found))
    write_picture(tmp_path / "maps.png", "maps", maps_of(found), OUTCOMES, COLOURS, SETTLED_NOMINAL)
    assert (tmp_path / "maps.png").read_bytes().startswith(b"\x89PNG")


def test_a_map_has_every_sample_in_its_place(fastest_fmus: Path, tmp_path: Path) -> None:
    """Gaps out of reach end elsewhere; which they are stands in the dataset."""
    study = planned(tmp_path, fastest_fmus, vary=[
        {"set": ["plant.v.position_start", "reference.v.start"], "name": "initial gap", "kind": "list",
         "values": ["9 mm", "19.5 mm", "20 mm"]},
        {"set": "reference.v.end", "name": "target gap", "kind": "list", "values": ["19.5 mm", "20 mm"]},
        {"set": "reference.h.end", "name": "horizontal step", "kind": "list", "values": [0.0]},
        {"set": "plant.C1", "name": "constants", "mode": "factor", "kind": "list", "values": [0.95, 1.0]}],
        metrics=["end error"], keep=["controller.motor.i_d_cmd", "controller.motor.i_q_cmd"])
    path = run_study(study, tmp_path, 1, None, False, lambda _done, _all: None, print)
    varied, ends = read_outcomes(path)
    assert ends.shape == (1, 2, 3, 2)
    samples = pq.read_table(path).to_pylist()
    for row in samples:
        place = tuple(int(np.argmin(np.abs(values - row[name]))) for name, values in varied.items())
        assert (ends[place] in (STOPPED, RECOVERED)) == (row["stop contact time"] < inf)
    assert {row["stop contact time"] < inf for row in samples} == {True, False}
    origin = origin_of([path, path])
    assert origin.guids.keys() == {"Plant2DOF", "Regulator2DOF"}
    write_grids(tmp_path / "maps.json", OUTCOMES, {"2dof": StageGrids({"moves": Grid(varied, {"nonlinear": ends})},
                                                                    origin)})
    again = read_grids(tmp_path / "maps.json")["2dof"]
    assert again.origin == origin
    grid, = again.grids.values()
    assert grid.laws["nonlinear"].tolist() == ends.tolist()
    assert [*grid.varied] == [*varied]
    for name, values in varied.items():
        assert grid.varied[name].tolist() == values.tolist()


@pytest.mark.parametrize("stage", ["2dof", "3dof", "5dof"])
def test_maps_of_the_package_are_of_the_grids_of_its_studies(stage: str) -> None:
    found, study = read_grids(FILE)[stage], load_study(f"range-{stage}")[0]
    grid, = found.grids.values()
    assert {varied.column for varied in study.vary} == {*grid.varied} and next(iter(grid.varied)) in STEPS
    for varied in study.vary:
        assert grid.varied[varied.column] == pytest.approx(tried_values(varied)), varied.column
    for ends in grid.laws.values():
        assert ends.shape == tuple(map(len, grid.varied.values()))
        assert {*np.unique(ends)} <= {*range(len(OUTCOMES))}


@pytest.mark.parametrize("stage", ["2dof", "3dof", "5dof"])
def test_studies_of_the_package_can_be_run_with_every_law(stage: str, fastest_fmus: Path, tmp_path: Path) -> None:
    study, path = load_study(f"range-{stage}")
    scenarios = sorted((path.parent / study.scenario).parent.glob(f"{stage}-*.toml"))
    laws = [each for each in scenarios if each.stem != f"{stage}-horizontal"]
    assert len(laws) == {"2dof": 3, "3dof": 4, "5dof": 3}[stage]
    for scenario in laws:
        plan_study(study, prepare(load_plan(scenario), fastest_fmus, {}, {}), path.name, tmp_path, UNCHANGED)
