"""What friction, bias, ripple and modulation do to constants: the bound, and stages that have them and have not."""

from dataclasses import replace
from functools import cache
from math import pi
from typing import Any

import numpy as np
import pytest
from identification_data import Data, record, trial
from scipy.integrate import solve_ivp

from maglev.identification.effects import friction, ripple
from maglev.identification.identify import Identification, identify
from maglev.identification.recording import MotionRecording
from maglev.identification.regressors import ESTIMATED_STAGES, estimated_stage
from plant_fmu.guide import GuideFriction
from plant_fmu.ripple import Ripple
from pmlsm.stage_description import StageDescription

pytestmark = pytest.mark.usefixtures("slow")

AS_ASSUMED = 2.0   # of the friction that a description has; that of the stages of `trial`


def described(stage: str, times: float) -> StageDescription:
    """A description with so many times the Coulomb friction."""
    found = ESTIMATED_STAGES[stage].described
    return replace(found, axes=tuple(
        replace(axis, friction=replace(axis.friction, coulomb=times * axis.friction.coulomb)) for axis in found.axes))


@cache
def real(stage: str, method: str = "reduced") -> tuple[Identification, Data]:
    """A stage with all effects, identified by a description that has them as they are."""
    data = trial(stage, "real")
    recording = replace(data.recording, stage=estimated_stage(described(stage, AS_ASSUMED)))
    return identify(recording, method, match=True), data


@pytest.mark.thorough
@pytest.mark.parametrize(("stage", "method"), [("2dof", "reduced"), ("2dof", "fsdi"),
                                             pytest.param("3dof", "reduced", marks=pytest.mark.thorough)])
def test_the_truth_is_within_the_uncertainty(stage: str, method: str) -> None:
    """Scatter alone is not where it is: constants are up to twenty standard errors away."""
    found, data = real(stage, method)
    away = {name: abs(found.estimate.final[name] - value) for name, value in data.truth.items()}
    assert max(away[name] / found.standard_error[name] for name in away) > 5.0
    for name, distance in away.items():
        assert distance < found.uncertainty[name], name
        # It is no bound that holds for whatever comes: scatter, and the sum of effects some of which cancel.
        assert found.left_out[name] < 0.6 * found.estimate.final[name]


@pytest.mark.thorough
@pytest.mark.parametrize("stage", ["2dof", pytest.param("3dof", marks=pytest.mark.thorough)])
def test_it_bounds_what_a_stage_with_the_effects_gives_otherwise(stage: str) -> None:
    """Simulated and identified with and without them, and with one after the other switched off."""
    found, data = real(stage)
    without = identify(trial(stage, "encoder").recording, match=True)
    for name, value in found.estimate.final.items():
        difference = abs(value - without.estimate.final[name])
        scatter = 2.0 * (found.standard_error[name] + without.standard_error[name])
        assert difference < found.left_out[name] + scatter, name
    # The thrust constants are off by friction, nearly all of it, and the bound says how much.
    assert found.left_out["C1"] == pytest.approx(data.truth["C1"] - found.estimate.final["C1"], rel=0.2)


@pytest.mark.thorough
@pytest.mark.parametrize("stage", ["2dof", "3dof"])
def test_told_of_the_effects_the_estimator_finds_the_truth(stage: str) -> None:
    """The bias, with its sign, is what the estimate is off by."""
    found, data = real(stage)
    for name, value in list(data.truth.items())[:-1]:   # the last, of iron, is lost in what friction leaves
        assert abs((found.estimate.final[name] - found.bias[name]) / value - 1.0) < 0.025, name
        assert abs(found.bias[name]) <= found.left_out[name] * (1.0 + 1e-9)


