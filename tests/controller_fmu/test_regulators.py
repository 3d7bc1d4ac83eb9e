"""The regulators as wholes: linearisation in their model, antiwindup, bumpless start, trip, sampling."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from named_controllers import Regulator2DOF, Regulator3DOF
from reference_stage import G, shape_functions
from scipy.optimize import brentq

from controller_fmu.status import STEP_MISFIT

Regulator = Regulator2DOF | Regulator3DOF
AXES = {Regulator2DOF: ("v", "h"), Regulator3DOF: ("y", "x", "z")}
MOTORS = {Regulator2DOF: ("motor",), Regulator3DOF: ("alpha", "beta")}
BOTH = pytest.mark.parametrize("kind", [Regulator2DOF, Regulator3DOF])
gaps = st.floats(16e-3, 28e-3)


def vertical_acceleration(regulator: Regulator, gap: float, i_d: float, i_q: tuple[float, ...]) -> float:
    """Vertical row of (4.3) or (5.3) with the regulator's constants."""
    _, f2, f3, f4 = shape_functions(gap)
    r = regulator
    if isinstance(r, Regulator2DOF):
        return G - r.C4 * f4 * (i_d**2 + i_q[0]**2) + r.C3 * f3 * i_d - r.C2 * f2
    return (G - 2 * r.C5 * f4 * (2 * i_d**2 + sum(i**2 for i in i_q)) + 4 * r.C4 * f3 * i_d - 4 * r.C3 * f2)


def check_vertical(regulator: Regulator, gap: float, demand: float, i_d: float,
                   i_q: tuple[float, ...]) -> None:
    """Assert that i_d is the smaller current that makes the demand, or the best one where none does."""
    def row(i: float) -> float:
        return vertical_acceleration(regulator, gap, i, i_q)

    # The row is a parabola in i_d: three values give its coefficients.
    square, slope = (row(1.0) + row(-1.0)) / 2 - row(0.0), (row(1.0) - row(-1.0)) / 2
    vertex = -slope / (2 * square)
    margin = row(vertex) - demand
    if abs(margin) > 1e-6:
        assert regulator.feasible == (margin > 0.0)
    if regulator.feasible:
        assert row(i_d) == pytest.approx(demand, rel=1e-9, abs=1e-11)
        smaller = np.roots([square, slope, row(0.0) - demand]).real.min()
        assert i_d == pytest.approx(smaller, rel=1e-5)
    else:
        assert i_d == pytest.approx(vertex, rel=1e-9)


