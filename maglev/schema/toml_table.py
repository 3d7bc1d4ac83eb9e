"""Tables of a scenario file: unknown keys, one-line errors, and files that extend others."""

import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from maglev.errors import ScenarioError, key_path, nearest, shortened
from maglev.units import parse_quantity

# The experiments are a folder beside the package in the repository, and in it where it is installed.
HERE = Path(__file__).parents[1]
PACKAGED = next(folder for folder in (HERE / "scenarios", HERE.parent / "scenarios") if folder.is_dir())
RIGS = ("2dof", "3dof")   # folders with the experiments themselves

Seconds = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "s"))]
Metres = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "m"))]


def key_refused(key: str | int, value: object, expectation: str, *above: str | int) -> PydanticCustomError:
    """Return the refusal of `value` of a key, with the keys that lead to it from the table that refuses."""
    return PydanticCustomError("key_refused", "{expectation}",
                               {"keys": (*above, key), "value": value, "expectation": expectation})


class Table(BaseModel):
    """A table of the file: immutable, and it names the nearest valid key when it meets an unknown one."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    @model_validator(mode="before")
    @classmethod
    def refuse_unknown_keys(cls, table: Any) -> Any:
        """Refuse a key that the table does not have."""
        if isinstance(table, Mapping):
            valid = [field.alias or name for name, field in cls.model_fields.items()]
            for key, value in table.items():
                if key not in valid:
                    expectation = f"unknown key, nearest valid key is {nearest(key, valid)}"
                    raise key_refused(key, value, expectation)
        return table


class Layer(NamedTuple):
    """One TOML file and what it says."""

    path: Path
    table: dict[str, Any]


def read_layers(path: Path, extending: tuple[Path, ...] = ()) -> list[Layer]:
    """Read a file and those it extends, the file itself last.

    Raises
    ------
    ScenarioError
        If a file is missing, is not TOML, or extends itself.
    """
    if path in extending:
        raise ScenarioError(f"{extending[0]}: extends = {str(path)!r}: a file cannot extend itself")
    return extended(Layer(path, read_toml(path)), extending)


def extended(layer: Layer, extending: tuple[Path, ...] = ()) -> list[Layer]:
    """Layers of the files that a table extends, in their order, and the table itself last."""
    path, table = layer
    bases = table.pop("extends", [])
    bases = [bases] if isinstance(bases, str) else bases
    if not isinstance(bases, list) or not all(isinstance(base, str) for base in bases):
        raise ScenarioError(f"{path}: extends = {bases!r}: expected the relative path of a scenario file, or a list")
    layers = [below for base in bases for below in read_layers(found_base(path, base), (*extending, path))]
    return [*layers, layer]


def found_base(path: Path, base: str) -> Path:
    """File that a file extends: beside it, or else among those of the package, such as "loops/3dof.toml"."""
    beside = (path.parent / base).resolve()
    packaged = [folder / base for folder in (PACKAGED, *(PACKAGED / rig for rig in RIGS))]
    return next((file.resolve() for file in (beside, *packaged) if file.is_file()), beside)


def merged(layers: list[Layer]) -> dict[str, Any]:
    """Merge layers, later ones over earlier ones."""
    table: dict[str, Any] = {}
    for layer in layers:
        table = merge(table, layer.table)
    return table


def read_toml(path: Path) -> dict[str, Any]:
    """Read one TOML file; its relative file names are made absolute."""
    try:
        table = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise ScenarioError(f"{path}: cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise ScenarioError(f"{path}: cannot be read: expected UTF-8 text") from None
    except tomllib.TOMLDecodeError as error:
        raise ScenarioError(f"{path}: TOML syntax: {error}") from None
    variants = table.get("variants")
    for part in (table, *(variants.values() if isinstance(variants, dict) else [])):
        if isinstance(part, dict):
            place_files(part, path.parent)
    return table


def place_files(table: dict[str, Any], folder: Path) -> None:
    """Make the file names in a table absolute: they lie beside their file, not beside one that extends it."""
    fmus = table.get("fmus")
    signals = table.get("signals")
    entries = [*(fmus.values() if isinstance(fmus, dict) else []), *(signals if isinstance(signals, list) else [])]
    for entry in entries:
        if isinstance(entry, dict) and isinstance(entry.get("file"), str):
            entry["file"] = str(folder / entry["file"])


def merge(base: Mapping[str, Any], over: Mapping[str, Any]) -> dict[str, Any]:
    """Merge two tables deeply: `over` wins, lists are replaced, new keys go to the end."""
    merged = dict(base)
    for key, value in over.items():
        if isinstance(value, Mapping) and isinstance(merged.get(key), Mapping):
            merged[key] = merge(merged[key], value)
        else:
            merged[key] = value
    return merged


def one_line(error: ValidationError, layers: list[Layer]) -> str:
    """Say the first refusal in one line: file, key, value, expectation."""
    first = error.errors()[0]
    context = first.get("ctx", {})
    keys = keys_in(merged(layers), first["loc"])
    value = first["input"]
    if first["type"] == "missing":
        return f"{layers[-1].path}: {key_path(keys)}: required key is missing"
    if first["type"] == "key_refused":
        keys += list(context["keys"])
        value = context["value"]
        expectation = context["expectation"]
    elif first["type"] in ("union_tag_invalid", "union_tag_not_found"):
        keys.append("kind")
        value = context.get("tag", "nothing")
        expectation = "expected the kind of a signal"
    elif first["type"] == "value_error":
        expectation = str(context["error"])
    else:
        expectation = first["msg"].replace("Input should be", "expected")
    valid = context.get("expected_tags", context.get("expected"))
    if isinstance(valid, str):
        valid_names = re.findall(r"'([^']*)'", valid)
        expectation += f", nearest is {nearest(str(value), valid_names)}"
    given = "" if value is None else f" = {shortened(value)}"
    return f"{file_of(keys, layers)}: {key_path(keys)}{given}: {expectation}"


def keys_in(table: Any, location: tuple[str | int, ...]) -> list[str | int]:
    """Return the keys of a pydantic location, without the names of the models that it mentions."""
    keys: list[str | int] = []
    for position, key in enumerate(location):
        last = position == len(location) - 1
        if isinstance(table, Mapping) and key not in table and (not last or key == table.get("kind")):
            continue
        keys.append(key)
        table = child(table, key)
    return keys


def child(table: Any, key: str | int) -> Any:
    """Return the entry of a table or list, None where there is none."""
    if isinstance(table, Mapping):
        return table.get(key)
    if isinstance(table, list) and isinstance(key, int) and key < len(table):
        return table[key]
    return None


def file_of(keys: list[str | int], layers: list[Layer]) -> Path:
    """Return the last file that has the key."""
    for layer in layers[::-1]:
        entry: Any = layer.table
        for key in keys:
            entry = child(entry, key)
        if entry is not None:
            return layer.path
    return layers[-1].path
