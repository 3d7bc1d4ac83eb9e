"""The state of a user's object as JSON, and back: nothing of it is executed, as pickled data would be.

An object that is held twice is one object again, and objects may hold each other in a circle. Objects are of classes
in the folder of the user's file; they are made without a call of the class.
"""

import sys
from base64 import b64decode, b64encode
from collections import deque
from enum import Enum
from pathlib import Path
from random import Random
from typing import Any

EXPECTED = ("numbers, texts, bytes, lists, tuples, dicts, sets, deques, arrays of numbers, and objects of your own "
            "classes without __slots__")
NUMBERS = "biufc"   # kinds of NumPy's arrays and numbers


class NotPlain(ValueError):
    """A value that has no plain form, or a plain form that no value has."""


def numpy_kind(value: Any, name: str) -> bool:
    """Return True if a value is NumPy's `ndarray` or `generic`, of numbers; NumPy is not imported for it."""
    numpy = sys.modules.get("numpy")
    return numpy is not None and isinstance(value, getattr(numpy, name)) and value.dtype.kind in NUMBERS


class Writer:
    """Turns values into JSON; `objects` are those that are referred to by their number."""

    def __init__(self) -> None:
        self.objects: list[Any] = []
        self.numbers: dict[int, int] = {}
        self.alive: list[Any] = []   # so that no id is used twice

    def plain(self, value: Any, name: str) -> Any:
        """Return the plain form of a value; NotPlain, with its name, if it has none."""
        kind = type(value)
        if value is None or kind in (bool, int, float, str):
            return value
        if kind in (tuple, frozenset):
            return {kind.__name__: [self.plain(entry, name) for entry in value]}
        if kind is complex:
            return {"complex": [value.real, value.imag]}
        if kind is bytes:
            return {"bytes": b64encode(value).decode("ascii")}
        if isinstance(value, Enum):
            return {"enum": [kind.__module__, kind.__qualname__, value.name]}
        if numpy_kind(value, "generic"):
            return {"number": [value.dtype.str, b64encode(value.tobytes()).decode("ascii")]}
        if id(value) not in self.numbers:
            self.numbers[id(value)] = len(self.objects)
            self.alive.append(value)
            self.objects.append(None)
            self.objects[self.numbers[id(value)]] = self.content(value, name)
        return {"object": self.numbers[id(value)]}

    def content(self, value: Any, name: str) -> list[Any]:
        kind = type(value)
        if kind in (list, set):
            return [kind.__name__, [self.plain(entry, name) for entry in value]]
        if kind is deque:
            return ["deque", [self.plain(entry, name) for entry in value], value.maxlen]
        if kind is dict:
            return ["dict", [[self.plain(key, name), self.plain(entry, f"{name}[{key!r}]")]
                             for key, entry in value.items()]]
        if kind is Random:
            return ["random", self.plain(value.getstate(), name)]
        if numpy_kind(value, "ndarray"):
            return ["array", value.dtype.str, list(value.shape), b64encode(value.tobytes()).decode("ascii")]
        plainly_made = all(getattr(kind, name) is getattr(object, name) for name in ("__reduce_ex__", "__new__"))
        slots = any(vars(base).get("__slots__") for base in kind.__mro__)
        if plainly_made and not slots and hasattr(value, "__dict__"):
            return ["own", kind.__module__, kind.__qualname__,
                    [[key, self.plain(entry, f"{name}.{key}")] for key, entry in vars(value).items()]]
        raise NotPlain(f"{name} is a {kind.__name__}, which no serialized state holds; expected {EXPECTED}")


def written_state(values: tuple[Any, ...], name: str) -> dict[str, Any]:
    """Return values as JSON has them; NotPlain, with the owner's name, if a value has no plain form."""
    writer = Writer()
    return {"value": {"tuple": [writer.plain(entry, name) for entry in values]}, "objects": writer.objects}


class Reader:
    """Makes values of JSON; classes are looked up among those of the modules in a folder."""

    def __init__(self, objects: list[Any], folder: Path | None):
        self.folder = folder
        self.contents = objects
        self.made: list[Any] = [self.empty(*content) for content in objects]

    def own_class(self, module: str, name: str) -> Any:
        found: Any = sys.modules.get(module)
        file = getattr(found, "__file__", None)
        if self.folder is None or file is None or self.folder not in Path(file).parents:
            raise NotPlain(f"class {name} of {module}")
        for part in name.split("."):
            found = vars(found)[part]
        if not isinstance(found, type) or found.__module__ != module:
            raise NotPlain(f"class {name} of {module}")
        return found

    def empty(self, kind: str, *content: Any) -> Any:
        """Return an object without any attributes yet."""
        if kind in ("list", "set", "dict", "random"):
            return {"list": list, "set": set, "dict": dict, "random": Random}[kind]()
        if kind == "deque":
            return deque(maxlen=content[1])
        if kind == "array":
            return self.numbers(content[0], content[2]).reshape(content[1]).copy()
        if kind == "own":
            return object.__new__(self.own_class(content[0], content[1]))
        raise NotPlain(kind)

    def numbers(self, item: str, data: str) -> Any:
        numpy = sys.modules["numpy"]
        if len(item) < 3 or item[1] not in NUMBERS or not item[2:].isdigit():
            raise NotPlain(item)
        return numpy.frombuffer(b64decode(data), item)

    def fill(self) -> None:
        """Fill in the contents of the objects; sets last, because their elements have to be complete."""
        for made, (kind, *content) in sorted(zip(self.made, self.contents, strict=True),
                                             key=lambda pair: bool(pair[1][0] == "set")):
            if kind in ("list", "deque"):
                made.extend(map(self.value, content[0]))
            elif kind == "set":
                made.update(map(self.value, content[0]))
            elif kind == "dict":
                made.update((self.value(key), self.value(entry)) for key, entry in content[0])
            elif kind == "random":
                made.setstate(self.value(content[0]))
            elif kind == "own":
                vars(made).update((str(key), self.value(entry)) for key, entry in content[2])

    def value(self, plain: Any) -> Any:
        if not isinstance(plain, dict):
            if isinstance(plain, list):
                raise NotPlain("a list without a number")
            return plain
        (kind, what), = plain.items()
        if kind == "object":
            return self.made[what]
        if kind in ("tuple", "frozenset"):
            return (tuple if kind == "tuple" else frozenset)(map(self.value, what))
        if kind == "complex":
            return complex(*what)
        if kind == "bytes":
            return b64decode(what)
        if kind == "number":
            return self.numbers(*what)[0]
        if kind == "enum" and issubclass(found := self.own_class(*what[:2]), Enum):
            return found[what[2]]
        raise NotPlain(kind)


def read_state(state: Any, folder: Path | None) -> Any:
    """Return the values that `written_state` has written, with objects of classes in a folder; NotPlain for others."""
    try:
        reader = Reader(state["objects"], folder)
        reader.fill()
        return reader.value(state["value"])
    except Exception as error:   # the text is not trusted, and may raise anything
        raise NotPlain(f"{type(error).__name__}: {error}") from error
