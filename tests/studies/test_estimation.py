"""The estimation study: likelihoods, roughness that is found again, residuals, its split, and that its files agree."""

import hashlib
import json
import math
import re
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import norm

from maglev.cosim.master import Recording
from maglev.experiment.execution import RunResult
from maglev.experiment.selection import select
from maglev.judging.verdicts import ClaimResult, MeasuredValue, judge
from maglev.schema.judged.claims import RunClaim
from maglev.schema.loading import load_plan
from plant_fmu.stage_2dof import Stage2DOF
from plant_fmu.stage_3dof import Stage3DOF
from pmlsm.rigs import RIGS
from studies.estimation.__main__ import DOCS, EFFECTS, FOUND, STAGES, as_assumed
from studies.estimation.causes import TILTING_LAYERS, ahead, tilting_text
from studies.estimation.evidence import Judged, log_likelihood, residual
from studies.estimation.flights import with_defaults
from studies.estimation.page import (
    RoughRow,
    best_scale,
    cause_table,
    estimate_table,
    number_table,
    scale_row,
    scale_table,
)
from studies.estimation.roughness import Estimate, Sums, adopted, estimate, spread
from studies.estimation.settings import FILE, read_settings, times

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
        value = reduce(getattr, path.split("."), PLANTS[model]())
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


def test_the_files_of_the_study_agree() -> None:
    """The page has the estimates that were found with these settings, and the effects are those of the settings."""
    found, text = json.loads(FOUND.read_text(encoding="utf-8")), DOCS.read_text(encoding="utf-8")
    assert found["settings"] == hashlib.sha256(FILE.read_bytes()).hexdigest()
    assert [float(scale) for scale in found["estimates"]] == [*SETTINGS.roughness.scales]
    assert estimate_table(SETTINGS, [Estimate(**each) for each in found["estimates"].values()]) in text
    for name in STAGES:
        assert (EFFECTS / f"{name}-as-assumed.toml").read_text(encoding="utf-8") == as_assumed(name, SETTINGS)


def test_plants_have_roughness_only_if_what_was_held_out_is_more_likely_with_it() -> None:
    """By the page's rows, and the rule that was written before."""
    text = DOCS.read_text(encoding="utf-8")
    rows = re.findall(r"^\| × [\d.]+, (no|with) roughness \| (.*) \|$", text, re.MULTILINE)
    assert [kind for kind, _ in rows] == ["no", "with"]
    likely = [Sums(*(float(cells.split(" | ")[k]) for k in (0, 2, 5))) for _, cells in rows]
    assert adopted(*likely) is any(axis.roughness.rms > 0.0 for rig in RIGS.values() for axis in rig.axes)


@pytest.mark.parametrize("name", STAGES)
def test_a_scenario_flies_with_other_effects_by_extending_them(name: str, tmp_path: Path) -> None:
    (tmp_path / "a.toml").write_text(
        f'extends = ["{EFFECTS.parent}/loops/{name}.toml", "{EFFECTS}/{name}-as-assumed.toml"]\n'
        'name = "a"\ntitle = "A"\ndescription = "A."\nstop_time = "1 s"\n', encoding="utf-8")
    start = load_plan(tmp_path / "a.toml").fmus["plant"].start
    given = {variable.partition(".")[2]: value for variable, value in SETTINGS.scale.assumed.items()
             if variable.startswith(f"Plant{name.upper()}")}
    assert {variable: each.value for variable, each in start.items()} == given


def number(value: float, of: str = "x") -> ClaimResult:
    return judge(claim(axis=of, relation="about", target="0.1 mm", digits=1), [MeasuredValue(value)])


def test_the_likelihood_of_a_number_is_that_of_a_normal_distribution_with_outliers() -> None:
    values = [0.08e-3, 0.1e-3, 0.14e-3, 0.11e-3]
    logs = np.log(values)
    density = norm.pdf(np.log(1e-4), logs.mean(), np.hypot(logs.std(), 0.05))
    found = log_likelihood([number(value) for value in values], 0.05)
    assert found == pytest.approx(np.log(0.95 * density + 0.05 / np.log(1e3)))
    # Wide and right is better than narrow and wrong; far off everything is alike.
    assert found > log_likelihood([number(0.05e-3)] * 4, 0.05)
    assert log_likelihood([number(1e-6)], 0.05) == pytest.approx(np.log(0.05 / np.log(1e3)))
    assert log_likelihood([replace(number(1.0), measured=math.inf)], 0.05) == pytest.approx(np.log(0.05 / np.log(1e3)))


def test_the_likelihood_of_anything_else_is_the_share_of_tracks_on_which_it_reproduces() -> None:
    good, bad = (judge(claim(relation="<", target="1 mm"), [MeasuredValue(value)]) for value in (0.5e-3, 2e-3))
    assert log_likelihood([good, good, bad], 0.05) == pytest.approx(np.log(2.5 / 4.0))
    assert log_likelihood([bad] * 9, 0.05) == pytest.approx(np.log(0.5 / 10.0))


