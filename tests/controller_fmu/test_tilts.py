"""Controllers of a platform that tilts: allocation of the forces, measurement of the tilts, and what follows."""

from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from named_controllers import PID5DOF, Commutation5DOF, Regulator3DOF, Regulator5DOF

from controller_fmu.force_allocation import ForceAllocation
from controller_fmu.motor_place import MotorPlace
from controller_fmu.status import BAD_PLACES, LINEAR, NONLINEAR, STEPPED
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from maglev.descriptions.packaged import PACKAGED_STAGES
from pmlsm.gap_functions import gap_functions
from pmlsm.velocity_rows import GRAVITY

STAGE_5DOF = PACKAGED_STAGES["5dof"]

MOTORS = STAGE_5DOF.motor_names
AXES = STAGE_5DOF.axis_names
PLACES = [(0.0, 0.2), (0.0, -0.2), (0.2, 0.0), (-0.2, 0.0)]   # x, z of the motors, m
J = np.array([[1.0, -z, x] for x, z in PLACES])
MASSES = 6.9, 10.6, 8.6   # kg, of y, x, z
INERTIA = 0.2             # kg m²
HEIGHT = -0.03            # m

LENGTH = st.floats(-0.5, 0.5)


def gap_of(controller: Any, motor: str) -> Any:
    """Place of a motor, with its gap."""
    return getattr(controller, f"{motor}_place")


def measure(controller: Any, gaps: Any, x: float = 0.0, z: float = 0.0) -> None:
    """Give a controller measurements."""
    controller.x.measured, controller.z.measured = x, z
    for motor, gap in zip(MOTORS, gaps, strict=True):
        gap_of(controller, motor).gap_measured = gap


def currents(controller: Any) -> np.ndarray:
    """Direct and quadrature currents that are commanded, A, shape (motors, 2)."""
    return np.array([[getattr(controller, motor).i_d_cmd, getattr(controller, motor).i_q_cmd] for motor in MOTORS])


def proportional(law: int, gaps: Any, demands: Any) -> Regulator5DOF:
    """Regulator whose axes demand these accelerations at these gaps, and nothing else."""
    controller = Regulator5DOF(law)
    controller.current_limit = 0.0
    for axis in AXES:
        regulator = getattr(controller, axis)
        regulator.k1, regulator.k2, regulator.k3, regulator.k4, regulator.k5 = -1.0, 0.0, 0.0, 0.0, 0.0
    assert controller.start() == STEPPED
    y, roll, pitch = np.linalg.pinv(J) @ gaps
    for axis, at in zip(AXES, (y, 0.0, 0.0, roll, pitch), strict=True):
        getattr(controller, axis).reference = at
    measure(controller, gaps)
    controller.sample()   # without an error, so that nothing is integrated
    for axis, demand in zip(AXES, demands, strict=True):
        getattr(controller, axis).reference += demand
    controller.sample()
    return controller


def accelerations(controller: Any, gaps: Any) -> np.ndarray:
    """Accelerations of y, x, z, roll, pitch by the commanded currents, from the equations of motion with C1 to C5."""
    normal, thrust = [], []
    for k, (gap, (i_d, i_q)) in enumerate(zip(gaps, currents(controller), strict=True)):
        f1, f2, f3, f4 = gap_functions(controller.geometry, gap)
        normal.append(MASSES[0] * (controller.C4 * f3 * i_d - controller.C5 * f4 * (i_d**2 + i_q**2)
                                   - controller.C3 * f2))
        thrust.append(-MASSES[1] * controller.C1 * f1 * i_q if k < 2 else -MASSES[2] * controller.C2 * f1 * i_q)
    along_x, along_z = sum(thrust[:2]), sum(thrust[2:])
    roll = -sum(z * n for (_, z), n in zip(PLACES, normal, strict=True)) + HEIGHT * along_z
    pitch = sum(x * n for (x, _), n in zip(PLACES, normal, strict=True)) - HEIGHT * along_x
    return np.array([GRAVITY + sum(normal) / MASSES[0], along_x / MASSES[1], along_z / MASSES[2], roll / INERTIA,
                     pitch / INERTIA])


def shared(places: list[tuple[float, float]]) -> tuple[TiltingPlatform, list[MotorPlace], bool]:
    """Platform with motors at places, and whether these can make every torque."""
    platform = TiltingPlatform(HEIGHT, [MotorPlace(x, z, 0.025) for x, z in places], 2)
    return platform, platform.places, platform.prepare()


