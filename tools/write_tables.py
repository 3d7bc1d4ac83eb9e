"""Put the tables of stages, of capability flags, of the keys of a scenario file, and of units into their pages.

    python tools/write_tables.py
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.marked import markdown_table, write_part
from maglev.files.units import PREFIXES, UNITS
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.model_description import model_description, model_description_3
from maglev.scenario import run_plan
from maglev.scenario.claims import Claim, Elsewhere, ProcedureClaim, RunClaim
from maglev.scenario.procedure import ProcedureSettings
from maglev.scenario.quantities import METRICS, PROCEDURE_VALUES
from maglev.scenario.signals import Constant, Csv, SignalTable, Sinusoids, Steps, Term
from maglev.scenario.toml_table import Table, ValueKind
from pmlsm.stage_description import StageDescription

DOCS = Path(__file__).parents[1] / "docs"
YES_NO = {"false": "no", "true": "yes"}
INTERFACES = {"CoSimulation": "co-simulation", "ModelExchange": "model exchange"}
IN_FMI_3 = {"canGetAndSetFMUstate": "canGetAndSetFMUState", "canSerializeFMUstate": "canSerializeFMUState",
            "providesDirectionalDerivative": "providesDirectionalDerivatives"}

# Kinds of FMU that share all their flags, each with the beginnings of its names.
GROUPS = {"plants": ("Plant",), "closed loops": ("ClosedLoop",),
          "controllers, estimators, measurements, commutations": ("",)}

TABLES: tuple[type[Table], ...] = (
    run_plan.RunPlan, run_plan.FmuTable, run_plan.RunOutput, SignalTable, Constant, Steps, Sinusoids, Term, Csv,
    run_plan.Axis, run_plan.Motor, run_plan.MetricSettings, run_plan.Event, run_plan.CheckSettings,
    run_plan.SignalTolerance, RunClaim, ProcedureSettings, ProcedureClaim, Elsewhere)

# What keys name that stand for many things.
NAMES: dict[tuple[type[Table], str], Iterable[str]] = {
    (RunClaim, "metric"): METRICS, (ProcedureClaim, "value"): PROCEDURE_VALUES}

WORDS: dict[Any, str] = {str: "text", float: "number", int: "whole number", bool: "true or false"}

# Units by dimension; the letters before a symbol are PREFIXES.
MEASURED = {
    "length": "m, cm, mm, um, nm", "time": "s, ms, us, ns, min, h", "mass": "kg, g",
    "angle": "rad, mrad, urad, deg (°)", "current": "A", "voltage": "V", "resistance": "Ohm (ohm, Ω)",
    "inductance": "H", "capacitance": "F", "charge": "C",
    "magnetic flux": "Wb", "flux density": "T", "force": "N", "torque": "N.m, mN.m, Nm, mNm", "energy": "J, Wh",
    "power": "W", "pressure": "Pa, bar", "speed of rotation": "rad/s, rpm", "frequency": "Hz, kHz, MHz",
    "temperature": "K", "share": "1, %"}


def short(stage: StageDescription) -> str:
    return stage.title.removesuffix(" stage")


def axes_table() -> str:
    rows = []
    for stage in PACKAGED_STAGES.values():
        for axis in stage.axes:
            length, mass, force = ("mrad", "kg m²", "N m") if axis.rotation else ("mm", "kg", "N")
            stop, place = (axis.stop, "") if axis.stop else (stage.motor_stop, ", at the motors")
            ends = "–" if axis.rotation or not stop else f"{1e3 * stop.lower:g} to {1e3 * stop.upper:g} mm{place}"
            friction = axis.friction
            rows.append((short(stage), f"`{axis.name}`", axis.meaning, f"{axis.mass:g} {mass}",
                         f"{1e3 * axis.start:g} {length}", ends,
                         f"{friction.coulomb:g} {force}", f"{1e3 * friction.presliding:g} {length}",
                         f"{friction.viscous:g} {force} s" + ("" if axis.rotation else "/m")))
    return markdown_table(("stage", "axis", "meaning", "mass, inertia", "start", "end stops", "Coulomb friction",
                           "presliding", "viscous friction"), rows)


def motors_table() -> str:
    rows = []
    for stage in PACKAGED_STAGES.values():
        for motor in stage.motors:
            amplifier, winding = motor.amplifier, motor.winding
            place = f"x = {1e3 * motor.x:g}, z = {1e3 * motor.z:g} mm" if stage.rotations else ""
            rows.append((short(stage), f"`{motor.name}`", f"{stage.sharing:g}", f"`{motor.drives}`", place,
                         f"{amplifier.peak:g} A", f"{amplifier.continuous:g} A", f"{1e3 * amplifier.lag:g} ms",
                         f"{winding.resistance:g} Ω", f"{1e3 * winding.inductance:g} mH"))
    return markdown_table(("stage", "motor", "motors in it", "drives", "place", "peak current", "continuous current",
                           "lag", "resistance", "inductance"), rows)


def constants_table() -> str:
    rows = [(short(stage), f"`{each.name}`", each.meaning, f"{each.plant:g}", f"{each.model:g}", each.unit)
            for stage in PACKAGED_STAGES.values() for each in stage.constants]
    return markdown_table(("stage", "constant", "meaning", "plant", "controllers' model", "unit"), rows)


def limits_table() -> str:
    rows = []
    for stage in PACKAGED_STAGES.values():
        design = stage.design
        rows.append((short(stage), f"{1e3 * stage.sample_time:g} ms", f"{1e3 * stage.longest_step:g} ms",
                     f"{1e6 * stage.resolution:g} µm", f"{design.current_limit:g} A",
                     f"{design.pid_current_limit:g} A" if design.pid_current_limit else "no limit",
                     YES_NO[str(design.antiwindup).lower()], f"{1e3 * design.observer_time:g} ms"))
    return markdown_table(("stage", "sample time", "longest integration step", "encoder resolution",
                           "limit of the regulators", "limit of the PID", "anti-windup", "velocity observer"), rows)


def flags_of(model: FmuDefinition) -> dict[tuple[str, str], dict[str, str]]:
    """Values of each flag, by its interface and its name in FMI 3.0, then by the kinds of FMU that have it."""
    texts = {"native FMI 2.0": model_description(model, "", "", 0, ("all.c",)),
             "FMI 3.0": model_description_3(model, "", "", 0),
             "Python": model_description(model, "", "", 0)}
    found: dict[tuple[str, str], dict[str, str]] = {}
    for kind, text in texts.items():
        for interface in ElementTree.fromstring(text):
            for name, value in interface.attrib.items() if interface.tag in INTERFACES else ():
                if name not in ("modelIdentifier", "fixedInternalStepSize"):   # the one is a name, the other a time
                    row = INTERFACES[interface.tag], f"`{IN_FMI_3.get(name, name)}`"
                    found.setdefault(row, {})[kind] = YES_NO.get(value, value)
    return found


def flag_cell(values: dict[str, str]) -> str:
    """Value of a flag; with the kinds of FMU that have it, where they differ or FMI 3.0 alone knows it."""
    if len({*values.values()}) == 1 and list(values) != ["FMI 3.0"]:
        return next(iter(values.values()))
    if values.get("native FMI 2.0") == values.get("FMI 3.0", values.get("native FMI 2.0")) and "Python" in values:
        return f"{values['native FMI 2.0']}; Python: {values['Python']}"
    return ", ".join(f"{kind}: {value}" for kind, value in values.items())


def flags_table() -> str:
    """Flags that a group's FMUs agree in, one row a flag; ValueError if they do not agree."""
    columns: dict[str, dict[tuple[str, str], dict[str, str]]] = {}
    for name in DEFINITIONS:
        group = next(group for group, beginnings in GROUPS.items() if name.startswith(beginnings))
        flags = flags_of(definition(name))
        if columns.setdefault(group, flags) != flags:
            raise ValueError(f"{name}: its capability flags differ from those of the other {group}")
    names = sorted({name for flags in columns.values() for name in flags})
    rows = [(*name, *(flag_cell(flags[name]) if name in flags else "–" for flags in map(columns.__getitem__, GROUPS)))
            for name in names]
    return markdown_table(("interface", "flag", *GROUPS), rows)


