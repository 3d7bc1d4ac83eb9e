"""The estimation study: its fit against exact results, its residuals, its split, and that its files agree."""

import json
import re
import tomllib
from dataclasses import replace
from functools import reduce
from pathlib import Path

import numpy as np
import pytest

from maglev.experiment.selection import select
from maglev.judging.verdicts import MeasuredValue, judge
from maglev.schema.claims import RunClaim
from maglev.schema.loading import load_plan
from plant_fmu.stage_2dof import Stage2DOF
from plant_fmu.stage_3dof import Stage3DOF
from pmlsm.rigs import RIGS
from studies.estimation.__main__ import DOCS, EFFECTS, FOUND, as_assumed, effects, from_data
from studies.estimation.evidence import Judged, residual
from studies.estimation.fit import Objective, fit
from studies.estimation.flights import with_defaults
from studies.estimation.page import best_scale, estimate_table, profile_table, scale_row, scale_table
from studies.estimation.settings import FILE, read_settings, times

pytestmark = pytest.mark.quick

SETTINGS = read_settings()
STAGES = {"Plant2DOF": Stage2DOF, "Plant3DOF": Stage3DOF}
MATRIX = np.array([[2.0, 0.5], [0.0, 1.5], [1.0, -1.0]])
SEEN = np.array([1.0, -0.8, 0.4])


def test_a_linear_problem_has_the_exact_posterior():
    """Residuals A u − b with a standard normal prior: mean (AᵀA + 1)⁻¹ Aᵀ b, covariance (AᵀA + 1)⁻¹."""
    found = fit(lambda u: MATRIX @ u - SEEN, np.full(2, -4.0), 1e-4, 20)
    precision = MATRIX.T @ MATRIX + np.eye(2)
    assert found.u == pytest.approx(np.linalg.solve(precision, MATRIX.T @ SEEN), abs=1e-6)
    assert found.deviations == pytest.approx(np.sqrt(np.diag(np.linalg.inv(precision))), rel=1e-6)
    assert found.cost_before == pytest.approx(0.5 * SEEN @ SEEN)
    assert found.cost < found.cost_before


def test_the_profile_of_a_strong_linear_problem_is_the_parabola_of_its_deviation():
    found = fit(lambda u: 100.0 * (MATRIX @ u - SEEN), np.full(2, -4.0), 1e-4, 20)
    assert found.profiles == pytest.approx(np.array([[2.0, 0.5, 0.5, 2.0]] * 2), rel=2e-2)


def test_a_parameter_without_evidence_keeps_its_prior():
    found = fit(lambda u: np.array([3.0 * (u[0] - 1.0)]), np.full(2, -4.0), 1e-4, 20)
    assert found.u[1] == pytest.approx(0.0, abs=1e-9)
    assert found.deviations[1] == pytest.approx(1.0)
    assert found.profiles[1] == pytest.approx(np.zeros(4), abs=1e-9)


def test_a_fit_stays_in_its_range():
    found = fit(lambda u: np.array([5.0 * (u[0] + 2.0)]), np.array([0.0]), 0.25, 20)
    assert found.u[0] == pytest.approx(0.0, abs=1e-6)
    assert np.isnan(found.profiles[0, :2]).all()


def test_what_was_evaluated_is_not_evaluated_again():
    calls = []

    def residuals(u: np.ndarray) -> np.ndarray:
        calls.append(1)
        return np.array([u[0]])

    objective = Objective(residuals, np.array([-4.0]))
    assert objective.cost(np.array([2.0])) == objective.cost(np.array([2.0])) == 4.0
    assert len(calls) == 1


def claim(**keys):
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
    """The model that predicts the rig has no friction, and says so; the compensator follows only where it is on."""
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


def test_what_is_assumed_is_what_the_plants_have_but_for_the_scale_of_friction():
    for parameter in (parameter for rig in SETTINGS.rigs for parameter in rig.parameters):
        for model, _, path in (variable.partition(".") for variable in parameter.variables):
            if model in STAGES and path.endswith(".coulomb"):
                assert SETTINGS.scale.assumed[f"{model}.{path}"] == parameter.assumed
            elif model in STAGES:
                assert reduce(getattr, path.split("."), STAGES[model]()) == parameter.assumed, parameter.name


def test_the_compensator_follows_the_friction_over_the_mass():
    follows = next(parameter.follows for parameter in SETTINGS.rigs[0].parameters if parameter.follows is not None)
    assert follows[1] == pytest.approx(1.0 / Stage2DOF().h.mass, rel=1e-6)
    given = load_plan("2dof-tracking-friction-compensation").fmus["controller"].start["h.friction_compensation"]
    assert follows[1] * Stage2DOF().h.friction.coulomb == pytest.approx(given.value, rel=2e-3)