@given(st.lists(st.tuples(LENGTH, LENGTH), min_size=3, max_size=6), st.tuples(*[st.floats(-100.0, 100.0)] * 3))
def test_the_allocation_makes_the_wrench_with_the_smallest_forces(places: list[tuple[float, float]],
                                                                  wrench: tuple[float, float, float]) -> None:
    """The pseudo-inverse of Jᵀ, whose solution has the smallest norm; and S, its transpose, measures the tilts."""
    jacobian = np.array([[1.0, -z, x] for x, z in places])
    assume(np.linalg.svd(jacobian, compute_uv=False)[-1] > 0.05)
    _, motors, solvable = shared(places)
    assert solvable
    forces = np.array([motor.carried(*wrench) for motor in motors])
    assert jacobian.T @ forces == pytest.approx(np.array(wrench), abs=1e-8)
    assert forces == pytest.approx(np.linalg.pinv(jacobian.T) @ np.array(wrench), rel=1e-9, abs=1e-8)
    tilts = TiltMeasurement()
    for motor in motors:
        tilts.add(motor, motor.moved(*wrench))
    assert (tilts.y, tilts.roll, tilts.pitch) == pytest.approx(wrench, abs=1e-8)


@pytest.mark.parametrize("places", [[(0.1, 0.1), (0.2, 0.2), (-0.3, -0.3)], [(0.0, 0.2), (0.0, -0.2), (0.0, 0.1)],
                                    [(0.1, 0.1)] * 4])
def test_motors_on_one_line_are_refused(places: list[tuple[float, float]]) -> None:
    assert not shared(places)[2]


@pytest.mark.parametrize("block", [Regulator5DOF, PID5DOF, Commutation5DOF])
def test_controllers_refuse_motors_on_one_line(block: type) -> None:
    controller = block()
    assert controller.start() == STEPPED
    for motor in MOTORS:
        gap_of(controller, motor).x = 0.0
    assert controller.start() == BAD_PLACES


@given(st.tuples(*[st.floats(0.021, 0.029)] * 4), st.floats(-4.0, 1.0), st.tuples(*[st.floats(-1.0, 1.0)] * 4))
def test_the_currents_make_the_demanded_accelerations(gaps: tuple[float, ...], vertical: float,
                                                      others: tuple[float, ...]) -> None:
    """Thrusts above the centre of mass do not tilt the platform, and both motors of an axis push alike."""
    demands = np.array([vertical, *others[:2], 5.0 * others[2], 5.0 * others[3]])
    controller = proportional(NONLINEAR, np.array(gaps), demands)
    assert controller.feasible
    assert accelerations(controller, gaps) == pytest.approx(demands, abs=1e-8)
    thrusts = [gap_functions(controller.geometry, gap)[0] * i_q for gap, (_, i_q) in
               zip(gaps, currents(controller), strict=True)]
    assert thrusts[0] == pytest.approx(thrusts[1], abs=1e-12)
    assert thrusts[2] == pytest.approx(thrusts[3], abs=1e-12)


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("law", [NONLINEAR, LINEAR])
def test_without_tilt_it_is_the_regulator_without_tilts(law: int) -> None:
    """Levitation alone: what thrusts take from the vertical acceleration, these make good at other motors."""
    five, three = Regulator5DOF(law), Regulator3DOF(law)
    assert five.start() == three.start() == STEPPED
    for k in range(2000):
        gap = 0.024 + 1e-3 * np.sin(0.01 * k)
        three.y.measured = gap
        measure(five, [gap] * 4)
        five.y.reference = three.y.reference = 0.0245
        five.sample()
        three.sample()
        assert currents(five)[:, 0] == pytest.approx([three.alpha.i_d_cmd] * 4, rel=1e-10)
        assert np.abs(currents(five)[:, 1]).max() == 0.0


def test_near_the_set_point_the_linear_law_is_the_nonlinear_one() -> None:
    """To first order in what the platform is away: half as far, a quarter of the difference."""
    away = np.array([40e-6, -25e-6, 15e-6, 30e-6])

    def difference(part: float) -> np.ndarray:
        """Between the direct currents of the two laws, each begun at rest at the setpoint."""
        laws = []
        for law in (NONLINEAR, LINEAR):
            controller = Regulator5DOF(law)
            assert controller.start() == STEPPED
            measure(controller, [0.025] * 4)
            controller.sample()
            measure(controller, 0.025 + part * away, 30e-6 * part, -20e-6 * part)
            controller.sample()
            laws.append(currents(controller)[:, 0])
        assert np.abs(laws[0]).max() > 1e-3 * part
        return laws[0] - laws[1]

    assert difference(0.5) == pytest.approx(0.25 * difference(1.0), rel=0.05, abs=1e-9)


