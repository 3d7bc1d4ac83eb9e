"""Reads calls of functions and methods, and of functions of Python's own."""

import ast
import inspect
import math
from typing import Any

from maglev.language.expressions import TOO_LARGE, Expressions
from maglev.language.program import (
    BOOL,
    FLOAT,
    INT,
    Assign,
    Call,
    Choice,
    Const,
    Expr,
    For,
    If,
    Jump,
    List,
    Logic,
    Operation,
    Struct,
)
from maglev.language.sources import parsed_expression

# Functions of `math` that return a float, for one number or for two. Python raises where they have no value.
ONE = {"sqrt", "sin", "cos", "tan", "asin", "acos", "atan", "exp", "expm1", "log", "log1p", "log2", "log10", "sinh",
       "cosh", "tanh", "erf", "erfc"}
TWO = {"fmod", "remainder", "atan2", "pow"}
WHOLE = {"floor", "ceil", "trunc"}     # give a whole number
TELLING = {"isfinite", "isnan", "isinf"}

CHANGING = {"append", "extend", "insert", "remove", "pop", "clear", "sort", "reverse"}   # of lists


class Calls(Expressions):
    """The expressions of one function, calls among them."""

    def call(self, node: ast.Call, alone: bool = False) -> Expr:
        """Read a call; of several results, or none, only where it stands alone."""
        function = self.constant(node.func)
        if function is not None:
            if (known := self.builtin(node, function)) is not None:
                return known
            if function is super:
                raise self.refusal(node, "super(): expected the method of the base class under another name")
            if not inspect.isfunction(function):
                raise self.refusal(node, f"{ast.unparse(node.func)}(): expected a def, a function of math, abs, min, "
                                         "max, len, any, all, int, float or bool")
            return self.called(node, function, [], None, alone)
        if not isinstance(node.func, ast.Attribute):
            raise self.refusal(node, f"{ast.unparse(node.func)}(): there is no such function, expected a def of the "
                                     "file")
        owner = self.expression(node.func.value)
        shown = ast.unparse(node.func)
        if isinstance(owner.type, List):
            raise self.refusal(node, f"{shown}(): " + (
                "a list keeps its length and order: expected assignments to its elements"
                if node.func.attr in CHANGING else "lists have no methods: expected a for over its elements"))
        if not isinstance(owner.type, Struct):
            raise self.refusal(node, f"{shown}(): {ast.unparse(node.func.value)} is {self.words(owner.type)}, expected "
                                     "an object")
        try:
            method = self.program.method_of(owner.type, node.func.attr)
        except AttributeError:
            written = self.program.layout.classes[owner.type.name]
            if isinstance(other := vars(written).get(node.func.attr), staticmethod | classmethod):
                raise self.refusal(node, f"{shown}() is a {type(other).__name__}: expected a method with self, or a "
                                         "def next to the class") from None
            raise self.refusal(node, f"{shown}(): {written.__name__} has no such method: expected a def in it"
                               ) from None
        return self.called(node, method, [owner], owner.type, alone)

    def called(self, node: ast.Call, source: Any, first: list[Expr], owner: Struct | None, alone: bool) -> Expr:
        """A call of a function, read for the types of its arguments."""
        shown = ast.unparse(node.func)
        signature = inspect.signature(source)
        if set(source.__code__.co_freevars) - {"__class__"}:   # which super() needs
            raise self.refusal(node, f"{shown}() is a def in a function: expected one of a module")
        if any(each.kind is not each.POSITIONAL_OR_KEYWORD for each in signature.parameters.values()):
            raise self.refusal(node, f"{shown}() has * or / in its def: expected every parameter by itself")
        if any(isinstance(each, ast.Starred) for each in node.args) or any(each.arg is None for each in node.keywords):
            raise self.refusal(node, f"{shown}() with * or **: expected every value by itself")
        try:
            bound = signature.bind(*first, *node.args, **{str(each.arg): each.value for each in node.keywords})
        except TypeError as error:
            raise self.refusal(node, f"{shown}(): {error}, expected {source.__name__}{signature}") from None
        given = self.in_order([*node.args, *(each.value for each in node.keywords)])
        values = dict(zip(map(id, [*node.args, *(each.value for each in node.keywords)]), given, strict=True))
        arguments: list[Expr] = []
        for name, parameter in signature.parameters.items():
            argument = bound.arguments.get(name, parameter.default)
            value = values.get(id(argument), argument)
            arguments.append(value if isinstance(value, Expr) else self.literal(node, value, name))
        for written, value in zip(node.args, given, strict=False):
            if value.type is None:
                raise self.refusal(written, f"{ast.unparse(written)} has no value: expected a return in it")
        called = self.program.function(source, [each.type for each in arguments], owner)
        if called not in self.function.calls:
            self.function.calls.append(called)
        for (name, _), value in zip(called.parameters, arguments, strict=True):
            if name in called.changed:
                self.mark_changed(node, value)
        if not called.results and not alone:
            raise self.refusal(node, f"{shown}() has no value: expected a return in it")
        if len(called.results) != 1 and not alone:
            raise self.refusal(node, f"{shown}() has {len(called.results)} values: expected one, or a name for each")
        return Call(called, tuple(arguments))

    def builtin(self, node: ast.Call, function: Any) -> Expr | None:
        """A call of a function of Python's; None if it is another function."""
        names = {abs: "abs", min: "min", max: "max", len: "len", any: "any", all: "all", sum: "sum", int: "int",
                 float: "float", bool: "bool"}
        is_math = getattr(function, "__module__", "") == "math"
        try:
            name = function.__name__ if is_math else names.get(function)
        except TypeError:
            return None
        if name is None:
            return None
        if node.keywords or any(isinstance(each, ast.Starred) for each in node.args):
            raise self.refusal(node, f"{name}() with names or *: expected values alone")
        if name in ("any", "all", "sum", "len"):
            return self.of_list(node, name)
        values = self.in_order(node.args)
        count = 2 if name in TWO | {"copysign"} else 1
        if name in ("min", "max") and len(values) >= 2:
            return self.extreme(node, name, values)
        if len(values) != count or name in ("min", "max"):
            wanted = "two numbers or more" if name in ("min", "max") else "one value" if count == 1 else "two values"
            raise self.refusal(node, f"{ast.unparse(node)}: expected {wanted}")
        value = values[0]
        if name == "bool":
            return value if value.type == BOOL else Operation("!=", tuple(self.numbers(node, value, self.literal(
                node, 0.0 if value.type == FLOAT else 0))), BOOL)
        if name in ("int", "float") and value.type == BOOL:
            number: Any = {"int": int, "float": float}[name]
            one, zero = (self.literal(node, number(truth)) for truth in (True, False))
            return Choice(value, one, zero, INT if name == "int" else FLOAT)
        self.numbers(node, *values)
        if name == "int" or name in WHOLE:
            if value.type == INT:
                return value
            site = self.site(node, f"{TOO_LARGE}, or no number")
            return Operation({"int": "trunc"}.get(name, name), (value,), INT, site)
        if name == "float":
            return self.as_float(value)
        if name == "abs" and value.type == INT:
            return Operation("abs", (value,), INT, self.site(node, TOO_LARGE))
        floats = tuple(map(self.as_float, values))
        if name in ("abs", "fabs"):
            return Operation("fabs", floats, FLOAT)
        if name == "copysign":
            return Operation(name, floats, FLOAT)
        if name in TELLING:
            return Operation(name, floats, BOOL)
        if name in ("radians", "degrees"):
            factor = math.pi / 180.0 if name == "radians" else 180.0 / math.pi
            return Operation("*", (floats[0], Const(factor, FLOAT)), FLOAT)
        if name in ONE | TWO:
            return self.computed(node, name, floats)
        known = ", ".join(sorted(ONE | TWO | WHOLE | TELLING))
        raise self.refusal(node, f"{ast.unparse(node.func)}(): expected one of {known}, or of pmlsm")

    def computed(self, node: ast.Call, name: str, values: tuple[Expr, ...]) -> Expr:
        """A function of `math`; where its values are looked at too, they are computed once."""
        site = self.float_site(node, f"{name} has no result")
        if site is not None:
            values = tuple(self.temporary(each) if calls(each) else each for each in values)
        return Operation(name, values, FLOAT, site)

    def extreme(self, node: ast.Call, name: str, values: list[Expr]) -> Expr:
        """The smallest or largest of numbers, the first of equal ones."""
        if len({value.type for value in values}) > 1:
            raise self.refusal(node, f"{ast.unparse(node)}: expected numbers of one type, such as 0.0 for 0")
        result = self.numbers(node, *values)[0]
        for other in values[1:]:
            result = Operation(name, (result, other), result.type)
        return result

    def of_list(self, node: ast.Call, name: str) -> Expr:
        """len(), any(), all() or sum() of a list, the middle two also of a generator over one list."""
        if len(node.args) != 1:
            raise self.refusal(node, f"{ast.unparse(node)}: expected one list")
        argument = node.args[0]
        if isinstance(argument, ast.GeneratorExp) and name in ("any", "all"):
            return self.any_or_all(node, name, argument)
        source = self.expression(argument)
        if not isinstance(source.type, List):
            raise self.refusal(node, f"{ast.unparse(node)}: {ast.unparse(argument)} is {self.words(source.type)}, "
                                     "expected a list")
        if name == "len":
            return Const(source.type.length, INT)
        elements = [self.element(source, Const(k, INT)) for k in range(source.type.length)]
        if name in ("any", "all"):
            if elements and source.type.item != BOOL:
                raise self.refusal(node, f"{ast.unparse(node)}: expected a list of Booleans")
            return Logic({"any": "or", "all": "and"}[name], tuple(elements)) if elements else Const(name == "all", BOOL)
        if elements and source.type.item != INT:
            raise self.refusal(node, "sum() of floats differs from Python 3.12 on: expected a for")
        total: Expr = Const(0, INT)
        for element in elements:
            total = self.operation(node, ast.Add(), total, element)
        return total

    def any_or_all(self, node: ast.Call, name: str, generator: ast.GeneratorExp) -> Expr:
        """any() or all() of a value computed for each element of a list, until the result is decided."""
        each = generator.generators[0]
        if len(generator.generators) > 1 or each.ifs or not isinstance(each.target, ast.Name):
            raise self.refusal(node, f"{ast.unparse(node)}: expected one for over a list, without an if")
        source = self.expression(each.iter)
        if not isinstance(source.type, List):
            raise self.refusal(node, f"{ast.unparse(each.iter)} is {self.words(source.type)}: expected a list")
        result = self.temporary(Const(name == "all", BOOL))
        if not source.type.length:
            return result
        index = self.new_counter()
        item = self.new_local(self.element(source, index).type)
        renamed = Renamed(each.target.id, item.name).visit(parsed_expression(ast.unparse(generator.elt)))
        for inner in ast.walk(renamed):
            ast.copy_location(inner, node)
        self.known.add(item.name)
        self.refers[item.name] = [source]
        body, test = self.aside(lambda: self.truth(renamed))
        decided = test if name == "any" else Operation("not", (test,), BOOL)
        self.body.append(For(index.name, Const(0, INT), Const(source.type.length, INT), 1, [
            Assign(item, self.element(source, index)), *body,
            If(decided, [Assign(result, Const(name == "any", BOOL)), Jump("break")], [])]))
        return result


def calls(value: Expr) -> bool:
    """Return True if a function of the program is called for a value."""
    return isinstance(value, Call) or any(map(calls, getattr(value, "operands", ()))) or any(
        calls(getattr(value, part)) for part in ("base", "index", "test", "yes", "no") if hasattr(value, part))


class Renamed(ast.NodeTransformer):
    """An expression with another name instead of one."""

    def __init__(self, name: str, other: str):
        self.name, self.other = name, other

    def visit_Name(self, node: ast.Name) -> ast.Name:
        return ast.Name(self.other if node.id == self.name else node.id, node.ctx)
