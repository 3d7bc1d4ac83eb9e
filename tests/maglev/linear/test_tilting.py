"""A stage that tilts: its equations written again, the poles of its design, and native runs at its margins."""

from collections.abc import Callable

import numpy as np
import pytest
from complex_stage import complex_step, shape_functions
from facts import raises
from fmu_access import put, put_reals, read_reals
from reference_5dof import ARM, ATTRACTION, COILS, DISPLACEMENTS, GAPS, IRON, NOMINAL, THRUST, Reference5DOF
from reference_stage import LAG, T1, TAU, G

from maglev.cosim.fmu import Fmu
from maglev.files.errors import LinearModelError
from maglev.linear.design import regulator_polynomial
from maglev.linear.equilibrium import equilibrium
from maglev.linear.linearise import Currents, linearise
from maglev.linear.loop import Loop, linearise_loop

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

AXES = ("y", "x", "z", "roll", "pitch")
MOTORS = ("alpha1", "alpha2", "beta1", "beta2")
PLACES = [(25e-3, 0.0, 0.0, 0.0, 0.0), (22e-3, 7e-3, -13e-3, 8e-3, -3e-3), (28e-3, -31e-3, 2e-3, -6e-3, 9e-3)]
LOADED = {"payload.mass": 0.6, "payload.x": 0.1, "payload.z": -0.05, "roll.guide.stiffness": 150.0,
          "pitch.guide.stiffness": 150.0, "roll.guide.play": 2e-3, "pitch.guide.play": 2e-3}
QUIET = {**{f"{axis}.bias": 0.0 for axis in AXES}, **{f"{axis}.friction.viscous": 0.0 for axis in AXES},
         "y.ripple.amplitude": 0.0}
GAINS = {"y": (-1274.0, -104.0, -50001.0, -3936.0, -7774.0), "x": (-463.0, -35.0, -15121.0, -997.0, -2548.0)}