def test_the_antiwindup_of_y_roll_and_pitch_is_the_transpose_of_the_allocation() -> None:
    """A limit that takes of the motors what no tilt needs corrects y alone, others what the pseudo-inverse says."""
    demands = np.array([-8.0, 0.0, 0.0, 20.0, -30.0])
    free, limited = (proportional(NONLINEAR, np.full(4, 0.022), np.zeros(5)) for _ in range(2))
    limited.current_limit = 1.0
    for axis, demand in zip(AXES, demands, strict=True):
        for controller in (free, limited):
            getattr(controller, axis).reference += demand
    free.sample()
    limited.sample()
    taken = currents(limited)[:, 0] - currents(free)[:, 0]
    assert (np.count_nonzero(taken), limited.saturated) == (pytest.approx(3, abs=1), True)
    expected = np.linalg.pinv(J) @ taken
    for axis, excess in zip(("y", "roll", "pitch"), expected, strict=True):
        of = getattr(limited, axis)
        corrected = of.model.xi3 - getattr(free, axis).model.xi3
        assert corrected == pytest.approx(of.ec3 * limited.sample_time * excess, rel=1e-6, abs=1e-18)


def test_allocated_torques_hold_off_the_levers_of_the_thrusts() -> None:
    """By hand: 1 m/s² along x at 30 mm above the centre of mass is 0.318 N m, held by beta1 and beta2 at 0.2 m."""
    platform, motors, _ = shared(PLACES)
    allocation = ForceAllocation(*MASSES, INERTIA, INERTIA)
    allocation.demand(platform, GRAVITY, 1.0, 0.0, 0.0, 0.0)
    forces = [6.9 * motor.carried(allocation.force, allocation.roll_torque, allocation.pitch_torque)
              for motor in motors]
    assert forces == pytest.approx([0.0, 0.0, -0.795, 0.795], abs=1e-12)


@pytest.mark.parametrize(("block", "name"), [(Regulator5DOF, "trip_error"), (PID5DOF, "trip_error"),
                                             (Regulator5DOF, "trip_tilt"), (PID5DOF, "trip_tilt")])
def test_trips_of_positions_and_of_tilts_are_two(block: type, name: str) -> None:
    """1 mm of error on y does not trip a tilt, 10 mrad of roll no position."""
    away = {"trip_error": np.full(4, 1e-3), "trip_tilt": J @ [0.0, 0.01, 0.0]}
    other = "trip_tilt" if name == "trip_error" else "trip_error"
    for limit, shift, tripped in ((name, name, True), (other, name, False)):
        controller = block()
        setattr(controller, limit, 0.5e-3 if limit == "trip_error" else 5e-3)
        assert controller.start() == STEPPED
        measure(controller, 0.025 + away[shift])
        controller.sample()
        assert controller.tripped is tripped
        assert bool(np.any(currents(controller))) is not tripped


@pytest.mark.parametrize("block", [Regulator5DOF, PID5DOF])
def test_it_begins_with_the_currents_that_hold_the_platform(block: type) -> None:
    """Also tilted; the model's forces then balance on y, roll and pitch."""
    gaps = 0.025 + J @ [0.0, 3e-3, -2e-3]
    controller = block()
    assert controller.start() == STEPPED
    measure(controller, gaps)
    for axis, at in zip(("y", "roll", "pitch"), (0.025, 3e-3, -2e-3), strict=True):
        getattr(controller, axis).reference = at
    controller.sample()
    tolerance = 1e-9 if block is Regulator5DOF else 0.02   # a PID's slopes are four currents by least squares
    assert accelerations(controller, gaps)[[0, 3, 4]] == pytest.approx(np.zeros(3), abs=tolerance)


def test_motors_commutate_with_the_displacement_at_their_magnets() -> None:
    """Of alpha x − h pitch, of beta z + h roll."""
    controller = Commutation5DOF()
    assert controller.start() == STEPPED
    measure(controller, 0.025 + J @ [0.0, 4e-3, -6e-3], 0.010, -0.005)
    for motor in MOTORS:
        getattr(controller, motor).i_d_reference = 1.0
    controller.sample()
    for motor, displacement in zip(MOTORS, [0.010 + 0.03 * -6e-3] * 2 + [-0.005 - 0.03 * 4e-3] * 2, strict=True):
        angle = controller.geometry.electrical_angle(displacement)
        assert getattr(controller, motor).command.i_a_cmd == pytest.approx(np.cos(angle), abs=1e-12)
