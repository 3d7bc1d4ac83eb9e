"""The varied quantities of a study, in units for people: percentages and factors with their nominal values."""

from collections.abc import Mapping
from typing import Any, NamedTuple

import pyarrow as pa

from maglev.files.arrays import Array
from maglev.pages.study_text import numbers, units_of
from maglev.scenario.quantities import printed, shown_in


class Varied(NamedTuple):
    """A quantity that varies: the name of its column and how pages call it, and its values in a unit, (samples,)."""

    name: str
    label: str
    unit: str
    values: Array
    signed: bool = False   # a change: its sign is always written
    scale: float = 1.0     # of the unit per SI unit

    def text(self, *values: float, digits: int = 4) -> str:
        """Values as a range with its unit, such as "−20 to +20 %"."""
        sign = "+" if self.signed else ""
        shown = dict.fromkeys(f"{value:{sign}.{digits}g}" for value in values)
        return f"{' to '.join(shown)} {self.unit}".rstrip()


def varied_of(table: pa.Table, about: Mapping[str, Any]) -> list[Varied]:
    """All that varies, in its order."""
    units, found = units_of(table), []
    for parameter in about["vary"]:
        name, values = parameter["name"], numbers(table, parameter["name"])
        if parameter.get("kind") == "percent":
            nominal = parameter.get("nominal")
            label = " and ".join(parameter["set"]) if name == f"factor of {parameter['set'][0]}" else name
            of = f", change from {printed(nominal, parameter['unit'])}" if nominal is not None else ", change"
            found.append(Varied(name, label + of, "%", 100.0 * (values - 1.0), True))
        elif parameter.get("mode") == "factor":
            nominal = parameter.get("nominal")
            of = f" {printed(nominal, parameter['unit'])}" if nominal is not None else ""
            found.append(Varied(name, name, f"times{of}", values))
        else:
            unit, scale = shown_in(values.tolist(), units[name])
            found.append(Varied(name, name, unit, scale * values, scale=scale))
    return found
