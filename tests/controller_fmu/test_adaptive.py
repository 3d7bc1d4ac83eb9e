"""The adaptive regulators: the fixed one while frozen, the true constants under excitation, and no others without."""

import math
from itertools import pairwise
from operator import attrgetter
from typing import Any

import numpy as np
import pytest
from direct_loop import LAYOUTS, simulate
from estimator_run import PLACES
from hypothesis import given
from hypothesis import strategies as st
from motor import MOTOR
from named_controllers import (
    AdaptiveRegulator2DOF,
    AdaptiveRegulator3DOF,
    AdaptiveRegulator5DOF,
    Estimator2DOF,
    Regulator2DOF,
    Regulator3DOF,
    Regulator5DOF,
)
from named_stage import Stage2DOF, Stage3DOF

from controller_fmu.adaptation import Adaptation, Travel, followed
from controller_fmu.constant_estimate import ConstantEstimate
from controller_fmu.status import BAD_GEOMETRY, BAD_PLACES, STEP_MISFIT, STEPPED
from maglev.fmi.definition import read

Adaptive = AdaptiveRegulator2DOF | AdaptiveRegulator3DOF
PAIRS: list[tuple[type, type]] = [(AdaptiveRegulator2DOF, Regulator2DOF), (AdaptiveRegulator3DOF, Regulator3DOF),
                                  (AdaptiveRegulator5DOF, Regulator5DOF)]
CONSTANTS = ("C1", "C2", "C3", "C4", "C5")


class Seen:
    """An adaptive regulator as a controller is called: its ports are those of the regulator within."""

    def __init__(self, adaptive: Any):
        self.adaptive = adaptive
        self.start, self.step = adaptive.start, adaptive.step

    def __getattr__(self, name: str) -> Any:
        return getattr(self.adaptive.regulator, name)


def measured(regulator: Any) -> list[str]:
    """Places of what a regulator measures: the gaps first, as many as it has."""
    gaps = [f"{name}.gap_measured" for name in regulator.parts if name.endswith("_place")]
    axes = ["x", "z"] if gaps else [name for name in regulator.parts if name in ("v", "h", "y", "x", "z")]
    return [*gaps, *(f"{axis}.measured" for axis in axes)]


def put(block: Any, place: str, value: float) -> None:
    owner, _, name = place.rpartition(".")
    setattr(attrgetter(owner)(block), name, value)


@pytest.mark.parametrize(("adaptive", "fixed"), PAIRS)
def test_frozen_it_is_the_fixed_regulator(adaptive: type, fixed: type) -> None:
    """Every command, to the bit: at rest, far away with all at its limit, and after a trip."""
    learning, plain = adaptive(), fixed()
    learning.adaptation.active = False
    for regulator in (learning.regulator, plain):
        regulator.trip_error = 20e-3
    assert learning.start() == plain.start() == STEPPED
    motors = [name for name, part in plain.parts.items() if hasattr(part, "i_a_cmd")]
    places, dt = measured(plain), plain.sample_time
    gaps = [place for place in places if "gap" in place] or places[:1]
    rest = {place: attrgetter(place)(plain) for place in places}
    random = np.random.default_rng(3)
    seen = set()
    for k in range(600):
        size = 1e-4 if k < 200 else 6e-3 if k < 400 else 2e-2
        for place in places:
            value = rest[place] + size * random.uniform(-1.0, 1.0 if place in gaps else 2.0)
            put(plain, place, value)
            put(learning.regulator, place, value)
        assert learning.step(k * dt, dt) == plain.step(k * dt, dt) == STEPPED
        for motor in motors:
            assert vars(getattr(learning.regulator, motor)) == vars(getattr(plain, motor)), (k, motor)
        seen.add((plain.saturated, plain.tripped))
    assert seen == {(False, False), (True, False), (False, True)}
    assert learning.adaptation.frozen


def sines(centre: float, *terms: tuple[float, float]) -> Any:
    """Reference of sinusoids, amplitude (m) and rad/s, and its rate."""
    return lambda t: (centre + math.fsum(a * math.sin(w * t) for a, w in terms),
                      math.fsum(a * w * math.cos(w * t) for a, w in terms))