def varied(seed: int, times: float) -> Data:
    """A 2-DOF stage with other constants, and 0.6 to 1 times so many times the effects that are described."""
    random = np.random.default_rng(seed)
    scale = {name: random.uniform(0.95, 1.05) for name in ESTIMATED_STAGES["2dof"].constants}
    shares = times * random.uniform(0.6, 1.0, 5)
    signs = random.uniform(-1.0, 1.0, 2)

    def adjust(stage: Any) -> None:
        for axis, coulomb, viscous, bias in zip((stage.v, stage.h), shares[:2], shares[2:4], signs, strict=True):
            axis.friction.coulomb *= coulomb
            axis.friction.viscous *= viscous
            axis.bias *= times * bias
        stage.attraction_modulation *= shares[4]

    return record("2dof", 10.0, 0.5e-3, ideal=False, scale=scale, adjust=adjust)


@pytest.mark.few(2)
@pytest.mark.parametrize("times", [1.0, AS_ASSUMED], ids=["as described", "twice"])
@pytest.mark.parametrize("seed", range(15))
def test_the_uncertainty_covers_stages_as_described_and_others_are_noticed(seed: int, times: float) -> None:
    data = varied(seed, times)
    found = identify(data.recording, match=True)
    for name, value in data.truth.items():
        assert abs(found.estimate.final[name] - value) < found.uncertainty[name], name
    noticed = [warning for warning in found.warnings if "contradicts the description" in warning]
    assert bool(noticed) == (times > 1.0)
    if noticed:   # at least 1.2 times the friction of both axes
        assert any("times the friction" in warning for warning in noticed)


def test_a_stage_without_effects_leaves_nothing_out() -> None:
    data = record("2dof", 2.0, 1e-3)
    plain = ESTIMATED_STAGES["2dof"].described
    smooth = replace(plain, modulation=0.0, axes=tuple(
        replace(axis, bias=0.0, friction=replace(axis.friction, coulomb=0.0, viscous=0.0),
                ripple=replace(axis.ripple, amplitude=0.0)) for axis in plain.axes))
    found = identify(replace(data.recording, stage=estimated_stage(smooth)), velocities=data.velocity)
    assert set(found.left_out.values()) == {0.0}
    assert found.uncertainty == {name: 2.0 * error for name, error in found.standard_error.items()}


def test_effects_of_unexcited_rows_are_unknown() -> None:
    data = record("2dof", 2.0, 1e-3)
    r = data.recording
    # Where h stands, the modulation passes for a weaker attraction: nothing tells them apart.
    still = MotionRecording(r.stage, r.time, np.stack([r.positions[:, 0], np.full(len(r.time), 4e-3)], axis=1), r.i_d,
                            r.i_q)
    found = identify(still)
    assert not any("modulation" in warning for warning in found.warnings)
    assert found.left_out["C1"] == np.inf
    assert np.isfinite([found.left_out[name] for name in ("C2", "C3", "C4")]).all()


def test_the_effects_are_those_of_the_plant() -> None:
    """Along a motion: the guide by scipy's integration of its equation, as the plant's part has it."""
    axis = ESTIMATED_STAGES["2dof"].described.axes[1]
    t = np.linspace(0.0, 1.2, 6001)   # to and fro
    x, v = 0.02 * np.sin(pi * t) + 0.004 * np.sin(7.0 * t), 0.02 * pi * np.cos(pi * t) + 0.028 * np.cos(7.0 * t)
    guide = GuideFriction(axis.friction.coulomb, axis.friction.presliding, axis.friction.viscous)
    solved = solve_ivp(lambda time, w: guide.slide(0.0, w[0], np.interp(time, t, v))[1], (0.0, t[-1]), [0.0],
                       t_eval=t, max_step=2e-4, rtol=1e-8, atol=1e-10)
    expected = [-guide.slide(0.0, w, rate)[0] / axis.mass for w, rate in zip(solved.y[0], v, strict=True)]
    assert friction(axis, x, v) == pytest.approx(np.array(expected), abs=2e-3 * np.ptp(expected))
    wavy = replace(axis, ripple=replace(axis.ripple, amplitude=0.3, period=0.01))
    part = Ripple(0.3, 0.01)
    assert ripple(wavy, x, v) == pytest.approx([part.acceleration(place) for place in x.tolist()])
