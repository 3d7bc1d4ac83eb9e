"""What laws tolerate: a study sets one disturbance at a time, and a table has up to where every run holds."""

from pathlib import Path

import pytest
from tiny_study import UNCHANGED

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.many.study_plan import plan_study
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan
from studies.tolerances import DISTURBANCES, DOCS, LAWS, NAMES, SIZES, rows_of, study_of, worst_value

COUNT = len(SIZES) * sum(len(each.values) for each in DISTURBANCES)


def test_a_law_holds_up_to_the_last_value_before_it_first_fails() -> None:
    delay = DISTURBANCES[1]
    rest = [True] * (len(delay.values) - 3)
    assert worst_value([True, True, False, *rest], delay) == "1 ms"
    assert worst_value([True] * len(delay.values), delay) == "15 ms and worse"
    assert worst_value([False, True, True, *rest], delay) == "—"


@pytest.mark.parametrize("stage", LAWS)
def test_a_study_sets_one_disturbance_at_a_time(tmp_path: Path, stage: str) -> None:
    study = study_of(PACKAGED_STAGES[stage], "linear", tmp_path)
    encoders = {"v", "h"} if stage == "2dof" else {"y", "x", "z"} if stage == "3dof" else {
        "x", "z", "alpha1", "alpha2", "beta1", "beta2"}
    noise, delay, voltage, lost, gap = study.vary
    assert {*noise.set} == {f"measurement.{name}.noise" for name in encoders} and delay.set == ["measurement.delay"]
    assert "controller.setpoint" in gap.set, "it is linearised about where it goes"
    for sample in zip(*(each.values for each in (noise, delay, voltage, lost)), strict=True):
        assert sum(value.value != 0.0 for value in sample) <= 1


def test_rows_have_the_runs_of_their_step_in_the_order_of_the_study(tmp_path: Path) -> None:
    """Runs that fail from a value on, by what the study sets, are read back from the rows."""
    study = study_of(PACKAGED_STAGES["3dof"], "pid", tmp_path)
    _, delay, voltage, _, gap = ([value.written for value in each.values or ()] for each in study.vary)
    held = [not (gap[k] == gap[-1] and delay[k] in ("4 ms", "15 ms")) and voltage[k] != "4 V" for k in range(COUNT)]
    assert rows_of("pid", held) == [("PID", "1 mm", "200 µm and worse", "15 ms and worse", "6 V", "99 % and worse"),
                                    ("PID", "3 mm", "200 µm and worse", "2 ms", "6 V", "99 % and worse")]


@pytest.mark.parametrize("stage", LAWS)
def test_every_law_can_be_run_and_has_its_rows_on_the_page(fastest_fmus: Path, tmp_path: Path, stage: str) -> None:
    page = DOCS.read_text(encoding="utf-8").partition(f"<!-- tolerances-{stage}: ")[2].partition("<!-- end of")[0]
    for law in LAWS[stage]:
        study = study_of(PACKAGED_STAGES[stage], law, tmp_path)
        prepared = prepare(load_plan(Path(study.scenario)), fastest_fmus, {}, {})
        planned = plan_study(study, prepared, study.name, tmp_path, UNCHANGED)
        assert len(planned.values) == COUNT
        assert all(f"\n| {NAMES.get(law, law)} | {size:g} mm |" in page for size in SIZES)
