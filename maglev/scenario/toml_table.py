"""Tables of a scenario file: unknown keys, and one-line errors."""

import re
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Annotated, Any, ClassVar, NamedTuple, Self, get_args

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, model_validator
from pydantic_core import PydanticCustomError

from maglev.files.errors import ScenarioError, key_path, nearest, shortened, similar
from maglev.files.units import parse_quantity
from maglev.scenario.layers import Layer, child, merged


class ValueKind(NamedTuple):
    """The kind of a value in words, for the table of the keys, and the SI unit of its default."""

    words: str
    unit: str = ""


Seconds = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "s")), ValueKind("time", "s")]
Metres = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "m")), ValueKind("length", "m")]
Radians = Annotated[float, BeforeValidator(lambda value: parse_quantity(value, "rad")), ValueKind("angle", "rad")]


def key_refused(key: str | int, value: object, expectation: str, *above: str | int) -> PydanticCustomError:
    """Return the refusal of `value` of a key, with the keys that lead to it from the table that refuses."""
    return PydanticCustomError("key_refused", "{expectation}",
                               {"keys": (*above, key), "value": value, "expectation": expectation})


class Table(BaseModel):
    """A table of the file: immutable, and it names the nearest valid key when it meets an unknown one.

    The description of each field is its meaning, in messages and in the documentation. A field without one is no key.
    """

    model_config = ConfigDict(extra="forbid", frozen=True, defer_build=True)

    PLACE: ClassVar[str] = ""             # of the table in a file, such as "[metrics]"

    @classmethod
    def known_tables(cls) -> list[type["Table"]]:
        """Return the tables that there are, so that a key in the wrong one is found."""
        return [table for kind in cls.__subclasses__() for table in (kind, *kind.known_tables())]

    @classmethod
    def keys_of_table(cls) -> dict[str, str]:
        return {field.alias or name: field.description for name, field in cls.model_fields.items() if field.description}

    @model_validator(mode="before")
    @classmethod
    def refuse_unknown_keys(cls, table: Any) -> Any:
        if isinstance(table, Mapping):
            valid = [field.alias or name for name, field in cls.model_fields.items()]
            for key, value in table.items():
                if key not in valid:
                    raise key_refused(key, value, unknown_key(str(key), cls, valid))
        return table

    @classmethod
    def of_file(cls, table: Mapping[str, Any], layers: list[Layer]) -> Self:
        """Return the model of the layers of files; ScenarioError with the first refusal in one line."""
        try:
            return cls.model_validate(table)
        except ValidationError as error:
            raise ScenarioError(one_line(error, layers, cls)) from None


# How pydantic counts.
COUNTED = re.compile(r"^(?:List|Tuple|Dictionary) should have (at (?:least|most)) (\d+) items? after validation, .*")


def unknown_key(key: str, table: type[Table], valid: Sequence[str]) -> str:
    """Return the expected keys for one that a table does not have: keys like it, or the table that it belongs to."""
    meanings = table.keys_of_table()
    valid = [*meanings] or valid   # what has no description is not for users
    near = get_close_matches(key, valid, n=2, cutoff=0.6)
    places = dict.fromkeys(other.PLACE for other in Table.known_tables()
                           if other.PLACE and key in other.keys_of_table())
    if table.PLACE and places and not near:
        return f"unknown key, expected it in {' or '.join(places)}"
    near_keys = ", or ".join(f"{key!r} ({meanings[key]})" if key in meanings else repr(key) for key in near)
    return f"unknown key, {f'nearest is {near_keys}' if near_keys else nearest(key, valid)}"


def meaning_at(model: type[Table], location: Sequence[str | int]) -> str:
    """Return the meaning of the key at a place of a table; empty text if it has none by itself."""
    models, meaning = [model], ""
    for key in location:
        fields = [field for model in models for name, field in model.model_fields.items() if key in (name, field.alias)]
        if fields:
            models, meaning = [model for field in fields for model in tables_in(field.annotation)], ""
            meaning = fields[0].description or ""
    return meaning


def tables_in(annotation: Any) -> list[type[Table]]:
    if isinstance(annotation, type) and issubclass(annotation, Table):
        return [annotation]
    return [model for part in get_args(annotation) for model in tables_in(part)]


def one_line(error: ValidationError, layers: list[Layer], model: type[Table] = Table) -> str:
    """Return the first refusal in one line: file, key, value, expectation."""
    first = error.errors()[0]
    context = first.get("ctx", {})
    keys = keys_in(merged(layers), first["loc"])
    value = first["input"]
    meaning = meaning_at(model, first["loc"])
    if first["type"] == "missing":
        return f"{layers[-1].place}: {key_path(keys)}: required key is missing" + (f": {meaning}" if meaning else "")
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
        expectation = COUNTED.sub(r"expected \1 \2 entries", first["msg"].replace("Input should be", "expected"))
        expectation = expectation.replace("String should", "expected it to")
        if meaning and isinstance(first["loc"][-1], str):
            expectation += f" ({meaning})"
    valid = context.get("expected_tags", context.get("expected"))
    if isinstance(valid, str):
        valid_names = re.findall(r"'([^']*)'", valid)
        expectation += similar(value, valid_names)
    given = "" if value is None else f" = {shortened(value)}"
    return f"{place_of(keys, layers)}: {key_path(keys)}{given}: {expectation}"


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


def place_of(keys: list[str | int], layers: list[Layer]) -> object:
    for layer in layers[::-1]:
        entry: Any = layer.table
        for key in keys:
            entry = child(entry, key)
        if entry is not None:
            return layer.place
    return layers[-1].place
