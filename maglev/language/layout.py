"""Layout of a block: the types and values of the attributes that its constructor has set."""

from collections.abc import Callable, Iterator
from typing import Any

from maglev.language.program import BOOL, FLOAT, INT, List, Struct, Type, Untranslatable
from maglev.language.texts import place_of_attribute

LARGEST = 2**63   # whole numbers are below it


def scalar_type(value: Any) -> Type | None:
    """Type of a number or a Boolean, of NumPy's too; None of anything else."""
    kind = getattr(getattr(value, "dtype", None), "kind", "") if getattr(value, "shape", None) == () else ""
    if isinstance(value, bool) or kind == "b":
        return BOOL
    if isinstance(value, int) or kind in ("i", "u"):
        return INT
    return FLOAT if isinstance(value, float) or kind == "f" else None


def items_of(value: Any) -> list[Any] | None:
    """Elements of a list, a tuple or an array of NumPy; None of anything else."""
    if isinstance(value, list | tuple):
        return list(value)
    return value.tolist() if hasattr(value, "tolist") and getattr(value, "shape", ()) != () else None


class Layout:
    """The types of objects: a struct for every class, and for every set of attributes that its instances have.

    Values other than numbers, objects and lists, such as texts, have no type; a method that reads one is refused.
    """

    def __init__(self, block: Any, free_name: Callable[[str], str]):
        self.free_name = free_name
        self.fields: dict[str, dict[str, Type]] = {}
        self.classes: dict[str, type] = {}
        self.names: dict[tuple[Any, ...], str] = {}
        self.unlike: dict[tuple[type, str], str] = {}   # why an attribute of a class has no type
        self.places: dict[int, str] = {}
        self.kept: list[Any] = []     # whatever has a place, so that its id is not given again
        try:
            root = self.type_of(block, "self")
        except Untranslatable as error:
            raise Untranslatable(f"{place_of_attribute(type(block), str(error))}{error}") from None
        assert isinstance(root, Struct)
        self.root = root

    def type_of(self, value: Any, place: str) -> Type | None:
        """Type of a value at a place such as self.motors[0]; None if it has none."""
        if (scalar := scalar_type(value)) is not None:
            if scalar == INT and not -LARGEST <= value < LARGEST:
                raise Untranslatable(f"{place} = {value}: a whole number is below 2^63")
            return scalar
        items = items_of(value)
        if items is not None:
            self.own(value, place)
            kinds = [self.type_of(item, f"{place}[{k}]") for k, item in enumerate(items)]
            other = next((k for k, kind in enumerate(kinds) if kind is None or kind != kinds[0]), None)
            if other is not None:
                raise Unlike(f"{place}[{other}] is unlike {place}[0]: expected a list of numbers of one type, or of "
                             "objects of one class with attributes of the same types")
            return List(kinds[0] if kinds else None, len(items))
        if hasattr(value, "__dict__") and not callable(value) and not isinstance(value, type):
            return self.struct_of(value, place)
        return None

    def own(self, value: Any, place: str) -> None:
        """Raise for an object that stands in two places: in C it would be two."""
        if isinstance(value, tuple):
            return
        before = self.places.setdefault(id(value), place)
        if before != place:
            raise Untranslatable(f"{place} is the same object as {before}: expected one of its own, or a number that "
                                 "says which one is meant")
        self.kept.append(value)

    def struct_of(self, value: Any, place: str) -> Struct:
        self.own(value, place)
        fields: dict[str, Type] = {}
        for name, part in dict(vars(value)).items():
            try:
                kind = self.type_of(part, f"{place}.{name}")
            except Unlike as error:
                self.unlike[type(value), name] = str(error).replace(f"{place}.", "self.")   # as the class has it
                continue
            if kind is None:
                what = "None" if part is None else f"of {type(part).__name__}"
                self.unlike[type(value), name] = (f"self.{name} is {what}: expected a number, a Boolean, an object "
                                                  "or a list")
            else:
                fields[name] = kind
        key = (type(value), *fields.items())
        if key not in self.names:
            name = self.free_name(type(value).__name__)
            self.names[key], self.fields[name], self.classes[name] = name, fields, type(value)
        return Struct(self.names[key])

    def value_of(self, value: Any, kind: Type) -> Any:
        """A value as numbers, Booleans, dicts of attributes and lists."""
        if isinstance(kind, Struct):
            return {name: self.value_of(getattr(value, name), part) for name, part in self.fields[kind.name].items()}
        if isinstance(kind, List):
            return [] if kind.item is None else [self.value_of(item, kind.item) for item in items_of(value) or []]
        return {FLOAT: float, INT: int, BOOL: bool}[kind](value)

    def structs(self) -> Iterator[tuple[str, dict[str, Type]]]:
        """Names and attributes of the structs, each after those that it is made of."""
        yield from self.fields.items()


class Unlike(Untranslatable):
    """A list of different things, which raises an error where a method reads it."""
