"""Maps that are fine where outcomes change: what is run for them, and what is filled in."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.figure import Figure
from tiny_study import UNCHANGED

import maglev
from maglev.many.study_file import load_study
from maglev.many.study_plan import plan_study
from maglev.pages.outcome_map import Factor, LawMap, Outcomes
from maglev.runs.preparation import prepare
from maglev.scenario.layers import PACKAGED
from maglev.scenario.loading import load_plan
from studies.landing import COMPARED, WORDS, Where, refined, write_picture

SCENARIOS, AMPLITUDE = PACKAGED / "landing", "reference.plant.y.force.amplitude"


def halves(angle: float, offset: float, scale: int) -> Outcomes:
    """Map of two half-planes, whole: the outcome changes along a straight line."""
    row, column = np.mgrid[: 8 * scale + 1, : 6 * scale + 1] / scale
    return np.asarray(math.cos(angle) * row + math.sin(angle) * column > offset, np.uint8)[None]


@given(st.floats(0.0, math.tau), st.floats(-5.0, 9.0), st.integers(0, 4))
def test_a_straight_border_is_found_exactly(angle: float, offset: float, fine: int) -> None:
    """Both half-planes are convex: where the corners of a square are in one of them, all of it is."""
    whole = halves(angle, offset, 2**fine)

    def classify(where: Where) -> Outcomes:
        return np.asarray(whole[tuple(where.T)])

    cells, simulated = refined(classify, 1, 9, 7, fine)
    assert np.array_equal(cells, whole)
    assert simulated[:, :: 2**fine, :: 2**fine].all()


def test_squares_are_halved_at_the_border_alone() -> None:
    whole, asked = halves(0.3, 4.0, 16), 0

    def classify(where: Where) -> Outcomes:
        nonlocal asked
        asked += len(where)
        return np.asarray(whole[tuple(where.T)])

    _, simulated = refined(classify, 1, 9, 7, 4)
    assert asked == simulated.sum() < whole.size / 4, "no place is asked for twice, and few are"


def test_a_throw_is_the_speed_that_it_says(fastest_fmus: Path) -> None:
    """An impulse of one sample: after it the mover is faster by that, whatever the controller does."""
    thrown, at_rest = (maglev.run({"extends": str(SCENARIOS / "3dof-nonlinear.toml"), "name": "thrown",
                                   "output_interval": "0.2 ms"}, fmus=fastest_fmus, set={AMPLITUDE: speed})
                       for speed in (0.25, 0.0))
    after = 2
    assert thrown.time[after] == pytest.approx(0.4e-3)
    faster, moved = (thrown[f"plant.y.{name}"][after] - at_rest[f"plant.y.{name}"][after]
                     for name in ("velocity", "position"))
    assert abs(faster - 0.25) < 1e-3
    assert abs(moved - 0.25 * 0.1e-3) < 1e-6, "the speed grows evenly over the sample"


@pytest.mark.parametrize("law", COMPARED)
def test_the_study_can_be_run_with_every_law(law: str, fastest_fmus: Path, tmp_path: Path) -> None:
    study, path = load_study("landing-3dof")
    plan = load_plan((path.parent / study.scenario).with_name(f"3dof-{law}.toml"))
    planned = plan_study(study, prepare(plan, fastest_fmus, {}, {}), path.name, tmp_path, UNCHANGED)
    assert len(planned.values) == 17 * 17 * 3


def test_a_picture_has_a_map_of_each_law_and_payload(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    sides = [Factor(name, unit, np.linspace(0.0, 1.0, count), {}) for name, unit, count in (
        ("gap", "m", 9), ("speed", "m/s", 17), ("payload", "kg", 2))]
    cells = (np.arange(2 * 9 * 17) % 3).astype(np.uint8).reshape(2, 9, 17)
    figures: list[Figure] = []
    monkeypatch.setattr(Figure, "savefig", lambda figure, path, dpi: figures.append(figure))
    write_picture(tmp_path / "maps.png", [LawMap(law, "", sides, cells) for law in ("nonlinear", "PID")])
    figure, = figures
    assert [axes.get_title() for axes in figure.axes] == ["nonlinear", "PID", "", ""]
    assert [[label.get_text() for label in axes.get_yticklabels()] for axes in figure.axes[::2]] == [
        ["0", "250", "500", "750", "1e+03"]] * 2
    assert [axes.get_ylabel() for axes in figure.axes[::2]] == ["Payload 0 g\ngap, mm", "Payload 1000 g\ngap, mm"]
    assert [np.asarray(axes.collections[0].get_array()).tolist() for axes in figure.axes] == [
        layer.tolist() for layer in cells for _ in range(2)]
    assert [text.get_text() for text in figure.legends[0].get_texts()] == [*WORDS[:3]]
