"""Amplifiers with a voltage: the windings' current, what the motion induces, heat, warm magnets."""

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from named_stage import Stage2DOF, Stage3DOF, Stage5DOF
from reference_stage import reference_2dof, reference_3dof
from scipy.integrate import solve_ivp
from stage_cases import equilibrium_current, phases, run_block

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.linear.linearise import linearise
from plant_fmu.magnets import magnet_strength
from plant_fmu.motor_supply import MotorSupply
from plant_fmu.winding import Winding

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

DT = 0.2e-3
STAGES = {"2dof": Stage2DOF, "3dof": Stage3DOF, "5dof": Stage5DOF}


def supplied(*commands: float) -> MotorSupply:
    """A motor's supply, 7 ohm and 70 mH, with commands of its phases."""
    motor = MotorSupply(9.0, 7.0, 7.0, 0.07)
    motor.i_a_cmd, motor.i_b_cmd, motor.i_c_cmd = commands
    return motor


def test_response_to_a_step_of_voltage() -> None:
    """A command far beyond what the voltage drives: i = V/R (1 − exp(−R t/L)), and the phase without one stays at 0."""
    motor = supplied(0.0, 0.0, 0.0)
    motor.advance(DT, 24.0)
    motor.i_a_cmd, motor.i_b_cmd = 8.0, -8.0
    for k in range(1, 301):
        motor.advance(DT, 24.0)
        expected = 24.0 / 7.0 * -math.expm1(-7.0 / 0.07 * k * DT)
        assert motor.phases[0].current == pytest.approx(expected, rel=1e-12)
        assert motor.phases[1].current == -motor.phases[0].current
        assert motor.voltage == 24.0
    motor.deliver()
    assert motor.i_c == 0.0 and motor.saturated


@settings(max_examples=30)
@given(current=st.floats(-9.0, 9.0), target=st.floats(-9.0, 9.0), induced=st.floats(-15.0, 15.0),
       voltage=st.floats(0.5, 80.0), lag=st.sampled_from([0.3e-3, 5e-3, 30e-3]), inductance=st.floats(2e-3, 0.1))
def test_current_and_charge_against_their_equation(current: float, target: float, induced: float, voltage: float,
                                                   lag: float, inductance: float) -> None:
    """di/dt = (i* − i)/T within (±V − e − R i)/L, over one time constant; windings quicker and slower than the lag."""
    winding = Winding(7.0, inductance)

    def rates(_: float, state: np.ndarray) -> list[float]:
        i = state[0]
        low, high = (-voltage - induced - 7.0 * i) / inductance, (voltage - induced - 7.0 * i) / inductance
        return [min(max((target - i) / lag, low), high), i]

    dt = 5e-3
    solved = solve_ivp(rates, (0.0, dt), [current, 0.0], rtol=1e-8, atol=1e-10, max_step=0.05 * dt)
    assert winding.follow(current, target, lag, induced, voltage, dt) == pytest.approx(
        tuple(solved.y[:, -1]), rel=1e-5, abs=2e-5)


@pytest.mark.parametrize("name", STAGES)
def test_power_into_the_induced_voltage_is_that_of_the_forces(name: str) -> None:
    """Σ e i = Σ force × speed over all axes, tilts included, of what the forces owe to the currents."""
    description, random = PACKAGED_STAGES[name], np.random.default_rng(5)
    stage: Any = STAGES[name]()
    for scale in (0.01, 1.0):
        powers, axes = [], [getattr(stage, axis) for axis in description.axis_names]
        currents = random.uniform(-4.0, 4.0, (len(description.motors), 2))
        for axis, of in zip(axes, description.axes, strict=True):
            axis.position = axis.position_start + (random.uniform(-2e-3, 2e-3)
                                                   if of.rotation or of is description.vertical
                                                   else random.uniform(-0.03, 0.03))
            axis.velocity = scale * random.uniform(-1.0, 1.0)
            axis.begin()
        stage.magnet_rise = 40.0
        for flowing in (currents, 0.0 * currents):
            speeds = [axis.velocity for axis in axes]
            places = [axis.position for axis in axes]
            for motor, (i_d, i_q) in zip(description.motor_names, flowing, strict=True):
                getattr(stage, motor).i_d, getattr(stage, motor).i_q = float(i_d), float(i_q)
            stage.mover.place(stage.axes)
            stage.mover.induce(stage.axes, stage.motors, stage.magnetics, 0.0)
            stage.add_slope(0.0, 0.0)
            for axis, place, speed in zip(axes, places, speeds, strict=True):
                axis.position, axis.velocity = place, speed
            if flowing is currents:
                electrical = 0.0
                for motor, (i_d, i_q) in zip(description.motor_names, currents, strict=True):
                    supply = getattr(stage, motor)
                    place = stage.mover.displacements[supply.axis]
                    electrical += phases(i_d, i_q, place) @ [supply.e_a, supply.e_b, supply.e_c]
            powers.append(sum(axis.mass * axis.acceleration * axis.velocity for axis in axes))
        assert electrical == pytest.approx(powers[0] - powers[1], rel=1e-9)
        assert abs(electrical) > 0.1 * scale


