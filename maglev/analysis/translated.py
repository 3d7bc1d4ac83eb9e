"""The linear model of a user's class that keeps to the subset of native FMUs: the derivative of its own code."""

from typing import Any

import numpy as np

from maglev.analysis.participant import Participant
from maglev.analysis.realisation import Realisation
from maglev.cosim.user_class import WrittenController
from maglev.files.arrays import Array
from maglev.fmi.definition import write
from maglev.language.program import Untranslatable
from maglev.linear.tangent import derivatives
from maglev.user.source import PythonFile


def translated_realisation(part: Participant, base: Array, inputs: int) -> tuple[Realisation, tuple[str, ...]] | None:
    """State space of one sample of a class where it is marked, with the names of its states.

    Exact except for rounding, on the branch that it takes there. States are the numbers that it keeps from one sample
    to
    the next: the inputs reach them, and they reach an output. At rest it has the inputs `base`, shape (all inputs,), of
    which the first so many are those of the model. None of an FMU, of a class that no file has, that is not sampled as
    its loop, or that has what no native FMU can have.
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
