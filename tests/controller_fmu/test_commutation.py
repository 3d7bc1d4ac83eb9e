"""Commutation alone: the plant gets back what was asked for, limit, sampling, refusals, a parabola, the scripts."""

import math
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import SCRIPTS, run_script
from fmu_access import put, refusal
from hypothesis import given
from hypothesis import strategies as st
from motor import MOTOR
from named_controllers import Commutation2DOF, Commutation3DOF
from named_stage import Stage2DOF, Stage3DOF
from reference_stage import shape_functions

from controller_fmu.status import STEP_MISFIT
from maglev.cosim.fmu import Fmu
from pmlsm.dq_transform import clarke, park
from pmlsm.sine_cosine import sine_cosine

Load = Callable[[str], Fmu]
Commutation = Commutation2DOF | Commutation3DOF
Kind = type[Commutation2DOF] | type[Commutation3DOF]

PAIRS = {Commutation2DOF: (("motor", "h"),), Commutation3DOF: (("alpha", "x"), ("beta", "z"))}
BOTH = pytest.mark.parametrize("kind", PAIRS)

amperes = st.floats(-20.0, 20.0)
metres = st.floats(-0.1, 0.1)
asked = st.lists(st.tuples(amperes, amperes, metres), min_size=2, max_size=2)


def ask(block: Commutation, wanted: list[tuple[float, float, float]]) -> None:
    """Set i_d, i_q (A) and displacement (m) of each motor."""
    for (motor, axis), (i_d, i_q, displacement) in zip(PAIRS[type(block)], wanted, strict=False):
        getattr(block, motor).i_d_reference, getattr(block, motor).i_q_reference = i_d, i_q
        getattr(block, axis).measured = displacement


def phases(motor: Any) -> tuple[float, float, float]:
    """Commands to the phases of a motor (A)."""
    return motor.i_a_cmd, motor.i_b_cmd, motor.i_c_cmd


def commands(block: Commutation) -> list[float]:
    """Every current that is commanded (A)."""
    motors = [getattr(block, motor).command for motor, _ in PAIRS[type(block)]]
    return [i for motor in motors for i in (*phases(motor), motor.i_d_cmd, motor.i_q_cmd)]


def started(load: Load, kind: Kind) -> Fmu:
    """FMU of a block, initialised."""
    component = load(kind.__name__)
    component.initialise({}, 0.0, 1.0)
    return component


@BOTH
@given(wanted=asked)
def test_the_plant_gets_the_reference_currents(kind: Kind, wanted: list[tuple[float, float, float]]) -> None:
    block = kind()
    ask(block, wanted)
    assert block.start() == block.step(0.0, block.sample_time) == 0
    for (name, _), (i_d, i_q, displacement) in zip(PAIRS[kind], wanted, strict=False):
        motor = getattr(block, name).command
        angle = MOTOR.electrical_angle(displacement)
        assert park(*clarke(*phases(motor)), *sine_cosine(angle)) == pytest.approx((i_d, i_q), abs=1e-13)
        assert (motor.i_d_cmd, motor.i_q_cmd) == (i_d, i_q)
    assert not block.saturated


@BOTH
@given(wanted=asked, limit=st.floats(0.1, 25.0))
def test_limit(kind: Kind, wanted: list[tuple[float, float, float]], limit: float) -> None:
    """On i_d and i_q of each motor by itself."""
    block = kind()
    block.current_limit = limit
    ask(block, wanted)
    block.step(0.0, block.sample_time)
    wanted = wanted[:len(PAIRS[kind])]
    for (name, _), (i_d, i_q, displacement) in zip(PAIRS[kind], wanted, strict=True):
        motor, limited = getattr(block, name).command, tuple(np.clip((i_d, i_q), -limit, limit))
        assert (motor.i_d_cmd, motor.i_q_cmd) == limited
        angle = sine_cosine(MOTOR.electrical_angle(displacement))
        assert park(*clarke(*phases(motor)), *angle) == pytest.approx(limited, abs=1e-13)
    assert block.saturated == any(abs(i) > limit for each in wanted for i in each[:2])


@BOTH
@pytest.mark.parametrize("motor", [0, 1])
@pytest.mark.parametrize("component", ["i_d_reference", "i_q_reference"])
def test_saturated_comes_and_goes_with_each_reference(kind: Kind, motor: int, component: str) -> None:
    block = kind()
    block.current_limit = 2.0
    name = PAIRS[kind][motor % len(PAIRS[kind])][0]
    for k, (current, beyond) in enumerate([(2.0, False), (-2.1, True), (-2.0, False), (2.1, True), (0.0, False)]):
        setattr(getattr(block, name), component, current)
        block.step(k * block.sample_time, block.sample_time)
        assert block.saturated == beyond


