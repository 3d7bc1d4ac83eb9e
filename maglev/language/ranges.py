"""Ranges of whole numbers that follow from a program, so that its C has no checks that cannot fail."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from maglev.language.constants import Place, values_in
from maglev.language.layout import LARGEST
from maglev.language.liveness import within
from maglev.language.program import (
    INT,
    Assign,
    Call,
    Choice,
    Const,
    ConstList,
    Expr,
    Field,
    For,
    Function,
    Item,
    Local,
    Operation,
    Perform,
    Struct,
    inner,
)

Range = tuple[int, int]   # the smallest and the largest value
Name = tuple[int, str]    # a function by its identity, and a parameter or a local name of it


class Ranges:
    """Ranges of the expressions of functions, which call each other and are called from outside as `roots`.

    `attributes` has the values of attributes that never change. A name has the values of all its assignments, wherever
    these are. The names of lists and objects have no range.
    """

    def __init__(self, functions: Sequence[Function], roots: Sequence[Function],
                 attributes: Mapping[Place, Sequence[Any]]):
        self.attributes = attributes
        self.sources: dict[Name, list[tuple[Function, Expr | For | None]]] = {}   # None for a value without a range
        self.found: dict[Name, Range | None] = {}
        for root in roots:
            for name, _ in root.parameters:
                self.add(root, name, root, None)
        for function in functions:
            for statement in inner(function.body):
                match statement:
                    case Assign(target=Local(name=name), value=value):
                        self.add(function, name, function, value)
                    case Perform(targets=targets):
                        for target in targets:
                            if isinstance(target, Local):
                                self.add(function, target.name, function, None)
                    case For(name=name):
                        self.add(function, name, function, statement)
                for value in values_in(statement):
                    for each in within(value):
                        if isinstance(each, Call):
                            for (name, _), argument in zip(each.function.parameters, each.arguments, strict=True):
                                self.add(each.function, name, function, argument)

    def add(self, owner: Function, name: str, function: Function, source: Expr | For | None) -> None:
        """Note that a name of `owner` gets a value of `function`."""
        self.sources.setdefault((id(owner), name), []).append((function, source))

    def of(self, function: Function, value: Expr) -> Range | None:
        """Return the range of an expression of a function, None if it is unknown or exceeds 64 bits."""
        if value.type != INT:
            return None
        match value:
            case Const(value=number):
                return number, number
            case Local(name=name):
                return self.of_name((id(function), name))
            case Field() | Item():
                numbers = list(self.numbers(value))
                return (min(numbers), max(numbers)) if numbers else None
            case Choice(yes=yes, no=no):
                return hull([self.of(function, yes), self.of(function, no)])
            case Operation(name=name, operands=operands):
                return computed(name, [self.of(function, each) for each in operands])
        return None

    def of_name(self, name: Name) -> Range | None:
        if name not in self.found:
            self.found[name] = None   # while it is looked for: a number that depends on itself may be any
            self.found[name] = hull([self.of_source(*each) for each in self.sources.get(name, [])])
        return self.found[name]

    def of_source(self, function: Function, source: Expr | For | None) -> Range | None:
        if not isinstance(source, For):
            return None if source is None else self.of(function, source)
        start, stop = self.of(function, source.start), self.of(function, source.stop)
        if start is None or stop is None:
            return None
        low, high = (start[0], stop[1] - 1) if source.step > 0 else (stop[0] + 1, start[1])
        return min(low, high), max(low, high)

    def numbers(self, value: Expr) -> Iterator[int]:
        """Values of an attribute that never changes, or of an element of a constant list."""
        match value:
            case Item(base=base):
                yield from self.numbers(base)
            case ConstList(values=values):
                yield from flat(values)
            case Field(base=base, name=name) if isinstance(base.type, Struct):
                yield from flat(self.attributes.get((base.type.name, name), ()))


def flat(values: Sequence[Any]) -> Iterator[int]:
    for each in values:
        yield from flat(each) if isinstance(each, tuple) else (each,)


def hull(ranges: Sequence[Range | None]) -> Range | None:
    """Return the range that contains all others, None if one is unknown."""
    known = [each for each in ranges if each is not None]
    if not known or len(known) < len(ranges):
        return None
    return min(low for low, _ in known), max(high for _, high in known)


def computed(name: str, ranges: Sequence[Range | None]) -> Range | None:
    """Return the range of a sum, difference, product or negative, None if it exceeds 64 bits."""
    known = [each for each in ranges if each is not None]
    if len(known) < len(ranges):
        return None
    match name, known:
        case "neg", [(low, high)]:
            ends = [-low, -high]
        case "+", [(low, high), (other_low, other_high)]:
            ends = [low + other_low, high + other_high]
        case "-", [(low, high), (other_low, other_high)]:
            ends = [low - other_high, high - other_low]
        case "*", [(low, high), others]:
            ends = [one * other for one in (low, high) for other in others]
        case _:
            return None
    return (min(ends), max(ends)) if min(ends) >= -LARGEST and max(ends) < LARGEST else None
