"""The linear model of a user's class that keeps to the subset of native FMUs: the derivative of its own code."""

from typing import Any

import numpy as np

from fmi_export.definition import write
from fmi_export.errors import ExportError
from fmi_export.native.tangent import named, tangent_module
from fmi_export.sources import carried_modules
from maglev.analysis.differences.participant import Participant
from maglev.analysis.differences.realisation import Realisation
from maglev.arrays import Array
from maglev.cosim.user_classes.fmu import WrittenController
from maglev.errors import BuildError
from maglev.linear.blocks.tangent import derivatives
from maglev.packages import PACKAGES
from maglev.user_controllers.build import buildable
from maglev.user_controllers.source import is_class


def translated_realisation(part: Participant, base: Array, inputs: int) -> tuple[Realisation, tuple[str, ...]] | None:
    """State space of one sample of a class where it is marked, with the names of its states.

    Exact but for rounding, on the branch that it takes there. States are the numbers that it keeps from one sample to
    the next: the inputs reach them, and they reach an output. At rest it has the inputs `base`, shape (all inputs,), of
    which the first so many are those of the model. None of an FMU, of a class that no file has, that is not sampled as
    its loop, or that has what no native FMU can have.
    """
    fmu, path = part.fmu, part.setup.path
    if not isinstance(fmu, WrittenController) or is_class(path) or part.setup.ports is not None:
        return None
    part.back()
    block = fmu.slave.block
    law = block.law
    if not block.sampled or law.sample_time != part.size:
        return None
    try:
        with buildable(path, PACKAGES, native=True) as built:
            texts = carried_modules(built.definition.block.__module__, (*PACKAGES, *built.packages))
            names: dict[str, Any] = {}
            exec(tangent_module(texts, built.definition.name, "step"), names)
    except (BuildError, ExportError):
        return None
    places = {v.name: v.place.removeprefix("law.") for v in built.definition.variables}
    given, wanted = ([places[name] for name in ports] for ports in (part.inputs, part.outputs))
    fixed = {*given, *(places[v.name] for v in built.definition.variables if v.causality == "parameter")}
    kept = [place for place in numbers_of(law) if place not in fixed]
    n = len(kept)
    for place, value in zip(given, base.tolist(), strict=True):
        write(law, place, value)
    slopes = derivatives(law, {"step": (part.count * part.size,)}, [*kept, *given[:inputs]], [*kept, *wanted],
                         lambda *_: names[named(f"{built.definition.name}.step")])
    (a, b), (c, d) = (np.hsplit(rows, [n]) for rows in np.vsplit(slopes, [n]))
    moves = np.nonzero(reached(a, np.abs(b).sum(axis=1)) * reached(a.T, np.abs(c).sum(axis=0)))[0]
    return (Realisation(a[np.ix_(moves, moves)], b[moves], c[:, moves], d, 0.0), tuple(kept[k] for k in moves))


def numbers_of(part: Any, before: str = "") -> list[str]:
    """Attribute paths of the numbers of an object and its parts that can vary a little, in the order of definition."""
    places = []
    for name, value in vars(part).items():
        if isinstance(value, float):
            places.append(f"{before}{name}")
        elif hasattr(value, "__dict__"):
            places += numbers_of(value, f"{before}{name}.")
    return places


def reached(a: Array, first: Array) -> Array:
    """Above 0 where a state is reached, through the entries of a matrix, from those that something reaches at once."""
    touched: Array = np.sign(np.abs(first))
    for _ in range(len(a)):
        touched = np.sign(touched + np.abs(a) @ touched)
    return touched
