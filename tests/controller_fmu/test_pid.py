"""PID with pre-filter: designed poles, gains that are set, bumpless start, and the law written again from the page."""

import numpy as np
import pytest
from direct_loop import LAYOUTS
from hypothesis import given, settings
from hypothesis import strategies as st
from linear_model import linearised, thrusts, vertical_row
from named_controllers import PID2DOF, PID3DOF, Regulator2DOF, Regulator3DOF
from named_stage import Stage2DOF, Stage3DOF
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from controller_fmu.reference_prefilter import LARGEST_ANGLE, ReferencePrefilter
from controller_fmu.status import NO_EQUILIBRIUM, PREFILTER_TOO_FAST

PID = PID2DOF | PID3DOF
KINDS = [PID2DOF, PID3DOF]
AXES = {PID2DOF: ("v", "h"), PID3DOF: ("y", "x", "z")}
POLES = {PID2DOF: [(-8, -12, 50), (-6, -16, 46)], PID3DOF: [(-7, -10, 42), (-2, -7, 15), (-2, -7, 15)]}
# These have the constants of the model as well.
MODEL: dict[type, type[Regulator2DOF | Regulator3DOF]] = {PID2DOF: Regulator2DOF, PID3DOF: Regulator3DOF}


def polynomial(pole: float, real: float, imaginary: float) -> np.ndarray:
    return np.polymul([1.0, -pole], [1.0, -2.0 * real, real**2 + imaginary**2])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("setpoint", [18e-3, 20e-3, 25e-3])
def test_poles_where_designed(kind: type[PID], setpoint: float) -> None:
    """e'' = α e + β (kp e + ki ∫e + kd ė) has the polynomial s³ − β kd s² − (α + β kp) s − β ki."""
    controller = kind()
    controller.setpoint = setpoint
    assert controller.start() == 0
    model = MODEL[kind]()
    rows = [linearised(model, setpoint), *((0.0, b) for b in thrusts(model, setpoint))]
    for name, (alpha, beta), poles in zip(AXES[kind], rows, POLES[kind], strict=True):
        axis = getattr(controller, name)
        ours = np.array([1.0, -beta * axis.kd, -(alpha + beta * axis.kp), -beta * axis.ki])
        assert ours == pytest.approx(polynomial(*poles), rel=1e-9), name


@pytest.mark.parametrize("kind", KINDS)
def test_gains_that_are_set_stay(kind: type[PID]) -> None:
    controller = kind()
    name = AXES[kind][0]
    designed = getattr(controller, name).kp
    getattr(controller, name).kp = 1.5 * designed
    controller.C3 *= 1.1
    assert controller.start() == controller.start() == 0
    assert getattr(controller, name).kp == 1.5 * designed
    assert getattr(controller, AXES[kind][1]).kp == getattr(kind(), AXES[kind][1]).kp


@pytest.mark.parametrize("kind", KINDS)
def test_design_follows_its_parameters(kind: type[PID]) -> None:
    """Another model, setpoint or pole gives other gains, and going back gives the first ones back."""
    controller, first = kind(), kind()
    name = AXES[kind][0]
    axis = getattr(controller, name)
    for attribute, value in (("C3", 9.0 if kind is PID2DOF else 300.0), ("setpoint", 22e-3)):
        before = getattr(controller, attribute)
        setattr(controller, attribute, value)
        assert controller.start() == 0
        assert axis.kp != getattr(first, name).kp
        setattr(controller, attribute, before)
        assert controller.start() == 0
        assert (axis.kp, axis.ki, axis.kd) == tuple(getattr(getattr(first, name), k) for k in ("kp", "ki", "kd"))
    axis.pole = -20.0
    assert controller.start() == 0
    assert abs(axis.ki) > abs(getattr(first, name).ki)


@pytest.mark.parametrize("kind", KINDS)
def test_refusals_of_the_start(kind: type[PID]) -> None:
    controller = kind()
    getattr(controller, AXES[kind][1]).prefilter = 1.001 * LARGEST_ANGLE / controller.sample_time
    assert controller.start() == PREFILTER_TOO_FAST
    controller = kind()
    controller.setpoint, controller.C3 = 9e-3, 0.1 if kind is PID2DOF else 1e4
    assert controller.start() == NO_EQUILIBRIUM


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("gap", [18e-3, 22e-3, 26e-3])
def test_first_command_is_the_equilibrium(kind: type[PID], gap: float) -> None:
    controller = kind()
    controller.current_limit = 0.0
    assert controller.start() == 0
    for name, error in zip(AXES[kind], (1e-3, -2e-3, 3e-3), strict=False):
        axis = getattr(controller, name)
        axis.measured = gap if name in "vy" else 5e-3
        axis.reference = axis.measured - error
        axis.prefilter = 20.0
    assert controller.step(0.0, controller.sample_time) == 0
    held = brentq(lambda i: vertical_row(MODEL[kind](), gap, i), -12, 12)
    for motor in [controller.motor] if isinstance(controller, PID2DOF) else [controller.alpha, controller.beta]:
        assert motor.i_d_cmd == pytest.approx(held, abs=1e-9)
        assert motor.i_q_cmd == pytest.approx(0.0, abs=1e-9)


