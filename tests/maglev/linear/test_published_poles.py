"""The thesis's poles from its gains: the tables of the documentation, and what they say."""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

from maglev.files.marked import with_part
from maglev.linear.design import regulator_polynomial

ROOT = Path(__file__).parents[3]
OMEGA0 = 1.5 * np.pi


@pytest.fixture(scope="module")
def tool() -> ModuleType:
    spec = importlib.util.spec_from_file_location("published_poles", ROOT / "tools" / "published_poles.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("name", ["design", "loop"])
def test_the_page_has_the_table(tool: ModuleType, name: str) -> None:
    text = with_part(tool.PAGE, name, tool.TABLES[name]())
    assert tool.PAGE.read_text(encoding="utf-8") == text, "python tools/published_poles.py writes it again"


def test_polynomial_is_that_of_the_matrix() -> None:
    """e'' = K [e, ė, ξ]ᵀ + ξ1, ξ' = φ ξ + N e, as a matrix of numbers without structure."""
    gains = np.array([-2.0, -3.0, -5.0, 7.0, -11.0])
    matrix = np.zeros((5, 5))
    matrix[0, 1] = matrix[2, 3] = matrix[3, 4] = matrix[4, 0] = 1.0
    matrix[1] = gains
    matrix[1, 2] += 1.0
    matrix[4, 3] = -1.7**2
    assert regulator_polynomial(gains.tolist(), 1.7) == pytest.approx(np.poly(matrix), rel=1e-12)


@pytest.mark.parametrize(("gains", "poles", "within"), [
    ((-1182, -55, -154440, -45128, -11924), [-9, -10, -11, -12, -13], 7e-4),
    ((-1662, -65, -360360, -103350, -20332), [-11, -12, -13, -14, -15], 5e-4),
    ((-463, -35, -15121, -997, -2548), [-5, -6, -7, -8, -9], 5e-4),
    ((-1274, -104, -50001, -3936, -7774), [-91.3, -4.2 + 6.4j, -4.2 - 6.4j, -2.3 + 2j, -2.3 - 2j], 6.1e-3)])
def test_printed_gains_have_the_printed_poles(gains: tuple[float, ...], poles: list[complex], within: float) -> None:
    """Poles that are printed to a digit or two, by their polynomials."""
    assert regulator_polynomial(gains, OMEGA0) == pytest.approx(np.poly(poles).real, rel=within)


def test_the_sign_of_the_fourth_gain() -> None:
    printed = np.poly([-31.6, -2.8 + 5.6j, -2.8 - 5.6j, -2.1 + 1.7j, -2.1 - 1.7j]).real
    corrected, as_printed = (regulator_polynomial((-354, -41, -8945, k4, -1472), OMEGA0) for k4 in (1201, -1201))
    assert np.abs(corrected / printed - 1.0).max() < 0.02 < 0.3 < np.abs(as_printed / printed - 1.0).max()


def test_the_ripple_moves_the_slow_poles(tool: ModuleType) -> None:
    """What the page says of Ky (5.14): without the ripple the loop's slow pairs are those that are printed."""
    ky = tool.SETS[-1]
    slow = tool.axis_rates(tool.loop_with(ky, {"y.ripple.amplitude": 0.0}), "y")[:4]
    assert slow == pytest.approx([-2.3 - 2.0j, -2.3 + 2.0j, -4.2 - 6.4j, -4.2 + 6.4j], abs=0.07)
    other = tool.axis_rates(tool.loop_with(ky), "y")
    assert other[:2] == pytest.approx([-1.7 - 2.1j, -1.7 + 2.1j], abs=0.07)
    assert other[4].real == pytest.approx(-142.0, abs=0.5)
