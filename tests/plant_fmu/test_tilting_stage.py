"""The 5-DOF stage against its equations, written independently, and the 3-DOF stage; forces against virtual work."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from named_stage import Stage3DOF, Stage5DOF
from reference_5dof import Reference5DOF
from reference_stage import G
from stage_cases import equilibrium_current, phases

from plant_fmu.payload import Payload
from plant_fmu.tilt_guide import TiltGuide

pytestmark = pytest.mark.usefixtures("slow")

AXES, MOTORS = ("y", "x", "z", "roll", "pitch"), ("alpha1", "alpha2", "beta1", "beta2")
STEP = 0.2e-3
Commands = Callable[[int], np.ndarray]   # phase commands by step, shape (4, 3)

gaps = st.floats(20e-3, 28e-3)
ways = st.tuples(*[st.floats(-0.03, 0.03)] * 2)
tilts = st.tuples(*[st.floats(-0.01, 0.01)] * 2)
currents = st.tuples(*[st.floats(-3.0, 3.0)] * 8)


def axes_of(stage: Any) -> list[Any]:
    return [getattr(stage, name) for name in AXES]


def command(stage: Any, motor: str, currents: Sequence[float] | np.ndarray) -> None:
    supply = getattr(stage, motor)
    supply.i_a_cmd, supply.i_b_cmd, supply.i_c_cmd = map(float, currents)


def ideal(stage: Stage5DOF) -> Stage5DOF:
    """A stage without guides' effects, so that only motors, gravity and payload move it."""
    for axis in axes_of(stage):
        axis.bias = axis.friction.coulomb = axis.friction.viscous = axis.ripple.amplitude = 0.0
    return stage


def moved_to(stage: Stage5DOF, q: Sequence[float] | np.ndarray) -> Stage5DOF:
    """The stage at a place, at rest."""
    for axis, position in zip(axes_of(stage), q, strict=True):
        axis.position = position
    stage.mover.place(stage.axes)
    return stage


def simulated(stage: Stage5DOF, commands: Commands, steps: int) -> np.ndarray:
    """Positions at every communication point, shape (steps + 1, 5)."""
    assert stage.start() == 0
    rows = [[axis.position for axis in axes_of(stage)]]
    for k in range(steps):
        for motor, given_to in zip(MOTORS, commands(k), strict=True):
            command(stage, motor, given_to)
        assert stage.step(k * STEP, STEP) == 0
        rows.append([axis.position for axis in axes_of(stage)])
    return np.array(rows)


def lively(gap: float) -> Commands:
    """Currents near the equilibrium at a gap, another one in every motor."""
    i_d = equilibrium_current(3, gap)

    def commands(k: int) -> np.ndarray:
        t = k * STEP
        return np.array([phases(i_d + 0.2 * np.sin(100.0 * t + i), 0.8 * np.sin(90.0 * t + 2.0 * i), 0.004)
                         for i in range(4)])
    return commands


CASES: dict[str, tuple[Reference5DOF, tuple[float, ...], Commands]] = {
    "far from the middle": (Reference5DOF(push=(3.0, -4.0, 5.0, 0.1, -0.2)), (23e-3, 4e-3, -10e-3, 4e-3, 3e-3),
                            lively(23e-3)),
    "payload": (Reference5DOF(payload=(0.5, 0.1, 0.05)), (24e-3, 0.0, 0.0, 0.0, 0.0), lively(24e-3)),
    "guides": (Reference5DOF(guide=(2e3, 0.5e-3)), (25e-3, 0.0, 0.0, 1e-3, 0.0), lively(25e-3)),
    "into the stops": (Reference5DOF(), (29e-3, 0.0, 0.0, 8e-3, -5e-3), lambda k: np.zeros((4, 3)))}


@pytest.mark.few(1)
@pytest.mark.parametrize("name", CASES)
def test_motion_is_that_of_the_equations(name: str) -> None:
    reference, start, commands = CASES[name]
    stage = Stage5DOF()
    for axis, position, push in zip(axes_of(stage), start, reference.push, strict=True):
        axis.position_start, axis.force = position, push
    stage.payload.mass, stage.payload.x, stage.payload.z = reference.payload
    for guide in (stage.roll_guide, stage.pitch_guide):
        guide.stiffness, guide.play = reference.guide
    steps = 500 if name == "into the stops" else 300   # on the way there as long
    found = simulated(stage, commands, steps)
    expected = reference.solve(np.array(start), commands, STEP, steps)
    assert np.ptp(found, axis=0).min() > 1e-4, "all move"
    assert stage.at_stop or name != "into the stops"
    assert np.abs(found - expected).max() < 1e-7


