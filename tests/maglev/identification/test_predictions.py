"""What the model predicts from its constants, against the stages' force balance, the controllers' law and parabolas."""

from math import sqrt
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from motor import MOTOR
from named_stage import Stage2DOF, Stage3DOF
from scipy.optimize import brentq

from controller_fmu.feedback_linearisation import equilibrium_current
from maglev.identification.regressors import (
    ESTIMATED_STAGES,
    accelerations,
    attraction_force,
    equilibrium_currents,
    row_of,
    thrust_of_parabola,
    thrust_shape,
)
from pmlsm.gap_functions import gap_functions
from pmlsm.velocity_rows import GRAVITY

STAGES: dict[str, Any] = {"2dof": Stage2DOF, "3dof": Stage3DOF}
both_stages = pytest.mark.parametrize("name", ["2dof", "3dof"])


def constants_of(name: str) -> dict[str, float]:
    """Constants of the stage."""
    stage = STAGES[name]()
    return {constant: getattr(stage, constant) for constant in ESTIMATED_STAGES[name].constants}


@st.composite
def cases(draw: st.DrawFn) -> tuple[str, np.ndarray, dict[str, float]]:
    """A stage, air gaps of its range, and constants around its own."""
    name = draw(st.sampled_from(["2dof", "3dof"]))
    gaps = draw(st.lists(st.floats(0.008, 0.04), min_size=1, max_size=5))
    return name, np.array(gaps), {constant: draw(st.floats(0.3, 3.0)) * value
                                  for constant, value in constants_of(name).items()}


def discriminant(name: str, gap: float, constants: dict[str, float]) -> tuple[float, float]:
    """Discriminant of the vertical row at an air gap (m), by hand from (4.10), and its larger term."""
    _, f2, f3, f4 = gap_functions(MOTOR, gap)
    c2, c3, c4 = ((constants["C2"], constants["C3"], constants["C4"]) if name == "2dof"
                  else (4 * constants["C3"], 4 * constants["C4"], 4 * constants["C5"]))
    terms = (c3 * f3) ** 2, 4.0 * c4 * f4 * (c2 * f2 - GRAVITY)
    return terms[0] - terms[1], max(map(abs, terms))


@given(case=cases())
def test_equilibrium_currents_hold_the_mover(case: tuple[str, np.ndarray, dict[str, float]]) -> None:
    """Plugged into the rows of the stage they leave no vertical acceleration; without a root there is no value."""
    name, gaps, constants = case
    stage = ESTIMATED_STAGES[name]
    currents = equilibrium_currents(stage, gaps, constants)
    assert currents.shape == gaps.shape
    for gap, current in zip(gaps.tolist(), currents.tolist(), strict=True):
        left, scale = discriminant(name, gap, constants)
        # Within rounding of a double root either is right.
        if left > 1e-9 * scale:
            positions = np.array([[gap, *([0.0] * (len(stage.axes) - 1))]])
            i_d = np.full((1, len(stage.motors)), current)
            vertical = accelerations(stage, positions, i_d, np.zeros_like(i_d), constants)[0, 0]
            _, f2, f3, _ = gap_functions(MOTOR, gap)
            assert abs(vertical) < 1e-9 * (GRAVITY + abs(current) * 4 * max(constants.values()) * f3)
        elif left < -1e-9 * scale:
            assert np.isnan(current)


def test_predicts_no_current_where_none_holds_the_mover() -> None:
    """Attraction and repulsion a hundred times as strong leave no equilibrium in small air gaps, but in large ones."""
    constants = constants_of("2dof")
    stiff = {**constants, "C2": 100.0 * constants["C2"], "C4": 100.0 * constants["C4"]}
    with np.errstate(all="raise"):
        found = equilibrium_currents(ESTIMATED_STAGES["2dof"], np.array([0.01, 0.02]), stiff)
        assert np.isnan(found).all()
        assert np.isfinite(equilibrium_currents(ESTIMATED_STAGES["2dof"], np.array([0.01, 0.02]), constants)).all()


@given(gap=st.floats(0.008, 0.04))
def test_the_smaller_root_is_that_of_the_controllers(gap: float) -> None:
    """Of both stages; the 3-DOF one has four motors, one direct current in both pairs."""
    constants = constants_of("2dof")
    expected, found = equilibrium_current(MOTOR, constants["C2"], constants["C3"], constants["C4"], gap)
    assert found
    assert equilibrium_currents(ESTIMATED_STAGES["2dof"], np.array([gap]), constants)[0] == pytest.approx(expected,
                                                                                                         abs=1e-9)
    constants = constants_of("3dof")
    expected, found = equilibrium_current(MOTOR, 4 * constants["C3"], 4 * constants["C4"], 4 * constants["C5"], gap)
    assert found
    assert equilibrium_currents(ESTIMATED_STAGES["3dof"], np.array([gap]), constants)[0] == pytest.approx(expected,
                                                                                                         abs=1e-9)


def vertical_acceleration(name: str, gap: float, current: float) -> float:
    """Of the stage itself (m/s²) at an air gap (m) and a direct current (A) in all motors, by its amplifiers."""
    stage = STAGES[name]()
    stage.attraction_modulation = 0.0
    axis = getattr(stage, ESTIMATED_STAGES[name].axes[0])
    axis.bias = axis.friction.coulomb = axis.friction.viscous = 0.0
    if name == "3dof":
        axis.ripple.amplitude = 0.0
    axis.stop.lower, axis.stop.upper, axis.position_start = 0.008, 0.04, gap
    assert stage.start() == 0
    for motor in ESTIMATED_STAGES[name].motors:
        supply = getattr(stage, motor)
        supply.amplifier.lag = 0.0
        supply.i_a_cmd, supply.i_b_cmd, supply.i_c_cmd = phases(current)
    step = 1e-6
    assert stage.step(0.0, step) == 0
    return axis.velocity / step


