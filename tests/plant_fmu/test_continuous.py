"""The stages as continuous models: rates, events, and derivatives, against what is computed in other ways."""

import numpy as np
import pytest
from complex_stage import complex_step, phase_commands, rates
from continuous_block import ContinuousBlock
from reference_stage import LAG, reference_2dof, reference_3dof

from plant_fmu.current_amplifier import AmplifierRating, CurrentAmplifier
from plant_fmu.end_stop import TOUCH, EndStop
from plant_fmu.winding import Winding

AXES = {2: "vh", 3: "yxz"}
MOTORS = {2: ("motor",), 3: ("alpha", "beta")}

# Everything that a continuous model can have, switched on.
EVERYTHING = {
    "Plant2DOF": {
        "bus_voltage": 40.0, "magnet_rise": 30.0, "v.mode.frequency": 90.0, "h.mode.frequency": 60.0,
        "motor.winding.thermal_resistance": 2.0, "h.ripple.amplitude": 0.2, "motor.i_a_cmd": 1.1,
        "h.roughness.rms": 0.3, "v.roughness.rms": 0.8, "guide_seed": 7.0, "h.friction.variation": 0.4,
        "motor.i_b_cmd": -0.2, "motor.i_c_cmd": -0.7},
    "Plant3DOF": {
        "bus_voltage": 40.0, "magnet_rise": 30.0, **{f"{axis}.mode.frequency": 60.0 for axis in "yxz"},
        "alpha.winding.thermal_resistance": 2.0, "beta.winding.thermal_resistance": 1.0, "y.force": 3.0,
        "x.roughness.rms": 0.2, "z.roughness.rms": 0.2, "y.roughness.rms": 0.1, "z.roughness.correlation": 1e-3,
        "z.floor_acceleration": 0.2, "alpha.i_a_cmd": 2.0, "alpha.i_b_cmd": -0.7, "beta.i_a_cmd": 1.0},
    "Plant5DOF": {
        "bus_voltage": 60.0, "magnet_rise": -20.0, "payload.mass": 1.0, "payload.x": 0.1, "payload.z": -0.05,
        "roll.guide.stiffness": 200.0, "roll.torque": 0.1, "height": -0.04, "alpha1.x": 0.02, "alpha2.x": 0.03,
        "x.roughness.rms": 0.2, "y.roughness.rms": 0.1, "x.friction.variation": 0.4,
        "beta1.z": 0.02, "beta2.z": -0.01, "alpha1.i_a_cmd": 1.0, "beta2.i_b_cmd": -1.5,
        **{f"{axis}.mode.frequency": 80.0 for axis in ("y", "x", "z", "roll", "pitch")},
        **{f"{motor}.winding.thermal_resistance": 1.0 for motor in ("alpha1", "alpha2", "beta1", "beta2")}}}


@pytest.mark.parametrize("name", EVERYTHING)
@pytest.mark.usefixtures("slow")
def test_solver_and_steps_agree(name: str) -> None:
    """Over 0.05 s from rest, with all that is continuous: 1e-9 m and rad."""
    continuous = ContinuousBlock(name, EVERYTHING[name])
    stepped = ContinuousBlock(name, EVERYTHING[name])
    solved = continuous.solve(0.05)
    for k in range(250):
        assert stepped.block.step(2e-4 * k, 2e-4) == 0
    difference = dict(zip(continuous.states, np.abs(solved - stepped.get(stepped.states)), strict=True))
    places = [state for state in difference if state.endswith(".position")]
    assert max(difference[place] for place in places) < 1e-9
    assert max(difference.values()) < 1e-5
    moved = np.abs(solved - ContinuousBlock(name, EVERYTHING[name]).get(continuous.states))
    assert sum(moved > 1e-6) > 10


