"""Parameters of the plant as an environment takes them: fixed, or drawn anew for every episode."""

from collections.abc import Mapping, Sequence
from math import isfinite
from numbers import Real
from typing import Any

import numpy as np
from fmpy.model_description import ScalarVariable

from maglev.errors import QuantityError, ScenarioError, UnknownName, nearest
from maglev.units import known_unit, parse_quantity

Value = float | str | bool                # SI, or text with a unit such as "25 mm"
Setting = Value | Sequence[Value]         # a pair: drawn between the two, in every episode


class PlantParameters:
    """Start values of a plant, which has `variables`, by their names, such as "y.friction.coulomb".

    UnknownName if the plant has no such parameter, ScenarioError if a value cannot be used.
    """

    def __init__(self, variables: Mapping[str, ScalarVariable], settings: Mapping[str, Setting]):
        self.known = {name: each for name, each in variables.items() if each.causality == "parameter"}
        self.ranges = {name: self.range_of(name, setting) for name, setting in settings.items()}

    def range_of(self, name: str, setting: Setting) -> tuple[float | bool, float | bool]:
        """Range in which a parameter is drawn; twice the same for a single value."""
        if name not in self.known:
            raise UnknownName(f"{name}: the plant has no such parameter; nearest is {nearest(name, self.known)}")
        pair = setting if isinstance(setting, Sequence) and not isinstance(setting, str) else (setting, setting)
        if len(pair) != 2:
            raise ScenarioError(f"{name} = {setting!r}, expected a value or a pair of values, low and high")
        low, high = (self.value_of(name, value) for value in pair)
        if not low <= high:
            raise ScenarioError(f"{name} = {setting!r}, expected the lower value first")
        return low, high

    def value_of(self, name: str, value: Any) -> float | bool:
        """A parameter's value in SI."""
        variable = self.known[name]
        if variable.type == "Boolean":
            if not isinstance(value, bool | np.bool_):
                raise ScenarioError(f"{name} = {value!r}, expected True or False")
            return bool(value)
        unit = variable.unit or "1"
        try:
            if isinstance(value, str) and known_unit(unit) is None:
                raise QuantityError(f"{value!r}: expected a plain number, in {unit}")
            found = parse_quantity(float(value) if isinstance(value, Real) and not isinstance(value, bool) else value,
                                   unit if known_unit(unit) else None)
        except QuantityError as error:
            raise ScenarioError(f"{name} = {error}") from None
        low, high = float(variable.min), float(variable.max)
        if not (isfinite(found) and low <= found <= high):
            raise ScenarioError(f"{name} = {found!r} {unit}, expected a number from {low:g} to {high:g}")
        return found

    def extremes(self, name: str) -> tuple[float, float]:
        """Smallest and largest value that a parameter can have; the plant's own if none is given."""
        low, high = self.ranges.get(name, (self.own(name), self.own(name)))
        return float(low), float(high)

    def own(self, name: str) -> float:
        """Value that the plant has if none is given."""
        return float(self.known[name].start)

    def draw(self, random: np.random.Generator, settings: Mapping[str, Setting]) -> dict[str, float | bool]:
        """Values for one episode, in which some settings go before those of all episodes."""
        ranges = {**self.ranges, **{name: self.range_of(name, setting) for name, setting in settings.items()}}
        return {name: low if low == high else self.drawn(random, low, high) for name, (low, high) in ranges.items()}

    def drawn(self, random: np.random.Generator, low: float | bool, high: float | bool) -> float | bool:
        """A value between two, which are not the same; of a Boolean, either."""
        return bool(random.integers(2)) if isinstance(low, bool) else float(random.uniform(low, high))
