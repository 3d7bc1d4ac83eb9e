"""The estimation study: residuals, its split, the scale that is chosen, and that its files agree."""

import re
import tomllib
from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Any

import pytest
from facts import raises
from named_stage import Stage2DOF, Stage3DOF

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.runs.chain import select
from maglev.runs.verdicts import ClaimResult, MeasuredValue, judge
from maglev.scenario.claims import RunClaim
from maglev.scenario.loading import load_plan
from studies.estimation import (
    DOCS,
    EFFECTS,
    FILE,
    STAGES,
    as_assumed,
    best_scale,
    read_settings,
    residual,
    split,
    table_of,
    times,
    with_defaults,
)

pytestmark = pytest.mark.quick

SETTINGS = read_settings()
PLANTS = {"Plant2DOF": Stage2DOF, "Plant3DOF": Stage3DOF}


def claim(**keys: Any) -> RunClaim:
    return RunClaim.model_validate({"text": "a", "source": "p. 1", "metric": "mean_tracking_error", **keys})


@pytest.mark.parametrize(("keys", "value", "expected"), [
    ({"relation": "about", "target": "0.4 mm", "digits": 1}, 0.45e-3, 1.0),     # half a digit is more than 5 %
    ({"relation": "about", "target": "1.64 mm", "digits": 3}, 1.722e-3, 1.0),   # 5 % is more than half a digit
    ({"relation": "about", "target": "1.64 mm", "digits": 3}, 1.558e-3, -1.0),
    ({"relation": "<", "target": "1 mm"}, 0.9e-3, 0.0),
    ({"relation": "<", "target": "1 mm"}, 1.1e-3, 1.0),
    ({"relation": ">", "target": "1 mm"}, 0.8e-3, 2.0),
    ({"metric": "settling_time", "band": "10 um", "relation": "<", "target": "5 s"}, float("inf"), 1.0),
    ({"metric": "failed", "relation": "is", "target": True}, False, 1.0),
    ({"metric": "failed", "relation": "is", "target": True}, True, 0.0)])
def test_residuals_are_in_standard_deviations(keys, value, expected):
    result = judge(claim(**keys), [MeasuredValue(value)])
    assert residual(result, 1e6) == pytest.approx(expected, abs=1e-9)
    assert abs(residual(result, 4.0)) <= abs(expected) + 1e-9


def test_the_residual_of_a_bound_is_in_ticks_and_that_of_a_comparison_in_tenths():
    bound = RunClaim.model_validate({"figure": "1", "metric": "highest", "column": "a", "unit": "mm", "target": [2, 4]})
    assert residual(judge(bound, [MeasuredValue(7e-3)]), 1e6) == pytest.approx(1.5)
    comparison = claim(relation="<", factor=0.5, than="other")
    result = judge(comparison, [MeasuredValue(0.6e-3)], [MeasuredValue(1e-3)])
    assert residual(result, 1e6) == pytest.approx(2.0)


def test_a_run_that_failed_counts_as_the_largest_residual():
    assert residual(judge(claim(relation="<", target="1 mm"), None), 4.0) == 4.0


def test_defaults_leave_what_a_scenario_gives():
    """The model that predicts the stage has no friction, and says so; the compensator follows only where it is on."""
    defaults = {"Plant2DOF.h.friction.coulomb": 0.25, "Plant3DOF.x.friction.coulomb": 9.0}
    following = {"Regulator2DOF.h.friction_compensation": 0.157}
    off = with_defaults(load_plan("2dof-identification-model"), defaults, following)
    assert off.fmus["plant"].start["h.friction.coulomb"].value == 0
    plain = with_defaults(load_plan("2dof-tracking-nonlinear"), defaults, following)
    assert plain.fmus["plant"].start["h.friction.coulomb"].value == 0.25
    assert "x.friction.coulomb" not in plain.fmus["plant"].start
    assert "h.friction_compensation" not in plain.fmus["controller"].start
    compensated = with_defaults(load_plan("2dof-tracking-friction-compensation"), defaults, following)
    assert compensated.fmus["controller"].start["h.friction_compensation"].value == 0.157