def rates(stage: Reference5DOF, state: np.ndarray, inputs: np.ndarray, phases: bool) -> np.ndarray:
    """Rates of positions, velocities, i_d and i_q (4, 2) under commands and external forces; for complex numbers."""
    q, v, dq = state[:5], state[5:10], state[10:].reshape(4, 2)
    d, gaps = DISPLACEMENTS @ q, GAPS @ q
    f = [shape_functions(gap) for gap in gaps]
    pull = [ATTRACTION * f[i][1] * (1 - stage.modulation * np.sin(np.pi * d[i] / T1)**2) for i in range(4)]
    normal = np.array([NOMINAL[0] * (COILS * f[i][2] * dq[i, 0] - IRON * f[i][3] * (dq[i] @ dq[i]) - pull[i])
                       for i in range(4)])
    thrust = np.array([-NOMINAL[1 + i // 2] * THRUST[i // 2] * f[i][0] * dq[i, 1] for i in range(4)])
    p, a, b = stage.payload
    k, play = stage.guide
    held = [-k * (tilt - play * np.sign(tilt.real)) if abs(tilt.real) > play else 0.0 for tilt in q[3:]]
    force = GAPS.T @ normal + DISPLACEMENTS.T @ thrust + inputs[-5:] + np.array(
        [stage.masses[0] * G, 0.0, 0.0, held[0] - p * G * b, held[1] + p * G * a])
    force = force - np.array([axis.viscous for axis in stage.axes]) * v
    ripple = [axis.ripple * np.sin(2 * np.pi * place / axis.period + 0.5)
              for axis, place in zip(stage.axes, q, strict=True)]
    angles = [np.pi / TAU * (each - TAU / 2) + np.array([0, -2 * np.pi / 3, 2 * np.pi / 3]) for each in d]
    commanded = (np.array([2 / 3 * np.array([np.cos(each) @ i, -np.sin(each) @ i])
                           for each, i in zip(angles, inputs[:-5].reshape(4, 3), strict=True)])
                 if phases else inputs[:-5].reshape(4, 2))
    turning = np.pi / TAU * (DISPLACEMENTS @ v)[:, None] * np.stack([dq[:, 1], -dq[:, 0]], axis=1)
    biases = np.array([axis.bias for axis in stage.axes])
    return np.concatenate([v, force / stage.masses + ripple + biases, ((commanded - dq) / LAG + turning).ravel()])


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("currents", ["dq", "phases"])
@pytest.mark.parametrize("loaded", [False, True])
def test_matrices_are_the_derivatives(place: tuple[float, ...], currents: Currents, loaded: bool) -> None:
    """Every entry to 1e-9 of itself, and the stage rests there."""
    stage = Reference5DOF(payload=(0.6, 0.1, -0.05), guide=(150.0, 2e-3)) if loaded else Reference5DOF()
    at = dict(zip(AXES, place, strict=True))
    model = linearise("Plant5DOF", at, currents=currents, forces=True, parameters=LOADED if loaded else {})
    rest = model.equilibrium
    state = np.array([*place, *np.zeros(5), *rest.currents.values()])
    inputs = np.array([*(rest.phases if currents == "phases" else rest.currents).values(), *np.zeros(5)])
    phases = currents == "phases"
    assert np.abs(rates(stage, state, inputs, phases)[:10]).max() < 1e-10
    np.testing.assert_allclose(model.A, complex_step(lambda s: rates(stage, s, inputs, phases), state), rtol=1e-9,
                               atol=1e-9)
    np.testing.assert_allclose(model.B, complex_step(lambda u: rates(stage, state, u, phases), inputs), rtol=1e-9,
                               atol=1e-9)
    assert model.outputs == (*(f"{axis}.position" for axis in AXES), *(f"{motor}.gap" for motor in MOTORS))
    np.testing.assert_array_equal(model.C[5:, :5], GAPS)
    assert (model.units["roll.velocity"], model.units["pitch.torque"]) == ("rad/s", "N.m")


def test_level_it_is_the_3dof_stage() -> None:
    """With the motors at the height of the centre of mass, y, x, z are those of the stage without tilts."""
    level = {"height": 0.0, "attraction_modulation": 0.0}
    five = linearise("Plant5DOF", {"y": "23 mm", "x": "3 mm"}, parameters=level, amplifier=False)
    three = linearise("Plant3DOF", {"y": "23 mm", "x": "3 mm"}, parameters={"attraction_modulation": 0.0},
                      amplifier=False)
    own = [0, 1, 2, 5, 6, 7]
    np.testing.assert_allclose(five.A[np.ix_(own, own)], three.A, rtol=1e-12, atol=1e-12)
    pairs = np.repeat(np.eye(2), 2, axis=0)   # both motors of a pair have its currents
    np.testing.assert_allclose(five.B[own] @ np.kron(pairs, np.eye(2)), three.B, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("gap", [18.6e-3, 20e-3, 25e-3])
def test_left_to_itself_a_tilt_grows_as_by_hand(gap: float) -> None:
    """φ'' = k_t φ / I with k_t = 2 ℓ² ∂N/∂g, and what turns with the displacement h φ of the betas."""
    model = linearise("Plant5DOF", {"y": gap}, parameters={**QUIET, "height": 0.0}, amplifier=False)
    i_d = model.equilibrium.i_d[0]
    slopes = complex_step(lambda g: np.array(shape_functions(g[0])), [gap])[:, 0]
    stiffness = NOMINAL[0] * (COILS * slopes[2] * i_d - IRON * slopes[3] * i_d**2 - ATTRACTION * slopes[1])
    expected = np.sqrt(2 * ARM**2 * stiffness / NOMINAL[3])
    rows = [model.index("state", "roll.position"), model.index("state", "roll.velocity")]
    assert max(np.linalg.eigvals(model.A[np.ix_(rows, rows)]).real) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("at", [{"y": 25e-3}, {"y": 22e-3, "roll": 7e-3, "pitch": -4e-3}])
def test_sampled_fast_the_poles_of_the_design(at: dict[str, float | str]) -> None:
    """With the plant's constants, no lag and no observer, feedback linearisation leaves the polynomial of the gains."""
    own = {f"C{k}": value for k, value in zip(range(1, 6), (0.6135, 0.8224, 327.50, 8.48, 0.0070), strict=True)}
    loop = linearise_loop("Plant5DOF", "Regulator5DOF", at, amplifier=False,
                          plant_parameters={**own, **QUIET, "attraction_modulation": 0.0},
                          controller_parameters={"sample_time": "10 us", "observer.time1": 0.0, "observer.time2": 0.0})
    for axis in AXES:
        places = [k for k, name in enumerate(loop.closed.states)
                  if axis in (name.split(".")[0], name.split(".")[1])]
        z = np.linalg.eigvals(loop.closed.A[np.ix_(places, places)])
        found = np.log(z[np.abs(z) > 0.9].astype(complex)) / 10e-6
        assert len(found) == 5, axis
        designed = regulator_polynomial(GAINS["x" if axis in "xz" else "y"], 1.5 * np.pi)
        assert np.poly(found).real == pytest.approx(designed, rel=1e-2), axis


def test_openings_say_what_they_open() -> None:
    loop = linearise_loop("Plant5DOF", "Regulator5DOF", {"y": "25 mm"})
    assert loop.measured == tuple(f"{axis}.measured" for axis in AXES)
    assert loop.openings == (*loop.measured, *(f"{motor}.gap_measured" for motor in MOTORS), *loop.plant.inputs)
    assert loop.opening("alpha1") == "alpha1.gap_measured"
    with raises(LinearModelError, "'gamma'", "y.measured"):
        loop.opening("gamma")


@pytest.mark.parametrize("axis", ["y", "roll", "pitch"])
def test_an_axis_opened_is_its_share_of_every_gap(axis: str) -> None:
    """The sum over the gaps, each with what the axis does to it, of loops that are opened at all gaps at once."""
    loop = linearise_loop("Plant5DOF", "Regulator5DOF", {"y": "23 mm", "roll": "4 mrad"})
    opened = loop.opened(axis)
    assert np.poly(opened.A - opened.B @ opened.C) == pytest.approx(np.poly(loop.closed.A), rel=1e-6, abs=1e-9)
    # A controller that measures the axes themselves has the same loop and the same margins.
    controller = loop.controller
    gaps = [controller.index("input", f"{motor}.gap_measured") for motor in MOTORS]
    names = ("y.measured", "roll.measured", "pitch.measured")
    rows = GAPS[:, [0, 3, 4]]
    mine = type(controller)(
        "mine", controller.states, (*(each for each in controller.inputs if "gap" not in each), *names),
        controller.outputs, controller.A, np.hstack([np.delete(controller.B, gaps, 1), controller.B[:, gaps] @ rows]),
        controller.C, np.hstack([np.delete(controller.D, gaps, 1), controller.D[:, gaps] @ rows]),
        {**controller.units, **dict.fromkeys(names, "m")}, controller.sample_time, controller.equilibrium)
    theirs, ours = (vars(each.margins(axis)) for each in (Loop(loop.plant, mine), loop))
    # Where a flat maximum is, is known to the root of its rounding.
    assert ours == {key: value if key == "at" else
                    pytest.approx(value, rel=1e-4 if key == "sensitivity_frequency" else 1e-6)
                    for key, value in theirs.items()}


def test_a_controller_has_to_see_where_the_platform_is() -> None:
    loop = linearise_loop("Plant5DOF", "PID5DOF", {"y": "25 mm"})
    three = [name for name in loop.controller.inputs if name != "beta2.gap_measured"]
    assert Loop(loop.plant, loop.controller.select(three, loop.controller.outputs)).stable is False   # blind at beta2
    two = [name for name in three if name != "beta1.gap_measured"]
    with raises(LinearModelError, "'y.measured'"):
        Loop(loop.plant, loop.controller.select(two, loop.controller.outputs))


@pytest.mark.parametrize(("at", "parameters", "facts"), [
    ({"y": "25 mm", "roll": "35 mrad"}, {}, ["alpha1.gap", "18 mm", "18.5…32 mm"]),
    ({"y": "25 mm", "roll": "1 mm"}, {}, ["roll", "'1 mm'", "rad"]),
    ({"y": "25 mm", "roll": "20 mrad"}, {"C4": 1e-3}, ["roll", "20 mrad", "tilt"]),
    ({"y": "25 mm"}, {"roll.locked": True}, ["roll.locked", "true"]),
    ({"y": "25 mm"}, {"payload.mass": 2.0, "payload.x": 0.2}, ["beta1.amplifier.continuous", "4 A"])])
def test_refusals(at: dict[str, float | str], parameters: dict[str, float | str | bool], facts: list[str]) -> None:
    with raises(LinearModelError, "Plant5DOF", *facts):
        equilibrium("Plant5DOF", at, parameters)


SMOOTH = {**{f"{axis}.friction.coulomb": 0.0 for axis in AXES}, "encoder.resolution": 0.0,
          **{f"{motor}.amplifier.{limit}": 1000.0 for motor in MOTORS for limit in ("peak", "continuous")}}
SECONDS, WINDOW, BEGINNING, LOST = 5.0, 2.0, 0.1, 2e-3   # s, s, s, m or rad


def growth(load: Callable[[str], Fmu], axis: str, factor: float, rest: dict[str, float]) -> float:
    """How much larger the error is in the last two seconds than in the first tenth of one; inf if the stage is lost.

    What the regulator sees of the axis in the gaps at the motors is multiplied by a factor. It begins with what its
    integrators do not know yet.
    """
    plant, controller = load("Plant5DOF"), load("Regulator5DOF")
    row, dt = GAPS[:, AXES.index(axis)], 0.2e-3
    plant.initialise({**SMOOTH, **{f"{each}.position_start": rest[each] for each in AXES}}, 0.0, SECONDS)
    controller.initialise({"current_limit": 0.0}, 0.0, SECONDS)   # limits would keep what grows
    put(controller, {f"{each}.reference": rest[each] for each in AXES})
    outputs = [f"{axis}.position", *(f"{motor}.gap_encoder" for motor in MOTORS), "x.encoder", "z.encoder"]
    inputs = [*(f"{motor}.gap_measured" for motor in MOTORS), "x.measured", "z.measured"]
    commands = [f"{motor}.i_{phase}_cmd" for motor in MOTORS for phase in "abc"]
    errors: list[float] = []
    while len(errors) < round(SECONDS / dt):
        t = len(errors) * dt
        position, *measured = read_reals(plant, outputs)
        errors.append(position - rest[axis])
        if abs(errors[-1]) > LOST:
            return float("inf")
        for k, moved in enumerate(row.tolist()):
            measured[k] += moved * (factor - 1.0) * errors[-1]
        put_reals(controller, dict(zip(inputs, measured, strict=True)))
        controller.instance.doStep(t, dt)
        put_reals(plant, dict(zip(commands, read_reals(controller, commands), strict=True)))
        plant.instance.doStep(t, dt)
    return float(np.abs(errors[-round(WINDOW / dt):]).max() / np.abs(errors[:round(BEGINNING / dt)]).max())


@pytest.mark.thorough
@pytest.mark.parametrize("axis", ["y", "roll"])
@pytest.mark.parametrize("side", ["gain_down", "gain_up"])
def test_native_fmus_within_a_tenth_of_the_margin_and_beyond(load_native: Callable[[str], Fmu], axis: str,
                                                             side: str) -> None:
    at = {"y": 24e-3, "roll": 2e-3, "pitch": 0.0, "x": 0.0, "z": 0.0}
    margins = linearise_loop("Plant5DOF", "Regulator5DOF", at).margins(axis)
    limit, away = (margins.gain_down, 0.9) if side == "gain_down" else (margins.gain_up, 1.0 / 0.9)
    assert growth(load_native, axis, limit / away, at) < 0.5
    assert growth(load_native, axis, limit * (away if side == "gain_down" else 1.1), at) > 2.0
