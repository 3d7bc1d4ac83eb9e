"""Linear and scheduled laws: the same poles as the nonlinear law at the setpoint, regions, refusals."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linear_model import linearised, thrusts, vertical_row
from motor import MOTOR
from named_controllers import Regulator2DOF, Regulator3DOF
from reference_stage import shape_functions
from scipy.differentiate import derivative
from scipy.optimize import brentq

from controller_fmu.status import LINEAR, NO_EQUILIBRIUM, SCHEDULED
from pmlsm.gap_slopes import gap_slopes

Regulator = Regulator2DOF | Regulator3DOF
KINDS = [Regulator2DOF, Regulator3DOF]
AXES = {Regulator2DOF: ("v", "h"), Regulator3DOF: ("y", "x", "z")}
SETPOINTS = [16e-3, 18e-3, 20e-3, 22.5e-3, 25e-3, 27e-3, 30e-3]


def current_gains(regulator: Regulator) -> np.ndarray:
    """Gains of [e, ė, ξ1, ξ2, ξ3] on the current of each axis, shape (axes, 5), by trying them one by one."""
    names = AXES[type(regulator)]
    rows = np.zeros((len(names), 5))
    for row, name in enumerate(names):
        axis = getattr(regulator, name)
        for column in range(5):
            unit = [float(column == k) for k in range(5)]
            axis.error, axis.error_rate, axis.model.xi1, axis.model.xi2, axis.model.xi3 = unit
            rows[row, column] = regulator.currents(*(getattr(regulator, n).demand() for n in names))[row]
        axis.error = axis.error_rate = axis.model.xi1 = axis.model.xi2 = axis.model.xi3 = 0.0
    return rows


def loop_polynomial(alpha: float, beta: float, gains: np.ndarray, omega0: float) -> np.ndarray:
    """Characteristic polynomial of e'' = α e + β K x, ξ' = φ ξ + N e."""
    matrix = np.zeros((5, 5))
    matrix[0, 1] = 1.0
    matrix[1] = beta * gains
    matrix[1, 0] += alpha
    matrix[2, 3] = matrix[3, 4] = matrix[4, 0] = 1.0
    matrix[4, 3] = -omega0**2
    # Faddeev–LeVerrier: exact except for rounding, where the clustered eigenvalues would lose half of the digits.
    polynomial, product = [1.0], np.eye(5)
    for k in range(1, 6):
        product = matrix @ product
        polynomial.append(-np.trace(product) / k)
        product += polynomial[-1] * np.eye(5)
    return np.array(polynomial)


def nonlinear_polynomial(axis: object, omega0: float) -> np.ndarray:
    """Characteristic polynomial that the gains give a double integrator."""
    k1, k2, k3, k4, k5 = (getattr(axis, f"k{i}") for i in range(1, 6))
    return np.array([1.0, -k2, omega0**2 - k1, -(k2 * omega0**2 + k5), -(k1 * omega0**2 + k4), -(k3 + 1.0)])


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("setpoint", SETPOINTS)
def test_polynomials_equal_the_nonlinear_ones(kind: type[Regulator], setpoint: float) -> None:
    regulator = kind(LINEAR)
    regulator.setpoint = setpoint
    assert regulator.start() == 0
    alpha, beta = linearised(regulator, setpoint)
    rows = [(alpha, beta), *((0.0, b) for b in thrusts(regulator, setpoint))]
    for name, (a, b), gains in zip(AXES[kind], rows, current_gains(regulator), strict=True):
        ours = loop_polynomial(a, b, gains, regulator.omega0)
        assert ours == pytest.approx(nonlinear_polynomial(getattr(regulator, name), regulator.omega0), rel=1e-9), name


@given(st.floats(8.1e-3, 39.9e-3))
def test_slopes_of_the_shape_functions(gap: float) -> None:
    functions = [np.vectorize(lambda g, i=i: shape_functions(g)[i]) for i in (1, 2, 3)]
    expected = [float(derivative(f, gap, initial_step=1e-4 * 0.9).df) for f in functions]
    assert gap_slopes(MOTOR, gap) == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize(("gap", "setpoint"), [
    (35e-3, 27e-3), (np.nextafter(26e-3, 1.0), 27e-3), (26e-3, 25e-3), (25e-3, 25e-3), (24e-3, 25e-3),
    (np.nextafter(24e-3, 0.0), 23e-3), (22e-3, 23e-3), (np.nextafter(22e-3, 0.0), 21e-3), (18e-3, 21e-3)])
