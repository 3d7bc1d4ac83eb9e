"""Linear models of the controllers against the one-sample maps of their blocks."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pytest
from complex_stage import shape_functions
from linear_blocks import jacobian, read_all, set_all
from named_blocks import named
from scipy.linalg import expm
from scipy.optimize import least_squares

from maglev.descriptions.registry import known_stages
from maglev.files.errors import LinearModelError
from maglev.fmi.parameter import Parameter
from maglev.linear.linearise import Currents, linearise
from maglev.linear.loop import linearise_loop
from maglev.linear.model import LinearModel
from maglev.linear.parameters import block_of, linear_stage

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

PLACES = [("2DOF", {"v": 18e-3, "h": -6e-3}), ("3DOF", {"y": 27.3e-3, "x": 4e-3, "z": -9e-3}),
          ("5DOF", {"y": 26e-3, "x": 4e-3, "z": -9e-3, "roll": 6e-3, "pitch": -4e-3})]
# Biases that need sizeable quadrature currents: the axes are coupled then.
BIASES = {"2DOF": {"h.bias": 1.5}, "3DOF": {"x.bias": 0.4, "z.bias": -0.6}, "5DOF": {"x.bias": 0.4, "z.bias": -0.6}}
NAMES = ["Regulator2DOF", "LinearRegulator2DOF", "PID2DOF", "Regulator3DOF", "LinearRegulator3DOF",
         "ScheduledRegulator3DOF", "InterpolatedRegulator3DOF", "PID3DOF", "Regulator5DOF", "LinearRegulator5DOF",
         "PID5DOF"]
CASES = [*((name, {}) for name in NAMES),
         ("Regulator3DOF", {"observer.time1": 0.0, "observer.time2": "3 ms", "omega0": 0.0, "sample_time": "1 ms"}),
         ("Regulator3DOF", {"C5": 0.05, "antiwindup": True}),
         ("LinearRegulator3DOF", {"setpoint": "29 mm", "x.k1": -700.0}),
         ("PID2DOF", {"v.prefilter": 25.0, "h.prefilter": 6.0, "setpoint": "18 mm"}),
         ("PID3DOF", {"x.prefilter": 40.0, "observer.time2": 0.0}),
         ("Regulator5DOF", {"C5": 0.05, "height": "-50 mm", "roll.inertia": 0.25, "alpha1.z": "260 mm"}),
         ("LinearRegulator5DOF", {"setpoint": "28 mm", "beta2.x": "-150 mm", "y.mass": 7.5}),
         ("PID5DOF", {"roll.prefilter": 30.0, "height": "20 mm"}),
         ("AdaptiveRegulator2DOF", {}),
         ("AdaptiveRegulator3DOF", {"C1": 0.409, "forgetting": "0.5 1/s"}),
         ("AdaptiveRegulator5DOF", {"C3": 300.0, "height": "-50 mm"})]


class Adapting:
    """The whole of an adaptive regulator, estimator and all, that is looked at as the regulator in it."""

    def __init__(self, name: str, parameters: dict[str, float | str]):
        definition = known_stages().definition(name)
        whole = definition.new_block()
        for variable in definition.variables:
            if variable.name in parameters:
                value = Parameter.of(variable).read(parameters[variable.name], name, LinearModelError)
                variable.write(whole, value)
        self.start, self.step = whole.start, whole.step
        self.regulator = named(whole.regulator, linear_stage(name))
        self.regulator.started = True

    def __getattr__(self, name: str) -> Any:
        return getattr(self.regulator, name)


def block_that_runs(name: str, parameters: dict[str, float | str]) -> Any:
    if name.startswith("Adaptive"):
        return Adapting(name, parameters)
    return named(block_of(name, parameters), linear_stage(name))


def rest_of(name: str, parameters: dict[str, float | str]) -> Any:
    """Equilibrium of the plant, whose constants are not the controller's, in the loop; the motors are where it says."""
    stage, place = next(pair for pair in PLACES if pair[0] == name[-4:])
    moved = {key: value for key, value in parameters.items() if key in ("height", "alpha1.z", "beta2.x")}
    biases: dict[str, float | str] = {**BIASES[stage], **moved}
    return linearise_loop(f"Plant{stage}", name, place, plant_parameters=biases,
                          controller_parameters=parameters).plant.equilibrium


