"""The regulators as wholes: linearisation in their model, antiwindup, bumpless start, trip, sampling."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from reference_stage import G, shape_functions
from scipy.optimize import brentq

from controller_fmu.regulator_2dof import STEP_MISFIT, Regulator2DOF
from controller_fmu.regulator_3dof import Regulator3DOF

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


@given(gaps, st.floats(-5.0, 3.0), st.floats(-3.0, 3.0), st.floats(-3.0, 3.0))
def test_linearisation_makes_the_demanded_accelerations(gap: float, vertical: float, x: float, z: float) -> None:
    f1 = shape_functions(gap)[0]
    two, three = Regulator2DOF(), Regulator3DOF()
    two.v.measured = three.y.measured = gap
    i_d, i_q = two.linearise(vertical, x)
    assert -two.C1 * f1 * i_q == pytest.approx(x, rel=1e-12, abs=1e-12)
    if two.feasible:
        assert vertical_acceleration(two, gap, i_d, (i_q,)) == pytest.approx(vertical, abs=1e-9)
    i_d, i_qa, i_qb = three.linearise(vertical, x, z)
    assert -2 * three.C1 * f1 * i_qa == pytest.approx(x, rel=1e-12, abs=1e-12)
    assert -2 * three.C2 * f1 * i_qb == pytest.approx(z, rel=1e-12, abs=1e-12)
    if three.feasible:
        assert vertical_acceleration(three, gap, i_d, (i_qa, i_qb)) == pytest.approx(vertical, abs=1e-9)


def test_infeasible_demand_is_flagged_and_recovered_from() -> None:
    regulator = Regulator2DOF()
    regulator.v.measured = 20e-3
    _, _, f3, f4 = shape_functions(20e-3)
    i_d, _ = regulator.linearise(1e3, 0.0)
    assert regulator.feasible is False
    assert i_d == pytest.approx(regulator.C3 * f3 / (2 * regulator.C4 * f4), rel=1e-12)
    best = vertical_acceleration(regulator, 20e-3, i_d, (0.0,))
    assert all(vertical_acceleration(regulator, 20e-3, i_d + d, (0.0,)) < best for d in (-0.1, 0.1))
    regulator.linearise(0.0, 0.0)
    assert regulator.feasible is True


def run(regulator: Regulator, samples: int = 1, **measured: float) -> None:
    """Set measurements and take samples."""
    for name, value in measured.items():
        getattr(regulator, name).measured = value
    for k in range(samples):
        assert regulator.step(k * regulator.sample_time, regulator.sample_time) == 0


def started(kind: type[Regulator]) -> Regulator:
    regulator = kind()
    assert regulator.start() == 0
    return regulator


@BOTH
@pytest.mark.parametrize("gap", [17e-3, 20e-3, 23e-3, 25e-3])
@pytest.mark.parametrize("off", [0.0, 1e-3])
def test_first_command_is_the_equilibrium(kind: type[Regulator], gap: float, off: float) -> None:
    """At the measured gap, whatever the errors: no current across, no bump."""
    regulator = started(kind)
    regulator.current_limit = 0.0
    for name in AXES[kind]:
        axis = getattr(regulator, name)
        axis.measured = gap if name in "vy" else 5e-3
        axis.reference = axis.measured - off
    run(regulator)
    held = brentq(lambda i: vertical_acceleration(regulator, gap, i, (0.0, 0.0)), -12, 12)
    for name in MOTORS[kind]:
        motor = getattr(regulator, name)
        assert motor.i_d_cmd == pytest.approx(held, abs=1e-9)
        assert motor.i_q_cmd == pytest.approx(0.0, abs=1e-9)
    if off == 0.0:
        run(regulator, 200)
        assert all(getattr(regulator, name).model.xi1 == 0.0 for name in AXES[kind])


@BOTH
def test_no_measurement_yet(kind: type[Regulator]) -> None:
    """A gap of 0 is no measurement: no current, and the start is at the first real one."""
    late, prompt = started(kind), started(kind)
    vertical, motor = AXES[kind][0], MOTORS[kind][0]
    run(late, 3, **dict.fromkeys(AXES[kind], 0.0))
    assert getattr(late, motor).i_d_cmd == getattr(late, motor).i_a_cmd == 0.0
    assert not late.started
    for regulator in (late, prompt):
        run(regulator, 5, **{vertical: 21.5e-3})
    assert getattr(late, motor).i_d_cmd == getattr(prompt, motor).i_d_cmd != 0.0


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
def test_limit_holds_and_zero_is_none(kind: type[Regulator]) -> None:
    for limit in (4.0, 0.0):
        regulator = started(kind)
        regulator.current_limit = limit
        run(regulator)
        run(regulator, 1, **{name: getattr(regulator, name).measured + 45e-3 for name in AXES[kind][1:]})
        largest = max(abs(getattr(regulator, name).i_q_cmd) for name in MOTORS[kind])
        assert regulator.saturated == (limit > 0.0)
        assert largest == 4.0 if limit > 0.0 else largest > 4.0


@BOTH
def test_trip_is_latched(kind: type[Regulator]) -> None:
    for name in AXES[kind]:
        regulator = started(kind)
        regulator.trip_error = 2e-3
        run(regulator, 3)
        place = getattr(regulator, name).measured
        run(regulator, 1, **{name: place + 2.5e-3})
        assert regulator.tripped
        run(regulator, 3, **{name: place})
        assert regulator.tripped
        for motor in MOTORS[kind]:
            m = getattr(regulator, motor)
            assert (m.i_d_cmd, m.i_q_cmd, m.i_a_cmd, m.i_b_cmd, m.i_c_cmd) == (0.0,) * 5
        assert not regulator.saturated


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
    dt, commands = regulator.sample_time / 4, []
    motor = getattr(regulator, MOTORS[kind][0])
    axis = getattr(regulator, AXES[kind][0])
    for k in range(40):
        axis.measured += 1e-6
        assert regulator.step(k * dt, dt) == 0
        commands.append(motor.i_b_cmd)
    held = np.reshape(commands, (10, 4))
    assert (held == held[:, :1]).all()
    assert len(set(held[:, 0])) == 10
    assert regulator.step(1.0, 0.3 * regulator.sample_time) == STEP_MISFIT


def test_rate_of_the_reference_counts() -> None:
    """ė = v̂ − ṙ: a reference that moves with the measurement demands nothing."""
    still, moving = started(Regulator2DOF), started(Regulator2DOF)
    for regulator, rate in ((still, 0.0), (moving, 0.01)):
        regulator.h.reference_rate = rate
        run(regulator)
    assert moving.h.demand() - still.h.demand() == pytest.approx(-55.0 * -0.01, rel=1e-9)
    assert math.isfinite(moving.motor.i_q_cmd)
