"""Maps of sudden changes: what the samples set, that a map's run is a run, and what the table says of maps."""

import tomllib

import numpy as np
import pytest

import maglev
from studies.sudden_changes import CHANGES, LAWS, PUBLISHED, SCENARIO, TIMES, border, grid, run_change, table, values_of

SIDE = 2


def test_what_the_study_calls_nominal_is_what_the_scenario_begins_with() -> None:
    scenario = tomllib.loads(SCENARIO.with_name("learning.toml").read_text(encoding="utf-8"))
    signals = {signal["to"]: signal["values"] for signal in scenario["signals"] if signal["kind"] == "steps"}
    for name, value in PUBLISHED.items():
        assert {*signals[f"plant.{name}"]} == {value}, name


def test_a_payload_adds_the_same_mass_to_every_axis_and_a_field_squares_in_the_attraction() -> None:
    size, time = grid(CHANGES["payload"], SIDE)
    assert {*time} == {*TIMES}
    landed = values_of(CHANGES["payload"], "fixed", SIDE)
    for axis in "yxz":
        added = landed[f"reference.plant.{axis}.mass.end"] - PUBLISHED[f"{axis}.mass"]
        assert added == pytest.approx(6.9 * size, rel=1e-12)
    weaker = values_of(CHANGES["field"], "fixed", SIDE)
    assert weaker["reference.plant.C3.end"] / PUBLISHED["C3"] == pytest.approx(
        (weaker["reference.plant.C4.end"] / PUBLISHED["C4"]) ** 2, rel=1e-12)


def test_bounds_are_set_only_where_there_are_any() -> None:
    bounds = "controller.adaptation.range"
    assert bounds in values_of(CHANGES["bounds"], "adaptive", SIDE)
    assert bounds not in values_of(CHANGES["bounds"], "fixed", SIDE)


def test_the_table_counts_what_one_law_loses_alone() -> None:
    fixed = np.array([[1.0, 1.0], [np.inf, 2.0], [np.inf, np.inf]])
    adaptive = np.array([[0.5, 1.5], [1.0, np.inf], [np.inf, np.inf]])
    assert border(CHANGES["field"], fixed) == "21.0, 40.0"
    assert border(CHANGES["field"], np.array([[1.0], [1.0]])) == "held"
    row = table({"field": {"fixed": fixed, "adaptive": adaptive}}).splitlines()[-1]
    cells = [cell.strip() for cell in row.split("|")[2:9]]
    assert cells == ["adaptive", "21.0, 40.0", "1", "1", "1.00", "1.50", "50 %"]


@pytest.mark.thorough
@pytest.mark.parametrize("law", LAWS)
def test_a_cell_is_the_run_of_its_size_and_time(law: str) -> None:
    change = CHANGES["field"]
    found = run_change(change, law, SIDE, 1)
    values = {name: float(each[0]) for name, each in values_of(change, law, SIDE).items()}
    run = maglev.run(SCENARIO, controller=LAWS[law], set=values)
    assert run.metrics is not None
    assert found[0, 0] == next(each.peak_tracking_error for each in run.metrics.tracking if each.axis == "y")
    assert np.isinf(found[1]).all(), "no law holds with 40 % less"
