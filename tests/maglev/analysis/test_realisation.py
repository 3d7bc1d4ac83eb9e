"""State space from responses: the poles come back, and noise makes no state."""

import numpy as np
import pytest
from scipy.linalg import block_diag

from maglev.analysis.realisation import realise

STEP = 0.2e-3


def system() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """A fast lag, an integrator, and an oscillator of 4.7 rad/s, which two inputs and three outputs see differently."""
    turn = 4.7 * STEP
    a = block_diag(np.diag([np.exp(-1000.0 * STEP), 1.0]),
                   [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]])
    b = np.array([[1.0, 0.2], [STEP, -0.3 * STEP], [0.0, 2.0 * STEP], [STEP, 0.0]])
    c = np.array([[1.0, 2.0, -1.0, 0.0], [0.0, 1.0, 0.0, 3.0], [-0.5, 0.0, 1.0, 1.0]])
    return a, b, c, np.array([[0.5, 0.0], [0.0, 1.0], [0.1, -0.2]])


def responses(samples: int) -> np.ndarray:
    a, b, c, d = system()
    found, state = [d], b
    for _ in range(samples - 1):
        found.append(c @ state)
        state = a @ state
    return np.array(found)


@pytest.mark.parametrize("scale", [1.0, 1e-6])
def test_poles_come_back_in_the_presence_of_noise(scale: float) -> None:
    given = responses(3000)
    noise = 1e-12 * np.random.default_rng(1).standard_normal(given.shape)
    found = realise((given + noise) * [1.0, scale])
    rates = np.log(np.linalg.eigvals(found.A).astype(complex)) / STEP
    rates = rates[np.lexsort((rates.real.round(), rates.imag.round()))]
    np.testing.assert_allclose(rates, [-4.7j, -1000.0, 0.0, 4.7j], atol=2e-3)
    assert found.misfit < 1e-9


def test_what_it_was_not_made_of_is_foretold() -> None:
    """Half of the responses give the other half."""
    given = responses(6000)
    a, b, c, _, _ = realise(given[:3000])
    for k in (4000, 5999):
        np.testing.assert_allclose(c @ np.linalg.matrix_power(a, k - 1) @ b, given[k], atol=1e-8)


def test_nothing_has_no_states() -> None:
    found = realise(np.zeros((100, 2, 1)))
    assert found.A.shape == (0, 0)
    assert found.misfit == 0.0
