"""A mass other than the nominal one: motors and guides push as before, and the mover answers by its mass."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from direct_loop import LAYOUTS, idealise
from hypothesis import given
from hypothesis import strategies as st
from named_controllers import Regulator2DOF, Regulator3DOF
from named_stage import Stage2DOF, Stage3DOF
from reference_stage import T1, G, shape_functions
from scipy.optimize import brentq
from stage_cases import phases

from maglev.identification.regressors import ESTIMATED_STAGES as described_stages
from maglev.identification.regressors import accelerations

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

STAGES: dict[int, Any] = {2: Stage2DOF, 3: Stage3DOF}
REGULATORS: dict[int, Any] = {2: Regulator2DOF, 3: Regulator3DOF}
NOMINAL = {2: (4.350, 1.594), 3: (6.9, 10.6, 8.6)}   # kg, Tables 4.1 and 5.1
both = pytest.mark.parametrize("description", [2, 3])
loads = st.floats(0.3, 4.0)


def motor_forces(stage: int, c: Sequence[float], positions: Sequence[float], modulation: float,
                 i_d: Sequence[float], i_q: Sequence[float]) -> list[float]:
    """Forces of the motors (N) on the axes: (4.3) and (5.3) times the masses at which their constants hold."""
    f1, f2, f3, f4 = shape_functions(positions[0])
    f2 *= 1 - modulation * np.sin(np.pi * positions[1] / T1)**2
    squares = sum(i**2 for i in (*i_d, *i_q))
    m = NOMINAL[stage]
    if stage == 2:
        return [m[0] * (-c[3] * f4 * squares + c[2] * f3 * i_d[0] - c[1] * f2), -m[1] * c[0] * f1 * i_q[0]]
    return [m[0] * (-2 * c[4] * f4 * squares + 2 * c[3] * f3 * sum(i_d) - 4 * c[2] * f2),
            -2 * m[1] * c[0] * f1 * i_q[0], -2 * m[2] * c[1] * f1 * i_q[1]]


def constants(stage: int, block: Any) -> list[float]:
    """C1, C2, … of a stage or a controller."""
    return [getattr(block, f"C{k}") for k in range(1, stage + 3)]


def axes_of(description: int, stage: Any) -> list[Any]:
    """Axes of a stage, the vertical one first."""
    return [getattr(stage, name) for name in LAYOUTS[description][0]]


@both
@given(load=st.tuples(loads, loads, loads), gap=st.floats(19e-3, 27e-3), x=st.tuples(*[st.floats(-0.03, 0.03)] * 2),
       speed=st.tuples(*[st.floats(-0.3, 0.3)] * 3), i=st.tuples(*[st.floats(-4.0, 4.0)] * 4),
       outside=st.tuples(*[st.floats(-20.0, 20.0)] * 3))
def test_acceleration_is_force_over_mass(description: int, load: tuple[float, ...], gap: float, x: tuple[float, ...],
                                         speed: tuple[float, ...], i: tuple[float, ...], outside: tuple[float, ...]
                                         ) -> None:
    """Every axis, with all effects on: bias and gravity are accelerations, everything else is a force."""
    stage = STAGES[description]()
    axes, motors = axes_of(description, stage), [getattr(stage, name) for name in LAYOUTS[description][1]]
    masses = [nominal * factor for nominal, factor in zip(NOMINAL[description], load, strict=False)]
    positions = [gap, *x][:description]
    for axis, mass, position, v, force in zip(axes, masses, positions, speed, outside, strict=False):
        axis.mass, axis.position, axis.velocity, axis.force, axis.deflection = mass, position, v, force, 0.4
        axis.begin()
    for k, motor in enumerate(motors):
        motor.i_d, motor.i_q = i[k], i[2 + k]
    stage.add_slope(0.0, 0.0)
    forces = motor_forces(description, constants(description, stage), positions, stage.attraction_modulation,
                          i[:description - 1],
                          i[2:description + 1])
    if description == 3:
        forces[0] += NOMINAL[3][0] * 0.15 * np.sin(2 * np.pi * gap / 5e-3 + 0.5)
    for k, axis in enumerate(axes):
        friction = axis.friction.coulomb * 0.4 + axis.friction.viscous * speed[k]
        expected = (G if k == 0 else 0.0) + axis.bias + (forces[k] + outside[k] - friction) / masses[k]
        assert axis.acceleration == pytest.approx(expected, rel=1e-12, abs=1e-12)


def simulated(description: int, axis: str, mass: float, current: float, stop_time: float = 0.1) -> float:
    """How far (m) a horizontal axis goes at a mass (kg) under a quadrature current (A), the others held, no effects."""
    stage = STAGES[description]()
    idealise(description, stage, REGULATORS[description]())
    names, motors, dt = LAYOUTS[description]
    for name in names:
        getattr(stage, name).locked = name != axis
    moving, motor = getattr(stage, axis), getattr(stage, motors[names.index(axis) - 1])
    moving.mass = mass
    assert stage.start() == 0
    for k in range(round(stop_time / dt)):
        motor.i_a_cmd, motor.i_b_cmd, motor.i_c_cmd = phases(0.0, current, moving.position).tolist()
        assert stage.step(k * dt, dt) == 0
    return float(moving.position)


@pytest.mark.parametrize(("description", "axis", "constant", "motors"), [
    (2, "h", "C1", 1), (3, "x", "C1", 2), (3, "z", "C2", 2)])
@pytest.mark.parametrize("factor", [0.5, 1.0, 2.0, 10.0])
def test_a_current_drives_a_mass_by_newtons_law(description: int, axis: str, constant: str, motors: int,
                                                factor: float) -> None:
    """Half the way at twice the mass, the same way at twice the mass under twice the current; alike on h, x and z."""
    nominal = NOMINAL[description][LAYOUTS[description][0].index(axis)]
    gap = shape_functions(20e-3 if description == 2 else 25e-3)[0]
    thrust = nominal * motors * getattr(REGULATORS[description](), constant) * gap   # N/A
    way = simulated(description, axis, factor * nominal, 0.5)
    assert way == pytest.approx(-0.5 * thrust * 0.5 / (factor * nominal) * 0.1**2, rel=2e-3)
    heavier = simulated(description, axis, factor * nominal, 0.5 * factor)
    assert heavier == pytest.approx(simulated(description, axis, nominal, 0.5), rel=2e-3)


@both
def test_ten_times_the_mass_falls_another_way(description: int) -> None:
    """Without friction, stops or an external force, where only the motors know of the mass."""
    def fall(factor: float) -> float:
        stage = STAGES[description]()
        idealise(description, stage, REGULATORS[description]())
        vertical = axes_of(description, stage)[0]
        vertical.mass *= factor
        assert stage.start() == 0
        assert stage.step(0.0, 0.02) == 0
        return float(vertical.position - vertical.position_start)

    attraction = motor_forces(description, constants(description, REGULATORS[description]()),
                              [20e-3 if description == 2 else 25e-3, 0.0, 0.0], 0.0,
                              [0.0] * (description - 1), [0.0] * (description - 1))[0] / NOMINAL[description][0]
    for factor in (1.0, 10.0):
        assert fall(factor) == pytest.approx(0.5 * (G + attraction / factor) * 0.02**2, rel=0.05)


@both
@given(factor=st.floats(0.7, 1.4), gap=st.floats(19e-3, 24e-3))
def test_equilibrium_current_is_the_root_of_the_balance_of_forces(description: int, factor: float, gap: float) -> None:
    """The current that balances m G in newtons holds the stage; that of the nominal mass lets it go by G (1 − m0/m)."""
    stage = STAGES[description]()
    idealise(description, stage, REGULATORS[description]())
    mass = factor * NOMINAL[description][0]

    def balance(current: float, at: float) -> float:
        return at * G + motor_forces(description, constants(description, stage), [gap, 0.0, 0.0], 0.0,
                                     [current] * (description - 1),
                                     [0.0] * (description - 1))[0]

    def acceleration(current: float) -> float:
        for motor in LAYOUTS[description][1]:
            getattr(stage, motor).i_d, getattr(stage, motor).i_q = current, 0.0
        vertical.begin()
        stage.add_slope(0.0, 0.0)
        return float(vertical.acceleration)

    vertical = axes_of(description, stage)[0]
    vertical.mass, vertical.position = mass, gap
    held = brentq(balance, -30.0, 30.0, args=(mass,), xtol=1e-13)
    assert acceleration(held) == pytest.approx(0.0, abs=1e-9)
    unloaded = brentq(balance, -30.0, 30.0, args=(NOMINAL[description][0],), xtol=1e-13)
    assert acceleration(unloaded) == pytest.approx(G * (1.0 - 1.0 / factor), abs=1e-9)


@both
@given(load=st.tuples(loads, loads, loads), gap=st.floats(19e-3, 27e-3), i=st.tuples(*[st.floats(-4.0, 4.0)] * 4))
def test_an_identification_sees_constants_at_the_present_masses(description: int, load: tuple[float, ...], gap: float,
                                                                i: tuple[float, ...]) -> None:
    """Its model moves like the stage with every constant times nominal mass / mass of the axis that it acts on."""
    stage, described = STAGES[description](), described_stages[f"{description}dof"]
    idealise(description, stage, REGULATORS[description]())
    i_d, i_q = i[:description - 1], i[2:description + 1]
    seen = {}
    for axis, nominal, factor, row in zip(axes_of(description, stage), NOMINAL[description], load, described.rows,
                                          strict=False):
        axis.mass = factor * nominal
        axis.begin()
        seen.update({name: getattr(stage, name) / factor for name in row.constants})
    axes_of(description, stage)[0].position = gap
    for name, direct, quadrature in zip(LAYOUTS[description][1], i_d, i_q, strict=True):
        getattr(stage, name).i_d, getattr(stage, name).i_q = direct, quadrature
    stage.add_slope(0.0, 0.0)
    expected = accelerations(described, np.array([[gap, 0.0, 0.0][:description]]), np.array([i_d]), np.array([i_q]),
                             seen)
    assert [axis.acceleration for axis in axes_of(description, stage)] == pytest.approx(expected[0], rel=1e-12,
                                                                                        abs=1e-12)


@both
def test_a_load_put_on_counts_from_the_next_step(description: int) -> None:
    """The mass is tunable."""
    stage = STAGES[description]()
    idealise(description, stage, REGULATORS[description]())
    vertical = axes_of(description, stage)[0]
    vertical.locked = False
    assert stage.start() == 0
    assert stage.step(0.0, 1e-4) == 0
    before = vertical.acceleration
    vertical.mass *= 2.0
    assert stage.step(1e-4, 1e-4) == 0
    assert vertical.acceleration - G == pytest.approx(0.5 * (before - G), rel=1e-3)