def test_roughness_is_found_that_made_the_numbers() -> None:
    """Errors that grow with the rms of their own axis, and scatter from track to track: its multiple comes back."""
    settings = replace(SETTINGS.roughness, rms={"Plant3DOF.x.roughness.rms": 0.1, "Plant3DOF.z.roughness.rms": 0.2})

    def fly(scale: float, rms: Mapping[str, float], seed: int) -> list[Judged]:
        scatter = 1.0 + 0.2 * math.sin(seed)
        errors = {"x": rms["Plant3DOF.x.roughness.rms"] / 0.15, "z": rms["Plant3DOF.z.roughness.rms"] / 0.4}
        return [Judged(axis, number(max(1e-9, 1e-4 * scale * error * scatter), axis)) for axis, error in errors.items()]

    found = estimate(settings, 1.0, fly)
    assert found.rms == pytest.approx({"Plant3DOF.x.roughness.rms": 0.15, "Plant3DOF.z.roughness.rms": 0.4})
    assert estimate(settings, 0.5, fly).rms["Plant3DOF.x.roughness.rms"] == pytest.approx(0.3)
    assert found.log_likelihood > estimate(settings, 0.1, fly).log_likelihood


def test_roughness_is_taken_over_only_if_both_parts_gain() -> None:
    without = Sums(-60.0, -50.0, -10.0)
    assert adopted(without, Sums(-70.0, -49.0, -9.0))
    assert not adopted(without, Sums(-10.0, -51.0, -9.0))
    assert not adopted(without, Sums(-10.0, -49.0, -11.0))


def test_the_spread_over_tracks_is_from_the_first_to_the_last_tenth() -> None:
    found = spread([number(1e-6 * k) for k in range(1, 22)])
    assert (found.low, found.median, found.high) == (pytest.approx(3e-6), pytest.approx(11e-6), pytest.approx(19e-6))
    assert spread([replace(number(1.0), measured=None), replace(number(1.0), measured=math.nan)]).median == math.inf


@pytest.mark.parametrize(("owner", "chose"), [("2dof-procedure-4", ""), ("2dof-setpoints", ", it chose the rms")])
def test_a_printed_number_is_judged_by_its_distribution_and_by_the_nearest_cause(owner: str, chose: str) -> None:
    rows = [RoughRow("no", Sums(0.0, 0.0, 0.0), [[Judged(owner, number(0.05e-3))]]),
            RoughRow("rough", Sums(0.0, 0.0, 0.0), [[Judged(owner, number(1e-6 * k))] for k in range(60, 121, 5)])]
    near, far = ([Judged(owner, number(value))] for value in (0.09e-3, 0.04e-3))
    line = number_table(SETTINGS, rows, {"near": near, "far": far}).splitlines()[2]
    assert line.endswith(f"| 90 µm (65 µm … 0.115 mm) | inside, median missed{chose} | near | 90 µm |")
    assert "| none |" in number_table(SETTINGS, rows, {"far": far})


def test_what_other_causes_make_of_a_number_that_does_not_reproduce() -> None:
    judged = [Judged("a", number(0.05e-3)), Judged("b", number(0.1e-3))]
    lines = cause_table(judged, {"near": [Judged("a", number(0.09e-3))], "far": []}).splitlines()
    assert lines[0] == "| not reproduced | here | near | far |"
    assert [line.endswith("| 50 µm | 90 µm | – |") for line in lines[2:]] == [True]


def test_the_scenario_of_a_stage_that_tilts_flies_the_sinusoids(tmp_path: Path) -> None:
    path = tmp_path / "tilting.toml"
    path.write_text(f"extends = {json.dumps(TILTING_LAYERS)}\n{tilting_text()}", encoding="utf-8")
    plan, own = load_plan(path), load_plan("3dof-tracking-nonlinear")
    assert [signal.to for signal in plan.signals] == [signal.to for signal in own.signals]
    assert (plan.stop_time, plan.metrics.tracking_from) == (own.stop_time, own.metrics.tracking_from)


def test_a_late_measurement_on_references_ahead_is_a_late_command() -> None:
    """By the plan's own metrics: the mover that follows the reference of 2 ms later has no error."""
    plan = load_plan("3dof-tracking-nonlinear")
    time = np.arange(0.0, 16.0, 1e-3)
    columns = {name: np.zeros(len(time)) for axis in plan.axes.values() for name in (axis.position, axis.reference)}
    columns |= {name: np.zeros(len(time)) for motor in plan.motors.values() for name in (*motor.currents,
                                                                                         *motor.commands)}
    columns |= {name: np.zeros(len(time)) for name in (plan.stop_flag, plan.trip_flag) if name is not None}
    columns[plan.axes["x"].reference] = np.sin(time)
    columns[plan.axes["x"].position] = np.sin(time + 2e-3)
    found = ahead(plan, RunResult(plan, Recording(time, columns)), 2e-3)
    assert found.metrics is not None
    assert max(each.peak_tracking_error for each in found.metrics.tracking) < 1e-12


def test_a_settings_file_with_a_key_too_many_is_refused(tmp_path: Path) -> None:
    text = FILE.read_text(encoding="utf-8").replace("outliers = 0.05", "outliers = 0.05\nsize = 1", 1)
    assert tomllib.loads(text)
    (tmp_path / "a.toml").write_text(text, encoding="utf-8")
    with pytest.raises(TypeError, match="size"):
        read_settings(tmp_path / "a.toml")