@pytest.mark.parametrize("stops", [False, True])
def test_without_tilt_it_is_the_3_dof_stage(stops: bool) -> None:
    """Both motors of a pair commanded alike, and no modulation; also on the end stops."""
    five, three = Stage5DOF(), Stage3DOF()
    five.roll.locked = five.pitch.locked = True
    five.attraction_modulation = three.attraction_modulation = 0.0
    start = 30.5e-3 if stops else 25e-3
    five.y.position_start = three.y.position_start = start
    assert five.start() == three.start() == 0
    i_d = 0.0 if stops else equilibrium_current(3, start)
    met, furthest = False, 0.0
    for k in range(500):
        t = k * STEP
        pairs = {"alpha": phases(i_d + 0.1 * np.sin(80 * t), np.sin(60 * t), 0.0), "beta": phases(i_d, -1.0, 0.0)}
        for pair, given_to in pairs.items():
            for motor in (pair, f"{pair}1", f"{pair}2"):
                command(three if motor == pair else five, motor, given_to)
        assert five.step(t, STEP) == three.step(t, STEP) == 0
        met = met or three.at_stop
        furthest = max(furthest, abs(three.y.position - start))
        for axis in ("y", "x", "z"):
            assert getattr(five, axis).position == pytest.approx(getattr(three, axis).position, rel=1e-12, abs=1e-15)
        assert five.yaw_moment == pytest.approx(0.0, abs=1e-12)
        assert five.at_stop is three.at_stop
    assert met is stops and furthest > 1e-4 and abs(three.x.position) > 1e-4


@given(gap=gaps, way=ways, tilt=tilts, i=currents)
def test_forces_are_the_gradient_of_virtual_work(gap: float, way: tuple[float, float], tilt: tuple[float, float],
                                                 i: tuple[float, ...]) -> None:
    """What a coordinate gets of a motor is its force times how its gap and its displacement go with the coordinate."""
    stage, q = ideal(Stage5DOF()), np.array([gap, *way, *tilt])
    for motor, i_d, i_q in zip(MOTORS, i[:4], i[4:], strict=True):
        getattr(stage, motor).i_d, getattr(stage, motor).i_q = i_d, i_q
    for axis in axes_of(stage):
        axis.begin()   # takes the bias
    moved_to(stage, q).add_slope(0.0, 0.0)
    mounts = [getattr(stage, f"{motor}_mount") for motor in MOTORS]
    forces = [(mount.normal, mount.thrust) for mount in mounts]
    accelerations = [axis.acceleration for axis in axes_of(stage)]
    for k, axis in enumerate(axes_of(stage)):
        work = []
        for ahead in (1e-4, -1e-4):
            moved_to(stage, q + ahead * np.eye(5)[k])
            work.append(sum(n * mount.gap + t * stage.mover.displacements[mount.axis]
                            for mount, (n, t) in zip(mounts, forces, strict=True)))
        weight = axis.mass * G if k == 0 else 0.0
        assert axis.mass * accelerations[k] == pytest.approx((work[0] - work[1]) / 2e-4 + weight, rel=1e-9, abs=1e-8)


