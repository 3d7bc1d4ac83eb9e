"""Port names, units and step of a third-party FMU, from a TOML file.

    [controller]
    step = "1 ms"                                      # only if it is not the communication step
    "v.measured" = { port = "gap", unit = "mm" }       # ours = theirs
    "motor.i_a_cmd" = "current_u"

With such a map, and with units that the FMU declares itself, it is seen as if it had our names and SI units.
"""

from collections.abc import Mapping
from copy import copy
from dataclasses import dataclass, field
from math import inf, isfinite
from pathlib import Path
from typing import NamedTuple

from fmpy.model_description import ModelDescription, ScalarVariable

from maglev.files.errors import ScenarioError, key_path, nearest, shortened
from maglev.files.fmi_units import BASE_UNITS
from maglev.files.toml_file import read_toml
from maglev.files.units import Unit, known_unit, measures, parse_quantity, refused_as, unit_of, unit_of_powers
from maglev.fmi.parameter import REALS

FMUS = ("controller", "plant")


class Scale(NamedTuple):
    """Conversion of a variable: its value in the FMU's unit is (SI value − offset) × up / down.

    One of the two factors is 1: 20 mm / 1000 is the number nearest to 0.02, 20 mm × 0.001 need not be.
    """

    up: float
    down: float
    offset: float = 0.0   # SI value of 0 in the FMU's unit, as 273.15 K of 0 °C

    def to_own(self, value: float) -> float:
        """Value in the FMU's unit of a value in SI."""
        return (value - self.offset) * self.up / self.down

    def to_si(self, value: float) -> float:
        """Value in SI of a value in the FMU's unit."""
        return value * self.down / self.up + self.offset


class Port(NamedTuple):
    """Name and unit of one of our ports in an FMU; unit None: the one that the FMU declares."""

    name: str
    unit: str | None = None


@dataclass(frozen=True)
class PortMap:
    place: str = ""   # file and table, for messages
    ports: Mapping[str, Port] = field(default_factory=dict)   # by our names
    step: float | None = None   # step that the FMU wants, s; None: the communication step
    # units of our ports, assumed where the FMU declares none
    units: Mapping[str, str | None] = field(default_factory=dict)

    def refuse(self, ours: str, expectation: str) -> ScenarioError:
        port = self.ports[ours]
        value: object = port.name if port.unit is None else {"port": port.name, "unit": port.unit}
        return ScenarioError(f"{self.place}.{key_path([ours])} = {shortened(value)}: {expectation}")

    def require_known(self, known: Mapping[str, str | None]) -> None:
        """Raise for a line about an unknown port, or in a unit of another dimension than the port's."""
        for ours, port in self.ports.items():
            if ours not in known:
                raise self.refuse(ours, f"unknown port, {nearest(ours, known)}")
            unit = known[ours]
            if port.unit is not None and unit is not None and not measures(port.unit, unit):
                raise self.refuse(ours, f"expected a unit that converts to {unit}")


def read_port_maps(path: Path) -> dict[str, PortMap]:
    """Maps of a file, by name in the run; ScenarioError, with file, key and value, for an unexpected entry."""
    maps = {}
    for name, table in read_toml(path).items():
        if name not in FMUS:
            raise ScenarioError(f"{path}: unknown table {name!r}, {nearest(name, FMUS)}")
        place, step = f"{path}: {name}", None
        if not isinstance(table, dict):
            raise ScenarioError(f"{place} = {shortened(table)}: expected a table")
        if "step" in table:
            with refused_as(ScenarioError, f"{place}.step = {shortened(table['step'])}"):
                step = parse_quantity(table["step"], "s")
            if not step > 0.0:
                raise ScenarioError(f"{place}.step = {shortened(table['step'])}: expected a step > 0")
        maps[name] = PortMap(place, {ours: read_port(f"{place}.{key_path([ours])}", value)
                                     for ours, value in table.items() if ours != "step"}, step)
    return maps


