"""A typed program: the form into which a block and its methods are read, and which every backend prints.

Expressions have no effect and no order: a call that changes something is a statement, or the only call in its place.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any

from maglev.language.errors import ExportError


class Untranslatable(ExportError):
    """A block has an unsupported construct; the message gives file and line, the construct, and its replacement."""


@dataclass(frozen=True)
class Scalar:
    """Type of a number or a Boolean, by its name in Python."""

    name: str


@dataclass(frozen=True)
class Struct:
    """Type of an object: the name of a class, with a number if its instances have different attributes."""

    name: str


@dataclass(frozen=True)
class List:
    """Type of a list of fixed length."""

    item: "Type | None"   # None for an empty list
    length: int


Type = Scalar | Struct | List

FLOAT, INT, BOOL = Scalar("float"), Scalar("int"), Scalar("bool")


@dataclass(frozen=True)
class Site:
    """A place that can fail while a step is computed: the failure, with file and line."""

    number: int   # from 1 on
    text: str


@dataclass(frozen=True)
class Const:
    """A number or a Boolean; `name` is that of a module's constant."""

    value: Any
    type: Type
    name: str = ""


@dataclass(frozen=True)
class ConstList:
    """A module's tuple or list of numbers."""

    name: str
    values: tuple[Any, ...]
    type: List


@dataclass(frozen=True)
class Local:
    """A parameter or a local name; of objects and lists a reference."""

    name: str
    type: Type


@dataclass(frozen=True)
class Field:
    """An attribute of an object."""

    base: "Expr"
    name: str
    type: Type


@dataclass(frozen=True)
class Item:
    """An element of a list; without a site the index is known to be within it."""

    base: "Expr"
    index: "Expr"
    type: Type
    site: Site | None = None


@dataclass(frozen=True)
class Operation:
    """An operator, a conversion or a function of `math` on numbers: "+", "neg", "int", "sqrt", "max", …"""

    name: str
    operands: tuple["Expr", ...]
    type: Type
    site: Site | None = None


@dataclass(frozen=True)
class Logic:
    """`and` or `or` of Booleans, in their order."""

    name: str
    operands: tuple["Expr", ...]
    type: Type = BOOL


@dataclass(frozen=True)
class Choice:
    """`yes if test else no`."""

    test: "Expr"
    yes: "Expr"
    no: "Expr"
    type: Type


@dataclass(frozen=True)
class Call:
    """A call of a function with one result or none."""

    function: "Function"
    arguments: tuple["Expr", ...]

    @property
    def type(self) -> Any:
        return self.function.results[0] if self.function.results else None


Expr = Const | ConstList | Local | Field | Item | Operation | Logic | Choice | Call


@dataclass
class Assign:
    """An assignment to a local name, an attribute or an element; of objects and lists to a local name alone."""

    target: Expr
    value: Expr


@dataclass
class Perform:
    """A call as a statement; its results go to the targets, in their order, or nowhere without targets."""

    call: Call
    targets: tuple[Expr, ...] = ()


@dataclass
class If:
    test: Expr
    yes: "list[Statement]"
    no: "list[Statement]"


@dataclass
class While:
    test: Expr
    body: "list[Statement]"


@dataclass
class For:
    """A loop over start, start + step, … before stop; `name` is of no use after it."""

    name: str
    start: Expr
    stop: Expr
    step: int
    body: "list[Statement]"


@dataclass
class Return:
    values: tuple[Expr, ...]


@dataclass
class Jump:
    """`break` or `continue`."""

    word: str


Statement = Assign | Perform | If | While | For | Return | Jump


@dataclass(eq=False)
class Function:
    """A function or method, for the types that it is called with."""

    name: str                      # in C: Class__method or module__function
    source: Callable[..., Any]     # in Python
    file: str
    line: int
    parameters: list[tuple[str, Type]]
    results: tuple[Type, ...] = ()
    body: list[Statement] = field(default_factory=list)
    locals: dict[str, Type] = field(default_factory=dict)   # without the names of loops
    changed: set[str] = field(default_factory=set)          # parameters and lists through which it writes
    calls: "list[Function]" = field(default_factory=list)   # each once, in their order
    sites: list[Site] = field(default_factory=list)         # of its own
    fails: bool = False                                     # true if it or a function that it calls can fail

    @property
    def writes(self) -> bool:
        """Return True if it changes values outside itself."""
        return any(name in self.changed for name, _ in self.parameters)


def functions_of(roots: "list[Function]") -> list[Function]:
    """The functions and all that they call, each after those that it calls."""
    ordered: dict[int, Function] = {}

    def visit(function: Function) -> None:
        if id(function) not in ordered:
            for called in function.calls:
                visit(called)
            ordered[id(function)] = function

    for root in roots:
        visit(root)
    return list(ordered.values())


def inner(body: "list[Statement]") -> "Iterator[Statement]":
    """The statements of a body, and those within them."""
    for statement in body:
        yield statement
        if isinstance(statement, If):
            yield from inner(statement.yes)
            yield from inner(statement.no)
        elif isinstance(statement, While | For):
            yield from inner(statement.body)


def ends(functions: "list[Function]") -> bool:
    """Return True if every call ends soon, whatever the values: all loops have literal bounds."""
    loops = [statement for function in functions for statement in inner(function.body)
             if isinstance(statement, While | For)]
    return all(isinstance(loop, For) and isinstance(loop.start, Const) and isinstance(loop.stop, Const)
               for loop in loops)
