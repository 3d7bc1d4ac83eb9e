"""Attributes that never change: whole numbers and Booleans, and lists of them."""

import re
from collections.abc import Collection, Iterable, Iterator
from typing import Any

from maglev.language.layout import Layout
from maglev.language.liveness import within
from maglev.language.program import (
    BOOL,
    INT,
    Assign,
    Call,
    Choice,
    Expr,
    Field,
    For,
    Function,
    If,
    Item,
    List,
    Local,
    Perform,
    Return,
    Statement,
    Struct,
    Type,
    While,
    inner,
)

Place = tuple[str, str]   # a struct and an attribute
PART = re.compile(r"\w+|\[")


def constant_attributes(layout: Layout, block: Any, functions: Iterable[Function], settable: Collection[str]
                        ) -> dict[Place, list[Any]]:
    """Return, by struct and attribute, the values of all its objects, if no function assigns them.

    `settable` are the paths of attributes that are assigned from outside, such as "axes[0].locked".
    """
    changed = {place for function in functions for place in assigned(function)} | {
        place_of(layout, path) for path in settable}
    found: dict[Place, list[Any]] = {}
    for place, value in values_of(layout, block, layout.root):
        if place not in changed:
            found.setdefault(place, []).append(value)
    return found


def values_of(layout: Layout, value: Any, kind: Type) -> Iterator[tuple[Place, Any]]:
    """Attributes of an object and of its parts with their values: whole numbers, Booleans, and lists of them."""
    if isinstance(kind, List):
        for item in value:
            if isinstance(kind.item, List | Struct):
                yield from values_of(layout, item, kind.item)
    elif isinstance(kind, Struct):
        for name, part in layout.fields[kind.name].items():
            own = getattr(value, name)
            if part in (INT, BOOL):
                yield (kind.name, name), layout.value_of(own, part)
            elif isinstance(part, List) and part.item in (INT, BOOL):
                yield (kind.name, name), tuple(layout.value_of(own, part))
            else:
                yield from values_of(layout, own, part)


def place_of(layout: Layout, path: str) -> Place:
    """The struct and the attribute at the end of a path."""
    kind: Any = layout.root
    place = (kind.name, "")
    for part in PART.findall(re.sub(r"\[\d+\]", "[", path)):
        if part == "[":
            kind = kind.item
        else:
            place = (kind.name, part)
            kind = layout.fields[kind.name][part]
    return place


def assigned(function: Function) -> Iterator[Place]:
    """Attributes that a function assigns; also lists that it hands on, which may be assigned elsewhere."""
    for statement in inner(function.body):
        match statement:
            case Assign(target=Local(), value=value):
                if isinstance(value.type, List):
                    yield from attributes(value)
            case Assign(target=target):
                yield from attributes(target)
            case Perform(targets=targets):
                for target in targets:
                    yield from attributes(target)
        for value in values_in(statement):
            for each in within(value):
                if isinstance(each, Call):
                    for argument in each.arguments:
                        if isinstance(argument.type, List):
                            yield from attributes(argument)


def attributes(value: Expr) -> Iterator[Place]:
    """The attribute that an expression refers to, itself or an element of it."""
    if isinstance(value, Choice):
        yield from attributes(value.yes)
        yield from attributes(value.no)
    elif isinstance(value, Item):
        yield from attributes(value.base)
    elif isinstance(value, Field) and isinstance(value.base.type, Struct):
        yield value.base.type.name, value.name


def values_in(statement: Statement) -> tuple[Expr, ...]:
    """The expressions of a statement, without those of the statements within it."""
    match statement:
        case Assign(target=target, value=value):
            return target, value
        case Perform(call=call, targets=targets):
            return call, *targets
        case If(test=test) | While(test=test):
            return (test,)
        case For(start=start, stop=stop):
            return start, stop
        case Return(values=values):
            return values
    return ()