def integrators(model: LinearModel) -> list[str]:
    """The states that hold the currents of the equilibrium."""
    return [state for state in model.states if state.endswith((".xi1", ".integral"))]


def operating_point(model: LinearModel, block: Any) -> tuple[np.ndarray, np.ndarray]:
    """States and inputs of a block at rest: references are measurements, integrators hold the currents."""
    positions = model.equilibrium.positions
    state = dict.fromkeys(model.states, 0.0)
    for axis, position in positions.items():
        state[f"{axis}.observer.position"] = position
        if f"{axis}.filter.position" in state:
            state[f"{axis}.filter.position"] = position
    for motor in model.equilibrium.motors if model.equilibrium.stage.rotations else ():
        place = getattr(block, f"{motor}_place")
        positions = {**positions, motor: place.moved(positions["y"], positions["roll"], positions["pitch"])}
    inputs = np.array([0.0 if name.endswith("rate") else positions[name.partition(".")[0]] for name in model.inputs])
    held = list(model.equilibrium.currents.values())
    names = [f"{name}_cmd" for name in model.equilibrium.currents]

    def miss(values: np.ndarray) -> np.ndarray:
        x = np.array([*{**state, **dict(zip(integrators(model), values, strict=True))}.values()])
        sample(block, model, x, inputs)
        return np.array(read_all(block, names)) - held

    found = least_squares(miss, np.zeros(len(integrators(model))), x_scale="jac", xtol=1e-15, ftol=1e-15, gtol=1e-15)
    state.update(zip(integrators(model), found.x, strict=True))
    x = np.array(list(state.values()))
    assert np.abs(miss(np.array([state[name] for name in integrators(model)]))).max() < 1e-9
    return x, inputs


def sample(block: Any, model: LinearModel, state: Sequence[float] | np.ndarray, inputs: np.ndarray) -> np.ndarray:
    """States after one sample, then the outputs."""
    set_all(block, model.states, list(state))
    set_all(block, [name.replace(".gap_measured", "_place.gap_measured") for name in model.inputs], list(inputs))
    block.started = True
    block.clock.remaining = 0.0
    assert block.step(0.0, block.sample_time) == 0
    return np.array([*read_all(block, model.states), *read_all(block, model.outputs)])


@pytest.mark.few(20)
@pytest.mark.parametrize(("name", "parameters"), CASES)
@pytest.mark.parametrize("currents", ["dq", "phases"])
def test_matrices_are_those_of_the_block(name: str, parameters: dict[str, float | str], currents: Currents) -> None:
    model = linearise(name, rest_of(name, parameters), currents=currents, parameters=parameters)
    block = block_that_runs(name, parameters)
    assert block.start() == 0
    x, u = operating_point(model, block)
    assert block.feasible
    assert not block.saturated
    n = len(x)
    fixed = sample(block, model, x, u)
    assert fixed[:n] == pytest.approx(x, rel=1e-9, abs=1e-12)   # it rests there
    expected = model.equilibrium.currents if currents == "dq" else model.equilibrium.phases
    assert fixed[n:] == pytest.approx([expected[output.removesuffix("_cmd")] for output in model.outputs], abs=1e-7)
    small = {"m": 1e-7, "m/s": 1e-5, "rad": 1e-7, "rad/s": 1e-5}
    steps = np.array([small.get(model.units[state], 1e-6 * max(1e-3, abs(value)))
                      for state, value in zip(model.states, x, strict=True)])
    by_state = jacobian(lambda s: sample(block, model, s, u), x, steps)
    steps = np.array([small[model.units[name]] for name in model.inputs])
    by_input = jacobian(lambda i: sample(block, model, x, i), u, steps)
    for ours, theirs in ((model.A, by_state[:n]), (model.B, by_input[:n]), (model.C, by_state[n:]),
                         (model.D, by_input[n:])):
        assert np.abs(ours - theirs).max(axis=1) == pytest.approx(np.zeros(len(ours)), abs=1e-6 * np.abs(theirs).max())
        np.testing.assert_allclose(ours, theirs, rtol=2e-6, atol=2e-7 * np.abs(theirs).max())