def test_schedule_switches_at_the_gaps_of_the_table(gap: float, setpoint: float) -> None:
    """Table 5.4: each region has the gains of the linear law at its setpoint; the internal models carry over."""
    scheduled, linear = Regulator3DOF(SCHEDULED), Regulator3DOF(LINEAR)
    linear.setpoint = setpoint
    assert scheduled.start() == linear.start() == 0
    scheduled.antiwindup = False   # it would move the internal models as well
    scheduled.y.measured = scheduled.y.reference = 30e-3
    scheduled.step(0.0, 2e-4)
    state = scheduled.y.model.xi1
    scheduled.y.measured = scheduled.y.reference = float(gap)
    scheduled.step(2e-4, 2e-4)
    assert scheduled.y.model.xi1 == state
    assert (current_gains(scheduled) == current_gains(linear)).all()


@pytest.mark.parametrize(("kind", "law"),
                         [(Regulator2DOF, LINEAR), (Regulator3DOF, LINEAR), (Regulator3DOF, SCHEDULED)])
@pytest.mark.parametrize("gap", [20e-3, 23e-3, 27e-3])
def test_first_command_is_the_equilibrium(kind: type[Regulator], gap: float, law: int) -> None:
    """At the measured gap by the nonlinear model, whatever the errors, although no current is fed forward."""
    regulator = kind(law)
    regulator.setpoint, regulator.current_limit = 22e-3, 0.0
    assert regulator.start() == 0
    for name, error in zip(AXES[kind], (2e-3, -3e-3, 1e-3), strict=False):
        axis = getattr(regulator, name)
        axis.measured = gap if name in "vy" else 5e-3
        axis.reference = axis.measured - error
    assert regulator.step(0.0, regulator.sample_time) == 0
    held = brentq(lambda i: vertical_row(regulator, gap, i), -12, 12)
    motors = [regulator.motor] if isinstance(regulator, Regulator2DOF) else [regulator.alpha, regulator.beta]
    for motor in motors:
        assert motor.i_d_cmd == pytest.approx(held, abs=1e-9)
        assert motor.i_q_cmd == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("kind", KINDS)
def test_start_at_the_setpoint_feeds_its_equilibrium_current_forward(kind: type[Regulator]) -> None:
    """Not bumpless: i_d* of the nonlinear model at the setpoint, plus the gains on the errors, and no integral."""
    regulator = kind(LINEAR)
    regulator.setpoint, regulator.current_limit, regulator.bumpless = 22e-3, 0.0, False
    assert regulator.start() == 0
    errors = (2e-3, -3e-3, 1e-3)[:len(AXES[kind])]
    for name, error in zip(AXES[kind], errors, strict=True):
        axis = getattr(regulator, name)
        axis.reference = 22e-3 if name in "vy" else 5e-3
        axis.measured = axis.reference + error
    assert regulator.step(0.0, regulator.sample_time) == 0
    gains = [row[0] for row in current_gains(kind_like(regulator))]
    forward = brentq(lambda i: vertical_row(regulator, 22e-3, i), -12, 12)
    motors = [regulator.motor] if isinstance(regulator, Regulator2DOF) else [regulator.alpha, regulator.beta]
    for motor, gain, error in zip(motors, gains[1:], errors[1:], strict=True):
        assert motor.i_d_cmd == pytest.approx(forward + gains[0] * errors[0], abs=1e-9)
        assert motor.i_q_cmd == pytest.approx(gain * error, abs=1e-9)


def kind_like(regulator: Regulator) -> Regulator:
    """A fresh linear regulator with the same setpoint, whose states are zero."""
    fresh = type(regulator)(LINEAR)
    fresh.setpoint = regulator.setpoint
    assert fresh.start() == 0
    return fresh


@pytest.mark.parametrize("kind", KINDS)
def test_setpoint_without_equilibrium_is_refused(kind: type[Regulator]) -> None:
    """Strong attraction and weak coils: nothing holds the mover at a small gap."""
    regulator = kind(LINEAR)
    regulator.setpoint, regulator.C3 = 9e-3, 0.1 if kind is Regulator2DOF else 1e4
    assert regulator.start() == NO_EQUILIBRIUM
    regulator = Regulator3DOF(SCHEDULED)
    regulator.C3 = 1e5
    assert regulator.start() == NO_EQUILIBRIUM


@pytest.mark.parametrize("speed", [0.0, 0.05, -0.05])
def test_friction_compensation_demands_in_the_direction_of_motion(speed: float) -> None:
    regulator = Regulator2DOF()
    regulator.start()
    regulator.h.observer.velocity = speed
    without = regulator.h.demand()
    regulator.h.friction_compensation = 0.3
    assert regulator.h.demand() - without == pytest.approx(0.3 * np.sign(speed), abs=1e-15)
