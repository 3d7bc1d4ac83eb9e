"""Values as lines of JSON, and back: messages of processes that run third-party code are read without trust.

Nothing in such a line is executed, as pickled data would be. It holds numbers, texts, bytes, paths, arrays of numbers,
tuples, lists, dicts, errors, and this project's named tuples, frozen dataclasses and parts of the motor. Each field of
these must have the type that its class declares.
"""

import json
import re
import sys
from base64 import b64decode, b64encode
from collections.abc import Callable, Mapping
from dataclasses import is_dataclass
from functools import cache
from inspect import isfunction
from pathlib import Path
from types import UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np

from maglev.files.errors import MaglevError

OWN = ("maglev", "pmlsm")   # packages whose named tuples and dataclasses are made again
PARTS = "pmlsm"             # package whose other classes are, too: they hold numbers, and one another
NUMBERS = "biufc"           # kinds of arrays
LARGEST = 2**63             # of the whole numbers in fields, which are counts
NUMBER = re.compile(rf"[<>|][{NUMBERS}]\d{{1,2}}")   # type of an array of numbers, as it states it


def line_of(value: Any) -> bytes:
    """Return a value as one line, with its end; TypeError if JSON has no form of it."""
    return json.dumps(as_json(value)).encode("ascii") + b"\n"


def value_of(line: bytes) -> Any:
    """Return the value of a line; ValueError if it is not one that `line_of` writes."""
    try:
        return unpacked(json.loads(line))
    except Exception as error:   # the values are not trusted, and may raise anything
        raise ValueError(f"{error}") from error


def as_json(value: Any) -> Any:
    """Return a value as JSON types."""
    if value is None or isinstance(value, bool | int | float | str):
        return value
    if isinstance(value, tuple) and not hasattr(value, "_fields"):
        return [as_json(entry) for entry in value]
    for name, (own_kind, parts_of, _) in PLAIN.items():
        if isinstance(value, own_kind):
            return {name: parts_of(value)}
    if isinstance(value, np.ndarray) and value.dtype.kind in NUMBERS:
        return {"array": [value.dtype.str, list(value.shape), as_json(value.tobytes())]}
    if isinstance(value, BaseException):
        return {"error": packed_error(value)}
    kind = type(value)
    if not is_own(kind):
        raise TypeError(f"a {kind.__name__} cannot be sent to another process")
    held = {name: getattr(value, name) for name in kind._fields} if isinstance(value, tuple) else vars(value)
    return {"own": [kind.__module__, kind.__name__, {name: as_json(entry) for name, entry in held.items()}]}


def unpacked(message: Any) -> Any:
    """Return the value of JSON types."""
    if isinstance(message, list):
        return tuple(unpacked(entry) for entry in message)
    if not isinstance(message, dict):
        return message
    (kind, what), = message.items()
    if kind in PLAIN:
        return PLAIN[kind][2](what)
    if kind == "array":
        item, shape, data = what
        if not NUMBER.fullmatch(item):
            raise ValueError(f"an array of {item}")
        return np.frombuffer(unpacked(data), item).reshape(shape).copy()
    if kind == "error":
        return unpacked_error(*what)
    module, name, held = what
    own = getattr(sys.modules[module], name)
    if kind != "own" or own.__module__ != module or not is_own(own):
        raise ValueError(f"{kind} {module}.{name}")
    values = {name: unpacked(entry) for name, entry in held.items()}
    if not own.__module__.startswith(f"{PARTS}.") or is_dataclass(own):
        for name, value in values.items():
            if not fits(value, hints(own)[name]):
                raise ValueError(f"{own.__name__}.{name} = {value!r}")
        return own(**values)
    part = object.__new__(own)
    vars(part).update(values)
    return part


# Classes with the functions from an object to JSON and back.
PLAIN: dict[str, tuple[type, Callable[[Any], Any], Callable[[Any], Any]]] = {
    "list": (list, lambda value: [as_json(entry) for entry in value], lambda what: [unpacked(entry) for entry in what]),
    "dict": (dict, lambda value: [[as_json(key), as_json(entry)] for key, entry in value.items()],
             lambda what: {unpacked(key): unpacked(entry) for key, entry in what}),
    "complex": (complex, lambda value: [value.real, value.imag], lambda what: complex(*what)),
    "bytes": (bytes, lambda value: b64encode(value).decode("ascii"), b64decode), "path": (Path, str, Path)}


def is_own(kind: Any) -> bool:
    """Return True if a class belongs to this project and its objects can be made again."""
    if not isinstance(kind, type) or kind.__module__.partition(".")[0] not in OWN:
        return False
    if is_dataclass(kind):
        return bool(kind.__dataclass_params__.frozen)   # type: ignore[attr-defined]   # typeshed hides it
    return hasattr(kind, "_fields") or kind.__module__.startswith(f"{PARTS}.")


@cache
def hints(kind: Any) -> dict[str, Any]:
    """Return the declared type of each field of a class, or of each argument and result of a function."""
    return get_type_hints(kind)


def fits(value: Any, hint: Any) -> bool:
    """Return True if a value has a declared type, as have the values in it.

    pydantic would need the types of all fields of all classes in them, which NumPy's are not made for.
    """
    origin, arguments = get_origin(hint) or hint, get_args(hint)
    if origin is Any:
        return True
    if origin in (Union, UnionType):
        return any(fits(value, argument) for argument in arguments)
    if origin is Literal:
        return any(type(value) is type(argument) and value == argument for argument in arguments)
    if isinstance(value, int) and origin in (int, float):
        return not isinstance(value, bool) and abs(value) < LARGEST
    if origin is None or not isinstance(value, origin):
        return value is None and origin in (None, type(None))
    if not arguments or origin is np.ndarray:
        return True
    if issubclass(origin, Mapping):
        return all(fits(key, arguments[0]) and fits(entry, arguments[1]) for key, entry in value.items())
    if origin is tuple and arguments[1:] != (...,):
        return len(value) == len(arguments) and all(map(fits, value, arguments))
    return not isinstance(value, str | bytes) and all(fits(entry, arguments[0]) for entry in value)


def packed_error(error: BaseException) -> Any:
    """Return an error as data: the class of this project's errors, the number of the system's, or the text."""
    notes = list(getattr(error, "__notes__", ()))
    if isinstance(error, OSError):
        return [None, [error.errno, error.strerror or str(error), error.filename and str(error.filename)], notes]
    own = next((kind.__name__ for kind in type(error).__mro__ if plain_error(kind)), None)
    return [own, [str(error)], notes]


def unpacked_error(own: str | None, arguments: list[Any], notes: list[str]) -> Exception:
    kind: Any = OSError if len(arguments) == 3 else RuntimeError
    if own is not None:
        kind = getattr(sys.modules[MaglevError.__module__], own)
        if not plain_error(kind):
            raise ValueError(f"an error {own}")
    error: Exception = kind(*arguments)
    for note in notes:
        error.add_note(note)
    return error


def plain_error(kind: Any) -> bool:
    """Return True for a class of `maglev.files.errors` whose errors are made of a message alone."""
    return (isinstance(kind, type) and issubclass(kind, MaglevError) and kind.__module__ == MaglevError.__module__
            and not isfunction(kind.__init__))
