"""Derivatives of a block at a point: its Python, differentiated as that of model exchange is, runs on two blocks."""

from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

import numpy as np

from fmi_export.definition import read, write
from fmi_export.native.tangent import named, tangent_module
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
    made: dict[int, tuple[Any, Any]] = {}
    numbers: list[tuple[Any, Any, str, float]] = []

    def copies(part: Any) -> tuple[Any, Any]:   # those of deepcopy take three times as long, and are slower to run
        if id(part) not in made:
            made[id(part)] = own, other = object.__new__(type(part)), object.__new__(type(part))
            for name, value in vars(part).items():
                if isinstance(value, (bool, int, float)):
                    numbers.append((own, other, name, value))
                else:
                    for each, copy in zip((own, other), copies(value), strict=True):
                        setattr(each, name, copy)
        return made[id(part)]

    own, direction = copies(block)
    slopes = np.zeros((len(wanted), len(places)))
    for column, place in enumerate(places):
        for part, other, name, value in numbers:
            setattr(part, name, value)
            setattr(other, name, 0.0)
        write(direction, place, 1.0)
        for function, arguments in calls:
            function(own, direction, *arguments)
        slopes[:, column] = [read(direction, path) for path in wanted]
    return slopes
