"""Short forms of FMI calls for the tests: single values by name, steps, and refusals with their message."""

import math
from collections.abc import Callable, Iterable, Mapping
from copy import copy
from typing import Any
from weakref import WeakKeyDictionary

import pytest
from fmpy.fmi1 import FMICallException
from fmpy.model_description import ScalarVariable

from maglev.cosim.fmu import Fmu


def another(fmu: Fmu) -> Fmu:
    """A further instance of the same library, where each `Fmu` has a copy of its own; for who asks to free."""
    found = copy(fmu)
    found.key = fmu.key + b"+"
    found.instance = fmu.fmi.instantiated(fmu.description, fmu.folder, found.key, found.take_message)
    return found


def variables(fmu: Fmu, causality: str) -> list[ScalarVariable]:
    """Variables of a causality."""
    return [v for v in fmu.description.modelVariables if v.causality == causality]


def put(fmu: Fmu, values: Mapping[str, float | bool]) -> None:
    """Set variables by name."""
    for name, value in values.items():
        v = fmu.variable(name)
        setter = fmu.instance.setBoolean if v.type == "Boolean" else fmu.instance.setReal
        setter([v.valueReference], [value])


def read(fmu: Fmu, name: str) -> float:
    """Value of a variable."""
    v = fmu.variable(name)
    getter = fmu.instance.getBoolean if v.type == "Boolean" else fmu.instance.getReal
    value: float = getter([v.valueReference])[0]
    return value


def put_reals(fmu: Fmu, values: Mapping[str, float]) -> None:
    """Set Real variables by name, in one call."""
    fmu.instance.setReal([fmu.variable(name).valueReference for name in values], list(values.values()))


def read_reals(fmu: Fmu, names: Iterable[str]) -> list[float]:
    """Values of Real variables, in one call."""
    values: list[float] = fmu.instance.getReal([fmu.variable(name).valueReference for name in names])
    return values


OUTPUTS: WeakKeyDictionary[Fmu, dict[str, ScalarVariable]] = WeakKeyDictionary()   # to look for them takes longer


def outputs(fmu: Fmu) -> dict[str, float]:
    """Values of all outputs."""
    if fmu not in OUTPUTS:
        OUTPUTS[fmu] = {v.name: v for v in variables(fmu, "output")}
    found = dict.fromkeys(OUTPUTS[fmu], 0.0)
    for boolean, getter in ((False, fmu.instance.getReal), (True, fmu.instance.getBoolean)):
        of_type = {name: v.valueReference for name, v in OUTPUTS[fmu].items() if (v.type == "Boolean") is boolean}
        if of_type:
            found.update(zip(of_type, getter([*of_type.values()]), strict=True))
    return found


def step(fmu: Fmu, first: int, count: int, size: float,
         before: Callable[[int, float], None] | None = None) -> list[dict[str, float]]:
    """Take communication steps `first` … `first + count − 1` of a size (s); outputs after each."""
    rows = []
    for k in range(first, first + count):
        if before is not None:
            before(k, k * size)
        fmu.instance.doStep(k * size, size)
        rows.append(outputs(fmu))
    return rows


def refusal(fmu: Fmu, call: Callable[[], Any]) -> str:
    """Message that the FMU logs when it refuses a call; fails the test if it does not refuse."""
    fmu.said()
    with pytest.raises(FMICallException):
        call()
    text = fmu.said()
    assert text, "refused without a message"
    return text


def bits(rows: list[dict[str, float]]) -> list[dict[str, str]]:
    """Values such that equal means equal bit for bit, NaN included."""
    return [{name: float(value).hex() if math.isfinite(value) else repr(value) for name, value in row.items()}
            for row in rows]