def idle(stage: Any, axes: tuple[str, ...], motors: tuple[str, ...]) -> None:
    """Switch off what the model of the regulator leaves out."""
    stage.attraction_modulation = stage.encoder.resolution = 0.0
    for name in axes:
        axis = getattr(stage, name)
        axis.bias = axis.friction.coulomb = axis.friction.viscous = axis.ripple.amplitude = 0.0
    for name in motors:
        getattr(stage, name).amplifier.lag = 0.0


def nominals(stage: int, controller: Any) -> list[float]:
    """Constants from which those of a regulator are adapted."""
    return [read(controller.estimator, PLACES[stage][f"{name}_start"]) for name in CONSTANTS[:stage + 2]]


@pytest.mark.thorough
@pytest.mark.parametrize(("description", "stage", "adaptive", "factors", "seconds"), [
    (2, Stage2DOF, AdaptiveRegulator2DOF, (0.75, 1.1, 0.9, 1.0), 14.0),
    (3, Stage3DOF, AdaptiveRegulator3DOF, (0.8, 1.15, 0.95, 1.1, 1.0), 9.0)])
def test_it_finds_the_constants_of_a_stage(slow: None, description: int, stage: type, adaptive: type,
                                           factors: tuple[float, ...], seconds: float) -> None:
    """Of a stage as the model says except for the constants that are adapted: from a run, by its commands."""
    axes, motors, _ = LAYOUTS[description]
    plant, controller = stage(), adaptive()
    idle(plant, axes, motors)
    true = [factor * nominal for factor, nominal in zip(factors, nominals(description, controller), strict=True)]
    for name, value in zip(CONSTANTS, true, strict=False):
        setattr(plant, name, value)
    centre = getattr(plant, axes[0]).position_start
    references = {axes[0]: sines(centre, (1e-3, 4.0), (1e-3, 7.0)),
                  **{name: sines(0.0, (10e-3, 3.0 + k), (10e-3, 7.0)) for k, name in enumerate(axes[1:])}}
    errors = simulate(description, Seen(controller), plant, references, seconds)
    assert np.abs(errors).max() < 5e-3
    found = [getattr(controller.regulator, name) for name, _ in zip(CONSTANTS, factors, strict=False)]
    assert found[:-1] == pytest.approx(true[:-1], rel=0.01)
    assert found[-1] == true[-1]   # coils and iron: not adapted


@pytest.mark.few(1)
@pytest.mark.parametrize(("description", "stage", "adaptive"), [(2, Stage2DOF, AdaptiveRegulator2DOF),
                                                        (3, Stage3DOF, AdaptiveRegulator3DOF)])
def test_without_excitation_the_constants_stay(slow: None, description: int, stage: type, adaptive: type) -> None:
    """Held at one place by a stage with other constants, friction and bias, which the estimates do not survive."""
    axes, _, _ = LAYOUTS[description]
    controller = adaptive()
    simulate(description, Seen(controller), stage(),
             {name: sines(getattr(stage(), name).position_start) for name in axes}, 4.0)
    own = CONSTANTS[:description + 2]
    assert [getattr(controller.regulator, name) for name in own] == nominals(description, controller)
    assert not controller.adaptation.frozen
    assert max(abs(read(controller.estimator, PLACES[description][name]) / nominal - 1.0)
               for name,
               nominal in zip(own, nominals(description, controller), strict=True)) > 0.1, "they would have moved"


def test_misleading_data_change_nothing() -> None:
    """At a stop, for the pause after it, and for good after a trip; the observer continues."""
    block = AdaptiveRegulator2DOF()
    assert block.start() == STEPPED
    regulator, estimator = block.regulator, block.estimator

    def at(gap: float, k: int) -> tuple[float, ...]:
        regulator.v.measured = gap
        assert block.step(k * 5e-4, 5e-4) == STEPPED
        sigma = estimator.v.information
        return (estimator.h.thrust.value, estimator.v.attraction.value, estimator.v.coils.value, sigma.s11, sigma.s21,
                sigma.s22, estimator.h.information)

    block.travels[0].upper = 20.1e-3   # so near that no command comes to its limit
    for k in range(20):
        before = at(20e-3 + 2e-6 * k, k)
    assert not block.adaptation.frozen
    velocity = estimator.v.velocity
    assert at(20.1e-3, 20) == before
    assert block.adaptation.frozen
    assert estimator.v.velocity != velocity
    for k in range(21, 220):   # 0.1 s
        assert at(20.05e-3, k) == before
        assert block.adaptation.frozen
    assert any(at(20e-3, k) != before for k in range(220, 224))
    assert not block.adaptation.frozen
    regulator.trip_error = 1e-3
    at(22e-3, 224)
    before = at(22e-3, 225)
    assert all(at(20e-3, k) == before for k in range(226, 500))


