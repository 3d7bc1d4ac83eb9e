"""Gains against their poles, and what regulation promises: disturbances and sinusoids rejected on an ideal stage."""

import math

import numpy as np
import pytest
from direct_loop import LAYOUTS, Reference, idealise, simulate
from named_controllers import Regulator2DOF, Regulator3DOF
from named_stage import Stage2DOF, Stage3DOF

OMEGA0 = 1.5 * math.pi

KH = (-1182, -55, -154440, -45128, -11924)                    # (4.17)
KV = (-1662, -65, -360360, -103350, -20332)                   # (4.17)
KV_LOW_OVERSHOOT = (-1592, -81, -55736, -11573, -15825)       # p. 53
KX_ORIGINAL = (-354, -41, -8945, 1201, -1472)                 # (5.12), the fourth corrected from −1201
KY_ORIGINAL = (-1487, -140, -50001, -560, -7836)              # (5.12)
KX_IMPROVED = (-463, -35, -15121, -997, -2548)                # (5.14)
KY_IMPROVED = (-1274, -104, -50001, -3936, -7774)             # (5.14)

SETTLED = {2: 4.0, 3: 10.0}   # s: the poles of the 2-DOF stage are at -9 1/s and further, those of the other at -2 1/s

# Gains, printed poles, largest relative error of a coefficient that the rounding of both leaves.
SETS: dict[str, tuple[tuple[float, ...], list[complex], float]] = {
    "Kh (4.17)": (KH, [-9, -10, -11, -12, -13], 0.0007),
    "Kv (4.17)": (KV, [-11, -12, -13, -14, -15], 0.0005),
    "Kv p. 53": (KV_LOW_OVERSHOOT, [-57.9, -9.9 + 11.3j, -9.9 - 11.3j, -1.6 + 1.4j, -1.6 - 1.4j], 0.057),
    "Kx (5.12)": (KX_ORIGINAL, [-31.6, -2.8 + 5.6j, -2.8 - 5.6j, -2.1 + 1.7j, -2.1 - 1.7j], 0.019),
    "Ky (5.12)": (KY_ORIGINAL, [-129.1, -3.3 + 5.8j, -3.3 - 5.8j, -2.2 + 1.9j, -2.2 - 1.9j], 0.030),
    "Kx (5.14)": (KX_IMPROVED, [-5, -6, -7, -8, -9], 0.0005),
    "Ky (5.14)": (KY_IMPROVED, [-91.3, -4.2 + 6.4j, -4.2 - 6.4j, -2.3 + 2.0j, -2.3 - 2.0j], 0.007),
}


def closed_loop_polynomial(gains: tuple[float, ...]) -> np.ndarray:
    """Of position, velocity and internal model under (4.16), from the matrix."""
    phi = np.array([[0, 1, 0], [0, 0, 1], [0, -OMEGA0**2, 0]])
    matrix = np.zeros((5, 5))
    matrix[0, 1] = 1.0
    matrix[1] = gains
    matrix[1, 2] += 1.0   # the feed-through of ξ1
    matrix[2:, 2:] = phi
    matrix[4, 0] = 1.0
    return np.poly(matrix)


def worst(gains: tuple[float, ...], poles: list[complex]) -> float:
    """Largest relative error of a coefficient."""
    wanted = np.poly(poles).real
    return float(np.max(np.abs(closed_loop_polynomial(gains) - wanted)[1:] / np.abs(wanted[1:])))


@pytest.mark.parametrize("name", SETS)
def test_printed_gains_have_the_printed_poles(name: str) -> None:
    gains, poles, tolerance = SETS[name]
    assert worst(gains, poles) < tolerance
    assert np.roots(closed_loop_polynomial(gains)).real.max() < 0.0
    k1, k2, k3, k4, k5 = gains
    formula = [1, -k2, OMEGA0**2 - k1, -(k2 * OMEGA0**2 + k5), -(k1 * OMEGA0**2 + k4), -(k3 + 1)]
    assert closed_loop_polynomial(gains) == pytest.approx(np.array(formula), rel=1e-9)


def test_the_printed_sign_in_5_12_is_an_error() -> None:
    as_printed = (*KX_ORIGINAL[:3], -1201, KX_ORIGINAL[4])
    assert worst(as_printed, SETS["Kx (5.12)"][1]) == pytest.approx(0.34, abs=0.01)


def gains_of(axis: object) -> tuple[float, ...]:
    return tuple(getattr(axis, f"k{i}") for i in range(1, 6))


