"""Directional derivatives of a block: forward-mode differentiation of its typed program.

Every function that a method of the block calls gets a second one, with `_dot` after its name, that computes the same
and the derivative of each number along a direction. The direction lies in a second block of the same kind: where a
block has the number `self.y.position`, `self_dot.y.position` is its derivative. Each operation is differentiated by its
rule, so that the result is exact except for rounding; at a kink it is that of the branch that is taken.
"""

import ast
from collections.abc import Sequence
from dataclasses import replace
from math import pi
from typing import Any

from maglev.language.expressions import writes
from maglev.language.program import (
    BOOL,
    FLOAT,
    Assign,
    Call,
    Choice,
    Const,
    ConstList,
    Expr,
    Field,
    For,
    Function,
    If,
    Item,
    Jump,
    List,
    Local,
    Logic,
    Operation,
    Perform,
    Return,
    Statement,
    Struct,
    Type,
    Untranslatable,
    While,
)
from maglev.language.sources import parsed_expression

SUFFIX = "_dot"

# Derivatives of functions at x, whose own derivative is d and whose value is f. They are of `math`, of which users'
# laws use more than the packaged laws, and of elementary functions, whose steps are not differentiated.
RULES = {
    "sqrt": "0.5 * d / f", "fabs": "d if x >= 0.0 else -d", "fraction": "d", "rounded_down": "0.0 * d",
    "sin": "cos(x) * d", "cos": "-sin(x) * d", "tan": "(1.0 + f * f) * d", "exp": "f * d",
    "log": "d / x", "atan": "d / (1.0 + x * x)", "tanh": "(1.0 - f * f) * d",
    "exponential": "f * d", "exponential_minus_one": "(f + 1.0) * d", "logarithm": "d / x",
    "logarithm_one_plus": "d / (1.0 + x)", "arctangent": "d / (1.0 + x * x)",
    "arctangent_integral": "arctangent(x) * d"}
TURNED = "sine_of_turns"
PAIR = "sine_cosine"   # has two values, each the other's derivative except for a sign

# Methods that store constants, whose derivative is 0, and so are called unchanged.
KEEPING = ("Track__enter",)

Dual = tuple[Expr, Expr | None]   # a number and its derivative, None where that is zero whatever the direction
ZERO = Const(0.0, FLOAT)


def zeros(values: tuple[Any, ...]) -> tuple[Any, ...]:
    """Derivatives of the constants in a list, or in a list of lists."""
    return tuple(zeros(each) if isinstance(each, tuple) else 0.0 for each in values)


def dual(name: str) -> str:
    """Name of the derivative's share of a name."""
    return name + SUFFIX


class Derivatives:
    """The differentiated functions of a program, each made once; `functions` has those that rules call, by name."""

    def __init__(self, functions: dict[str, Function]):
        self.rules = functions
        self.made: dict[int, Function] = {}

    def of(self, function: Function) -> Function:
        """The function that does the same, with a derivative next to each number."""
        if id(function) not in self.made:
            self.made[id(function)] = made = replace(
                function, name=dual(function.name), parameters=list(spread(function.parameters)), body=[], calls=[],
                results=tuple(part for kind in function.results for part in [kind, kind][:1 + (kind == FLOAT)]),
                locals=dict(spread([*function.locals.items()])), sites=list(function.sites),
                changed={part for name in function.changed for part in (name, dual(name))})
            Differentiated(self, function, made)
            made.fails = bool(made.sites) or any(called.fails for called in made.calls)
        return self.made[id(function)]


def varies(kind: Type | None) -> bool:
    """Return True if values of a type have a derivative next to them."""
    return kind == FLOAT or isinstance(kind, Struct) or (isinstance(kind, List) and kind.item is not None
                                                         and varies(kind.item))


def spread(names: Sequence[tuple[str, Type]]) -> "list[tuple[str, Type]]":
    """Names with their types, each followed by the name of its derivative if it has one."""
    return [part for name, kind in names for part in [(name, kind), (dual(name), kind)][:2 if varies(kind) else 1]]