class Key(NamedTuple):
    """One key: its name, its type, its default, and its meaning."""

    name: str
    kind: str
    without: str
    meaning: str


# What puts files and variants together, before there is one table.
OF_FILES = (
    Key("extends", "text, or list of text", "", "base files in this order, which this file overrides: next to it, "
        "or of the package, such as loops/3dof.toml"),
    Key("variants", "tables by name", "", "runs `NAME-VARIANT`, whose tables override the scenario"))


def keys_of(table: type[Table]) -> Iterator[Key]:
    """Keys of a table; of a kind of signal without those that all signals have."""
    shared: set[str] = set()
    if issubclass(table, SignalTable) and table is not SignalTable:
        shared = set(SignalTable.model_fields)
    if table is ProcedureClaim:
        shared = {name for name in Claim.model_fields if name != "quantity"}
    if table is run_plan.RunPlan:
        yield from OF_FILES
    for name, field in table.model_fields.items():
        key = field.alias or name
        if field.description and name not in shared:
            named = f": {', '.join(f'`{name}`' for name in NAMES[table, key])}" if (table, key) in NAMES else ""
            yield Key(key, kind_words(field.annotation, field.metadata), without_key(key, field),
                      field.description + named)


def kind_words(annotation: Any, metadata: Iterable[object] = ()) -> str:
    """Words for the values of a type, those of a `ValueKind` among its metadata first."""
    for item in metadata:
        if isinstance(item, ValueKind):
            return item.words
    arguments = get_args(annotation)
    origin = get_origin(annotation)
    if origin is Annotated:
        return kind_words(arguments[0], arguments[1:])
    if origin in (Union, UnionType):
        return ", or ".join(dict.fromkeys(kind_words(argument) for argument in arguments if argument is not NoneType))
    if origin is Literal:
        return " or ".join(f'"{argument}"' for argument in arguments)
    if origin is list:
        of = kind_words(arguments[0])
        return "tables" if "table" in of else f"list of {'pairs' if get_origin(arguments[0]) is tuple else plural(of)}"
    if origin is tuple:
        return f"two {plural(kind_words(arguments[0]))}"
    if origin is dict:
        of = kind_words(arguments[1])
        return "tables by name" if of == "table" else f"{plural(of)} by name"
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return "table"
    return WORDS[annotation]