def set_gains(axis: object, gains: tuple[float, ...]) -> None:
    for i, gain in enumerate(gains, start=1):
        setattr(axis, f"k{i}", float(gain))


def test_defaults() -> None:
    two, three = Regulator2DOF(), Regulator3DOF()
    assert (gains_of(two.v), gains_of(two.h)) == (KV, KH)
    assert (gains_of(three.y), gains_of(three.x), gains_of(three.z)) == (KY_IMPROVED, KX_IMPROVED, KX_IMPROVED)
    assert (two.current_limit, two.antiwindup) == (4.0, False)
    assert (three.current_limit, three.antiwindup) == (4.0, True)
    assert [(a.ec1, a.ec2, a.ec3) for a in (three.y, three.x, three.z)] == [(1e-5,) * 3, (1.1e-4,) * 3, (1.25e-4,) * 3]
    assert two.omega0 == three.omega0 == pytest.approx(OMEGA0)
    # Mid-range: an importer that sets no input sees a quiet stage.
    places = {two.v: 20e-3, two.h: 0.0, three.y: 25e-3, three.x: 0.0, three.z: 0.0}
    assert all(axis.measured == axis.reference == place for axis, place in places.items())
    assert not any(axis.reference_rate for axis in places)
    assert (two.sample_time, three.sample_time) == (LAYOUTS[2][2], LAYOUTS[3][2])


def ideal(description: int, original: bool = False) -> tuple[Regulator2DOF | Regulator3DOF, Stage2DOF | Stage3DOF]:
    """Regulator as it comes, or with the original gains and no limit, and a stage that is exactly its model."""
    controller, stage = (Regulator2DOF(), Stage2DOF()) if description == 2 else (Regulator3DOF(), Stage3DOF())
    if isinstance(controller, Regulator3DOF) and original:
        controller.current_limit = 0.0
        controller.antiwindup = False
        set_gains(controller.y, KY_ORIGINAL)
        set_gains(controller.x, KX_ORIGINAL)
        set_gains(controller.z, KX_ORIGINAL)
    idealise(description, stage, controller)
    return controller, stage


IDEAL = pytest.mark.parametrize(("description", "original"), [(2, False), (3, False), (3, True)])


# To a regulator both are one acceleration.
@pytest.mark.few(1)
@pytest.mark.parametrize(("description", "original", "disturbance"), [
    (2, False, "force"), (3, True, "force"), (2, False, "bias"), (3, False, "bias"),
    *(pytest.param(3, original, disturbance, marks=pytest.mark.thorough)
      for original, disturbance in ((False, "force"), (True, "bias")))])
@pytest.mark.usefixtures("slow")
def test_constant_disturbance_is_rejected(description: int, original: bool, disturbance: str) -> None:
    """An external force or a constant acceleration; the regulators with their default limits."""
    controller, stage = ideal(description, original)
    values = (2.0, 1.5, -1.5) if disturbance == "force" else (0.2, 0.2, -0.2)
    for name, value in zip(LAYOUTS[description][0], values, strict=False):
        setattr(getattr(stage, name), disturbance, value)
    errors = np.abs(simulate(description, controller, stage, {}, SETTLED[description]))
    assert errors.max(axis=0).min() > 1e-5, "the disturbance has to move every axis first"
    assert errors[-500:].max() < 1e-8


@pytest.mark.few(1)
@IDEAL
@pytest.mark.usefixtures("slow")
def test_sinusoid_of_the_internal_model_is_tracked(description: int, original: bool) -> None:
    """1.5π rad/s, 5 mm on the gap and 30 mm across, all axes together, from rest."""
    controller, stage = ideal(description, original)

    def sinusoid(offset: float, amplitude: float) -> Reference:
        return lambda t: (offset + amplitude * math.sin(OMEGA0 * t),
                          amplitude * OMEGA0 * math.cos(OMEGA0 * t))

    references = {name: sinusoid(0.0, 30e-3) for name in LAYOUTS[description][0][1:]}
    references[LAYOUTS[description][0][0]] = sinusoid(20e-3 if description == 2 else 25e-3, 5e-3)
    errors = np.abs(simulate(description, controller, stage, references, SETTLED[description]))
    assert errors.max(axis=0).min() > 5e-5, "the start has to disturb every axis"
    assert errors[round(0.6 * SETTLED[description] / LAYOUTS[description][2]):].mean(axis=0).max() < 0.02e-3