@BOTH
@pytest.mark.parametrize("parts", [1, 2, 5])
def test_commands_hold_between_samples(kind: Kind, parts: int) -> None:
    block, sampled = kind(), kind()
    dt = block.sample_time / parts
    for k in range(4 * parts):
        now = [(1.0 + k, 2.0 - k, 1e-3 * k), (3.0 - k, 0.5 * k, -2e-3 * k)]
        ask(block, now)
        assert block.step(k * dt, dt) == 0
        if k % parts == 0:
            ask(sampled, now)
            sampled.step(k * dt, block.sample_time)
        assert commands(block) == commands(sampled)


@BOTH
@pytest.mark.parametrize("misfit", [0.7, 1.001, 2.0])
def test_step_that_misfits(kind: Kind, misfit: float) -> None:
    block = kind()
    ask(block, [(1.0, 1.0, 0.0)] * 2)
    assert block.step(0.0, misfit * block.sample_time) == STEP_MISFIT
    assert commands(block) == [0.0] * len(commands(block))


@BOTH
@pytest.mark.parametrize("value", [math.inf, -1e9])
def test_input_that_is_no_sensible_number(load_either: Load, kind: Kind, value: float) -> None:
    for motor, axis in PAIRS[kind]:
        for variable in (f"{motor}.i_d_reference", f"{motor}.i_q_reference", f"{axis}.measured"):
            component = started(load_either, kind)
            text = refusal(component, partial(put, component, {variable: value}))
            assert f"{variable} = {value}" in text
            assert "expected a number from" in text


@BOTH
def test_step_that_the_fmu_refuses(load_either: Load, kind: Kind) -> None:
    component, size = started(load_either, kind), kind().sample_time
    text = refusal(component, lambda: component.instance.doStep(0.0, 0.7 * size))
    assert f"communication step = {0.7 * size} s, expected one that divides the controller's" in text
    assert f"sample_time = {size} s" in text


@BOTH
def test_parabola(kind: Kind) -> None:
    """(4.6): at a fixed gap a constant quadrature current accelerates the mover constantly, all along the stator."""
    block = kind()
    stage: Any = Stage2DOF() if kind is Commutation2DOF else Stage3DOF()
    gap_name, gap = ("v", 20e-3) if kind is Commutation2DOF else ("y", 25e-3)
    factor, current = (1.0, -0.5) if kind is Commutation2DOF else (2.0, -3.0)
    getattr(stage, gap_name).locked = True
    getattr(stage, gap_name).position_start = gap
    for motor, axis in PAIRS[kind]:
        moving = getattr(stage, axis)
        moving.bias = moving.friction.coulomb = moving.friction.viscous = 0.0
        moving.position_start = -50e-3
        getattr(stage, motor).amplifier.lag = 0.0
        getattr(block, motor).i_q_reference = current
    stage.encoder.resolution = 0.0
    assert block.start() == stage.start() == 0
    dt, steps = block.sample_time, 0
    while max(getattr(stage, axis).position for _, axis in PAIRS[kind]) < 50e-3:
        for _, axis in PAIRS[kind]:
            getattr(block, axis).measured = getattr(stage, axis).encoder
        assert block.step(steps * dt, dt) == 0
        for motor, _ in PAIRS[kind]:
            to = getattr(stage, motor)
            to.i_a_cmd, to.i_b_cmd, to.i_c_cmd = phases(getattr(block, motor).command)
        assert stage.step(steps * dt, dt) == 0
        steps += 1
    for (_, axis), constant in zip(PAIRS[kind], (stage.C1, stage.C2), strict=False):
        thrust = -factor * constant * shape_functions(gap)[0] * current
        travelled = 0.5 * thrust * (steps * dt)**2
        assert getattr(stage, axis).position == pytest.approx(-50e-3 + travelled, abs=2e-3 * travelled)


@pytest.mark.parametrize("stage", ["2dof", "3dof"])
def test_script(fmus: Path, tmp_path: Path, stage: str) -> None:
    """The command line gives the quadrature currents of its input file at the displacements of its input file."""
    out = tmp_path / "out.csv"
    run_script(f"commutation_{stage}.sh", fmus, out)
    result = np.genfromtxt(out, delimiter=",", names=True, dtype=float, deletechars="")
    given_inputs = np.genfromtxt(SCRIPTS / f"commutation_{stage}_inputs.csv", delimiter=",", names=True, deletechars="")
    kind = Commutation2DOF if stage == "2dof" else Commutation3DOF
    time = result["time"][:-1]
    assert len(time) == round(0.25 / kind().sample_time)
    for motor, axis in PAIRS[kind]:
        displacement = np.interp(time, given_inputs["time"], given_inputs[f"{axis}.measured"])
        for row, d in zip(result[1:], displacement, strict=True):
            currents = clarke(*(row[f"{motor}.i_{phase}_cmd"] for phase in "abc"))
            i_d, i_q = park(*currents, *sine_cosine(MOTOR.electrical_angle(float(d))))
            assert (i_d, i_q) == pytest.approx((0.0, given_inputs[f"{motor}.i_q_reference"][0]), abs=1e-9)
