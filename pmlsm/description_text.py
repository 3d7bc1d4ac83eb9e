"""A description as text, in which an FMU carries it: JSON, every number in SI and exact."""

import json
from dataclasses import MISSING, fields, is_dataclass
from types import NoneType, UnionType
from typing import Any, Union, cast, get_args, get_origin, get_type_hints

from pmlsm.stage_description import StageDescription


def to_text(stage: StageDescription) -> str:
    """Return the text of a description, without values that equal their defaults."""
    return json.dumps(as_data(stage), indent=1)


def from_text(text: str) -> StageDescription:
    """Description of a text that `to_text` has made."""
    return cast(StageDescription, of_data(StageDescription, json.loads(text)))


def as_data(value: Any) -> Any:
    """A value of a description as dicts, lists, texts, numbers and Booleans."""
    if is_dataclass(value) and not isinstance(value, type):
        parts = {member.name: getattr(value, member.name) for member in fields(value)}
        return {member.name: as_data(parts[member.name]) for member in fields(value)
                if repr(parts[member.name]) != repr(   # -0.0 is no 0.0
                    member.default if member.default_factory is MISSING else member.default_factory())}
    if isinstance(value, tuple):
        return [as_data(part) for part in value]
    return {name: as_data(part) for name, part in value.items()} if isinstance(value, dict) else value


def of_data(kind: Any, data: Any) -> Any:
    """Return the value of a description's type from the data that `as_data` returned for it."""
    if get_origin(kind) in (Union, UnionType):
        kind = next(each for each in get_args(kind) if each is not NoneType)
    if is_dataclass(kind):
        hints = get_type_hints(kind)
        return kind(**{name: of_data(hints[name], part) for name, part in data.items()})   # type: ignore[operator]
    if get_origin(kind) is tuple:
        return tuple(of_data(get_args(kind)[0], part) for part in data)
    return data
