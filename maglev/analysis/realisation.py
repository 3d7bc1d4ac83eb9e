"""State space of a controller, from responses to one sample alone or from the derivative of a class's own code.

From responses it is Ho and Kalman's realisation on a geometric grid.

A linear system is y[k] = Σ h[j] u[k − j] with h[0] = D, h[j] = C A^(j−1) B. Any matrix of its blocks h[1 + r_i + c_j]
is a product O R with rows C A^(r_i) of O and columns A^(c_j) B of R. With r and c that grow geometrically, a few dozen
of them see an observer that is over in ten samples and an integrator that takes thousands.

B. L. Ho, R. E. Kálmán, Effective construction of linear state-variable models from input/output functions,
Regelungstechnik 14, 1966.
"""

from typing import Any, NamedTuple

import numpy as np

from maglev.analysis.participant import Participant
from maglev.cosim.user_class import WrittenController
from maglev.files.arrays import Array
from maglev.fmi.definition import write
from maglev.language.program import Untranslatable
from maglev.linear.tangent import derivatives
from maglev.user.source import PythonFile

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


def translated_realisation(part: Participant, base: Array, inputs: int) -> tuple[Realisation, tuple[str, ...]] | None:
    """State space of one sample of a class where it is marked, with the names of its states.

    Exact except for rounding, on the branch that it takes there. States are the numbers that it keeps from one sample
    to the next: the inputs reach them, and they reach an output. At rest it has the inputs `base`, shape (all inputs,),
    of which the first so many are those of the model. None of an FMU, of a class that no file has, that is not sampled
    as its loop, or that has what no native FMU can have.
    """
    fmu, source = part.fmu, part.setup.source
    if not (isinstance(fmu, WrittenController) and isinstance(source, PythonFile)) or part.setup.ports is not None:
        return None
    part.back()
    law, definition = fmu.slave.block.law, source.load().definition
    if not definition.sampled or law.sample_time != part.size:
        return None
    places = {v.name: v.place.removeprefix("law.") for v in definition.variables}
    given, wanted = ([places[name] for name in ports] for ports in (part.inputs, part.outputs))
    fixed = {*given, *(places[v.name] for v in definition.variables if v.causality == "parameter")}
    kept = [place for place in numbers_of(law) if place not in fixed]
    n = len(kept)
    for place, value in zip(given, base.tolist(), strict=True):
        write(law, place, value)
    try:
        slopes = derivatives(law, {"step": (part.count * part.size,)}, [*kept, *given[:inputs]], [*kept, *wanted])
    except Untranslatable:
        return None
    (a, b), (c, d) = (np.hsplit(rows, [n]) for rows in np.vsplit(slopes, [n]))
    moves = np.nonzero(reached(a, np.abs(b).sum(axis=1)) * reached(a.T, np.abs(c).sum(axis=0)))[0]
    return (Realisation(a[np.ix_(moves, moves)], b[moves], c[:, moves], d, 0.0), tuple(kept[k] for k in moves))


def numbers_of(part: Any, before: str = "") -> list[str]:
    """Attribute paths of the numbers of an object and its parts that can vary a little, in the order of definition."""
    if isinstance(part, float):
        return [before.lstrip(".")]
    if isinstance(part, list):
        return [place for k, each in enumerate(part) for place in numbers_of(each, f"{before}[{k}]")]
    return [place for name, value in getattr(part, "__dict__", {}).items()
            for place in numbers_of(value, f"{before}.{name}")]


def reached(a: Array, first: Array) -> Array:
    """Above 0 where a state is reached, through the entries of a matrix, from those that something reaches at once."""
    touched: Array = np.sign(np.abs(first))
    for _ in range(len(a)):
        touched = np.sign(touched + np.abs(a) @ touched)
    return touched
