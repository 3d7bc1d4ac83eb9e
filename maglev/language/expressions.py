"""Reads the expressions of a function into a typed program, in Python's order of evaluation."""

import ast
import builtins
import inspect
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from types import ModuleType
from typing import Any

from maglev.language.layout import LARGEST, items_of, scalar_type
from maglev.language.program import (
    BOOL,
    FLOAT,
    INT,
    Assign,
    Call,
    Choice,
    Const,
    ConstList,
    Expr,
    Field,
    Function,
    If,
    Item,
    List,
    Local,
    Logic,
    Operation,
    Scalar,
    Site,
    Statement,
    Struct,
    Type,
    Untranslatable,
)
from maglev.language.reader import Reader
from maglev.language.sources import is_of
from maglev.language.texts import definition_of

# Expressions that the language does not have, and their replacements.
EXPRESSIONS: dict[type[ast.AST], str] = {
    ast.Lambda: "lambda: expected a def", ast.Yield: "yield: expected a return",
    ast.YieldFrom: "yield: expected a return",
    ast.Dict: "a dict: expected attributes", ast.Set: "a set: expected attributes",
    ast.List: "a new list: expected one that __init__ sets, and assignments to its elements",
    ast.ListComp: "a new list: expected one that __init__ sets, and a for", ast.DictComp: "a dict: expected attributes",
    ast.SetComp: "a set: expected attributes", ast.GeneratorExp: "a generator: expected a for, any() or all()",
    ast.JoinedStr: "text: expected numbers only", ast.Starred: "*: expected every value by itself",
    ast.NamedExpr: ":=: expected a line of its own", ast.Slice: "a part of a list: expected a for over its elements",
    ast.Tuple: "a tuple that is kept: expected a name for each value", ast.Await: "await: expected a call"}
OPERATORS: dict[type[ast.operator], str] = {
    ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/", ast.FloorDiv: "//", ast.Mod: "%", ast.LShift: "<<",
    ast.RShift: ">>", ast.BitAnd: "&", ast.BitOr: "|", ast.BitXor: "^"}
REFUSED_OPERATORS: dict[type[ast.operator], str] = {
    ast.Pow: "**: expected a product", ast.MatMult: "@: expected sums of products in a for"}
COMPARED: dict[type[ast.cmpop], str] = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "==",
                                        ast.NotEq: "!="}

CONVERTED: dict[Type, type] = {FLOAT: float, INT: int, BOOL: bool}
TOO_LARGE = "a whole number beyond 2^63"
# How operators of whole numbers fail, of which helpers tell the first by the number of a place, the second by the next.
FAILURES = {"//": ("division by zero", TOO_LARGE), "%": ("division by zero",),
            "<<": ("a shift by less than 0", TOO_LARGE), ">>": ("a shift by less than 0",)}