def test_an_axis_is_its_law_written_out() -> None:
    """Observer (Fig. 4.7), internal model (4.15) by the matrix exponential, demand (4.16), and i_q that makes it."""
    model = linearise("Regulator3DOF", {"y": "25 mm", "x": "4 mm"})
    k1, k2, k3, k4, k5 = -463.0, -35.0, -15121.0, -997.0, -2548.0
    share, square = 1.0 - np.exp(-0.2), (1.5 * np.pi)**2
    held = expm(0.2e-3 * np.array([[0, 1, 0, 0], [0, 0, 1, 0], [0, -square, 0, 1], [0, 0, 0, 0]]))
    a, b, e = np.zeros((5, 5)), np.zeros((5, 3)), np.array([-1.0, 0.0, 1.0])   # inputs: reference, rate, measured
    a[:2, :2] = [[1.0 - share, 0.0], [-share**2 / 0.2e-3, 1.0 - share]]
    b[:2, 2] = [share, share**2 / 0.2e-3]
    a[2:, 2:], b[2:] = held[:3, :3], np.outer(held[:3, 3], e)
    demand = np.array([0.0, 0.0, k3 + 1.0, k4, k5]) + k2 * a[1], k1 * e + k2 * (b[1] - [0.0, 1.0, 0.0])
    rows = [k for k, state in enumerate(model.states) if state.startswith("x.")]
    columns = [k for k, name in enumerate(model.inputs) if name.startswith("x.")]
    i_q = model.index("output", "alpha.i_q_cmd")
    thrust = 2.0 * 0.6135 * shape_functions(25e-3)[0]
    for ours, theirs in ((model.A[np.ix_(rows, rows)], a), (model.B[np.ix_(rows, columns)], b),
                         (model.C[i_q, rows], -demand[0] / thrust), (model.D[i_q, columns], -demand[1] / thrust)):
        np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-18)


def test_of_its_own_model() -> None:
    """Without a plant, the nonlinear law inverts the model that it is linearised about: g'' is the demand."""
    model = linearise("Regulator3DOF", {"y": "24 mm"})
    own = {f"C{k}": value for k, value in zip(range(1, 6), (0.6135, 0.8224, 327.50, 8.48, 0.0070), strict=True)}
    quiet = {f"{axis}.{name}": 0.0 for axis in "yxz" for name in ("bias", "friction.viscous")}
    plant = linearise("Plant3DOF", {"y": "24 mm"}, amplifier=False,
                      parameters={**own, **quiet, "y.ripple.amplitude": 0.0})
    assert plant.equilibrium.currents == pytest.approx(model.equilibrium.currents, abs=1e-12)
    # Accelerations by xi3 of each axis, through the law and then the motors: k5, axis by axis.
    xi3 = [model.index("state", f"{axis}.model.xi3") for axis in "yxz"]
    assert plant.B[3:] @ model.C[:, xi3] == pytest.approx(np.diag([-7774.0, -2548.0, -2548.0]), rel=1e-9, abs=1e-9)
    # By the gap: none but the demand, for the law takes the stiffness away.
    measured = model.D[:, model.index("input", "y.measured")]
    acceleration = plant.A[3:, 0] + plant.B[3:] @ measured
    demand = -1274.0 + -104.0 * linearise("Regulator3DOF", {"y": "24 mm"}).B[1, 2]
    assert acceleration == pytest.approx([demand, 0.0, 0.0], rel=1e-9, abs=1e-9)
