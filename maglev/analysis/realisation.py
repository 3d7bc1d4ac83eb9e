"""State space from responses to one sample alone: Ho and Kalman's realisation on a geometric grid.

A linear system is y[k] = Σ h[j] u[k − j] with h[0] = D, h[j] = C A^(j−1) B. Any matrix of its blocks h[1 + r_i + c_j]
is a product O R with rows C A^(r_i) of O and columns A^(c_j) B of R. With r and c that grow geometrically, a few dozen
of them see an observer that is over in ten samples and an integrator that takes thousands.

B. L. Ho, R. E. Kálmán, Effective construction of linear state-variable models from input/output functions,
Regelungstechnik 14, 1966.
"""

from typing import NamedTuple

import numpy as np

from maglev.files.arrays import Array

EACH = 8            # first samples, all of which are on the grid
GROWING = 26        # further ones
NOISE = 1e-11       # of a singular value over the largest, at which nothing but noise is left
FALL = 3.0          # of the singular values from one to the next, where a number of states is tried
AS_GOOD = 100.0     # times the least misfit, with which a number of states is enough


class Realisation(NamedTuple):
    """A sampled state space and how far its responses are from those that it was made of, relative to the largest."""

    A: Array
    B: Array
    C: Array
    D: Array
    misfit: float


def realise(responses: Array) -> Realisation:
    """Return the state space of responses to one sample, shape (samples, outputs, inputs), the first of which is D.

    The number of states is where the singular values fall most, among numbers that are enough for the responses. The
    rest is noise, and a state that fits noise may well be unstable.
    """
    samples, outputs, inputs = responses.shape
    most = float(np.abs(responses).max())
    if most == 0.0:
        return Realisation(np.zeros((0, 0)), np.zeros((0, inputs)), np.zeros((outputs, 0)), responses[0], 0.0)
    # In its own unit every input, and every output, has the same weight.
    by_input = np.abs(responses).max(axis=(0, 1))
    by_input[by_input == 0.0] = 1.0
    by_output = np.abs(responses / by_input).max(axis=(0, 2))
    by_output[by_output == 0.0] = 1.0
    scaled = responses / by_input / by_output[:, None]
    last = (samples - 3) // 2
    grid = np.unique(np.concatenate([np.arange(min(EACH, last)), np.geomspace(EACH, last, GROWING)]).astype(int))
    places = grid[:, None] + grid[None, :] + 1

    def blocks(ahead: int) -> Array:
        chosen: Array = scaled[places + ahead].transpose(0, 2, 1, 3)
        return chosen.reshape(len(grid) * outputs, len(grid) * inputs)

    left, values, right = np.linalg.svd(blocks(0), full_matrices=False)
    later = blocks(1)
    realisations: list[tuple[float, Realisation]] = []
    for n in range(1, int((values > NOISE * values[0]).sum()) + 1):
        fall = values[n - 1] / max(values[n], 1e-3 * NOISE * values[0]) if n < len(values) else 1.0
        if fall > FALL:
            root = np.sqrt(values[:n])
            a = (left[:, :n] / root).T @ later @ (right[:n].T / root)
            b = (root[:, None] * right[:n])[:, :inputs] * by_input
            c = (left[:, :n] * root)[:outputs] * by_output[:, None]
            realisations.append((fall, Realisation(a, b, c, responses[0], misfit(a, b, c, responses[0], responses))))
    if not realisations:
        return Realisation(np.zeros((0, 0)), np.zeros((0, inputs)), np.zeros((outputs, 0)), responses[0], 1.0)
    least = min(candidate.misfit for _, candidate in realisations)
    return max((pair for pair in realisations if pair[1].misfit <= AS_GOOD * least), key=lambda pair: pair[0])[1]


@np.errstate(over="ignore", invalid="ignore")   # one that grows beyond all numbers fits least
def misfit(a: Array, b: Array, c: Array, d: Array, responses: Array) -> float:
    """Largest difference between the responses of a state space and given ones, over the largest of these."""
    state, worst = b, float(np.abs(d - responses[0]).max())
    for response in responses[1:]:
        worst = max(worst, float(np.abs(c @ state - response).max()))
        state = a @ state
    share = worst / max(float(np.abs(responses).max()), 1e-300)
    return share if np.isfinite(share) else np.inf