@given(st.floats(1e-3, 1e3), st.floats(0.0, 0.9), st.floats(0.0, 1.0), st.lists(st.floats(-1e6, 1e6), min_size=1))
def test_a_constant_stays_within_its_bounds_and_never_jumps(nominal: float, largest: float, share: float,
                                                            estimates: list[float]) -> None:
    constant = ConstantEstimate(nominal, 1.0)
    values = [nominal]
    for constant.value in estimates:
        values.append(followed(values[-1], constant, share, largest))
    slack = 1e-12 * nominal
    assert all((1.0 - largest) * nominal - slack <= value <= (1.0 + largest) * nominal + slack for value in values)
    assert all(abs(after - before) <= share * 2.0 * largest * nominal + slack for before, after in pairwise(values))
    target = min(max(estimates[0], (1.0 - largest) * nominal), (1.0 + largest) * nominal)
    assert values[1] == pytest.approx(nominal + share * (target - nominal), abs=slack)


def test_the_share_of_a_sample_is_that_of_the_time_constant() -> None:
    adaptation = Adaptation()
    adaptation.time = 0.25
    assert (1.0 - adaptation.share(5e-4)) ** 500 == pytest.approx(math.exp(-1.0), rel=1e-12)


def test_travel() -> None:
    travel = Travel(-1e-3, 2e-3)
    assert [travel.ends(place) for place in (-1.1e-3, -1e-3, -0.9e-3, 1.9e-3, 2e-3, 3e-3)] == [
        True, True, False, False, True, True]


def test_both_models_of_the_motor_are_one() -> None:
    """The estimator takes in samples with the geometry of the regulator's motor."""
    block, alone = AdaptiveRegulator2DOF(), Estimator2DOF()
    block.regulator.geometry.slot_width = alone.geometry.slot_width = 0.7 * MOTOR.slot_width
    assert block.start() == alone.start() == STEPPED
    block.regulator.v.measured = alone.v.measured = 21e-3
    for k in range(3):
        assert block.step(k * 5e-4, 5e-4) == STEPPED
    alone.sample()
    assert block.estimator.v.filter1.output == alone.v.filter1.output
    alone.take(block.estimator.layout)
    assert block.estimator.v.filter1.output != alone.v.filter1.output


def test_parts_share_their_common_parameters() -> None:
    """The estimator of a platform that tilts has the regulator's places, clock and observer."""
    block = AdaptiveRegulator5DOF()
    for name in ("alpha1_place.x", "beta2_place.z", "observer.time1", "observer.time2", "sample_time"):
        put(block, f"regulator.{name}", 1.5 * attrgetter(f"regulator.{name}")(block) + 1e-4)
    block.estimator.y.attraction.guess = 300.0
    assert block.start() == STEPPED
    for name in ("alpha1_place.x", "beta2_place.z", "observer.time1", "observer.time2", "sample_time",
                 "observer.share1", "alpha2_place.share_roll"):
        assert attrgetter(name)(block.estimator) == attrgetter(name)(block.regulator), name
    assert block.estimator.y.attraction.value == block.regulator.C3 == 300.0
    assert block.step(0.0, 0.7 * block.regulator.sample_time) == STEP_MISFIT


def test_refusals_are_those_of_the_regulator() -> None:
    block = AdaptiveRegulator5DOF()
    block.regulator.geometry.slot_width = 1.0
    assert block.start() == BAD_GEOMETRY
    block = AdaptiveRegulator5DOF()
    for motor in ("alpha1", "alpha2", "beta1", "beta2"):
        getattr(block.regulator, f"{motor}_place").x = 0.0
    assert block.start() == BAD_PLACES