def phases(i_d: float) -> tuple[float, float, float]:
    """Phase currents of a direct current alone, up to its sign: at zero displacement phase a makes thrust only."""
    return 0.0, 0.5 * sqrt(3.0) * i_d, -0.5 * sqrt(3.0) * i_d


@both_stages
@pytest.mark.parametrize("gap", [0.0125, 0.02, 0.03])
def test_equilibrium_currents_balance_the_forces_of_the_stage(name: str, gap: float) -> None:
    scale = direct_current(name)
    current = brentq(lambda i: vertical_acceleration(name, gap, i / scale), -15.0, 15.0, xtol=1e-12)
    predicted = equilibrium_currents(ESTIMATED_STAGES[name], np.array([gap]), constants_of(name))
    assert predicted[0] == pytest.approx(current, abs=1e-5)


def direct_current(name: str) -> float:
    """Direct current (A) that the stage sees of `phases` of 1 A."""
    stage = STAGES[name]()
    for motor in ESTIMATED_STAGES[name].motors:
        supply = getattr(stage, motor)
        supply.amplifier.lag = 0.0
        supply.i_a_cmd, supply.i_b_cmd, supply.i_c_cmd = phases(1.0)
    assert stage.start() == stage.step(0.0, 1e-9) == 0
    supply = getattr(stage, ESTIMATED_STAGES[name].motors[0])
    assert supply.i_q == pytest.approx(0.0, abs=1e-12)
    return float(supply.i_d)


@pytest.mark.parametrize(("name", "axis", "constant", "factor"), [
    ("2dof", "h", "C1", 1.0), ("3dof", "x", "C1", 2.0), ("3dof", "z", "C2", 2.0)])
def test_an_axis_is_driven_by_so_many_motors(name: str, axis: str, constant: str, factor: float) -> None:
    time = np.linspace(0.0, 0.5, 50)
    position = 0.02 - 0.5 * factor * 3.0 * 2.0 * time**2   # at 2 A, and an L of 3 m/(s² A)
    assert thrust_of_parabola(ESTIMATED_STAGES[name], axis, time, position, 2.0) == pytest.approx(3.0)
    assert row_of(ESTIMATED_STAGES[name], axis).constants == (constant,)


@pytest.mark.parametrize("stage", ESTIMATED_STAGES.values(), ids=ESTIMATED_STAGES)
def test_row_of_an_axis(stage: Any) -> None:
    assert [row_of(stage, axis).axis for axis in stage.axes] == list(stage.axes)


@given(gaps=st.lists(st.floats(0.008, 0.04), min_size=1, max_size=5))
def test_shapes_over_the_air_gap(gaps: list[float]) -> None:
    expected = np.array([gap_functions(MOTOR, gap) for gap in gaps])
    assert np.array_equal(thrust_shape(ESTIMATED_STAGES["2dof"], np.array(gaps)), expected[:, 0])
    for stage in ESTIMATED_STAGES.values():
        force = attraction_force(stage, np.array(gaps), 21.01, 7.5)
        assert force == pytest.approx(7.5 * 21.01 * expected[:, 1], rel=1e-12)


AXES = st.sampled_from([("2dof", "h", 1), ("3dof", "x", 2), ("3dof", "z", 2)])
CURRENTS = st.floats(0.1, 6.0).flatmap(lambda size: st.sampled_from([size, -size]))


@given(axis=AXES, thrust=st.floats(0.1, 20.0), i_q=CURRENTS, start=st.floats(-0.06, 0.06), rows=st.integers(3, 400))
def test_thrust_of_an_exact_parabola(axis: tuple[str, str, int], thrust: float, i_q: float, start: float,
                                     rows: int) -> None:
    """x(t) = x(0) − ½ n L i_q t² gives L back, (4.6) and (5.5)."""
    name, which, motors = axis
    time = np.linspace(0.0, 0.2, rows)
    position = start - 0.5 * motors * thrust * i_q * time**2
    assert thrust_of_parabola(ESTIMATED_STAGES[name], which, time, position, i_q) == pytest.approx(thrust, rel=1e-6)


@given(seed=st.integers(0, 2**32 - 1), thrust=st.floats(4.0, 12.0))
def test_thrust_of_a_parabola_that_encoders_have_measured(seed: int, thrust: float) -> None:
    """Independent errors of an encoder move L by six of the standard deviations of least squares at the very most."""
    time = 0.5e-3 * np.arange(400, dtype=float)
    i_q, resolution = -0.5, 10e-6
    errors = np.random.default_rng(seed).uniform(-0.5, 0.5, len(time)) * resolution
    found = thrust_of_parabola(ESTIMATED_STAGES["2dof"], "h", time, -0.05 - 0.5 * thrust * i_q * time**2 + errors, i_q)
    square = 0.5 * time**2 - np.mean(0.5 * time**2)
    deviation = resolution / np.sqrt(12.0) / np.sqrt(square @ square) / abs(i_q)
    assert abs(found - thrust) < 6.0 * deviation < 2e-3 * thrust
