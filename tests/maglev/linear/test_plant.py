"""Linear models of the stages against derivatives by hand, by complex step, scipy's hold, and the blocks themselves."""

import numpy as np
import pytest
from complex_stage import complex_step, phase_commands, rates, rest_currents, shape_functions
from linear_blocks import AXES, MOTORS, plant_at, plant_state, set_all, smooth_stage
from reference_stage import TAU, ReferenceStage, reference_2dof, reference_3dof
from scipy.signal import cont2discrete

from maglev.linear.equilibrium import equilibrium
from maglev.linear.linearise import Currents, linearise
from maglev.linear.model import LinearModel

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

REFERENCE = {"Plant2DOF": reference_2dof, "Plant3DOF": reference_3dof}
PLACES = [("Plant2DOF", (16e-3, 0.0)), ("Plant2DOF", (20e-3, 4e-3)), ("Plant2DOF", (27e-3, -23e-3)),
          ("Plant3DOF", (19e-3, 0.0, 0.0)), ("Plant3DOF", (25e-3, 7e-3, -13e-3)),
          ("Plant3DOF", (29.5e-3, -31e-3, 2e-3))]
QUIET = {"Plant2DOF": {"v.bias": 0.0, "h.bias": 0.0},
         "Plant3DOF": {"y.bias": 0.0, "x.bias": 0.0, "z.bias": 0.0, "y.ripple.amplitude": 0.0}}


def at(name: str, place: tuple[float, ...]) -> dict[str, float | str]:
    return dict(zip(AXES[name], place, strict=True))


def by_complex_step(name: str, place: tuple[float, ...], currents: str, lag: bool, heavier: float = 1.0,
                    ripple: float | None = None) -> tuple[np.ndarray, np.ndarray]:
    """A and B with external forces, of the equations written again; masses by a factor, ripple (m/s²) of all axes."""
    stage: ReferenceStage = REFERENCE[name]()
    for axis in stage.axes:
        axis.mass *= heavier
        axis.ripple = axis.ripple if ripple is None else ripple
    dq = rest_currents(stage, place)
    n = len(place)
    state = np.array([*place, *np.zeros(n), *(dq.ravel() if lag else ())])
    inputs = np.array([*(dq.ravel() if currents == "dq" else phase_commands(dq, place)), *np.zeros(n)])
    assert np.abs(rates(stage, state, inputs, currents == "phases", lag)).max() < 1e-11
    a = complex_step(lambda s: rates(stage, s, inputs, currents == "phases", lag), state)
    b = complex_step(lambda u: rates(stage, state, u, currents == "phases", lag), inputs)
    return a, b