@pytest.mark.parametrize("stage", [2, 3])
def test_derivatives_are_those_of_the_equations_by_complex_step(stage: int) -> None:
    """To rounding, on the smooth part: `complex_stage` writes the equations of motion once more."""
    reference = reference_2dof() if stage == 2 else reference_3dof()
    axes, motors = AXES[stage], MOTORS[stage]
    values = {f"{axis}.friction.coulomb": 0.0 for axis in axes}
    plant = ContinuousBlock(f"Plant{stage}DOF", values)
    place = np.array([0.0213, 0.004, -0.01][:stage])
    speed = np.array([0.02, -0.15, 0.1][:stage])
    dq = np.array([[0.7, -0.4], [0.2, 0.9]][:stage - 1])
    phases = phase_commands(dq, place)
    commands = np.array([1.0, -0.3, -0.6, 0.5, 0.2, 0.1][:3 * (stage - 1)])
    known = [*(f"{a}.position" for a in axes), *(f"{a}.velocity" for a in axes),
             *(f"{m}.i_{p}" for m in motors for p in "abc"), *(f"{m}.i_{p}_cmd" for m in motors for p in "abc"),
             *(f"{a}.force" for a in axes)]
    point = [*place, *speed, *phases, *commands, *np.zeros(stage)]
    unknown = [f"der({a}.velocity)" for a in axes]
    found = plant.at(known, point, unknown)

    def accelerations(x: np.ndarray) -> np.ndarray:
        """By positions, velocities, phase currents, forces."""
        places, rest = x[:stage], x[2 * stage:]
        currents = park(places[1:], rest[:-stage])
        return rates(reference, np.concatenate([places, x[stage:2 * stage], currents]),
                     np.concatenate([0.0 * currents, rest[-stage:]]), phases=False, lag=True)[stage:2 * stage]

    at = np.array([*place, *speed, *phases, *np.zeros(stage)])
    np.testing.assert_allclose(found, np.real(accelerations(at.astype(complex))), rtol=1e-11)
    expected = complex_step(accelerations, at)
    of_state = known[:2 * stage + 3 * (stage - 1)] + known[-stage:]
    np.testing.assert_allclose(plant.jacobian(unknown, of_state), expected, rtol=1e-9, atol=1e-9)
    lag = plant.jacobian([f"der({m}.i_{p})" for m in motors for p in "abc"], [f"{m}.i_{p}_cmd" for m in motors
                                                                             for p in "abc"])
    np.testing.assert_allclose(lag, np.eye(len(lag)) / LAG, rtol=1e-12)


def park(places: np.ndarray, currents: np.ndarray) -> np.ndarray:
    """i_d and i_q of all motors by (2.1), for complex numbers."""
    found = []
    for d, phases in zip(places, currents.reshape(-1, 3), strict=True):
        angles = np.pi / 57.15e-3 * (d - 57.15e-3 / 2) + np.array([0, -2 * np.pi / 3, 2 * np.pi / 3])
        found += [2 / 3 * np.cos(angles) @ phases, -2 / 3 * np.sin(angles) @ phases]
    return np.array(found)


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("name", EVERYTHING)
def test_derivatives_and_dependencies(name: str) -> None:
    """Central differences, and what the model structure says of dependencies: all that are, and none that cannot be."""
    plant = ContinuousBlock(name, EVERYTHING[name])
    knowns = [*plant.states, *plant.inputs]
    outputs = [v.name for v in plant.definition.variables if v.causality == "output" and v.variability == "continuous"]
    unknowns = list(dict.fromkeys([*plant.rates, *outputs, *plant.model.indicators]))
    told = {name: set(knowns) for name, knowns in plant.model.indicators.items()} | {
        output: set(plant.model.outputs[output]) for output in outputs} | {
        state.derivative: set(state.depends_on) for state in plant.model.states}
    start = plant.get(knowns)
    size = np.array([1e-3 if k.endswith(("position", "mode.deflection")) else 0.1 for k in knowns])
    hot = np.array([k.endswith(".heat") for k in knowns])
    commands = np.array([k.endswith("_cmd") for k in knowns])
    generator = np.random.default_rng(5)
    found = {unknown: set[str]() for unknown in unknowns}
    # Without and with a limit of the voltage, with a clamp that falls, with a fault and at a stop. One phase has most.
    for point, (bus, stuck, warm) in enumerate([(0.0, True, False), (1e-3, False, False), (0.0, False, True),
                                                *[(1e4, False, False), (1e4, False, True)] * 3]):
        here = start + size * generator.normal(size=len(start))
        here[commands] += np.copysign(1e-3, here[commands])   # next to 0, where a margin has a kink
        most = np.array([k.endswith(f"i_{'abc'[point % 3]}_cmd") for k in knowns])
        here[most] = 3.0
        plant.set("bus_voltage", bus)
        for motor in {k.partition(".")[0] for k, is_command in zip(knowns, commands, strict=True) if is_command}:
            plant.set(f"{motor}.amplifier.stuck", stuck)
            mine = np.array([k.startswith(f"{motor}.") for k in knowns])
            if warm:
                rated = plant.get([f"{motor}.amplifier.continuous"])[0]
                here[hot & mine] = generator.uniform(0.92, 0.98, 3) * rated**2
                here[most & mine] = 20.0
        if stuck:
            here[0] += 8e-3   # beyond a stop
        plant.at(knowns, here, unknowns)
        plant.block.settle()
        plant.at(knowns, here, unknowns)
        exact = plant.jacobian(unknowns, knowns)
        for u, k in np.argwhere(exact):
            found[unknowns[u]].add(knowns[k])
        for k in range(len(knowns)) if point < 5 else ():
            step = np.zeros(len(here))
            step[k] = 1e-3 * size[k]
            above, below = (plant.at(knowns, here + sign * step, unknowns) for sign in (1, -1))
            rounding = 1e-13 * np.abs(above) / step[k]
            error = np.abs(exact[:, k] - (above - below) / (2 * step[k]))
            assert (error <= 1e-4 * np.abs(exact[:, k]) + 1e-6 * np.abs(exact[:, k]).max() + rounding).all(), knowns[k]
    assert {unknown: told[unknown] ^ found[unknown] for unknown in told if told[unknown] != found[unknown]} == {}