class Expressions:
    """The expressions of one function, and the statements before them in its body."""

    def __init__(self, program: Reader, function: Function):
        self.program = program
        self.function = function
        self.node = definition_of(function.source)
        self.body = function.body
        self.parameters = {name for name, _ in function.parameters}
        self.types: dict[str, Type] = dict(function.parameters)
        self.known: set[str] = set(self.parameters)     # names that have a value for certain
        self.within: dict[str, range] = {}              # values of the names of loops
        self.refers: dict[str, list[Expr]] = {}         # values of local names of objects and lists
        self.jumps: list[set[str]] = []
        self.returned: tuple[Type, ...] | None = None
        self.ended = False
        self.temporaries = 0
        self.assigned = {each.id for each in ast.walk(self.node) if isinstance(each, ast.Name)
                         and isinstance(each.ctx, ast.Store)}

    # Words

    def place_of(self, node: ast.AST) -> str:
        return f"{self.function.file}, line {getattr(node, 'lineno', self.function.line)}"

    def refusal(self, node: ast.AST, what: str) -> Untranslatable:
        """Return the error that names the place of an unsupported construct, and its replacement."""
        return Untranslatable(f"{self.place_of(node)}: {what}")

    def float_site(self, node: ast.AST, text: str) -> Site | None:
        """A place where Python raises for a float, and C continues; none in a package that is known to look before."""
        module = self.function.source.__module__ or ""
        return None if is_of(module, tuple(self.program.careful)) else self.site(node, text)

    def site(self, node: ast.AST, text: str) -> Site:
        """A place of this function that can fail."""
        site = self.program.site(self.function.file, getattr(node, "lineno", self.function.line), text)
        self.function.sites.append(site)
        return site

    def words(self, kind: Type | None) -> str:
        """A type, in a message."""
        if isinstance(kind, Struct):
            return f"an object of {self.program.layout.classes[kind.name].__name__}"
        if isinstance(kind, List):
            return f"a list of {kind.length} elements"
        return "nothing" if kind is None else {FLOAT: "a float", INT: "a whole number", BOOL: "a Boolean"}[kind]

    def instead(self, kind: Type, other: Type) -> str:
        """Return advice for a place where a value of another type is expected."""
        if {kind, other} == {FLOAT, INT}:
            return "a float, such as 0.0 for 0" if kind == FLOAT else "int() of it, or a float from the start"
        if isinstance(kind, Struct) and isinstance(other, Struct):
            return "an object whose attributes have the same types"
        return "a Boolean, such as True" if kind == BOOL else "the same type"

    # Temporary names

    def new_local(self, kind: Type) -> Local:
        """A local name of its own."""
        while True:
            self.temporaries += 1
            name = f"part_{self.temporaries}"
            if name not in self.types:
                self.types[name] = self.function.locals[name] = kind
                return Local(name, kind)

    def new_counter(self) -> Local:
        """A name for the turns of a loop, which declares it."""
        counter = self.new_local(INT)
        del self.function.locals[counter.name]
        return counter

    def temporary(self, value: Expr) -> Local:
        """A local name that has a value from here on."""
        local = self.new_local(value.type)
        if isinstance(value.type, List | Struct):
            self.refers[local.name] = [value]
        self.body.append(Assign(local, value))
        return local

    def mark_changed(self, node: ast.AST, place: Expr) -> None:
        """Note the parameter or list through which a value is written; a constant cannot be written."""
        waiting, seen = [place], set[str]()
        while waiting:
            each = waiting.pop()
            while isinstance(each, Field | Item):
                each = each.base
            if isinstance(each, Choice):
                waiting += [each.yes, each.no]
            elif isinstance(each, ConstList):
                raise self.refusal(node, f"{each.name} is a constant of a module, which cannot change: expected an "
                                         "attribute")
            elif isinstance(each, Local) and each.name not in seen:
                seen.add(each.name)
                self.function.changed.add(each.name)
                waiting += self.refers.get(each.name, [])

    # Values that are known while the program is read

    def constant(self, node: ast.expr) -> Any:
        """Return the value of a name that is not local, or of a name in a module; None if there is no such value."""
        if isinstance(node, ast.Name) and node.id not in self.types and node.id not in self.assigned:
            names = self.function.source.__globals__
            return names.get(node.id, getattr(builtins, node.id, None))
        if isinstance(node, ast.Attribute) and isinstance(owner := self.constant(node.value), ModuleType):
            return getattr(owner, node.attr, None)
        return None

    def literal(self, node: ast.AST, value: Any, name: str = "") -> Expr:
        """Return a number or a Boolean unchanged, or the list of a module."""
        kind = scalar_type(value)
        if kind == INT and not -LARGEST <= value < LARGEST:
            raise self.refusal(node, f"{value}: expected a whole number below 2^63")
        if kind is not None:
            return Const(CONVERTED[kind](value), kind, name)
        items = items_of(value)
        if items is not None:
            values = [self.literal(node, item) for item in items]
            types = {each.type for each in values}
            if len(types) > 1 or not all(isinstance(each, Const | ConstList) for each in values):
                raise self.refusal(node, f"{name}: expected numbers of one type")
            return ConstList(name, tuple(each.value if isinstance(each, Const) else each.values for each in values),  # type: ignore[union-attr]
                             List(types.pop() if types else None, len(values)))
        what = "None: expected a number, or a Boolean next to it" if value is None else (
            "text: expected numbers only" if isinstance(value, str | bytes) else
            f"{name or ast.unparse(node)} is of {type(value).__name__}: expected a number, or an attribute that "
            "__init__ sets")
        raise self.refusal(node, what)

    # Expressions

    def in_order(self, nodes: Sequence[ast.expr]) -> list[Expr]:
        """Values of expressions that Python evaluates one after the other, where one may change what another reads."""
        values: list[Expr] = []
        for node in nodes:
            mark = len(self.body)
            value = self.expression(node)
            if len(self.body) > mark or writes(value):
                late, self.body[mark:] = self.body[mark:], []
                values = [self.kept(each) for each in values]
                self.body += late
            values.append(value)
        return values if len(values) == 1 else [self.temporary(each) if writes(each) else each for each in values]

    def kept(self, value: Expr) -> Expr:
        """Return the value in a form that later statements cannot change."""
        if not isinstance(value.type, Scalar):
            return self.steady(value)
        return value if isinstance(value, Const) else self.temporary(value)

    def steady(self, place: Expr) -> Expr:
        """Return a place that stays the same whatever follows: an index that could change gets a name of its own."""
        if isinstance(place, Field):
            return replace(place, base=self.steady(place.base))
        if isinstance(place, Item):
            index = place.index if isinstance(place.index, Const | Local) else self.temporary(place.index)
            return replace(place, base=self.steady(place.base), index=index)
        return place if isinstance(place, Local | Const | ConstList) else self.temporary(place)

    def simple(self, value: Expr) -> Expr:
        """A value that can be written twice."""
        inner = value
        while isinstance(inner, Field):
            inner = inner.base
        return value if isinstance(inner, Const | Local) else self.temporary(value)

    def expression(self, node: ast.expr) -> Expr:
        """Read an expression."""
        match node:
            case ast.Constant(value=value):
                return self.literal(node, value)
            case ast.Name(id=name):
                return self.name(node, name)
            case ast.Attribute():
                return self.attribute(node)
            case ast.Subscript(value=base, slice=index):
                return self.subscript(node, base, index)
            case ast.BinOp(left=left, op=op, right=right):
                a, b = self.in_order([left, right])
                return self.operation(node, op, a, b)
            case ast.UnaryOp(op=op, operand=operand):
                return self.unary(node, op, operand)
            case ast.BoolOp(op=op, values=values):
                return self.logic("and" if isinstance(op, ast.And) else "or", values)
            case ast.Compare():
                return self.comparison(node)
            case ast.IfExp(test=test, body=yes, orelse=no):
                return self.choice(node, test, yes, no)
            case ast.Call():
                return self.call(node)
        raise self.refusal(node, EXPRESSIONS.get(
            type(node), f"{ast.unparse(node)}: expected numbers, attributes and calls"))

    def name(self, node: ast.Name, name: str) -> Expr:
        if name in self.types:
            if name not in self.known:
                raise self.refusal(node, f"{name} may have no value yet: expected one on every way that leads here")
            return Local(name, self.types[name])
        value = self.constant(node)
        if value is None and name not in self.function.source.__globals__:
            raise self.refusal(node, f"{name} has no value yet: expected an assignment before" if name in self.assigned
                               else f"there is no {name}: expected a name of the file")
        return self.literal(node, value, name)

    def attribute(self, node: ast.Attribute) -> Expr:
        if isinstance(owner := self.constant(node.value), ModuleType):
            if not hasattr(owner, node.attr):
                raise self.refusal(node, f"there is no {node.attr} in {owner.__name__}: expected a name of it")
            return self.literal(node, getattr(owner, node.attr), node.attr)
        base = self.expression(node.value)
        if not isinstance(base.type, Struct):
            raise self.refusal(node, f"{ast.unparse(node)}: {ast.unparse(node.value)} is {self.words(base.type)}, "
                                     "expected an object")
        kind = self.program.layout.fields[base.type.name].get(node.attr)
        if kind is not None:
            return Field(base, node.attr, kind)
        written = self.program.layout.classes[base.type.name]
        if why := self.program.layout.unlike.get((written, node.attr)):
            raise self.refusal(node, why)
        found = inspect.getattr_static(written, node.attr, None)
        if found is not None and not callable(found) and not isinstance(found, property | classmethod | staticmethod):
            return self.literal(node, found, node.attr)
        what = "a property" if isinstance(found, property) else "a method" if callable(found) else ""
        if what:
            raise self.refusal(node, f"{ast.unparse(node)} is {what}: expected a call of a method")
        raise self.refusal(node, f"{ast.unparse(node)} is no attribute with a number, an object or a list: expected "
                                 f"one that __init__ of {written.__name__} sets")

    def subscript(self, node: ast.Subscript, base: ast.expr, index: ast.expr) -> Expr:
        values = self.in_order([base, *(index.elts if isinstance(index, ast.Tuple) else [index])])
        result = values[0]
        for number in values[1:]:
            if not isinstance(result.type, List) or number.type != INT:
                raise self.refusal(node, f"{ast.unparse(node)}: expected a list and a whole number")
            result = self.element(result, number, node)
        return result

    def element(self, base: Expr, index: Expr, node: ast.AST | None = None) -> Expr:
        """Element of a list; without a node the index is known to be one of it."""
        assert isinstance(base.type, List)
        length, item = base.type.length, base.type.item
        if isinstance(index, Const):
            if not -length <= index.value < length:
                raise self.refusal(node or self.node, f"element {index.value} of a list of {length}: expected "
                                                      + (f"{-length} to {length - 1}" if length else "a longer one"))
            index = Const(index.value % length, INT)
            if isinstance(base, ConstList):
                value = base.values[index.value]
                return ConstList(f"{base.name}_{index.value}", value, item) if isinstance(item, List) else Const(
                    value, item)  # type: ignore[arg-type]
            return Item(base, index, item)  # type: ignore[arg-type]
        if item is None:
            raise self.refusal(node or self.node, "an element of an empty list: expected one with elements")
        turns = self.within.get(index.name) if isinstance(index, Local) else None
        if node is None or (turns is not None and len(turns) and min(turns) >= 0 and max(turns) < length):
            return Item(base, index, item)
        return Item(base, index, item, self.site(node, f"no such element of a list of {length}"))

    def numbers(self, node: ast.AST, *values: Expr) -> list[Expr]:
        """Values of one type, floats if one is; raise if one is no number."""
        for value in values:
            if value.type not in (FLOAT, INT):
                raise self.refusal(node, f"{ast.unparse(node)} has {self.words(value.type)}: expected numbers"
                                         + (", such as 1.0 if … else 0.0" if value.type == BOOL else
                                            ", such as its elements in a for" if isinstance(value.type, List) else ""))
        return [self.as_float(value) for value in values] if FLOAT in {value.type for value in values} else list(values)

    def as_float(self, value: Expr) -> Expr:
        if value.type == FLOAT:
            return value
        return Const(float(value.value), FLOAT, value.name) if isinstance(value, Const) else Operation(
            "float", (value,), FLOAT)

    def operation(self, node: ast.AST, op: ast.operator, a: Expr, b: Expr) -> Expr:
        """An operation on two numbers: of floats in C as it is, of whole numbers if it stays in 64 bits."""
        if type(op) in REFUSED_OPERATORS:
            raise self.refusal(node, REFUSED_OPERATORS[type(op)])
        sign = OPERATORS[type(op)]
        if sign in "&|^" and a.type == b.type == BOOL:
            return Operation({"&": "and", "|": "or", "^": "!="}[sign], (a, b), BOOL)
        a, b = self.numbers(node, a, b)
        if sign == "/":
            if a.type == b.type == INT and not (exact(a) and exact(b)):
                return Operation("/", (a, b), FLOAT, None if isinstance(b, Const) and b.value != 0 else self.site(
                    node, "division by zero"))
            a, b = self.as_float(a), self.as_float(b)
            site = None if isinstance(b, Const) and b.value != 0.0 else self.float_site(node, "division by zero")
            return Operation("/", (a, b), FLOAT, site)
        if a.type == FLOAT:
            if sign not in "+-*":
                raise self.refusal(node, f"{sign} of floats: expected {'floor' if sign == '//' else 'fmod'} of math"
                                   if sign in ("//", "%") else f"{sign} of floats: expected whole numbers")
            return Operation(sign, (a, b), FLOAT)
        if isinstance(a, Const) and isinstance(b, Const) and sign in "+-*&|^":
            return self.literal(node, {"+": a.value + b.value, "-": a.value - b.value, "*": a.value * b.value,
                                       "&": a.value & b.value, "|": a.value | b.value, "^": a.value ^ b.value}[sign])
        if sign in "&|^" or (sign == ">>" and isinstance(b, Const) and 0 <= b.value < 63):
            return Operation(sign, (a, b), INT)
        if isinstance(b, Const) and sign in ("//", "%") and b.value not in ((0, -1) if sign == "//" else (0,)):
            return Operation(sign, (a, b), INT)
        sites = [self.site(node, text) for text in FAILURES.get(sign, (TOO_LARGE,))]
        return Operation(sign, (a, b), INT, sites[0])

    def unary(self, node: ast.AST, op: ast.unaryop, operand: ast.expr) -> Expr:
        if isinstance(op, ast.Not):
            return Operation("not", (self.truth(operand),), BOOL)
        value, = self.numbers(node, self.expression(operand))
        if isinstance(op, ast.UAdd):
            return value
        if isinstance(op, ast.Invert):
            if value.type != INT:
                raise self.refusal(node, "~ of a float: expected a whole number")
            return Operation("~", (value,), INT)
        if isinstance(value, Const) and not value.name:
            return self.literal(node, -value.value)
        return Operation("neg", (value,), value.type, self.site(node, TOO_LARGE) if value.type == INT else None)

    def truth(self, node: ast.expr) -> Expr:
        """Read a condition."""
        value = self.expression(node)
        if value.type != BOOL:
            raise self.refusal(node, f"{ast.unparse(node)} is {self.words(value.type)}: expected a Boolean or a "
                                     "comparison")
        return value

    def aside(self, read: Callable[[], Expr]) -> tuple[list[Statement], Expr]:
        """Read an expression that is not always evaluated: the statements before it, and the value."""
        before, self.body = self.body, []
        value = read()
        own, self.body = self.body, before
        return own, value

    def logic(self, word: str, nodes: Sequence[ast.expr]) -> Expr:
        """`and` or `or`; if a later part needs statements of its own, an `if` replaces the operator."""
        parts = [self.truth(nodes[0])]
        for number, node in enumerate(nodes[1:], 1):
            own, value = self.aside(partial(self.truth, node))
            if own:
                result = self.temporary(parts[0] if len(parts) == 1 else Logic(word, tuple(parts)))
                rest = nodes[number + 1:]
                before, self.body = self.body, own
                self.body.append(Assign(result, value))
                if rest:
                    more, further = self.aside(partial(self.logic, word, rest))
                    test: Expr = result if word == "and" else Operation("not", (result,), BOOL)
                    self.body.append(If(test, [*more, Assign(result, further)], []))
                own, self.body = self.body, before
                go_on: Expr = result if word == "and" else Operation("not", (result,), BOOL)
                self.body.append(If(go_on, own, []))
                return result
            parts.append(value)
        return parts[0] if len(parts) == 1 else Logic(word, tuple(parts))

    def choice(self, node: ast.IfExp, test: ast.expr, yes: ast.expr, no: ast.expr) -> Expr:
        condition = self.truth(test)
        (before_yes, a), (before_no, b) = (self.aside(partial(self.expression, each)) for each in (yes, no))
        if a.type != b.type or a.type is None:
            raise self.refusal(node, f"{ast.unparse(node)} is {self.words(a.type)} or {self.words(b.type)}: expected "
                                     f"one type{', such as 0.0 for 0' if {a.type, b.type} == {FLOAT, INT} else ''}")
        if not before_yes and not before_no:
            return Choice(condition, a, b, a.type)
        result = self.new_local(a.type)
        self.refers[result.name] = [a, b]
        self.body.append(If(condition, [*before_yes, Assign(result, a)], [*before_no, Assign(result, b)]))
        return result

    def comparison(self, node: ast.Compare) -> Expr:
        """One comparison, or a chain of them, whose parts are evaluated once."""
        a, b = self.in_order([node.left, node.comparators[0]])
        if len(node.ops) == 1:
            return self.compared(node, node.ops[0], a, b)
        b = self.simple(b)
        return self.chain(node, self.compared(node, node.ops[0], a, b), b, 1)

    def chain(self, node: ast.Compare, first: Expr, a: Expr, number: int) -> Expr:
        """A comparison, and the rest of the chain, which is not evaluated where the comparison is false."""
        def rest() -> Expr:
            left = self.kept(a) if any(isinstance(each, ast.Call) for each in ast.walk(node)) else a
            b = self.expression(node.comparators[number])
            if number + 1 == len(node.ops):
                return self.compared(node, node.ops[number], left, b)
            b = self.simple(b)
            return self.chain(node, self.compared(node, node.ops[number], left, b), b, number + 1)

        own, value = self.aside(rest)
        if not own and not writes(value):
            return Logic("and", (first, value))
        result = self.temporary(first)
        self.body.append(If(result, [*own, Assign(result, value)], []))
        return result

    def compared(self, node: ast.Compare, op: ast.cmpop, a: Expr, b: Expr) -> Expr:
        if type(op) not in COMPARED:
            raise self.refusal(node, f"{ast.unparse(node)}: expected <, <=, >, >=, == or !=")
        sign = COMPARED[type(op)]
        if a.type == b.type == BOOL and sign in ("==", "!="):
            return Operation(sign, (a, b), BOOL)
        floats = self.numbers(node, a, b)
        if a.type != b.type and not all(exact(each) for each in (a, b) if each.type == INT):
            return Operation(sign, (a, b), BOOL)   # by their exact values, as in Python
        return Operation(sign, tuple(floats), BOOL)

    def call(self, node: ast.Call, alone: bool = False) -> Expr:
        """Read a call: `Calls` does it."""
        raise NotImplementedError


def exact(value: Expr) -> bool:
    """Return True if a literal whole number is the same as a float."""
    return isinstance(value, Const) and abs(value.value) <= 2**53


def writes(value: Expr) -> bool:
    """Return True if something changes while a value is computed."""
    if isinstance(value, Call):
        return value.function.writes or any(map(writes, value.arguments))
    if isinstance(value, Operation | Logic):
        return any(map(writes, value.operands))
    if isinstance(value, Choice):
        return writes(value.test) or writes(value.yes) or writes(value.no)
    if isinstance(value, Item):
        return writes(value.base) or writes(value.index)
    return isinstance(value, Field) and writes(value.base)