def plural(text: str) -> str:
    return {"quantity": "quantities"}.get(text, text if text.startswith(("text", "list")) else f"{text}s")


def without_key(key: str, field: FieldInfo) -> str:
    """Return the default of a key; empty text without a default."""
    if key == "output_interval":
        return "`step`"
    if field.is_required():
        return "required"
    default = field.get_default()
    if isinstance(default, run_plan.StartValue):
        default = default.value
    if default in (None, PydanticUndefined, "") or isinstance(default, (list, dict, Table)):
        return ""
    if isinstance(default, bool):
        return str(default).lower()
    unit = next((item.unit for item in field.metadata if isinstance(item, ValueKind)), "")
    return f"{default:g} {unit}".rstrip() if isinstance(default, float) else str(default)


def keys_markdown() -> str:
    return "\n".join(map(table_markdown, TABLES))


def table_markdown(table: type[Table]) -> str:
    place = table.PLACE if "[" not in table.PLACE else f"`{table.PLACE}`"
    rows = [("", "", "", "keys of `[[claims]]`, and:")] if table is ProcedureClaim else []
    rows += [(f"`{key.name}`", key.kind, key.without, key.meaning) for key in keys_of(table)]
    return f"**{place}**\n\n{markdown_table(('key', 'value', 'default', 'meaning'), rows)}"


def units_markdown() -> str:
    """Return the units by dimension."""
    prefixed = sorted({si for si, _ in UNITS.values() if f"k{si}" in UNITS and f"n{si}" in UNITS})
    return (markdown_table(("", ""), MEASURED.items())
            + f"\n{', '.join(prefixed)} also with {', '.join(PREFIXES)} before them.\n")


PARTS: dict[str, dict[str, Callable[[], str]]] = {
    "stages.md": {"axes": axes_table, "motors": motors_table, "constants": constants_table, "limits": limits_table},
    "fmi.md": {"flags": flags_table},
    "scenario_keys.md": {"units": units_markdown, "keys": keys_markdown}}


if __name__ == "__main__":
    for name, parts in PARTS.items():
        for part, made in parts.items():
            write_part(DOCS / name, part, made())
