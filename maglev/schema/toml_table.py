"""Tables of a scenario file: unknown keys, and one-line errors."""

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from maglev.errors import ScenarioError, key_path, nearest, shortened
from maglev.schema.layers import Layer, child, merged
from maglev.units import parse_quantity

Seconds = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "s"))]
Metres = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "m"))]
Radians = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "rad"))]


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

    @classmethod
    def of_file(cls, table: Mapping[str, Any], layers: list[Layer]) -> Self:
        """The model of what layers of files make; ScenarioError with the first refusal in one line."""
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise ScenarioError(one_line(error, layers)) from None


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


def file_of(keys: list[str | int], layers: list[Layer]) -> Path:
    """Return the last file that has the key."""
    for layer in layers[::-1]:
        entry: Any = layer.table
        for key in keys:
            entry = child(entry, key)
        if entry is not None:
            return layer.path
    return layers[-1].path