def test_stop_is_decided_at_events_alone() -> None:
    stop = EndStop(-0.01, 0.01)
    stop.resume(0.0)
    assert not stop.settle(1.0) and (stop.to_lower, stop.to_upper) == (0.01, 0.01)
    stop.resume(0.011)
    assert stop.force(0.011, 0.0) == 0.0, "no event yet"
    assert stop.settle(1.0)
    stop.resume(0.011)
    assert stop.force(0.011, 0.0) == pytest.approx(-400.0)
    for rounding in (-0.1 * TOUCH, 0.1 * TOUCH):   # found except for rounding: the velocity decides
        stop.resume(0.01 + rounding)
        assert stop.settle(1e-3) and not stop.settle(-1e-3)
        stop.resume(-0.01 + rounding)
        assert stop.settle(-1e-3) and not stop.settle(1e-3)
    stop.stiffness = stop.damping = 0.0
    stop.resume(0.5)
    assert not stop.settle(1.0) and stop.to_upper == stop.to_lower == 1.0


def test_amplifier_at_events_and_between() -> None:
    rating, winding, phase = AmplifierRating(5.0, 4.0), Winding(7.0, 0.07), CurrentAmplifier()
    phase.derive(7.0, rating, winding, 0.0, 0.0)
    assert phase.margin == -2.0 and phase.settle(rating) and (phase.current, phase.saturated) == (5.0, True)
    phase.derive(3.0, rating, winding, 0.0, 0.0)
    assert phase.current_rate == pytest.approx(-2.0 / 0.3e-3)
    assert phase.heat_rate == pytest.approx(9.0 / rating.thermal_time)
    assert not phase.settle(rating) and not phase.saturated, "started once"
    phase.derive(5.0, rating, winding, 2.0, 20.0)   # 35 V for the resistance alone
    assert phase.current_rate == pytest.approx((20.0 - 2.0 - 35.0) / 0.07) and phase.voltage == 20.0
    assert phase.margin == pytest.approx(-17.0)
    rating.stuck = True
    phase.derive(1.0, rating, winding, 0.0, 0.0)
    assert (phase.current_rate, phase.heat_rate, phase.margin) == (0.0, 25.0, 1.0) and not phase.settle(rating)
    phase.open = True
    assert phase.settle(rating) and phase.current == 0.0
    winding.thermal_resistance, winding.thermal_time = 0.5, 100.0
    winding.derive(8.0)
    assert winding.rise_rate == pytest.approx(0.5 * 7.0 * 8.0 / 100.0)
