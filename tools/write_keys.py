"""Put the tables of all keys of a scenario file, and of units, into docs/scenario_keys.md, between their markers.

    python tools/write_keys.py
"""

from collections.abc import Callable, Iterable, Iterator
from pathlib import Path
from types import NoneType, UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from maglev.files.marked import with_part
from maglev.files.units import PREFIXES, UNITS
from maglev.scenario import run_plan
from maglev.scenario.claims import Claim, Elsewhere, ProcedureClaim, RunClaim
from maglev.scenario.procedure import ProcedureSettings
from maglev.scenario.quantities import METRICS, PROCEDURE_VALUES
from maglev.scenario.signals import Constant, Csv, SignalTable, Sinusoids, Steps, Term
from maglev.scenario.toml_table import Table, ValueKind

TABLES: tuple[type[Table], ...] = (
    run_plan.RunPlan, run_plan.FmuTable, run_plan.RunOutput, SignalTable, Constant, Steps, Sinusoids, Term, Csv,
    run_plan.Axis, run_plan.Motor, run_plan.MetricSettings, run_plan.Event, run_plan.CheckSettings,
    run_plan.SignalTolerance, RunClaim, ProcedureSettings, ProcedureClaim, Elsewhere)

# What keys name that stand for many things.
NAMES: dict[tuple[type[Table], str], Iterable[str]] = {
    (RunClaim, "metric"): METRICS, (ProcedureClaim, "value"): PROCEDURE_VALUES}

# Units by dimension; the letters before a symbol are PREFIXES.
MEASURED = {
    "length": "m, cm, mm, um, nm", "time": "s, ms, us, ns, min, h", "mass": "kg, g",
    "angle": "rad, mrad, urad, deg (°)", "current": "A", "voltage": "V", "resistance": "Ohm (ohm, Ω)",
    "inductance": "H", "capacitance": "F", "charge": "C",
    "magnetic flux": "Wb", "flux density": "T", "force": "N", "torque": "N.m, mN.m, Nm, mNm", "energy": "J, Wh",
    "power": "W", "pressure": "Pa, bar", "speed of rotation": "rad/s, rpm", "frequency": "Hz, kHz, MHz",
    "temperature": "K", "share": "1, %"}

WORDS: dict[Any, str] = {str: "text", float: "number", int: "whole number", bool: "true or false"}


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
            yield Key(key, key_kind(field), without_key(key, field), field.description + named)


def key_kind(field: FieldInfo) -> str:
    kind = next((item for item in field.metadata if isinstance(item, ValueKind)), None)
    return kind.words if kind is not None else kind_words(field.annotation)


def kind_words(annotation: Any) -> str:
    arguments = get_args(annotation)
    origin = get_origin(annotation)
    if origin is Annotated:
        kind = next((item for item in arguments[1:] if isinstance(item, ValueKind)), None)
        return kind.words if kind is not None else kind_words(arguments[0])
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
    return "\n".join(line for table in TABLES for line in table_lines(table)) + "\n"


def table_lines(table: type[Table]) -> Iterator[str]:
    place = table.PLACE if "[" not in table.PLACE else f"`{table.PLACE}`"
    yield from (f"**{place}**", "", "| key | value | default | meaning |", "|---|---|---|---|")
    if table is ProcedureClaim:
        yield "| | | | keys of `[[claims]]`, and: |"
    yield from (f"| `{key.name}` | {key.kind} | {key.without} | {key.meaning} |" for key in keys_of(table))
    yield ""


PAGE = Path(__file__).parents[1] / "docs" / "scenario_keys.md"
def units_markdown() -> str:
    """Return the units by dimension."""
    prefixed = sorted({si for si, _ in UNITS.values() if f"k{si}" in UNITS and f"n{si}" in UNITS})
    return "\n".join(["| | |", "|---|---|", *(f"| {measured} | {units} |" for measured, units in MEASURED.items()), "",
                      f"{', '.join(prefixed)} also with {', '.join(PREFIXES)} before them.", ""])


PARTS: dict[str, Callable[[], str]] = {"units": units_markdown, "keys": keys_markdown}


if __name__ == "__main__":
    for name, made in PARTS.items():
        PAGE.write_text(with_part(PAGE, name, made()), encoding="utf-8")
