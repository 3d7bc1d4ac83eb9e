"""Arrays of FMI 3.0 in the definition of an FMU; no FMU carries this module."""

from collections.abc import Sequence
from dataclasses import replace
from math import prod

from maglev.fmi.definition import Array, FmuDefinition
from maglev.language.errors import ExportError

MOST_ELEMENTS = 255   # of an array: a byte in the FMU says how many it has


def with_arrays(definition: FmuDefinition, name: str, arrays: Sequence[Array]) -> FmuDefinition:
    """Return the same definition under another name, for co-simulation only, with arrays of FMI 3.0.

    They come last, those of an array one after the other. ExportError if they differ in more than name and start value.
    """
    by_name = {v.name: v for v in definition.variables}
    for array in arrays:
        first, *others = (by_name[element] for element in array.elements)
        for other in others:
            if replace(other, name=first.name, path=first.path, description=first.description, source=first.source,
                       hint=first.hint, depends_on=first.depends_on, starts_from=first.starts_from) != first:
                raise ExportError(f"{array.name}: {first.name} and {other.name} differ in causality, variability, unit "
                                  "or range, expected elements that are alike")
        if not prod(array.shape) == len(array.elements) <= MOST_ELEMENTS:
            raise ExportError(f"{array.name}: {len(array.elements)} elements, expected as many as shape = {array.shape}"
                              f" has, at most {MOST_ELEMENTS}")
    elements = [element for array in arrays for element in array.elements]
    scalars = [v for v in definition.variables if v.name not in elements]
    return replace(definition, name=name, variables=(*scalars, *(by_name[element] for element in elements)),
                   continuous=None, arrays=tuple(arrays))
