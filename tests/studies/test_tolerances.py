"""What laws tolerate: outcomes by their first cause, maps in their order, and the page that shows them."""

from math import inf, nan
from pathlib import Path

import numpy as np
import pytest

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.pages.grids import read_grids, write_grids
from maglev.pages.tolerances import (
    ASTRAY,
    FILE,
    HOLDS,
    OUTCOMES,
    QUESTIONS,
    STEP,
    STOPPED,
    TRIPPED,
    last_that_holds,
    table,
)
from studies.laws import LAWS, NAMES, shares_markdown
from studies.tolerances import SIZES, outcomes, study_of

DOCS = Path(__file__).parents[2] / "docs"
FOUND = read_grids(FILE)


@pytest.mark.parametrize(("tripped", "touched", "gap", "tilt", "outcome"), [
    (inf, inf, 0.9e-3, 4.9e-3, HOLDS), (inf, inf, 1.1e-3, 0.0, ASTRAY), (inf, inf, 0.0, 5.1e-3, ASTRAY),
    (inf, inf, nan, 0.0, ASTRAY), (inf, 0.6, 0.0, 0.0, STOPPED), (0.7, 0.6, 0.0, 0.0, STOPPED),
    (0.5, 0.6, 2e-3, 0.0, TRIPPED), (0.5, inf, 0.0, 0.0, TRIPPED)])
def test_the_first_cause_counts(tripped: float, touched: float, gap: float, tilt: float, outcome: int) -> None:
    columns = {"trip time": [tripped], "stop contact time": [touched], "end error of y": [gap],
               "end error of roll": [tilt]}
    assert outcomes({name: np.array(values) for name, values in columns.items()}, ("roll",)).tolist() == [outcome]


def test_a_law_holds_up_to_the_last_value_before_it_first_fails() -> None:
    side = QUESTIONS[0].along
    rest = [HOLDS] * (len(side.values) - 3)
    assert last_that_holds(np.array([HOLDS, HOLDS, STOPPED, *rest]), side) == "1 ms"
    assert last_that_holds(np.array([HOLDS] * len(side.values)), side) == "15 ms and worse"
    assert last_that_holds(np.array([TRIPPED, HOLDS, HOLDS, *rest]), side) == "—"
    assert QUESTIONS[1].down.text(0) == "no limit"


@pytest.mark.parametrize("stage", LAWS)
def test_a_study_sets_what_its_question_is_about(tmp_path: Path, stage: str) -> None:
    study = study_of(PACKAGED_STAGES[stage], "linear", QUESTIONS[0], tmp_path)
    encoders = {"v", "h"} if stage == "2dof" else {"y", "x", "z"} if stage == "3dof" else {
        "x", "z", "alpha1", "alpha2", "beta1", "beta2"}
    noise, delay, gap = study.vary
    assert {*noise.set} == {f"measurement.{name}.noise" for name in encoders} and delay.set == ["measurement.delay"]
    assert "controller.setpoint" in gap.set, "it is linearised about where it goes"


def test_results_are_complete_and_on_their_page(tmp_path: Path) -> None:
    write_grids(tmp_path / "found.json", OUTCOMES, FOUND)
    again = read_grids(tmp_path / "found.json")
    page = (DOCS / "results_faults.md").read_text(encoding="utf-8")
    for name, stage in FOUND.items():
        assert list(stage.grids) == [question.name for question in QUESTIONS]
        assert again[name].origin == stage.origin
        for question in QUESTIONS:
            grid = stage.grids[question.name]
            assert {what: values.tolist() for what, values in grid.varied.items()} == {STEP: [*SIZES], **{
                f"{side.name}, {side.unit}": [*side.values] for side in (question.down, question.along)}}
            assert list(grid.laws) == [NAMES.get(law, law) for law in LAWS[name]]
            for law, found in grid.laws.items():
                assert found.shape == (len(SIZES), len(question.down.values), len(question.along.values))
                assert {*np.unique(found)} <= {*range(len(OUTCOMES))}
                assert np.array_equal(found, again[name].grids[question.name].laws[law])
        assert shares_markdown(table(stage)) in page
        assert (DOCS / f"tolerances-{name}.png").is_file() and f"](tolerances-{name}.png)" in page
