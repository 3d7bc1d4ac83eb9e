"""Maps of the operating range: one outcome for each sample, in its place."""

from math import inf
from pathlib import Path

import numpy as np
import pyarrow.parquet as pq
import pytest
from tiny_study import UNCHANGED, planned

from maglev.experiment.preparation import prepare
from maglev.maps.operating_range import (
    ASTRAY,
    LIMITED,
    OUTCOMES,
    RECOVERED,
    SETTLED,
    STOPPED,
    TRIPPED,
    Map,
    RigMaps,
    read_maps,
    shares,
)
from maglev.maps.rows import Origin
from maglev.schema.loading import load_plan
from maglev.studies.design import tried_values
from maglev.studies.planning import plan_study
from maglev.studies.running import run_study
from maglev.studies.schema import load_study
from studies.laws import markdown_table, origin_of, write_picture
from studies.operating_range import COLOURS, outcomes, read_map, write_maps

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize(("tripped", "touched", "error", "at_limit", "outcome"), [
    (inf, inf, 0.9e-4, False, SETTLED), (inf, inf, 0.9e-4, True, SETTLED), (inf, 0.6, 0.9e-4, False, RECOVERED),
    (inf, 0.6, 1.1e-4, False, STOPPED), (inf, 0.6, 1.1e-4, True, STOPPED), (0.7, 0.6, 1.1e-4, False, TRIPPED),
    (inf, inf, 1.1e-4, True, LIMITED), (inf, inf, 1.1e-4, False, ASTRAY)])
def test_the_first_cause_counts(tripped: float, touched: float, error: float, at_limit: bool, outcome: int) -> None:
    columns = {"trip time": [tripped], "stop contact time": [touched], "end error of y": [error],
               "end error of x": [0.0]}
    found = outcomes({name: np.array(values) for name, values in columns.items()}, np.array([at_limit]))
    assert found.tolist() == [outcome]


def test_shares_are_of_the_map_with_the_constants_as_they_are(tmp_path: Path) -> None:
    ends = np.full((2, 2, 1, 2), STOPPED)
    ends[:, 0, 0, :] = SETTLED
    ends[0, 0, 0, 1] = TRIPPED   # with other constants
    found = Map(np.array([0.01, 0.02]), np.array([0.01, 0.02]), np.array([0.0]), np.array([1.0, 1.05]), ends)
    (step, nominal, always), = shares(found)
    assert (step, nominal[SETTLED], nominal[STOPPED], nominal[TRIPPED], always) == (0.0, 0.5, 0.5, 0.0, 0.25)
    maps = RigMaps({"nonlinear": found, "PID": found}, Origin("0.0", None))
    assert "| nonlinear | 0 mm | 50 % |" in markdown_table(maps.table())
    write_picture(tmp_path / "maps.png", "maps", maps.rows(), OUTCOMES, COLOURS)
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
    found = read_map(path)
    assert found.outcomes.shape == (3, 2, 1, 2)
    table = pq.read_table(path).to_pylist()
    for row in table:
        place = (*(int(np.argmin(np.abs(axis - row[name]))) for axis, name in (
            (found.initial, "initial gap"), (found.target, "target gap"))), 0,
            int(np.argmin(np.abs(found.constants - row["constants"]))))
        assert (found.outcomes[place] in (STOPPED, RECOVERED)) == (row["stop contact time"] < inf)
    assert {row["stop contact time"] < inf for row in table} == {True, False}
    origin = origin_of([path, path])
    assert origin.guids.keys() == {"Plant2DOF", "Regulator2DOF"}
    write_maps(tmp_path / "maps.json", {"2dof": RigMaps({"nonlinear": found}, origin)})
    again = read_maps(tmp_path / "maps.json")["2dof"]
    assert again.origin == origin
    for name in ("initial", "target", "steps", "constants", "outcomes"):
        assert getattr(again.laws["nonlinear"], name).tolist() == getattr(found, name).tolist()


@pytest.mark.parametrize("rig", ["2dof", "3dof", "5dof"])
def test_maps_of_the_package_are_those_that_the_documentation_tells(rig: str) -> None:
    """Its page has the table of their shares, as it stands; and they are those of the studies' grids."""
    maps, study = read_maps()[rig], load_study(f"range-{rig}")[0]
    assert markdown_table(maps.table()) in (DOCS / "faults.md").read_text(encoding="utf-8")
    for found in maps.laws.values():
        for axis, varied in zip((found.initial, found.target, found.steps, found.constants), study.vary,
                                strict=True):
            assert axis == pytest.approx(tried_values(varied)), varied.column


@pytest.mark.parametrize("rig", ["2dof", "3dof", "5dof"])
def test_studies_of_the_package_can_be_flown_with_every_law(rig: str, fastest_fmus: Path, tmp_path: Path) -> None:
    study, path = load_study(f"range-{rig}")
    scenarios = sorted((path.parent / study.scenario).parent.glob(f"{rig}-*.toml"))
    laws = [each for each in scenarios if each.stem != f"{rig}-horizontal"]
    assert len(laws) == {"2dof": 3, "3dof": 4, "5dof": 3}[rig]
    for scenario in laws:
        plan_study(study, prepare(load_plan(scenario), fastest_fmus, {}, {}), path.name, tmp_path, UNCHANGED)