def test_plants_and_compensator_have_the_scale_that_training_chooses():
    """The page's bold row is the one with most of the sentences for training, and what the plants have."""
    text = DOCS.read_text(encoding="utf-8")
    rows = re.findall(r"^\| (\*{0,2})× ([\d.]+)(, slot ripple)?\1 \| (\d+) /", text, re.MULTILINE)
    plain = {float(scale): int(sentences) for _, scale, ripple, sentences in rows if not ripple}
    assert tuple(plain) == SETTINGS.scale.candidates
    chosen, = (float(scale) for bold, scale, *_ in rows if bold)
    assert plain[chosen] == max(plain.values())
    assert {float(scale) for _, scale, ripple, _ in rows if ripple} == {chosen}
    for model, _, path in (name.partition(".") for name in SETTINGS.scale.assumed):
        value = reduce(getattr, path.split("."), STAGES[model]())
        assert value == chosen * SETTINGS.scale.assumed[f"{model}.{path}"], path
    given = load_plan("2dof-tracking-friction-compensation").fmus["controller"].start
    for name, value in times(chosen, SETTINGS.scale.follows).items():
        assert given[name.partition(".")[2]].value == value
    assert set(SETTINGS.scale.assumed) == {f"Plant{name.upper()}.{axis.name}.friction.coulomb"
                                           for name, rig in RIGS.items() if not rig.rotations for axis in rig.axes}
    leaning = {axis.name: axis for axis in RIGS["5dof"].axes}   # not flown: it has the guides of the 3-DOF stage
    assert all(leaning[axis.name].friction == axis.friction for axis in RIGS["3dof"].axes)


def judged_sentence(owner: str, value: float) -> Judged:
    return Judged(owner, judge(claim(relation="<", target="1 mm"), [MeasuredValue(value)]))


def test_the_scale_is_chosen_by_the_sentences_for_training_alone():
    """Held out, 0.5 is the better one; of equals the first is taken, and a row splits the evidence."""
    training = "2dof-setpoints"
    rows = [scale_row(SETTINGS, scale, False, [judged_sentence(training, value), judged_sentence("3dof-step-1", other)])
            for scale, value, other in ((0.5, 2.0, 0.5e-3), (1.0, 0.5e-3, 2.0), (2.0, 0.5e-3, 2.0))]
    assert [[len(row.training), len(row.held_out)] for row in rows] == [[1, 1]] * 3
    assert best_scale(rows) == 1.0
    table = scale_table(SETTINGS, [*rows, replace(rows[1], ripple=True)])
    assert "| **× 1** | 1 / 0 / 0 | 0 of 0 | 0.0 | 0 / 0 / 1 |" in table
    assert "| × 1, slot ripple | 1 / 0 / 0 |" in table and "| × 0.5 | 0 / 0 / 1 |" in table


def test_the_split_is_by_runs_that_exist_and_leaves_most_of_the_evidence_held_out():
    plans = {plan.name: plan for plan in select(None)}
    assert set(plans) >= SETTINGS.training
    training = sum(len(plans[name].claims) for name in SETTINGS.training)
    assert 0 < training < sum(len(plan.claims) for plan in plans.values()) / 2


def test_the_files_of_the_study_agree():
    """The page and the effects are those of the fit; the fit is that of the settings."""
    found, text = json.loads(FOUND.read_text(encoding="utf-8")), DOCS.read_text(encoding="utf-8")
    for rig in SETTINGS.rigs:
        fitted = from_data(found["fits"][rig.name])
        assert estimate_table(rig, fitted) in text
        assert profile_table(rig, fitted) in text
        assert (EFFECTS / f"{rig.name}-estimated.toml").read_text(encoding="utf-8") == effects(rig, SETTINGS, fitted)
        assert (EFFECTS / f"{rig.name}-as-assumed.toml").read_text(encoding="utf-8") == as_assumed(rig, SETTINGS)
        assert fitted.cost < fitted.cost_before
        assert RIGS[rig.name]


@pytest.mark.parametrize("kind", ["estimated", "as-assumed"])
@pytest.mark.parametrize("rig", SETTINGS.rigs, ids=lambda rig: rig.name)
def test_a_scenario_flies_with_other_effects_by_extending_them(rig, kind: str, tmp_path: Path):
    fitted = from_data(json.loads(FOUND.read_text(encoding="utf-8"))["fits"][rig.name])
    given = {**SETTINGS.scale.assumed, **(rig.defaults(fitted.u) if kind == "estimated" else {})}
    (tmp_path / "a.toml").write_text(
        f'extends = ["{EFFECTS.parent}/loops/{rig.name}.toml", "{EFFECTS}/{rig.name}-{kind}.toml"]\n'
        'name = "a"\ntitle = "A"\ndescription = "A."\nstop_time = "1 s"\n', encoding="utf-8")
    start = load_plan(tmp_path / "a.toml").fmus["plant"].start
    values = {name: value for name, value in given.items() if name.startswith(f"Plant{rig.name.upper()}")}
    assert {f"Plant{rig.name.upper()}.{name}" for name in start} == set(values)
    for name, value in values.items():
        assert start[name.partition(".")[2]].value == pytest.approx(value, rel=1e-3)


def test_a_settings_file_with_a_key_too_many_is_refused(tmp_path: Path):
    text = FILE.read_text(encoding="utf-8").replace('unit = "N"', 'unit = "N"\nsize = 1', 1)
    assert tomllib.loads(text)
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    with pytest.raises(TypeError, match="size"):
        read_settings(tmp_path / "a.toml")
