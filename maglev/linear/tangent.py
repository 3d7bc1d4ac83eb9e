"""Derivatives of a block at a point: its Python, differentiated as that of model exchange is, runs on two blocks."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from maglev.files.arrays import Array
from maglev.fmi.definition import put, read, write
from maglev.language.blocks import derivative
from maglev.language.program import FLOAT


def copied(part: Any) -> Any:
    """A copy of a block: those of deepcopy take three times as long, and are slower to run."""
    if isinstance(part, list):
        return [copied(each) for each in part]
    if not hasattr(part, "__dict__"):
        return part
    copy = object.__new__(type(part))
    for name, value in vars(part).items():
        setattr(copy, name, copied(value))
    return copy


def numbers_of(part: Any) -> Iterator[tuple[Any, str | int, Any]]:
    """The numbers of a block and its parts: where each is, and its value."""
    pairs: Any = enumerate(part) if isinstance(part, list) else vars(part).items() if hasattr(part, "__dict__") else ()
    for key, value in pairs:
        if isinstance(value, bool | int | float):
            yield part, key, value
        else:
            yield from numbers_of(value)


def derivatives(block: Any, methods: Mapping[str, Sequence[float]], places: Sequence[str],
                wanted: Sequence[str]) -> Array:
    """Derivatives (m, n), SI, of m numbers that methods, called in turn, leave in a block, by n that are in it before.

    Exact except for rounding; the block itself stays as it is. The arguments of the methods do not vary; `places` and
    `wanted` are attribute paths. Untranslatable if a method is not of the language of blocks.
    """
    calls = [(derivative(block, method, [FLOAT] * len(values)), [part for value in values for part in (value, 0.0)])
             for method, values in methods.items()]
    own, direction = copied(block), copied(block)
    values = [(part, other, key, value) for (part, key, value), (other, _, _) in zip(
        numbers_of(own), numbers_of(direction), strict=True)]
    slopes = np.zeros((len(wanted), len(places)))
    for column, place in enumerate(places):
        for part, other, key, value in values:
            put(part, key, value)
            put(other, key, 0.0)
        write(direction, place, 1.0)
        for function, arguments in calls:
            function(own, direction, *arguments)
        slopes[:, column] = [read(direction, path) for path in wanted]
    return slopes
