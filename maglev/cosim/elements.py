"""Arrays of FMI 3.0 in a co-simulation: each element is a variable of its own, such as gap[1] or gains[2,3]."""

from collections.abc import Iterator, Mapping, Sequence
from copy import copy
from ctypes import c_size_t, c_uint32, c_void_p
from itertools import count, product
from math import prod
from typing import Any

from fmpy.model_description import ModelDescription, ScalarVariable

MOST_ELEMENTS = 10_000   # of an array that is taken apart


class ElementReference(int):
    """Value reference of an element, which no variable of the FMU has."""

    array: int   # reference of the array
    index: int   # of the element, from 0 on
    size: int    # elements of the array

    @classmethod
    def of(cls, number: int, array: int, index: int, size: int) -> "ElementReference":
        reference = cls(number)
        reference.array, reference.index, reference.size = array, index, size
        return reference


def of_variable(variable: ScalarVariable) -> int:
    """Value reference of a variable, or of the array that it is an element of."""
    return int(getattr(variable.valueReference, "array", variable.valueReference))


def elements_of(variables: Sequence[ScalarVariable], kinds: Mapping[str, object]) -> Iterator[ScalarVariable]:
    """Yield the variables, with elements instead of arrays of these types; arrays of other types get the type "…[]".

    The structural parameters that decide how many there are keep their start values.
    """
    taken = {variable.valueReference for variable in variables}
    free = (number for number in count(2**32 - 1, -1) if number not in taken)
    for variable in variables:
        size = prod(variable.shape or ())
        if not variable.dimensions:
            yield variable
        elif variable.type not in kinds or not 0 < size <= MOST_ELEMENTS:
            whole = copy(variable)
            whole.type = f"{variable.type}[]"
            yield whole
        else:
            starts = (variable.start or "").split()
            for index, place in enumerate(product(*(range(1, n + 1) for n in variable.shape))):
                element = copy(variable)
                element.name = f"{variable.name}[{','.join(map(str, place))}]"
                element.valueReference = ElementReference.of(next(free), variable.valueReference, index, size)
                element.start = starts[index] if len(starts) == size else starts[0] if starts else None
                element.dimensions, element.shape = [], ()
                yield element


class ElementAccess:
    """A function of FMI 3.0 that gets or sets values, called as one of FMI 2.0, of variables and of elements.

    An element is set in its array as the FMU gives it.
    """

    def __init__(self, getter: Any, setter: Any, value: Any, references: Mapping[int, ElementReference]):
        self.getter, self.setter = getter, setter   # the latter None to get
        self.value = value
        self.references = references

    def __call__(self, handle: c_void_p, references: Any, number: c_size_t, values: c_void_p) -> int:
        given = (self.value * number.value).from_address(values.value or 0)
        if isinstance(references, c_void_p):
            references = (c_uint32 * number.value).from_address(references.value or 0)
        parts: dict[int, list[tuple[int, int]]] = {}   # of arrays: places in the call, and in the array
        sizes: dict[int, int] = {}
        for place, reference in enumerate(references):
            element = self.references.get(reference)
            array, size, index = (reference, 1, 0) if element is None else (element.array, element.size, element.index)
            parts.setdefault(array, []).append((place, index))
            sizes[array] = size
        status = 0
        for array, places in parts.items():
            held = (self.value * sizes[array])()
            if self.setter is None or len(places) < len(held):
                status = max(status, self.call(self.getter, handle, array, held))
            for place, index in places:
                if self.setter is None:
                    given[place] = held[index]
                else:
                    held[index] = given[place]
            if self.setter is not None:
                status = max(status, self.call(self.setter, handle, array, held))
        return status

    def call(self, function: Any, handle: c_void_p, array: int, held: Any) -> int:
        return int(function(handle, (c_uint32 * 1)(array), c_size_t(1), held, c_size_t(len(held))))


def with_elements(description: ModelDescription, types: Mapping[str, Any], getters: Mapping[str, Any],
                  setters: Mapping[str, Any]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Functions that get and set values, by type, for an FMU with arrays: see `ElementAccess`."""
    by_kind: dict[str, dict[int, ElementReference]] = {}
    for variable in description.modelVariables:
        if isinstance(variable.valueReference, ElementReference):
            by_kind.setdefault(variable.type, {})[int(variable.valueReference)] = variable.valueReference
    made = [dict(functions) for functions in (getters, setters)]
    for kind, references in by_kind.items():
        get, put = getters[kind].function, setters[kind].function
        made[0][kind] = ElementAccess(get, None, types[kind].value, references)
        made[1][kind] = ElementAccess(get, put, types[kind].value, references)
    return made[0], made[1]