def read_port(key: str, value: object) -> Port:
    entries = {"port": value} if isinstance(value, str) else value
    if not isinstance(entries, dict) or not all(isinstance(entry, str) for entry in entries.values()):
        raise ScenarioError(f"{key} = {shortened(value)}: expected the name of a port, or a table such as "
                            "{ port = \"gap\", unit = \"mm\" }")
    for entry in entries:
        if entry not in ("port", "unit"):
            raise ScenarioError(f"{key}.{entry} = {shortened(entries[entry])}: unknown key, expected port or unit")
    if "port" not in entries:
        raise ScenarioError(f"{key} = {shortened(value)}: expected the name of a port under the key port")
    if "unit" in entries:
        with refused_as(ScenarioError, f"{key}.unit = {entries['unit']!r}"):
            unit_of(entries["unit"])
    return Port(entries["port"], entries.get("unit"))


def declared_units(description: ModelDescription) -> dict[str, Unit]:
    """Return units without an offset that an FMU declares and that the table of units lacks, by name."""
    return {name: unit for name, (unit, offset) in units_with_offsets(description).items() if offset == 0.0}


def units_with_offsets(description: ModelDescription) -> dict[str, tuple[Unit, float]]:
    """Return all such units, each with its offset."""
    units = {}
    for unit in description.unitDefinitions:
        base = unit.baseUnit
        if base is None or known_unit(unit.name) is not None:
            continue
        if isfinite(base.offset) and 0.0 < base.factor < inf:
            powers = {name: getattr(base, name) for name in BASE_UNITS}
            units[unit.name] = unit_of_powers(powers, base.factor), base.offset
    return units


def apply(ports: PortMap, description: ModelDescription) -> dict[str, Scale]:
    """Give the variables of a model description our names and SI units; returns the conversions, by our names.

    One output can be several of our ports. A variable of the FMU whose name the map gives to another one is hidden.
    ScenarioError if it names a port that the FMU does not have, or one input twice, or a unit that does not fit.
    """
    theirs = {variable.name: variable for variable in description.modelVariables}
    first: dict[str, str] = {}
    seen: list[ScalarVariable] = []
    for ours, port in ports.ports.items():
        if port.name not in theirs:
            raise ports.refuse(ours, f"the FMU has no {port.name!r}, {nearest(port.name, theirs)}")
        variable = copy(theirs[port.name])
        if port.name in first and variable.causality != "output":
            raise ports.refuse(ours, f"{port.name!r} is {first[port.name]!r} already, expected another "
                                     f"{variable.causality or 'variable'}")
        first.setdefault(port.name, ours)
        if port.unit is not None and variable.type not in REALS:
            raise ports.refuse(ours, f"{port.name!r} is {variable.type}, expected a unit only of a Real")
        own = declared_unit(variable)
        declared = None if own == "1" else known_unit(own)   # some tools write 1 for every unit
        if port.unit is not None and declared is not None and not measures(port.unit, declared.si):
            raise ports.refuse(ours, f"the FMU declares {own}, expected a unit that converts to {declared.si}")
        variable.name, variable.unit = ours, port.unit or own
        seen.append(variable)
    seen += [copy(variable) for name, variable in theirs.items() if name not in {*first, *ports.ports}]
    description.modelVariables = seen
    for variable in seen:
        variable.unit = declared_unit(variable)
        if variable.type in REALS:
            variable.unit = variable.unit or ports.units.get(variable.name)
    declared_here = units_with_offsets(description)
    return {variable.name: scale for variable in seen if (scale := to_si_units(variable, declared_here)) is not None}


def declared_unit(variable: ScalarVariable) -> str | None:
    unit = variable.unit or getattr(variable.declaredType, "unit", None)
    return None if unit is None else str(unit)


def to_si_units(variable: ScalarVariable, declared: Mapping[str, tuple[Unit, float]]) -> Scale | None:
    """Give a variable its SI unit, of one known here or `declared`, its start value and range in it; the conversion."""
    known = known_unit(variable.unit)
    unit, offset = (known, 0.0) if known is not None else declared.get(variable.unit or "", (None, 0.0))
    if variable.type not in REALS or unit is None:
        return None
    by = unit.factor
    variable.unit = unit.si
    if by == 1.0 and offset == 0.0:
        return None
    inverse = round(1.0 / by)
    scale = Scale(float(inverse), 1.0, offset) if by < 1.0 and abs(inverse * by - 1.0) < 1e-12 else Scale(
        1.0, by, offset)
    for key in ("start", "min", "max"):
        if getattr(variable, key) is not None:
            setattr(variable, key, repr(scale.to_si(float(getattr(variable, key)))))
    return scale
