"""Runs on both sides of each margin: the blocks with a gain, a lag or a delay between the stage and its measurement."""

from collections import deque
from collections.abc import Callable
from functools import cache
from math import tan
from typing import Any

import numpy as np
import pytest
from linear_blocks import measure, rest, smooth_stage, step_both
from named_blocks import named

from maglev.linear.linearise import linearise
from maglev.linear.loop import Loop, linearise_loop
from maglev.linear.margins import Margins
from maglev.linear.parameters import block_of, linear_stage

# Where the direct current is large and commutation with a wrong displacement turns it into the most thrust.
PLACES = {"2DOF": ("h", {"v": 12e-3}), "3DOF": ("x", {"y": 19e-3}), "5DOF": ("roll", {"y": 21e-3, "pitch": 3e-3})}
SECONDS, WINDOW = 6.0, 2.0       # s
BEGINNING, LOST = 1e-8, 1e-6   # m; far below where a limit makes the loop another one
Change = Callable[[float], float]


@cache
def loop_of(stage: str) -> Loop:
    return linearise_loop(f"Plant{stage}", f"Regulator{stage}", PLACES[stage][1])


def growth(stage_name: str, change: Change) -> float:
    """How much larger than in its second and third second the error is in its last two; inf if the stage is lost.

    `change` makes the measured deviation (m) of the true one, sample by sample.
    """
    plant, axis, loop = f"Plant{stage_name}", PLACES[stage_name][0], loop_of(stage_name)
    name = f"Regulator{stage_name}"
    controller, stage = named(block_of(name, {}), linear_stage(name)), smooth_stage(plant, True)
    assert controller.start() == 0
    rest(plant, controller, stage, loop)
    at_rest = loop.plant.equilibrium.positions[axis]
    getattr(stage, axis).position += BEGINNING
    errors: list[float] = []
    while len(errors) * controller.sample_time < SECONDS:
        errors.append(getattr(stage, axis).position - at_rest)
        measure(plant, controller, stage, axis, change(errors[-1]) - errors[-1])
        step_both(plant, controller, stage)
        if abs(errors[-1]) > LOST:
            return float("inf")
    window = int(WINDOW / controller.sample_time)
    begin = int(1.0 / controller.sample_time)
    return float(np.abs(errors[-window:]).max() / np.abs(errors[begin:begin + window]).max())


def delayed(samples: int) -> Change:
    past = deque([0.0] * samples)

    def change(value: float) -> float:
        past.append(value)
        return past.popleft()

    return change


def turned(angle: float, frequency: float, sample_time: float) -> Change:
    """All-pass filter (c + 1/z)/(1 + c/z), which lags by an angle (rad) at a frequency (rad/s)."""
    ratio = tan(0.5 * angle) / tan(0.5 * frequency * sample_time)
    c, last = (1.0 - ratio) / (1.0 + ratio), [0.0, 0.0]

    def change(value: float) -> float:
        last[:] = value, c * value + last[0] - c * last[1]
        return last[1]

    return change


CHANGES: dict[str, Callable[[Margins, float, float], Change]] = {
    "less gain": lambda margins, far, _: lambda value: margins.gain_down / far * value,
    "more gain": lambda margins, far, _: lambda value: margins.gain_up * far * value,
    "phase": lambda margins, far, dt: turned(margins.phase * far, margins.phase_frequency, dt),
    "delay": lambda margins, far, dt: delayed(int(margins.delay * far / dt))}


# Gains of the 3-DOF stage say what those of the 2-DOF one do; those of the 5-DOF stage are run by native FMUs, in a
# fifth of the time: test_tilting.py. Lags at its tilts take the time of those of both other stages, whose margins are
# computed and run by the same code.
@pytest.mark.few(1)
@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(("stage", "changed"), [
    *(("2DOF", changed) for changed in CHANGES), ("3DOF", "delay"),
    *(pytest.param(stage, changed, marks=pytest.mark.thorough) for stage, changed in (
        ("3DOF", "less gain"), ("3DOF", "more gain"), ("3DOF", "phase"), ("5DOF", "phase"), ("5DOF", "delay")))])
def test_stable_within_a_tenth_of_the_margin_and_lost_beyond(stage: str, changed: str) -> None:
    margins, dt = loop_of(stage).margins(PLACES[stage][0]), loop_of(stage).plant.sample_time
    assert dt is not None
    within, beyond = (growth(stage, CHANGES[changed](margins, far, dt)) for far in (0.9, 1.1))
    assert within < 0.5
    assert beyond > 2.0


def test_margins_of_the_2dof_stage_at_12_mm() -> None:
    """Opened at the measurement, not at the command, which is commutated with the true displacement."""
    measured, command = (loop_of("2DOF").margins(name) for name in ("h", "motor.i_q"))
    assert (measured.gain_down, measured.gain_up) == pytest.approx((0.727, 19.5), rel=0.005)
    assert np.degrees(measured.phase) == pytest.approx(34.4, abs=0.3)
    assert measured.delay == pytest.approx(13.2e-3, abs=0.1e-3)
    assert (command.gain_down, command.gain_up) == pytest.approx((0.237, 21.4), rel=0.005)


@pytest.mark.few(1)
@pytest.mark.parametrize("stage", PLACES)
@pytest.mark.usefixtures("slow")
def test_the_same_with_phase_currents_as_commands(stage: str) -> None:
    """A controller that commutates itself has both uses of the measurement in its matrices."""
    place: Any = loop_of(stage).plant.equilibrium
    controller = linearise(f"Regulator{stage}", place, currents="phases")
    plant = linearise(f"Plant{stage}", place, currents="phases", hold=controller.sample_time)
    for axis in place.positions:
        theirs, ours = (vars(loop.margins(axis)) for loop in (Loop(plant, controller), loop_of(stage)))
        assert ours == {name: value if name == "at" else pytest.approx(value, rel=1e-4)
                        for name, value in theirs.items()}