class Differentiated:
    """The state of differentiating one function."""

    def __init__(self, derivatives: Derivatives, function: Function, made: Function):
        self.derivatives = derivatives
        self.function = function
        self.made = made
        self.body = made.body
        self.temporaries = 0
        self.block(function.body, made.body)

    def unknown(self, what: str) -> Untranslatable:
        return Untranslatable(f"{self.function.file}, line {self.function.line}: no derivative of {what} in "
                              f"{self.function.source.__name__}")

    def new_local(self, kind: Type) -> Local:
        while True:
            self.temporaries += 1
            name = f"value_{self.temporaries}"
            if name not in self.made.locals:
                self.made.locals[name] = kind
                return Local(name, kind)

    def temporary(self, value: Expr) -> Expr:
        if isinstance(value, Local | Const):
            return value
        local = self.new_local(value.type)
        self.body.append(Assign(local, value))
        return local

    def called(self, function: Function) -> Function:
        if function not in self.made.calls:
            self.made.calls.append(function)
        return function

    # Statements

    def block(self, statements: Sequence[Statement], body: list[Statement]) -> None:
        before, self.body = self.body, body
        for statement in statements:
            self.statement(statement)
        self.body = before

    def inner(self, statements: Sequence[Statement]) -> list[Statement]:
        body: list[Statement] = []
        self.block(statements, body)
        return body

    def statement(self, statement: Statement) -> None:
        """Add a statement and its derivative."""
        match statement:
            case Assign(target=target, value=value):
                self.assign(target, value)
            case Perform(call=call, targets=targets):
                self.perform(call, targets)
            case If(test=test, yes=yes, no=no):
                condition = self.plain(test)
                self.body.append(If(condition, self.inner(yes), self.inner(no)))
            case While(test=test, body=body):
                before, self.body = self.body, []
                condition = self.plain(test)
                head, self.body = self.body, before
                inside = self.inner(body)
                if head:
                    stop = If(Operation("not", (condition,), BOOL), [Jump("break")], [])
                    condition, inside = Const(True, BOOL), [*head, stop, *inside]
                self.body.append(While(condition, inside))
            case For(name=name, start=start, stop=stop, step=step, body=body):
                self.body.append(For(name, self.plain(start), self.plain(stop), step, self.inner(body)))
            case Return(values=values):
                self.body.append(Return(tuple(part for value in values for part in self.pair(value))))
            case Jump():
                self.body.append(statement)

    def assign(self, target: Expr, value: Expr) -> None:
        """Add an assignment: the derivative first, because it may need the old value."""
        if target.type == FLOAT:
            result, slope = self.number(value)
            self.body += [Assign(self.along(target), slope or ZERO), Assign(self.plain(target), result)]
        elif varies(target.type):
            self.body += [Assign(self.plain(target), self.plain(value)), Assign(self.along(target), self.along(value))]
        else:
            self.body.append(Assign(self.plain(target), self.plain(value)))

    def perform(self, call: Call, targets: Sequence[Expr]) -> None:
        function = call.function
        name = function.source.__name__
        if function.name in KEEPING:
            arguments = tuple(map(self.plain, call.arguments))
            self.body.append(Perform(Call(self.called(function), arguments), tuple(map(self.plain, targets))))
        elif name == PAIR:
            value, slope = self.number(call.arguments[0])
            sine, cosine = self.new_local(FLOAT), self.new_local(FLOAT)
            if slope is not None:
                slope = self.temporary(slope)
            self.body.append(Perform(Call(self.called(function), (value,)), (sine, cosine)))
            slope = slope or ZERO
            for target, result, rate in ((targets[0], sine, times(cosine, slope)),
                                         (targets[1], cosine, times(Operation("neg", (sine,), FLOAT), slope))):
                self.body += [Assign(self.plain(target), result), Assign(self.along(target), rate)]
        else:
            made, arguments = self.differentiated(call)
            places = tuple(part for target in targets for part in (
                (self.plain(target), self.along(target)) if varies(target.type) else (self.plain(target),)))
            self.body.append(Perform(Call(made, arguments), places))

    def differentiated(self, call: Call) -> tuple[Function, tuple[Expr, ...]]:
        """The differentiated function of a call, and its arguments."""
        arguments = tuple(part for value in call.arguments for part in self.pair(value))
        return self.called(self.derivatives.of(call.function)), arguments

    # Values without a derivative, or where it is

    def along(self, place: Expr) -> Expr:
        """Return the place of the derivative of the value at a place."""
        match place:
            case Local(name=name, type=kind):
                return Local(dual(name), kind)
            case Field(base=base):
                return replace(place, base=self.along(base))
            case Item(base=base, index=index):
                return replace(place, base=self.along(base), index=self.plain(index))
            case Choice(test=test, yes=yes, no=no):
                return replace(place, test=self.plain(test), yes=self.along(yes), no=self.along(no))
            case ConstList(name=name, values=values):
                return replace(place, name=dual(name), values=zeros(values))
        raise self.unknown("a list that changes")

    def aside(self, value: Expr) -> tuple[list[Statement], Expr]:
        before, self.body = self.body, []
        plain = self.plain(value)
        own, self.body = self.body, before
        return own, plain

    def plain(self, value: Expr) -> Expr:
        """A value without a derivative; calls that change something have theirs computed all the same."""
        match value:
            case Call() if writes(value):
                made, arguments = self.differentiated(value)
                names = tuple(map(self.new_local, made.results))
                self.body.append(Perform(Call(made, arguments), names))
                return names[0]
            case Call(function=function, arguments=arguments):
                return Call(self.called(function), tuple(map(self.plain, arguments)))
            case Field(base=base):
                return replace(value, base=self.plain(base))
            case Item(base=base, index=index):
                return replace(value, base=self.plain(base), index=self.plain(index))
            case Operation(operands=operands):
                return replace(value, operands=tuple(map(self.plain, operands)))
            case Choice(test=test, yes=yes, no=no):
                return replace(value, test=self.plain(test), yes=self.plain(yes), no=self.plain(no))
            case Logic(name=name, operands=operands):
                return self.logic(name, operands)
        return value

    def logic(self, name: str, operands: Sequence[Expr]) -> Expr:
        parts = [self.plain(operands[0])]
        for number, operand in enumerate(operands[1:], 1):
            own, part = self.aside(operand)
            if own:
                result = self.new_local(BOOL)
                self.body.append(Assign(result, parts[0] if len(parts) == 1 else Logic(name, tuple(parts))))
                before, self.body = self.body, own
                rest = operands[number + 1:]
                self.body.append(Assign(result, self.logic(name, [part, *rest]) if rest else part))
                own, self.body = self.body, before
                self.body.append(If(result if name == "and" else Operation("not", (result,), BOOL), own, []))
                return result
            parts.append(part)
        return Logic(name, tuple(parts))

    def pair(self, value: Expr) -> tuple[Expr, ...]:
        """A value, and its derivative if it has one."""
        if value.type == FLOAT:
            result, slope = self.number(value)
            return result, slope or ZERO
        return (self.plain(value), self.along(value)) if varies(value.type) else (self.plain(value),)

    # Numbers and their derivatives

    def number(self, value: Expr) -> Dual:
        """A number and its derivative."""
        match value:
            case Const():
                return value, None
            case Local() | Field() | Item():
                return self.plain(value), self.along(value)
            case Choice(test=test, yes=yes, no=no):
                return self.choice(test, yes, no)
            case Call():
                return self.call(value)
            case Operation():
                return self.operation(value)
        raise self.unknown(f"a {type(value).__name__}")

    def choice(self, test: Expr, yes: Expr, no: Expr) -> Dual:
        condition = self.temporary(self.plain(test))
        before, sides = self.body, []
        for each in (yes, no):
            self.body = []
            sides.append((*self.number(each), self.body))
        self.body = before
        (a, a_dot, first), (b, b_dot, second) = sides
        if not first and not second:
            return Choice(condition, a, b, FLOAT), Choice(condition, a_dot or ZERO, b_dot or ZERO, FLOAT)
        result, slope = self.new_local(FLOAT), self.new_local(FLOAT)
        self.body.append(If(condition, [*first, Assign(result, a), Assign(slope, a_dot or ZERO)],
                            [*second, Assign(result, b), Assign(slope, b_dot or ZERO)]))
        return result, slope

    def short(self, value: Expr) -> Dual:
        """A number and its derivative; anything longer than a name is computed before, as the rule needs it twice."""
        result, slope = self.number(value)
        if slope is None or isinstance(value, Local | Field | Item):
            return result, slope
        return self.temporary(result), self.temporary(slope)

    def call(self, call: Call) -> Dual:
        function = call.function
        name = function.source.__name__
        if name == TURNED:
            value, slope = self.short(call.arguments[0])
            turned = self.called(function)
            if slope is None:
                return Call(turned, (value,)), None
            quarter = Call(turned, (Operation("+", (value, Const(0.25, FLOAT)), FLOAT),))
            return Call(turned, (value,)), times(Operation("*", (Const(2.0 * pi, FLOAT), quarter), FLOAT), slope)
        if name in RULES:
            value, slope = self.short(call.arguments[0])
            return self.by_rule(name, Call(self.called(function), (value,)), value, slope)
        made, arguments = self.differentiated(call)
        names = tuple(map(self.new_local, made.results))
        self.body.append(Perform(Call(made, arguments), names))
        return names[0], names[1]

    def by_rule(self, name: str, result: Expr, value: Expr, slope: Expr | None) -> Dual:
        if slope is None:
            return result, None
        rule = parsed_expression(RULES[name])
        if any(isinstance(each, ast.Name) and each.id == "f" for each in ast.walk(rule)):
            result = self.temporary(result)
        return result, self.ruled(rule, {"x": value, "d": slope, "f": result})

    def ruled(self, node: ast.expr, names: dict[str, Expr]) -> Expr:
        """An expression of the table of rules."""
        match node:
            case ast.Constant(value=value):
                return Const(value, FLOAT)
            case ast.Name(id=name):
                return names[name]
            case ast.UnaryOp(operand=operand):
                return Operation("neg", (self.ruled(operand, names),), FLOAT)
            case ast.BinOp(left=left, op=op, right=right):
                sign = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}[type(op)]
                return Operation(sign, (self.ruled(left, names), self.ruled(right, names)), FLOAT)
            case ast.IfExp(test=ast.Compare(left=left, comparators=[right]), body=yes, orelse=no):
                test = Operation(">=", (self.ruled(left, names), self.ruled(right, names)), BOOL)
                return Choice(test, self.ruled(yes, names), self.ruled(no, names), FLOAT)
            case ast.Call(func=ast.Name(id=name), args=[argument]):
                inner = self.ruled(argument, names)
                other = self.derivatives.rules.get(name)
                return Operation(name, (inner,), FLOAT) if other is None else Call(self.called(other), (inner,))
        raise self.unknown(ast.unparse(node))

    def operation(self, value: Operation) -> Dual:
        """Sum, difference, product, quotient, or a function of `math`."""
        name, operands = value.name, value.operands
        if name == "float":
            return self.plain(value), None
        if name == "neg":
            a, a_dot = self.number(operands[0])
            return negative(a), a_dot and negative(a_dot)
        if name in ("+", "-"):
            (a, a_dot), (b, b_dot) = map(self.number, operands)
            slope = Operation(name, (a_dot, b_dot), FLOAT) if a_dot and b_dot else a_dot or (
                b_dot and (negative(b_dot) if name == "-" else b_dot))
            return replace(value, operands=(a, b)), slope
        if name == "*":
            (a, a_dot), (b, b_dot) = map(self.short, operands)
            terms = [times(*factors) for factors in ((a_dot, b), (a, b_dot)) if None not in factors]
            slope = Operation("+", (terms[0], terms[1]), FLOAT) if len(terms) == 2 else terms[0] if terms else None
            return replace(value, operands=(a, b)), slope
        if name == "/":
            (a, a_dot), (b, b_dot) = map(self.short, operands)
            result = replace(value, operands=(a, b))
            if b_dot is None:
                return result, a_dot and replace(value, operands=(a_dot, b))
            change = times(result, b_dot)
            above = Operation("-", (a_dot, change), FLOAT) if a_dot else negative(change)
            return result, replace(value, operands=(above, b))
        if name in ("min", "max"):
            (a, a_dot), (b, b_dot) = map(self.short, operands)
            test = Operation("<" if name == "min" else ">", (b, a), BOOL)
            return replace(value, operands=(a, b)), Choice(test, b_dot or ZERO, a_dot or ZERO, FLOAT)
        if name in RULES:
            inner, slope = self.short(operands[0])
            return self.by_rule(name, replace(value, operands=(inner,)), inner, slope)
        slopes = [self.number(each)[1] for each in operands]
        if any(slope is not None for slope in slopes):
            raise self.unknown(f"{name}()")
        return self.plain(value), None


def times(a: Expr, b: Expr) -> Expr:
    return Operation("*", (a, b), FLOAT)


def negative(value: Expr) -> Expr:
    return Operation("neg", (value,), FLOAT)
