"""Functions of a typed program as Python, which run on two blocks: one with values, one with a direction."""

from collections.abc import Callable, Sequence
from typing import Any

from maglev.language.program import (
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
    Local,
    Logic,
    Operation,
    Perform,
    Return,
    Statement,
    While,
    functions_of,
)

SIGNS = {"+", "-", "*", "/", "//", "%", "<<", ">>", "&", "|", "^", "<", "<=", ">", ">=", "==", "!="}
NAMED = {"trunc": "int", "copysign": "copysign"}


def executable(root: Function, made: set[int]) -> Callable[..., Any]:
    """The function in Python, with those that it calls; of the identities in `made` as text, others as they stand."""
    names: dict[str, Any] = {}
    lines = ["from math import *"]
    for function in functions_of([root]):
        if id(function) in made:
            lines += python_lines(function)
        else:
            names[function.name] = function.source
    exec("\n".join(lines), names)
    found: Callable[..., Any] = names[root.name]
    return found


def python_lines(function: Function) -> list[str]:
    parameters = ", ".join(name for name, _ in function.parameters)
    return [f"def {function.name}({parameters}):", *block(function.body, 1)]


def block(body: Sequence[Statement], depth: int) -> list[str]:
    return [f"{'    ' * depth}{line}" for line in ["pass"] if not body] + [
        line for statement in body for line in statement_lines(statement, depth)]


def statement_lines(statement: Statement, depth: int) -> list[str]:
    pad = "    " * depth
    match statement:
        case Assign(target=target, value=value):
            return [f"{pad}{text(target)} = {text(value)}"]
        case Perform(call=call, targets=targets):
            places = ", ".join(map(text, targets))
            return [f"{pad}{places} = {text(call)}" if places else f"{pad}{text(call)}"]
        case If(test=test, yes=yes, no=no):
            return [f"{pad}if {text(test)}:", *block(yes, depth + 1),
                    *([f"{pad}else:", *block(no, depth + 1)] if no else [])]
        case While(test=test, body=body):
            return [f"{pad}while {text(test)}:", *block(body, depth + 1)]
        case For(name=name, start=start, stop=stop, step=step, body=body):
            return [f"{pad}for {name} in range({text(start)}, {text(stop)}, {step}):", *block(body, depth + 1)]
        case Return(values=values):
            return [f"{pad}return {', '.join(map(text, values))}".rstrip()]
        case Jump(word=word):
            return [f"{pad}{word}"]


def text(value: Expr) -> str:
    """An expression, in parentheses if it has an operator."""
    match value:
        case Const(value=number):
            return f"({number!r})"
        case ConstList(values=values):
            return repr(values)
        case Local(name=name):
            return name
        case Field(base=base, name=name):
            return f"{text(base)}.{name}"
        case Item(base=base, index=index):
            return f"{text(base)}[{text(index)}]"
        case Logic(name=name, operands=operands):
            return f"({f' {name} '.join(map(text, operands))})"
        case Choice(test=test, yes=yes, no=no):
            return f"({text(yes)} if {text(test)} else {text(no)})"
        case Call(function=function, arguments=arguments):
            return f"{function.name}({', '.join(map(text, arguments))})"
    return operation(value)


def operation(value: Operation) -> str:
    parts = [text(each) for each in value.operands]
    if value.name in SIGNS:
        return f"({parts[0]} {value.name} {parts[1]})"
    if value.name in ("and", "or"):
        return f"({parts[0]} {'&' if value.name == 'and' else '|'} {parts[1]})"
    if value.name in ("not", "neg", "~"):
        return f"({dict(neg='-', **{'not': 'not ', '~': '~'})[value.name]}{parts[0]})"
    return f"{NAMED.get(value.name, value.name)}({', '.join(parts)})"
