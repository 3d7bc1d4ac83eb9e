"""Derivatives of a block at a point: its Python, differentiated as that of model exchange is, runs on two blocks."""

from collections.abc import Callable, Mapping, Sequence
from copy import deepcopy
from functools import cache
from typing import Any

import numpy as np

from fmi_export.definition import slot
from fmi_export.native.tangent import named, tangent_module
from fmi_export.slave import scalar_slots
from fmi_export.sources import carried_modules
from maglev.arrays import Array

PACKAGES = ("pmlsm", "plant_fmu", "controller_fmu")   # that blocks here are made of


@cache
def differentiated(block: type, method: str) -> Callable[..., Any]:
    """The function that does what a method does, to a block and to a second one with its derivatives along a way."""
    texts = carried_modules(block.__module__, PACKAGES)
    names: dict[str, Any] = {}
    exec(tangent_module(texts, block.__name__, method), names)
    function: Callable[..., Any] = names[named(f"{block.__name__}.{method}")]
    return function


def derivatives(block: Any, methods: Mapping[str, Sequence[float]], places: Sequence[str], wanted: Sequence[str],
                function: Callable[[type, str], Callable[..., Any]] = differentiated) -> Array:
    """Derivatives (m, n), SI, of m numbers that methods, called in turn, leave in a block, by n that are in it before.

    Exact but for rounding; the block itself stays as it is. The arguments of the methods do not vary; `places` and
    `wanted` are attribute paths. `function` gives what a method does to a block and to a second one with derivatives.
    """
    kind: type = type(block)
    calls = [(function(kind, method), [part for value in values for part in (value, 0.0)])
             for method, values in methods.items()]
    own, direction = deepcopy(block), deepcopy(block)
    at = [(part, name, getattr(part, name)) for part, name in scalar_slots(own, block)]
    along = scalar_slots(direction, block)
    slopes = np.zeros((len(wanted), len(places)))
    for column, place in enumerate(places):
        for part, name, value in at:
            setattr(part, name, value)
        for part, name in along:
            setattr(part, name, 0.0)
        setattr(*slot(direction, place), 1.0)
        for function, arguments in calls:
            function(own, direction, *arguments)
        slopes[:, column] = [getattr(*slot(direction, path)) for path in wanted]
    return slopes