@pytest.mark.parametrize(("name", "place"), PLACES)
@pytest.mark.parametrize("currents", ["dq", "phases"])
@pytest.mark.parametrize("lag", [True, False])
def test_matrices_are_the_derivatives(name: str, place: tuple[float, ...], currents: Currents, lag: bool) -> None:
    """Every entry to 1e-9 of itself, except for those that are zero up to rounding."""
    model = linearise(name, at(name, place), currents=currents, amplifier=lag, forces=True)
    a, b = by_complex_step(name, place, currents, lag)
    np.testing.assert_allclose(model.A, a, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(model.B, b, rtol=1e-9, atol=1e-9)
    assert np.sort_complex(model.poles) == pytest.approx(np.sort_complex(np.linalg.eigvals(a)), rel=1e-9, abs=1e-7)


@pytest.mark.parametrize(("name", "place"), PLACES[1:5:3])
def test_ripple_along_every_axis(name: str, place: tuple[float, ...]) -> None:
    """Its slope is a spring along each axis, and its force counts in the equilibrium."""
    of_all = {f"{axis}.ripple.amplitude": 0.21 for axis in AXES[name]}
    slot_pitch = {"v.ripple.period": 19.05e-3} if name == "Plant2DOF" else {}
    model = linearise(name, at(name, place), forces=True, parameters={**of_all, **slot_pitch})
    a, b = by_complex_step(name, place, "dq", True, ripple=0.21)
    np.testing.assert_allclose(model.A, a, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(model.B, b, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize(("name", "place"), PLACES[1:5:3])
def test_roughness_is_left_out(name: str, place: tuple[float, ...]) -> None:
    """Its slope is a random number at each place: neither model nor place of rest know of it."""
    rough = {f"{axis}.roughness.rms": 0.1 for axis in AXES[name]}
    with_it, without = (linearise(name, at(name, place), forces=True, parameters={**given, **QUIET[name]})
                        for given in (rough, {}))
    for one, other in ((with_it.A, without.A), (with_it.B, without.B)):
        assert np.array_equal(one, other)


@pytest.mark.parametrize(("name", "place"), PLACES[1:5:3])
@pytest.mark.parametrize("heavier", [0.9, 1.15])
def test_payload(name: str, place: tuple[float, ...], heavier: float) -> None:
    """The forces of motors and guide stay the same, so that their accelerations shrink; gravity and bias do not."""
    masses = {f"{axis}.mass": axis_of.mass * heavier for axis, axis_of in zip(AXES[name], REFERENCE[name]().axes,
                                                                               strict=True)}
    model = linearise(name, at(name, place), currents="phases", forces=True, parameters=masses)
    a, b = by_complex_step(name, place, "phases", True, heavier)
    np.testing.assert_allclose(model.A, a, rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(model.B, b, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("gap", [19e-3, 22.6e-3, 25e-3, 29e-3])
def test_eigenvalues_by_hand(gap: float) -> None:
    """3-DOF without bias, ripple and viscous friction: ±√α of the gap, each horizontal axis a double integrator.

    α = 4 C4 f3' i_d − 4 C5 f4' i_d² − 4 C3 f2', and i_d is the root of 4 C5 f4 i² − 4 C4 f3 i + 4 C3 f2 − G = 0 as in
    (5.7).
    """
    c3, c4, c5 = 334.52, 8.71, 0.0045
    _, f2, f3, f4 = shape_functions(gap)
    _, slope2, slope3, slope4 = complex_step(lambda g: np.array(shape_functions(g[0])), [gap])[:, 0]
    i_d = (c4 * f3 - np.sqrt((c4 * f3)**2 - c5 * f4 * (4 * c3 * f2 - 9.81))) / (2 * c5 * f4)
    alpha = 4 * c4 * slope3 * i_d - 4 * c5 * slope4 * i_d**2 - 4 * c3 * slope2
    beta = 2 * c4 * f3 - 4 * c5 * f4 * i_d
    friction = {f"{axis}.friction.viscous": 0.0 for axis in "yxz"}
    model = linearise("Plant3DOF", {"y": gap}, amplifier=False, parameters={**QUIET["Plant3DOF"], **friction})
    assert model.equilibrium.i_d == pytest.approx((i_d, i_d), rel=1e-12)
    assert np.sort(model.poles.real)[[0, -1]] == pytest.approx([-np.sqrt(alpha), np.sqrt(alpha)], rel=1e-9)
    assert np.sort(np.abs(model.poles))[:4] == pytest.approx(np.zeros(4), abs=1e-9)
    row = model.B[model.index("state", "y.velocity")]
    assert row == pytest.approx([beta, 0.0, beta, 0.0], rel=1e-9, abs=1e-15)


def test_eigenvalues_by_hand_with_friction() -> None:
    """2-DOF: s² + b/m s − α = 0 vertically, s (s + b/m) = 0 horizontally, −1/T for each current."""
    gap, masses, lag = 18e-3, (4.350, 1.594), 0.3e-3
    _, f2, f3, f4 = shape_functions(gap)
    _, slope2, slope3, slope4 = complex_step(lambda g: np.array(shape_functions(g[0])), [gap])[:, 0]
    i_d = (30.90 * f3 - np.sqrt((30.90 * f3)**2 - 4 * 0.12 * f4 * (791.0 * f2 - 9.81))) / (2 * 0.12 * f4)
    alpha = 30.90 * slope3 * i_d - 0.12 * slope4 * i_d**2 - 791.0 * slope2
    expected = [*np.roots([1.0, 2.0 / masses[0], -alpha]), 0.0, -1.0 / masses[1]]
    model = linearise("Plant2DOF", {"v": gap}, amplifier=False, parameters=QUIET["Plant2DOF"])
    assert np.sort(model.poles.real) == pytest.approx(np.sort(expected), rel=1e-9, abs=1e-12)
    # With lag, a third-order pole cluster; only the coupling through i_d, turned into i_q by motion along h, moves it.
    lagged = linearise("Plant2DOF", {"v": gap}, parameters=QUIET["Plant2DOF"])
    turned = 14.20 * shape_functions(gap)[0] * np.pi / TAU * i_d
    cubic = np.polymul([1.0, 1.0 / masses[1]], [1.0, 1.0 / lag])
    horizontal = np.roots(np.polyadd(np.polymul(cubic, [1.0, 0.0]), [-turned, 0.0]))
    poles = [*np.roots([1.0, 2.0 / masses[0], -alpha]), -1.0 / lag, *horizontal]
    assert np.sort(lagged.poles.real) == pytest.approx(np.sort(np.real(poles)), rel=1e-9, abs=1e-12)


@pytest.mark.parametrize(("name", "place"), PLACES)
def test_hold_is_that_of_scipy(name: str, place: tuple[float, ...]) -> None:
    continuous = linearise(name, at(name, place), currents="phases", forces=True)
    for model in (linearise(name, at(name, place), currents="phases", forces=True, hold="0.2 ms"),
                  continuous.discretise(0.2e-3)):
        a, b, *_ = cont2discrete((continuous.A, continuous.B, continuous.C, continuous.D), 0.2e-3)
        np.testing.assert_allclose(model.A, a, rtol=1e-12, atol=1e-15)
        np.testing.assert_allclose(model.B, b, rtol=1e-12, atol=1e-15)
        assert model.sample_time == 0.2e-3


@pytest.mark.parametrize(("name", "place"), PLACES)
def test_held_dq_commands_are_commutated_at_the_sample(name: str, place: tuple[float, ...]) -> None:
    """The same as phases held that are (C.1) of the commands at the displacement of the sample."""
    phases = linearise(name, at(name, place), currents="phases", hold=0.5e-3)
    held = linearise(name, at(name, place), hold=0.5e-3)
    n = len(place)
    dq = np.array(list(held.equilibrium.currents.values())).reshape(-1, 2)
    by_command = complex_step(lambda u: np.concatenate([
        np.cos(a) * i[0] - np.sin(a) * i[1] for i, a in zip(u.reshape(-1, 2), angles(place), strict=True)]), dq.ravel())
    by_place = complex_step(lambda x: np.concatenate([
        np.cos(a) * i[0] - np.sin(a) * i[1] for i, a in zip(dq, angles(x), strict=True)]), place)
    expected = phases.A.copy()
    expected[:, :n] += phases.B @ by_place
    np.testing.assert_allclose(held.A, expected, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(held.B, phases.B @ by_command, rtol=1e-9, atol=1e-15)


def angles(x: np.ndarray | tuple[float, ...]) -> list[np.ndarray]:
    return [np.pi / TAU * (d - TAU / 2) + np.array([0, -2 * np.pi / 3, 2 * np.pi / 3]) for d in x[1:]]


@pytest.mark.parametrize(("name", "place"), PLACES)
@pytest.mark.parametrize(("lag", "share"), [(True, 1.0), (False, 1.0), (True, 0.93)])
def test_micrometre_step_of_the_nonlinear_plant(name: str, place: tuple[float, ...], lag: bool, share: float) -> None:
    """1 µm off on every axis, currents as at rest, over 50 ms: within 0.1 % of the largest deviation.

    Half of the difference of a step up and one down: what is left of the curvature of the forces is of third order.
    """
    dt, steps = 0.2e-3, 250
    masses = {f"{axis}.mass": share * part.mass
              for axis, part in zip(AXES[name], REFERENCE[name]().axes, strict=True)}
    model = linearise(name, at(name, place), currents="phases", hold=dt, amplifier=lag, parameters=masses)
    n = len(place)
    runs = []
    for sign in (1.0, -1.0):
        stage = smooth_stage(name, lag)
        set_all(stage, list(masses), list(masses.values()))
        start = [position + sign * 1e-6 for position in place]
        plant_at(name, stage, start, model.equilibrium)
        runs.append(trial(name, stage, steps, dt))
    block = (runs[0] - runs[1]) / 2.0
    deviation = np.zeros(len(model.states))
    deviation[:n] = 1e-6
    if lag:   # the same phase currents, seen from the displaced mover
        dq = np.array(list(model.equilibrium.currents.values())).reshape(-1, 2)
        deviation[2 * n:] = (np.pi / TAU * 1e-6 * np.stack([dq[:, 1], -dq[:, 0]], axis=1)).ravel()
    linear = simulated(model, deviation, np.zeros(len(model.inputs)), steps)
    assert np.abs(block[:, 0]).max() > 2e-6   # it falls or rises
    for axis in range(n):
        assert np.abs(block[:, axis] - linear[:, axis]).max() < 1e-3 * np.abs(linear[:, axis]).max()


@pytest.mark.parametrize(("name", "place"), PLACES)
def test_milliampere_step_of_the_nonlinear_plant(name: str, place: tuple[float, ...]) -> None:
    """1 mA more in each phase in turn, over 20 ms, likewise."""
    dt, steps = 0.2e-3, 100
    model = linearise(name, at(name, place), currents="phases", hold=dt)
    for k, command in enumerate(model.inputs):
        runs = []
        for sign in (1.0, -1.0):
            stage = smooth_stage(name, True)
            plant_at(name, stage, place, model.equilibrium)
            # The lag starts at the first command: these currents flow already.
            plant_state(name, stage, [*place, *np.zeros(len(place)), *model.equilibrium.currents.values()])
            motor, _, phase = command.rpartition(".")
            supply = getattr(stage, motor)
            setattr(supply, phase, getattr(supply, phase) + sign * 1e-3)
            runs.append(trial(name, stage, steps, dt))
        block = (runs[0] - runs[1]) / 2.0
        linear = simulated(model, np.zeros(len(model.states)), 1e-3 * np.eye(len(model.inputs))[k], steps)
        assert np.abs(block - linear).max() < 1e-3 * np.abs(linear).max(), command


def trial(name: str, stage: object, steps: int, dt: float) -> np.ndarray:
    """Positions of the block from now on, shape (steps + 1, axes)."""
    rows = []
    for k in range(steps + 1):
        rows.append([getattr(stage, axis).position for axis in AXES[name]])
        assert stage.step(k * dt, dt) == 0   # type: ignore[attr-defined]
    return np.array(rows)


def simulated(model: LinearModel, state: np.ndarray, inputs: np.ndarray, steps: int) -> np.ndarray:
    """Outputs of a sampled model, shape (steps + 1, outputs)."""
    rows = []
    for _ in range(steps + 1):
        rows.append(model.C @ state)
        state = model.A @ state + model.B @ inputs
    return np.array(rows)


@pytest.mark.parametrize(("name", "place"), PLACES)
def test_stage_rests_at_the_equilibrium(name: str, place: tuple[float, ...]) -> None:
    """The block, with friction off, stays there for a while: 5 ms, within a millionth of a free fall."""
    found = equilibrium(name, at(name, place))
    stage = smooth_stage(name, True)
    plant_at(name, stage, place, found)
    moved = trial(name, stage, 25, 0.2e-3)[-1] - place
    assert np.abs(moved).max() < 1e-6 * 0.5 * 9.81 * 0.005**2
    assert set(found.currents) == {f"{motor}.i_{c}" for motor in MOTORS[name] for c in "dq"}


def test_no_current_at_the_gap_where_the_magnets_carry() -> None:
    """Without bias and ripple the controller's model of the 3-DOF stage needs none at 22.69 mm (Table 5.3)."""
    found = equilibrium("Regulator3DOF", {"y": "22.69 mm"})
    assert found.i_d == pytest.approx((0.0, 0.0), abs=0.05)
    assert found.i_q == (0.0, 0.0)
    assert equilibrium("Regulator3DOF", {"y": "20 mm"}).i_d[0] > 0.5 > -0.5 > equilibrium(
        "Regulator3DOF", {"y": "25 mm"}).i_d[0]