def test_plants_and_compensator_have_the_scale_that_training_chooses():
    """The page's bold row is the one with most of the sentences for training, and what the plants have."""
    text = DOCS.read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\*{0,2})× ([\d.]+)(, slot ripple)?\1 \| (\d+) /", text, re.MULTILINE)
    plain = {float(scale): int(sentences) for _, scale, ripple, sentences in rows if not ripple}
    assert [*plain] == SETTINGS.candidates
    chosen, = (float(scale) for bold, scale, *_ in rows if bold)
    assert plain[chosen] == max(plain.values())
    assert {float(scale) for _, scale, ripple, _ in rows if ripple} == {chosen}
    for model, _, path in (name.partition(".") for name in SETTINGS.assumed):
        assert reduce(getattr, path.split("."), PLANTS[model]()) == chosen * SETTINGS.assumed[f"{model}.{path}"], path
    given = load_plan("2dof-tracking-friction-compensation").fmus["controller"].start
    for name, value in times(chosen, SETTINGS.follows).items():
        assert given[name.partition(".")[2]].value == value
    assert set(SETTINGS.assumed) == {f"Plant{name.upper()}.{axis.name}.friction.coulomb"
                                           for name,
                                           stage in PACKAGED_STAGES.items()
                                           if not stage.rotations for axis in stage.axes}
    # not run: it has the guides of the 3-DOF stage
    leaning = {axis.name: axis for axis in PACKAGED_STAGES["5dof"].axes}
    assert all(leaning[axis.name].friction == axis.friction for axis in PACKAGED_STAGES["3dof"].axes)


def judged_sentence(owner: str, value: float) -> tuple[str, ClaimResult]:
    return owner, judge(claim(relation="<", target="1 mm"), [MeasuredValue(value)])


def test_the_scale_is_chosen_by_the_sentences_for_training_alone():
    """Held out, 0.5 is the better one; of equals the first is taken, and a row splits the evidence."""
    training = "2dof-setpoints"
    rows = [split(SETTINGS, scale, False, [judged_sentence(training, value), judged_sentence("3dof-step-1", other)])
            for scale, value, other in ((0.5, 2.0, 0.5e-3), (1.0, 0.5e-3, 2.0), (2.0, 0.5e-3, 2.0))]
    assert [[len(row.training), len(row.held_out)] for row in rows] == [[1, 1]] * 3
    assert best_scale(rows) == 1.0
    table = table_of(SETTINGS, [*rows, replace(rows[1], ripple=True)])
    assert "| **× 1** | 1 / 0 / 0 | 0 of 0 | 0.0 | 0 / 0 / 1 |" in table
    assert "| × 1, slot ripple | 1 / 0 / 0 |" in table and "| × 0.5 | 0 / 0 / 1 |" in table


def test_the_split_is_by_runs_that_exist_and_leaves_most_of_the_evidence_held_out():
    plans = {plan.name: plan for plan in select(None)}
    assert plans.keys() >= {*SETTINGS.training}
    training = sum(len(plans[name].claims) for name in SETTINGS.training)
    assert 0 < training < sum(len(plan.claims) for plan in plans.values()) / 2


def test_the_effects_are_those_of_the_settings() -> None:
    for name in STAGES:
        assert (EFFECTS / f"{name}-as-assumed.toml").read_text(encoding="utf-8") == as_assumed(name, SETTINGS)


def test_guides_are_as_smooth_as_the_page_says() -> None:
    assert "**the guides stay smooth**" in DOCS.read_text(encoding="utf-8")
    assert all(axis.roughness.rms == 0.0 for stage in PACKAGED_STAGES.values() for axis in stage.axes)


@pytest.mark.parametrize("name", STAGES)
def test_a_scenario_runs_with_other_effects_by_extending_them(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(
        f'extends = ["{EFFECTS.parent}/loops/{name}.toml", "{EFFECTS}/{name}-as-assumed.toml"]\n'
        'name = "a"\ntitle = "A"\ndescription = "A."\nstop_time = "1 s"\n', encoding="utf-8")
    start = load_plan(tmp_path / "a.toml").fmus["plant"].start
    given = {variable.partition(".")[2]: value for variable, value in SETTINGS.assumed.items()
             if variable.startswith(f"Plant{name.upper()}")}
    assert {variable: each.value for variable, each in start.items()} == given


def test_a_settings_file_with_a_key_too_many_is_refused(tmp_path: Path) -> None:
    text = FILE.read_text(encoding="utf-8").replace("[scale]", "[scale]\nsize = 1", 1)
    assert tomllib.loads(text)
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    with raises(TypeError, "'size'"):
        read_settings(tmp_path / "a.toml")