@pytest.mark.parametrize(("description", "gap", "bus", "accuracy"), [(2, 18e-3, 24.0, 3e-8), (3, 23e-3, 9.0, 2e-9)])
def test_motion_with_a_voltage_against_the_reference(description: int, gap: float, bus: float, accuracy: float) -> None:
    """Commands that jump, so that phases are at the voltage of the bus half of the time."""
    stage = (reference_2dof if description == 2 else reference_3dof)()
    stage.bus, held = bus, equilibrium_current(description, gap)
    dt, places = (0.5e-3, 0.2e-3)[description - 2], (0.004, -0.010)[:description - 1]
    jumps = np.random.default_rng(3).uniform(-1.5, 1.5, (12, description - 1, 2))

    def commands(k: int, _: np.ndarray) -> np.ndarray:
        return np.array([phases(held + d, q, x) for x, (d, q) in zip(places, jumps[int(k * dt / 5e-3)], strict=True)])

    steps = round(0.03 / dt)
    block, given_ = run_block(description, (gap, *places), commands, dt, steps, bus_voltage=bus)
    states = stage.solve((gap, *places), lambda k, _: given_[k], dt, steps, 1e-8)
    solved = states[:, :3 * description].reshape(len(states), description, 3)[:, :, :2]
    difference = np.abs(block - solved).max(axis=(0, 1))
    free, _ = run_block(description, (gap, *places), commands, dt, steps)
    assert difference[0] < accuracy and difference[1] < 100.0 * accuracy
    assert np.abs(block - free).max(axis=(0, 1))[0] > 3e-5, "the voltage matters"


@pytest.mark.parametrize("description", [2, 3])
def test_a_voltage_that_suffices_changes_nothing(description: int) -> None:
    """Bit for bit."""
    start = (20e-3 if description == 2 else 25e-3, *(0.0,) * (description - 1))

    def commands(k: int, _: np.ndarray) -> np.ndarray:
        return np.array([phases(math.sin(0.1 * k), math.cos(0.07 * k), 0.0)] * (description - 1))

    (free, _), (limited,
                _) = (run_block(description, start, commands, 0.3e-3, 60, bus_voltage=bus) for bus in (0.0, 1e5))
    assert (free == limited).all()


def test_heat_of_the_windings() -> None:
    """T Θ' = Rth R (1 + α Θ) Σ i² − Θ; the warm windings take more voltage."""
    motor = supplied(2.0, -2.0, 0.0)
    motor.winding.thermal_resistance, motor.winding.thermal_time = 0.9, 10.0
    cold = motor.winding.demanded(2.0, 2.0, 1e-3, 0.5)
    solved = solve_ivp(lambda t, rise: (0.9 * 7.0 * (1 + 3.93e-3 * rise) * 8.0 - rise) / 10.0, (0.0, 20.0), [0.0],
                       rtol=1e-10, atol=1e-10)
    for _ in range(20_000):
        motor.advance(1e-3, 0.0)
    assert motor.winding.rise == pytest.approx(solved.y[0, -1], rel=1e-4)
    assert motor.winding.demanded(2.0, 2.0, 1e-3, 0.5) - cold == pytest.approx(
        14.0 * 3.93e-3 * motor.winding.rise, rel=1e-12)


@pytest.mark.parametrize("name", STAGES)
def test_warm_magnets(name: str) -> None:
    """The poles of the linear model are those of a stage with weaker constants, and so is its fall."""
    description, weak = PACKAGED_STAGES[name], 1.0 - 1.2e-3 * 50.0
    thrusts, (attraction, coils,
              _) = [description.constants_of(axis.name)[0]
                    for axis in description.horizontal], description.constants_of(
        description.vertical.name)
    stage: Any = STAGES[name]()
    other: Any = STAGES[name]()
    factors = {**dict.fromkeys(thrusts, weak), attraction: weak**2, coils: weak}
    for constant, factor in factors.items():
        setattr(other, constant, factor * getattr(other, constant))
    stage.magnet_rise = 50.0
    for each in (stage, other):
        assert each.start() == 0
        for motor in description.motor_names:
            getattr(each, motor).i_a_cmd, getattr(each, motor).i_b_cmd = 1.5, -0.7
        for k in range(50):
            assert each.step(k * DT, DT) == 0
    for axis in description.axis_names:
        assert getattr(stage, axis).velocity == pytest.approx(getattr(other, axis).velocity, rel=1e-9, abs=1e-15)
    at = {description.vertical.name: 20e-3 if name == "2dof" else 23e-3}
    models = [linearise(f"Plant{description.suffix}", at, parameters=parameters) for parameters in (
        {"magnet_rise": 50.0}, {constant: getattr(other, constant) for constant in factors})]
    assert (np.abs(models[0].A - models[1].A) <= 1e-12 * np.abs(models[1].A)).all()
    assert magnet_strength(0.0) == 1.0


def test_estimated_windings() -> None:
    """What docs/model.md estimates them by: 900 turns, a slot 30 mm deep, 45 % of it copper."""
    mu0, turns, length, slot, depth, pairs = 4e-7 * math.pi, 900, 50e-3, 12.7e-3, 30e-3, 3
    a = math.pi / 57.15e-3 * (5e-3 + 25e-3)   # at a gap of 25 mm, slots left out
    main = 6 / math.pi * mu0 * turns**2 * length / pairs / math.tanh(a)
    leakage = 2 * mu0 * turns**2 / pairs * (length * depth / (3 * slot) + 75e-3 * 0.25)
    copper = 0.45 * slot * depth / (turns / pairs)
    winding = PACKAGED_STAGES["5dof"].motors[0].winding
    assert winding.inductance == pytest.approx(main + leakage, rel=0.1)
    assert winding.resistance == pytest.approx(1.72e-8 * turns * 0.25 / copper, rel=0.05)
    assert {motor.winding for motor in PACKAGED_STAGES["3dof"].motors} == {type(winding)(3.5, 0.035)}, "two in parallel"