@given(way=ways, tilt=tilts)
def test_gaps_are_those_of_a_turned_platform(way: tuple[float, float], tilt: tuple[float, float]) -> None:
    """A rotation about x and one about z, right-handed with y down, to the second order of the tilts."""
    stage = moved_to(Stage5DOF(), [25e-3, *way, *tilt])
    (c, s), (c2, s2) = ((np.cos(angle), np.sin(angle)) for angle in tilt)
    turn = np.array([[c2, -s2, 0], [s2, c2, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    for motor, along in zip(MOTORS, (0, 0, 2, 2), strict=True):
        mount = getattr(stage, f"{motor}_mount")
        place = np.array([mount.x, stage.height, mount.z])
        shift = turn @ place - place
        assert mount.gap == pytest.approx(25e-3 + shift[1], abs=4e-6)
        moved = stage.mover.displacements[mount.axis]
        assert moved == pytest.approx(way[along // 2] + shift[along], abs=0.25 * 1.5e-4)


def mirrored(across: str, place: np.ndarray) -> np.ndarray:
    """Coordinates in a mirror that turns x or z round."""
    return place * (np.array([1, -1, 1, 1, -1]) if across == "x" else np.array([1, 1, -1, -1, 1]))


@pytest.mark.parametrize("across", ["x", "z"])
def test_a_mirror_shows_the_same_motion(across: str) -> None:
    """Under external forces: a motor repeats after two pole pitches, not at a mirror image."""
    place, push, ends = np.array([24e-3, 2e-3, -3e-3, 1e-3, 2e-3]), np.array([5.0, 60.0, -40.0, 0.2, -0.3]), []
    for mirror in (False, True):
        stage = Stage5DOF()
        stage.x.bias = stage.z.bias = 0.0
        for axis, start, force in zip(axes_of(stage), mirrored(across, place) if mirror else place,
                                      mirrored(across, push) if mirror else push, strict=True):
            axis.position_start, axis.force = float(start), float(force)
        ends.append(simulated(stage, lambda k: np.zeros((4, 3)), 150)[-1])
    assert np.abs(ends[0] - place).min() > 5e-5, "all move"
    assert mirrored(across, ends[1]) == pytest.approx(ends[0], rel=1e-9)


@given(gap=gaps, i=st.tuples(*[st.floats(-3.0, 3.0)] * 4))
def test_yaw_moment(gap: float, i: tuple[float, ...]) -> None:
    """None of equal thrusts; else the lever times the difference, right-handed about y: a thrust along x at z > 0."""
    stage = Stage5DOF()
    stage.y.position_start = gap
    moments = []
    for q in (i, (i[0], i[0], i[2], i[2])):
        assert stage.start() == 0
        for motor, i_q in zip(MOTORS, q, strict=True):
            getattr(stage, motor).i_q = i_q
        stage.mover.push(stage.axes, stage.motors, stage.magnetics)
        stage.measure()
        moments.append(stage.yaw_moment)
    f1 = Reference5DOF().motors(np.array([gap, 0, 0, 0, 0]), np.array([phases(0.0, 1.0, 0.0)] * 4))[1]
    assert moments[0] == pytest.approx(0.2 * (f1[0] * (i[0] - i[1]) - f1[2] * (i[2] - i[3])), rel=1e-9, abs=1e-9)
    assert moments[1] == 0.0


@given(mass=st.floats(0.0, 5.0), x=st.floats(-0.2, 0.2), z=st.floats(-0.2, 0.2))
def test_a_payload_weighs_at_its_place(mass: float, x: float, z: float) -> None:
    """Torque r × F of its weight (0, p G, 0), and its moments of inertia about x and z as a point at the platform."""
    payload = Payload()
    payload.mass, payload.x, payload.z = mass, x, z
    torque = np.cross([x, 0.0, z], [0.0, mass * G, 0.0])
    assert (payload.roll_torque(), 0.0, payload.pitch_torque()) == pytest.approx(tuple(torque), abs=1e-15)
    inertia = mass * (np.dot([x, 0, z], [x, 0, z]) * np.eye(3) - np.outer([x, 0, z], [x, 0, z]))
    assert payload.roll_inertia() == pytest.approx(inertia[0, 0], abs=1e-15)
    assert payload.pitch_inertia() == pytest.approx(inertia[2, 2], abs=1e-15)


def test_a_payload_lands_in_mid_run() -> None:
    """From the step on in which its mass is set the platform has it, and no longer when it is taken away."""
    stage = ideal(Stage5DOF())
    stage.C3 = 0.0   # no attraction
    assert stage.start() == 0
    assert stage.step(0.0, 1e-3) == 0
    assert stage.roll.velocity == stage.pitch.velocity == 0.0
    stage.payload.mass, stage.payload.x, stage.payload.z = 2.0, 0.1, -0.05
    assert stage.step(1e-3, 1e-3) == 0
    spun = (1e-3 * 2.0 * G * 0.05 / (0.2 + 2.0 * 0.05**2), 1e-3 * 2.0 * G * 0.1 / (0.2 + 2.0 * 0.1**2))
    assert (stage.roll.velocity, stage.pitch.velocity) == pytest.approx(spun, rel=1e-12)
    assert stage.y.velocity == pytest.approx(2e-3 * G, rel=1e-12), "it falls as before"
    stage.payload.mass, stage.y.force = 0.0, 6.9
    assert stage.step(2e-3, 1e-3) == 0
    assert (stage.roll.velocity, stage.pitch.velocity) == pytest.approx(spun, rel=1e-12)
    assert stage.y.velocity == pytest.approx(3e-3 * G + 1e-3, rel=1e-12)


def test_guides_leave_a_play_and_hold_beyond() -> None:
    guide = TiltGuide()
    assert guide.torque(0.01) == 0.0, "off at the start"
    guide.stiffness, guide.play = 1e3, 2e-3
    assert [guide.torque(tilt) for tilt in (-3e-3, -2e-3, 0.0, 1e-3, 4e-3)] == pytest.approx([1.0, 0.0, 0.0, 0.0, -2.0])


@pytest.mark.parametrize(("start", "status"), [
    ({"x": 0.07}, 1), ({"z": -0.07}, 2), ({"y": 18e-3}, 3), ({"roll": -0.033}, 3), ({"roll": 0.033}, 4),
    ({"pitch": 0.033}, 5), ({"pitch": -0.033}, 6)])
def test_a_start_beyond_a_stop_is_refused(start: dict[str, float], status: int) -> None:
    """Of the motors the first whose gap is too small or too large: 26 mm and 0.2 m times 33 mrad are 32.6 mm."""
    stage = Stage5DOF()
    stage.y.position_start = 26e-3
    for axis, position in start.items():
        getattr(stage, axis).position_start = position
    assert stage.start() == status
