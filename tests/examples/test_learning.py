"""The examples that adapt: their observers and estimators by themselves, and what they are without adaptation."""

from importlib import import_module
from typing import Any

import numpy as np
import pytest
from direct_loop import simulate
from example_builds import EXAMPLES as ALL_EXAMPLES
from named_controllers import Regulator3DOF
from named_stage import Stage3DOF

from controller_fmu.status import NONLINEAR
from controller_fmu.velocity_observer import ObserverFilter
from maglev.user.build import buildable
from maglev.user.source import PythonFile

TS = 0.2e-3   # s
EXAMPLES = ALL_EXAMPLES / "adapting"
MOTORS = ("alpha", "beta")


@pytest.fixture(autouse=True)
def beside(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(EXAMPLES)


class Called:
    """A controller file as a block is called."""

    def __init__(self, law: Any):
        self.law = law

    def start(self) -> int:
        self.law.start()
        return 0

    def step(self, t: float, dt: float) -> int:
        self.law.step(t)
        return 0

    def __getattr__(self, name: str) -> Any:
        return getattr(self.law, name)


NAMES = {"ADRC": "adrc", "L1Regulator": "l1_adaptive", "DirectionalRegulator": "directional_rls"}


@pytest.mark.parametrize("law", NAMES)
def test_it_is_in_the_language_of_blocks(law: str) -> None:
    with buildable(PythonFile(EXAMPLES / f"{NAMES[law]}.py"), native=True) as built:
        assert built.definition.name == law


def test_the_poles_of_the_extended_state_observer_are_where_they_are_placed() -> None:
    """(z − exp(−ω T))³ is the characteristic polynomial of the error of its prediction."""
    observer = import_module("adrc").ExtendedStateObserver(200.0)
    observer.start(TS)
    A = np.array([[1.0, TS, TS**2 / 2.0], [0.0, 1.0, TS], [0.0, 0.0, 1.0]])
    L = np.array([[observer.to_position], [observer.to_velocity], [observer.to_disturbance]])
    error = A @ (np.eye(3) - L @ np.array([[1.0, 0.0, 0.0]]))
    np.testing.assert_allclose(np.poly(error), np.poly(3 * [np.exp(-200.0 * TS)]), atol=1e-12)


def test_the_extended_state_observer_finds_a_constant_disturbance() -> None:
    """An axis pushed by 0.3 m/s² next to a command of −0.1 m/s²: p = ½ 0.2 t²."""
    observer = import_module("adrc").ExtendedStateObserver(60.0)
    observer.start(TS)
    for k in range(4000):
        t = k * TS
        observer.correct(0.1 * t**2)
        assert k < 3000 or observer.disturbance == pytest.approx(0.3, rel=1e-9)
        observer.predict(-0.1, TS)
    np.testing.assert_allclose([observer.position, observer.velocity], [0.1 * 4000**2 * TS**2, 0.2 * 4000 * TS])


def test_the_uncertainty_is_the_motion_without_commands() -> None:
    """v' = u + 0.3 m/s² with u that changes: C σ̂ is the 0.3 behind 40 rad/s, and the observer's filters."""
    adaptive = import_module("l1_adaptive")
    axis, observer = adaptive.Uncertainty(40.0), ObserverFilter()
    observer.prepare(TS)
    axis.start(TS)
    filtered = adaptive.MatchedFilter()
    velocity, u, seen = 0.0, 0.0, []
    for k in range(5000):
        axis.update(filtered.update(velocity, observer), u, observer)
        seen.append(axis.compensated)
        u = np.sin(0.01 * k)
        velocity += TS * (u + 0.3)
    # The measured velocity is held over a sample of the predictor: a T of u and of what is found is not seen.
    assert seen[-1] == pytest.approx(0.3, abs=axis.rate * TS * 1.3)
    t = TS * np.arange(5000)
    # Three lags in series, of which two are much shorter: a delay by their sum, near enough from there on.
    late = t > 0.02
    np.testing.assert_allclose(np.array(seen)[late], 0.3 * (1.0 - np.exp(-40.0 * (t - 2e-3)))[late], atol=8e-3)


@pytest.mark.parametrize(("name", "law", "off"), [
    ("l1_adaptive", "L1Regulator", {"y_uncertainty.cutoff": 0.0, "x_uncertainty.cutoff": 0.0,
                                    "z_uncertainty.cutoff": 0.0}),
    ("directional_rls", "DirectionalRegulator", {"adaptation.active": False})])
def test_without_adaptation_it_is_the_regulator(name: str, law: str, off: dict[str, float]) -> None:
    """Every command, to the bit: at rest, and far away with all at its limit."""
    adaptive, plain = getattr(import_module(name), law)(), Regulator3DOF(NONLINEAR)
    for place, value in off.items():
        owner, attribute = place.split(".")
        setattr(getattr(adaptive, owner), attribute, value)
    adaptive.start()
    plain.start()
    random, limited = np.random.default_rng(1), 0
    for k in range(400):
        size = 1e-4 if k < 200 else 6e-3
        for axis in "yxz":
            value = (25e-3 if axis == "y" else 0.0) + size * random.uniform(-1.0, 1.0)
            getattr(adaptive, axis).measured = getattr(plain, axis).measured = value
        adaptive.step(k * TS)
        plain.step(k * TS, TS)
        limited += plain.saturated
        for motor in MOTORS:
            assert vars(getattr(adaptive, motor)) == vars(getattr(plain, motor)), (k, motor)
    assert 0 < limited < 400


def rows(number: int, second: bool) -> tuple[np.ndarray, np.ndarray]:
    """Rows (a1, a2, 1) of a motion, and accelerations by constants of 0.7, 0.2 and −0.1 with noise."""
    random = np.random.default_rng(2)
    phi = np.column_stack([random.normal(size=number), random.normal(size=number) * second, np.ones(number)])
    return phi, phi @ [0.7, 0.2, -0.1] + 0.05 * random.normal(size=number)


def estimate(phi: np.ndarray, accelerations: np.ndarray, forgotten: float) -> Any:
    """Estimates after rows; with filters that let everything through the velocity is its own derivative."""
    row, observer = import_module("directional_rls").DirectionalRLS(0.0, 1.0), ObserverFilter()
    observer.share1 = observer.share2 = 1.0
    row.start(0.0, 0.0, 0.0, 0.0, 10.0)
    for (a1, a2, _), acceleration in zip(phi, accelerations, strict=True):
        row.smooth = 0.0   # corner · (v − smooth) is the acceleration when a share of 0 is taken of the velocity
        row.phi1, row.phi2 = a1, a2
        row.update(acceleration, a1, a2, 0.0, observer, 1.0, 0.0, forgotten, False)
    return row


def test_without_forgetting_it_is_least_squares() -> None:
    """Of the rows, and of the weight of the first guesses (1, 0, 0), by numpy."""
    phi, accelerations = rows(300, True)
    row = estimate(phi, accelerations, 0.0)
    weighed = np.vstack([phi, np.sqrt(10.0) * np.eye(3)])
    expected = np.linalg.lstsq(weighed, np.concatenate([accelerations, np.sqrt(10.0) * np.array([1.0, 0.0, 0.0])]))[0]
    np.testing.assert_allclose([row.first, row.second, row.bias], expected, rtol=1e-9)


def test_unexcited_parameters_are_not_forgotten() -> None:
    """Friction that no row has keeps its guess and its weight; the others forget all but the last rows."""
    phi, accelerations = rows(5000, False)
    row = estimate(phi, accelerations, 0.01)
    assert row.information.s22 == 10.0
    assert row.second == 0.0
    assert row.information.s11 < 1000.0   # 5000 rows would weigh as much without forgetting
    assert row.first == pytest.approx(0.7, abs=0.05)
    assert row.bias == pytest.approx(-0.1, abs=0.05)


@pytest.mark.parametrize(("name", "law", "largest"), [("adrc", "ADRC", 0.3e-3), ("l1_adaptive", "L1Regulator", 0.5e-3),
                                                      ("directional_rls", "DirectionalRegulator", 1.2e-3)])
def test_it_holds_a_stage_whose_mass_is_not_as_known(name: str, law: str, largest: float) -> None:
    """With a load of 1 kg from the start; the gap is held within what the page says of sudden loads."""
    stage = Stage3DOF()
    for axis in (stage.y, stage.x, stage.z):
        axis.mass += 1.0
    errors = simulate(3, Called(getattr(import_module(name), law)()), stage, {}, 0.25)
    assert np.abs(errors[:, 0]).max() < largest
    assert np.abs(errors[:, 1:]).max() < 0.1e-3