@given(gaps, st.floats(-5.0, 5.0), st.floats(0.0, 200.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_linearisation_makes_the_demanded_accelerations(gap: float, vertical: float, more: float,
                                                        x: float, z: float) -> None:
    f1 = shape_functions(gap)[0]
    two, three = Regulator2DOF(), Regulator3DOF()
    assert two.start() == three.start() == 0
    two.v.measured = three.y.measured = gap
    # The most that the motors can make without a limit is 18 to 195 m/s², by stage and gap.
    for demand in (vertical, vertical + more):
        i_d, i_q = two.currents(demand, x)
        assert -two.C1 * f1 * i_q == pytest.approx(x, rel=1e-12, abs=1e-12)
        check_vertical(two, gap, demand, i_d, (i_q,))
        i_d, i_qa, i_qb = three.currents(demand, x, z)
        assert -2 * three.C1 * f1 * i_qa == pytest.approx(x, rel=1e-12, abs=1e-12)
        assert -2 * three.C2 * f1 * i_qb == pytest.approx(z, rel=1e-12, abs=1e-12)
        check_vertical(three, gap, demand, i_d, (i_qa, i_qb))


@BOTH
def test_infeasible_demand_is_flagged_and_recovered_from(kind: type[Regulator]) -> None:
    """Through the outputs: a drop far below the reference demands more than the motor has."""
    regulator = started(kind)
    regulator.current_limit = 0.0
    name, motor = AXES[kind][0], getattr(regulator, MOTORS[kind][0])
    gap = getattr(regulator, name).measured
    run(regulator)
    assert regulator.feasible is True
    getattr(regulator, name).reference = gap + 1.0
    run(regulator)
    assert regulator.feasible is False
    best = vertical_acceleration(regulator, gap, motor.i_d_cmd, (motor.i_q_cmd,) * 2)
    for other in (motor.i_d_cmd - 0.1, motor.i_d_cmd + 0.1):
        assert vertical_acceleration(regulator, gap, other, (motor.i_q_cmd,) * 2) < best
    getattr(regulator, name).reference = gap
    model = getattr(regulator, name).model
    model.xi1 = model.xi2 = model.xi3 = 0.0
    run(regulator)
    assert regulator.feasible is True


def run(regulator: Regulator, samples: int = 1, **measured: float) -> None:
    """Set measurements and take samples."""
    for name, value in measured.items():
        getattr(regulator, name).measured = value
    for k in range(samples):
        assert regulator.step(k * regulator.sample_time, regulator.sample_time) == 0


def commands(regulator: Regulator, motor: str) -> tuple[float, ...]:
    """i_d, i_q and the phase commands of a motor (A)."""
    m = getattr(regulator, motor)
    return m.i_d_cmd, m.i_q_cmd, m.i_a_cmd, m.i_b_cmd, m.i_c_cmd


def started(kind: type[Regulator]) -> Regulator:
    regulator = kind()
    assert regulator.start() == 0
    return regulator


@BOTH
@pytest.mark.parametrize("gap", [17e-3, 20e-3, 23e-3, 25e-3])
@pytest.mark.parametrize("off", [0.0, 1.0, -1.0])
def test_first_command_is_the_equilibrium(kind: type[Regulator], gap: float, off: float) -> None:
    """At the measured gap, whatever the errors: no current across, no bump."""
    regulator = started(kind)
    regulator.current_limit = 0.0
    errors = np.array([1e-3, -2e-3, 3e-3])[:len(AXES[kind])] * off
    for name, error in zip(AXES[kind], errors, strict=True):
        axis = getattr(regulator, name)
        axis.measured = gap if name in "vy" else 5e-3
        axis.reference = axis.measured - error
    run(regulator)
    held = brentq(lambda i: vertical_acceleration(regulator, gap, i, (0.0, 0.0)), -12, 12)
    for name in MOTORS[kind]:
        motor = getattr(regulator, name)
        assert motor.i_d_cmd == pytest.approx(held, abs=1e-9)
        assert motor.i_q_cmd == pytest.approx(0.0, abs=1e-9)
    if off == 0.0:
        run(regulator, 200)
        models = [getattr(regulator, name).model for name in AXES[kind]]
        assert all((m.xi1, m.xi2, m.xi3) == (0.0, 0.0, 0.0) for m in models)


@BOTH
def test_start_without_integral_action(kind: type[Regulator]) -> None:
    """k3 = −1 takes ξ1 out of the law: no state can cancel the error, and none is tried."""
    regulator = started(kind)
    for name in AXES[kind]:
        axis = getattr(regulator, name)
        axis.k3, axis.reference = -1.0, axis.measured - 1e-4
        axis.start(0.0, axis.measured - axis.reference)
        axis.sample(regulator.observer, regulator.sample_time)
        assert axis.model.xi1 == 0.0
        assert axis.demand() == pytest.approx(axis.k1 * 1e-4)


@BOTH
@pytest.mark.parametrize("unknown", [0.0, -1.0])
def test_no_measurement_yet(kind: type[Regulator], unknown: float) -> None:
    """A gap that is not positive is no measurement: no current, no trip; the first real one starts."""
    late, prompt = started(kind), started(kind)
    late.trip_error = prompt.trip_error = 5e-3
    run(late, 3, **dict.fromkeys(AXES[kind], unknown))
    assert not late.started
    assert (late.saturated, late.feasible, late.tripped) == (False, True, False)
    assert all(getattr(late, name).error == 0.0 for name in AXES[kind])
    assert all(commands(late, name) == (0.0,) * 5 for name in MOTORS[kind])
    places = dict.fromkeys(AXES[kind], 2e-3)
    places[AXES[kind][0]] = getattr(prompt, AXES[kind][0]).reference + 1.5e-3
    for _ in range(5):
        for regulator in (late, prompt):
            run(regulator, 1, **places)
        for name in MOTORS[kind]:
            assert commands(late, name) == commands(prompt, name) != (0.0,) * 5
        places = {name: place + 1e-5 for name, place in places.items()}


@BOTH
@pytest.mark.parametrize("antiwindup", [True, False])
def test_antiwindup_term(kind: type[Regulator], antiwindup: bool) -> None:
    """ξ₊ − Φ ξ − Γ e = Ts Ec (sat(u) − u), and exactly 0 when it is off."""
    regulator = started(kind)
    regulator.antiwindup = antiwindup
    names = AXES[kind]
    for i, name in enumerate(names):
        axis = getattr(regulator, name)
        axis.ec1, axis.ec2, axis.ec3 = 1e-4 * (i + 1), 2e-4 * (i + 1), 3e-4 * (i + 1)
    run(regulator, 1)
    for name, jump in zip(names, (3e-3, 40e-3, -40e-3), strict=False):
        axis = getattr(regulator, name)
        axis.measured += jump
        axis.model.xi2, axis.model.xi3 = 1e-5, -2e-5
    models = {name: getattr(regulator, name).model for name in names}
    before = {name: (m.xi1, m.xi2, m.xi3) for name, m in models.items()}
    run(regulator, 1)
    assert regulator.saturated
    o, ts = regulator.oscillator, regulator.sample_time
    motors = [getattr(regulator, name) for name in MOTORS[kind]]
    excess = [motors[0].excess_d] + [m.excess_q for m in motors]
    assert all(abs(e) > 0.1 for e in excess[1:])
    for name, u in zip(names, excess, strict=True):
        axis, model, (x1, x2, x3) = getattr(regulator, name), models[name], before[name]
        e = axis.error
        free = (x1 + o.sine * x2 + o.versine * x3 + o.ramp * e, o.cosine * x2 + o.sine * x3 + o.versine * e,
                o.minus_sine * x2 + o.cosine * x3 + o.sine * e)
        added = np.array((model.xi1, model.xi2, model.xi3)) - free
        expected = np.array((axis.ec1, axis.ec2, axis.ec3)) * ts * u
        if antiwindup:
            assert added == pytest.approx(expected, rel=1e-6, abs=1e-18)
        else:
            assert tuple(added) == (0.0, 0.0, 0.0)


@BOTH
@given(st.lists(st.floats(-4e-3, 4e-3), min_size=3, max_size=3), st.sampled_from([0.5, 2.0, 4.0]))
def test_limit_holds_and_zero_means_no_limit(kind: type[Regulator], errors: list[float], limit: float) -> None:
    """The command after a jump on every axis, with a limit and without."""
    free, limited = started(kind), started(kind)
    free.current_limit, limited.current_limit = 0.0, limit
    for regulator in (free, limited):
        regulator.antiwindup = False   # it would part the two once the first command is limited
        run(regulator)
        moved = {name: getattr(regulator, name).measured + (error if name in "vy" else 10.0 * error)
                 for name, error in zip(AXES[kind], errors, strict=False)}
        run(regulator, 1, **moved)
    assert not free.saturated
    wanted = np.array([commands(free, name)[:2] for name in MOTORS[kind]])
    made = np.array([commands(limited, name)[:2] for name in MOTORS[kind]])
    assert (made == np.clip(wanted, -limit, limit)).all()
    assert limited.saturated == bool((np.abs(wanted) > limit).any())


@BOTH
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_trip_is_latched(kind: type[Regulator], sign: float) -> None:
    for name in AXES[kind]:
        regulator = started(kind)
        regulator.trip_error = 2.0**-9
        axis = getattr(regulator, name)
        place = axis.measured = axis.reference = 2.0**-5   # the errors below are exact
        run(regulator, 3)
        run(regulator, 1, **{name: place + sign * 2.0**-9})
        assert not regulator.tripped, "an error of just trip_error is still allowed"
        run(regulator, 1, **{name: place + sign * (2.0**-9 + 2.0**-40)})
        assert regulator.tripped
        assert all(commands(regulator, motor) == (0.0,) * 5 for motor in MOTORS[kind])
        run(regulator, 3, **{name: place})
        assert regulator.tripped
        assert axis.error == 0.0
        assert all(commands(regulator, motor) == (0.0,) * 5 for motor in MOTORS[kind])
        assert not regulator.saturated


@BOTH
def test_trip_error_zero_never_trips(kind: type[Regulator]) -> None:
    for name in AXES[kind]:
        regulator = started(kind)
        run(regulator)
        run(regulator, 1, **{name: 5.0})
        assert not regulator.tripped


@BOTH
def test_errors_are_measured_minus_reference(kind: type[Regulator]) -> None:
    regulator = started(kind)
    for name in AXES[kind]:
        getattr(regulator, name).reference -= 1e-4
    run(regulator)
    assert [getattr(regulator, name).error for name in AXES[kind]] == pytest.approx([1e-4] * len(AXES[kind]))


@BOTH
def test_commands_hold_between_samples(kind: type[Regulator]) -> None:
    regulator = started(kind)
    dt, history = regulator.sample_time / 4, []
    for k in range(40):
        for name in AXES[kind]:
            getattr(regulator, name).measured += 1e-6
        assert regulator.step(k * dt, dt) == 0
        errors = [getattr(regulator, name).error for name in AXES[kind]]
        history.append(sum((commands(regulator, name) for name in MOTORS[kind]), ()) + tuple(errors))
    held: np.ndarray = np.reshape(history, (10, 4, -1))
    assert (held == held[:, :1]).all()
    assert all(len(set(row)) == 10 for row in held[:, 0].T if row.any())
    for misfit in (0.3, 2.0, 1.5):
        before = history[-1]
        assert regulator.step(1.0, misfit * regulator.sample_time) == STEP_MISFIT
        errors = [getattr(regulator, name).error for name in AXES[kind]]
        assert sum((commands(regulator, name) for name in MOTORS[kind]), ()) + tuple(errors) == before


def test_rate_of_the_reference_counts() -> None:
    """ė = v̂ − ṙ: a reference that moves with the measurement demands nothing."""
    still, moving = started(Regulator2DOF), started(Regulator2DOF)
    assert isinstance(still, Regulator2DOF) and isinstance(moving, Regulator2DOF)
    for regulator, rate in ((still, 0.0), (moving, 0.01)):
        regulator.h.reference_rate = rate
        run(regulator)
    assert moving.h.demand() - still.h.demand() == pytest.approx(-55.0 * -0.01, rel=1e-9)
    assert math.isfinite(moving.motor.i_q_cmd)
