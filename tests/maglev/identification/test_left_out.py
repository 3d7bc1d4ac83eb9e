"""What friction, bias, ripple and modulation do to constants: the bound, and stages that have them and have not."""

from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from math import pi

import numpy as np
import pytest
from identification_data import Data, record, trial
from scipy.integrate import solve_ivp

from maglev.identification.estimators import run_estimator
from maglev.identification.identify import Identification, friction, identify, left_out, matched, observed, ripple
from maglev.identification.recording import MotionRecording
from maglev.identification.rigs import RIGS, RowData, estimated_rig, regressors
from plant_fmu.guide import GuideFriction
from plant_fmu.ripple import Ripple
from pmlsm.rig import Rig

pytestmark = pytest.mark.usefixtures("slow")

AS_ASSUMED = 2.0   # of the friction that a description has; that of the stages of `trial`


def described(rig: str, times: float) -> Rig:
    """A description with so many times the Coulomb friction."""
    found = RIGS[rig].described
    return replace(found, axes=tuple(
        replace(axis, friction=replace(axis.friction, coulomb=times * axis.friction.coulomb)) for axis in found.axes))


@cache
def real(rig: str, method: str = "reduced") -> tuple[Identification, Data]:
    """A stage with all effects, identified by a description that has them as they are."""
    data = trial(rig, "real")
    recording = replace(data.recording, rig=estimated_rig(described(rig, AS_ASSUMED)))
    return identify(recording, method, match=True), data


@pytest.mark.thorough
@pytest.mark.parametrize(("rig", "method"), [("2dof", "reduced"), ("2dof", "fsdi"),
                                             pytest.param("3dof", "reduced", marks=pytest.mark.thorough)])
def test_the_truth_is_within_the_uncertainty(rig: str, method: str) -> None:
    """Scatter alone is not where it is: constants are up to twenty standard errors away."""
    found, data = real(rig, method)
    away = {name: abs(found.estimate.final[name] - value) for name, value in data.truth.items()}
    assert max(away[name] / found.standard_error[name] for name in away) > 5.0
    for name, distance in away.items():
        assert distance < found.uncertainty[name], name
        # It is no bound that holds for whatever comes: scatter, and the sum of effects some of which cancel.
        assert found.left_out[name] < 0.6 * found.estimate.final[name]


@pytest.mark.thorough
@pytest.mark.parametrize("rig", ["2dof", pytest.param("3dof", marks=pytest.mark.thorough)])
def test_it_bounds_what_a_stage_with_the_effects_gives_otherwise(rig: str) -> None:
    """Simulated and identified with and without them, and with one after the other switched off."""
    found, data = real(rig)
    without = identify(trial(rig, "encoder").recording, match=True)
    for name, value in found.estimate.final.items():
        difference = abs(value - without.estimate.final[name])
        scatter = 2.0 * (found.standard_error[name] + without.standard_error[name])
        assert difference < found.left_out[name] + scatter, name
    # The thrust constants are off by friction, nearly all of it, and the bound says how much.
    assert found.left_out["C1"] == pytest.approx(data.truth["C1"] - found.estimate.final["C1"], rel=0.2)


@pytest.mark.thorough
@pytest.mark.parametrize("rig", ["2dof", "3dof"])
def test_told_of_the_effects_the_estimator_finds_the_truth(rig: str) -> None:
    """Independent of how they are added up: rows that have all of them at once, and their signs."""
    found, data = real(rig)
    recording, truth = found.recording, data.truth
    signed = dict.fromkeys(truth, 0.0)

    def again(rows: Sequence[RowData]) -> dict[str, float]:
        other = run_estimator("reduced", rows, recording.time, found.guess).final
        for name in signed:
            signed[name] += found.estimate.final[name] - other[name]
        return other

    seen = observed(recording.positions, recording.dt)
    positions, i_d, i_q = (matched(each, recording.dt) for each in
                           (recording.positions, recording.i_d, recording.i_q))
    rows = regressors(recording.rig, positions, i_d, i_q, seen)
    bound = left_out(recording, rows, lambda each: matched(each, recording.dt), found.estimate.final, again)
    assert bound == pytest.approx(found.left_out)
    for name in list(truth)[:-1]:   # the last, of iron, is lost in what friction leaves
        error = (found.estimate.final[name] - signed[name]) / truth[name] - 1.0
        assert abs(error) < 0.025, name
        assert abs(signed[name]) <= bound[name] * (1.0 + 1e-9)


def test_a_stage_without_effects_leaves_nothing_out() -> None:
    data = record("2dof", 2.0, 1e-3)
    plain = RIGS["2dof"].described
    smooth = replace(plain, modulation=0.0, axes=tuple(
        replace(axis, bias=0.0, friction=replace(axis.friction, coulomb=0.0, viscous=0.0),
                ripple=replace(axis.ripple, amplitude=0.0)) for axis in plain.axes))
    found = identify(replace(data.recording, rig=estimated_rig(smooth)), velocities=data.velocity)
    assert set(found.left_out.values()) == {0.0}
    assert found.uncertainty == {name: 2.0 * error for name, error in found.standard_error.items()}


def test_what_is_not_excited_is_not_known() -> None:
    data = record("2dof", 2.0, 1e-3)
    r = data.recording
    still = MotionRecording(r.rig, r.time, np.stack([r.positions[:, 0], np.zeros(len(r.time))], axis=1), r.i_d, r.i_q)
    found = identify(still)
    assert found.left_out["C1"] == np.inf
    assert np.isfinite([found.left_out[name] for name in ("C2", "C3", "C4")]).all()


def test_the_effects_are_those_of_the_plant() -> None:
    """Along a motion: the guide by scipy's integration of its equation, as the plant's part has it."""
    axis = RIGS["2dof"].described.axes[1]
    t = np.linspace(0.0, 1.2, 6001)   # to and fro
    x, v = 0.02 * np.sin(pi * t) + 0.004 * np.sin(7.0 * t), 0.02 * pi * np.cos(pi * t) + 0.028 * np.cos(7.0 * t)
    guide = GuideFriction(axis.friction.coulomb, axis.friction.presliding, axis.friction.viscous)
    solved = solve_ivp(lambda time, w: guide.slide(w[0], np.interp(time, t, v))[1], (0.0, t[-1]), [0.0],
                       t_eval=t, max_step=2e-4, rtol=1e-8, atol=1e-10)
    expected = [-guide.slide(w, rate)[0] / axis.mass for w, rate in zip(solved.y[0], v, strict=True)]
    assert friction(axis, x, v) == pytest.approx(np.array(expected), abs=2e-3 * np.ptp(expected))
    wavy = replace(axis, ripple=replace(axis.ripple, amplitude=0.3, period=0.01))
    part = Ripple(0.3, 0.01)
    assert ripple(wavy, x, v) == pytest.approx([part.acceleration(place) for place in x.tolist()])