@settings(max_examples=15)
@given(st.floats(0.5, 300.0), st.floats(-0.05, 0.05))
@pytest.mark.usefixtures("slow")
def test_prefilter_has_unit_gain_and_no_overshoot(corner: float, reference: float) -> None:
    prefilter, largest = ReferencePrefilter(), 0.0
    prefilter.seed(0.0)
    for _ in range(int(30.0 / corner / 2e-4) + 1):
        prefilter.update(reference, 0.0, corner, 2e-4)
        largest = max(largest, abs(prefilter.position))
    assert prefilter.position == pytest.approx(reference, rel=1e-9, abs=1e-15)
    assert largest <= abs(reference) * (1.0 + 1e-9)


def test_prefilter_against_the_differential_equation() -> None:
    """First order in the sample time: halving it halves the distance to scipy's solution."""
    omega, errors = 25.0, []
    exact = solve_ivp(lambda t, y: [y[1], omega**2 * (np.sin(5 * t) - y[0]) - 2 * omega * y[1]], (0, 1), [0, 0],
                      rtol=1e-11, atol=1e-13).y[:, -1]
    for dt in (2e-4, 1e-4):
        prefilter = ReferencePrefilter()
        for k in range(round(1 / dt)):
            prefilter.update(np.sin(5 * k * dt), 0.0, omega, dt)
        errors.append(abs(prefilter.position - exact[0]))
    assert errors[0] < 5e-4
    assert errors[1] / errors[0] == pytest.approx(0.5, rel=0.05)


@pytest.mark.parametrize("antiwindup", [True, False])
def test_integral_holds_while_limited(antiwindup: bool) -> None:
    controller = PID2DOF()
    controller.antiwindup = antiwindup
    controller.start()
    controller.step(0.0, 5e-4)
    controller.h.measured = 0.2
    before = controller.h.integral
    controller.step(5e-4, 5e-4)
    assert controller.motor.excess_q != 0.0
    assert controller.h.integral == (before if antiwindup else before + 5e-4 * 0.2)


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("description", [2, 3])
def test_every_command_of_a_run(description: int) -> None:
    """The law written again, with matrices of gains from numpy's polynomials: 1 s, steps on all axes, pre-filter on."""
    axes, motors, dt = LAYOUTS[description]
    controller, stage = (PID2DOF(), Stage2DOF()) if description == 2 else (PID3DOF(), Stage3DOF())
    corner = 30.0
    for name in axes:
        getattr(controller, name).prefilter = corner
    assert controller.start() == stage.start() == 0
    model = MODEL[type(controller)]()
    rows = [linearised(model, 20e-3 if description == 2 else 25e-3),
            *((0.0, b) for b in thrusts(model, 20e-3 if description == 2 else 25e-3))]
    gains = []
    for (alpha, beta), poles in zip(rows, POLES[type(controller)], strict=True):
        a1, a2, a3 = polynomial(*poles)[1:]
        gains.append([-(a2 + alpha) / beta, -a3 / beta, -a1 / beta])
    kp, ki, kd = np.array(gains).T
    share = 1 - np.exp(-dt / 1e-3)
    first = np.array([getattr(stage, name).encoder for name in axes])
    low, velocity, filtered, rate = first.copy(), np.zeros(len(axes)), first.copy(), np.zeros(len(axes))
    held = brentq(lambda i: vertical_row(model, first[0], i), -12, 12)
    integral = np.array([held, *np.zeros(len(axes) - 1)]) / ki
    worst = 0.0
    for k in range(round(1.0 / dt)):
        reference = first + (np.array([1e-3, 8e-3, -8e-3])[:len(axes)] if k * dt >= 0.1 else 0.0)
        measured = np.array([getattr(stage, name).encoder for name in axes])
        for name, r, m in zip(axes, reference, measured, strict=True):
            getattr(controller, name).reference, getattr(controller, name).measured = float(r), float(m)
        assert controller.step(k * dt, dt) == 0
        change = share * (measured - low)
        low += change
        velocity += share * (change / dt - velocity)
        rate += dt * (corner**2 * (reference - filtered) - 2 * corner * rate)
        filtered += dt * rate
        u = kp * (measured - filtered) + ki * integral + kd * (velocity - rate)
        integral += dt * (measured - filtered)
        if description == 2:
            u = np.clip(u, -4.0, 4.0)
        ours = [getattr(controller, motors[0]).i_d_cmd, *(getattr(controller, name).i_q_cmd for name in motors)]
        worst = max(worst, float(np.abs(np.array(ours) - u).max()))
        assert [getattr(controller, name).error for name in axes] == list(measured - reference)
        for name in motors:
            to, source = getattr(stage, name), getattr(controller, name)
            to.i_a_cmd, to.i_b_cmd, to.i_c_cmd = source.i_a_cmd, source.i_b_cmd, source.i_c_cmd
        assert stage.step(k * dt, dt) == 0
    assert worst < 1e-7
