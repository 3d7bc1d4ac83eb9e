"""What of Python a native FMU can have: the line of a user's file that does not keep to it, in one message."""

import ast
from collections.abc import Iterable, Iterator
from graphlib import CycleError, TopologicalSorter

from fmi_export.sources import parsed
from fmi_export.user_classes.declaration import TABLES
from fmi_export.user_classes.trouble import OWN
from maglev.packages import OURS, PACKAGES

# Syntax that pyccel does not know, or for which its C needs a library; and what to write in its place.
SYNTAX: dict[type[ast.AST], str] = {
    ast.Raise: "raise: expected a value that says so", ast.Try: "try: expected an if before it can fail",
    ast.With: "with: expected numbers only", ast.Assert: "assert: expected an if", ast.Lambda: "lambda: expected a def",
    ast.Yield: "yield: expected a return", ast.YieldFrom: "yield: expected a return", ast.Dict: "a dict: expected "
    "attributes", ast.List: "a list: expected attributes, one for each number", ast.Set: "a set: expected attributes",
    ast.ListComp: "a list: expected attributes, one for each number", ast.DictComp: "a dict: expected attributes",
    ast.SetComp: "a set: expected attributes", ast.GeneratorExp: "a generator: expected a for",
    ast.JoinedStr: "text: expected numbers only", ast.Subscript: "[…]: expected attributes, one for each number",
    ast.AsyncFunctionDef: "async: expected a def", ast.Global: "global: expected an attribute",
    ast.Nonlocal: "nonlocal: expected an attribute", ast.Starred: "*: expected every value by itself",
    ast.NamedExpr: ":=: expected a line of its own",
    ast.Match: "match: expected an if", ast.Delete: "del: expected an assignment"}
OPERATORS: dict[type[ast.AST], str] = {
    ast.Pow: "**: expected a product", ast.FloorDiv: "//: expected floor of math", ast.Mod: "%: expected fmod of math",
    ast.MatMult: "@: expected sums of products"}
CALLS = {"min", "max", "abs", "round", "pow", "sum", "divmod", "dict", "list", "set", "tuple", "print", "open",
         "getattr", "setattr", "isinstance", "hasattr", "len", "zip", "enumerate", "map", "filter", "any", "all",
         "sorted", "reversed", "super", "str", "type", "vars", "complex"}


def misfits(text: str, tables: str = "") -> Iterator[tuple[int, str]]:
    """Lines, and what in each no native FMU can have; the tables of the class `tables` stay out of one."""
    tree = parsed(text)
    left_out = {line for first, last in table_lines(tree, tables) for line in range(first, last + 1)}
    # Neither documentation nor types get into C.
    silent = {id(inner) for node in ast.walk(tree) for outer in annotations(node) for inner in ast.walk(outer)}
    silent |= {id(node.body[0].value) for node in ast.walk(tree)
                     if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and node.body
                     and isinstance(node.body[0], ast.Expr)}
    for node in ast.walk(tree):
        line = getattr(node, "lineno", 0)
        if line in left_out or id(node) in silent:
            continue
        if isinstance(node, ast.Constant) and isinstance(node.value, (str, bytes)):
            yield line, "text: expected numbers only"
        elif isinstance(node, ast.Constant) and node.value is None:
            yield line, "None: expected a number, or a Boolean beside it"
        elif type(node) in SYNTAX:
            yield line, SYNTAX[type(node)]
        elif isinstance(node, (ast.BinOp, ast.AugAssign)) and type(node.op) in OPERATORS:
            yield line, OPERATORS[type(node.op)]
        elif isinstance(node, (ast.Import, ast.ImportFrom)):
            yield from import_roots(node)
        elif isinstance(node, ast.ClassDef):
            yield from of_class(node, left_out)
        elif isinstance(node, ast.FunctionDef):
            yield from of_function(node)
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in CALLS:
            yield line, f"{node.func.id}(): expected an if, or a function of math"
        elif isinstance(node, ast.Assign) and isinstance(node.value, ast.Tuple) and any(
                not isinstance(target, ast.Tuple) for target in node.targets):
            yield line, "a tuple that is kept: expected a name for each value"
        elif isinstance(node, ast.Compare):
            yield from comparison(node)


def annotations(node: ast.AST) -> Iterator[ast.AST]:
    if isinstance(node, ast.FunctionDef) and node.returns is not None:
        yield node.returns
    if isinstance(node, (ast.arg, ast.AnnAssign)) and node.annotation is not None:
        yield node.annotation


def table_lines(tree: ast.Module, name: str | None) -> list[tuple[int, int]]:
    """First and last lines of the tables of a class; of all without a name."""
    return [(node.lineno, node.end_lineno or node.lineno) for statement in tree.body
            if isinstance(statement, ast.ClassDef) and name in (None, statement.name) for node in statement.body
            if isinstance(node, (ast.Assign, ast.AnnAssign))
            and any(isinstance(target, ast.Name) and target.id in TABLES
                    for target in (node.targets if isinstance(node, ast.Assign) else [node.target]))]


def declaring_line(text: str, name: str | None, word: str) -> int | None:
    """Line in which a class, or any, declares a port, a parameter, or a table of these; None if there is none."""
    tree = parsed(text)
    tables = table_lines(tree, name)
    words = [(node.lineno, node.value if isinstance(node, ast.Constant) else node.id)
             for node in ast.walk(tree) if isinstance(node, ast.Constant | ast.Name)]
    return next((line for line, known in words if known == word
                 and any(first <= line <= last for first, last in tables)), None)


def without_tables(text: str, name: str) -> str:
    """Text with empty lines for the tables of a class."""
    lines = text.split("\n")
    for first, last in table_lines(parsed(text), name):
        lines[first - 1:last] = [""] * (last - first + 1)
    return "\n".join(lines)


def import_roots(node: ast.Import | ast.ImportFrom) -> Iterator[tuple[int, str]]:
    modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else [node.module or ""]
    for module in modules:
        top = module.split(".")[0]
        if isinstance(node, ast.Import) and top in ("math", *OURS):
            yield node.lineno, f"import {module}: expected from {module} import ..."
        elif top not in ("math", *PACKAGES) and not top.startswith(OWN):
            yield node.lineno, f"an import of {module}: expected math, modules beside the file, or parts of ours"


def of_class(node: ast.ClassDef, left_out: set[int]) -> Iterator[tuple[int, str]]:
    """Classes that are more than attributes and methods."""
    if node.bases or node.keywords or node.decorator_list:
        yield node.lineno, f"class {node.name} with a base or a decorator: expected a plain class"
    for statement in node.body:
        if isinstance(statement, (ast.Assign, ast.AnnAssign)) and statement.lineno not in left_out:
            yield statement.lineno, "an attribute of the class: expected it in __init__, as self.…"


def of_function(node: ast.FunctionDef) -> Iterator[tuple[int, str]]:
    """Functions whose parameters have no types."""
    if node.decorator_list:
        yield node.lineno, f"decorator of {node.name}: expected none"
    for argument in node.args.args:
        if argument.arg != "self" and argument.annotation is None:
            yield argument.lineno, f"{node.name}: {argument.arg} without a type, expected one such as " \
                                   f"{argument.arg}: float"
    if node.args.vararg or node.args.kwarg:
        yield node.lineno, f"{node.name} with * or **: expected every parameter by itself"


def comparison(node: ast.Compare) -> Iterator[tuple[int, str]]:
    """A trap: pyccel takes `dt != self.dt` for a comparison of dt with itself, and leaves out what follows."""
    names = [getattr(side, "attr", getattr(side, "id", None)) for side in (node.left, *node.comparators)]
    if len({name for name in names if name}) != sum(bool(name) for name in names):
        yield node.lineno, "a comparison of two things with one last name: expected another name for one of them"


def always_ends(texts: Iterable[str]) -> bool:
    """Whether modules of the subset come to an end, whatever the values; of some that do it is not known.

    Loops go over a number of turns that is written there, and no function comes back to itself.
    """
    nodes = [node for text in texts for node in ast.walk(parsed(text))]
    classes = {node.name for node in nodes if isinstance(node, ast.ClassDef)}
    functions = {node.name for node in nodes if isinstance(node, ast.FunctionDef)}
    holding: dict[str, set[str]] = {}   # classes by the last name of what may hold an object of one
    for node in nodes:
        counted = isinstance(node, ast.For) and isinstance(node.iter, ast.Call) and last_name(
            node.iter.func) == "range" and all(isinstance(argument, ast.Constant) for argument in node.iter.args)
        if isinstance(node, ast.While | ast.For) and not counted:
            return False
        if isinstance(node, ast.arg) and node.annotation is not None:
            holding.setdefault(node.arg, set()).add(last_name(node.annotation))
        if isinstance(node, ast.Assign):
            kinds = kinds_of(node.value, classes, functions)
            for target in (inner for outer in node.targets for inner in getattr(outer, "elts", [outer])):
                holding.setdefault(last_name(target), set()).update(kinds)
    owners = {function: node.name for node in nodes if isinstance(node, ast.ClassDef) for function in node.body}
    calls: dict[tuple[str, str], set[tuple[str, str]]] = {}   # by class, if it is a method, and name
    for node in nodes:
        if isinstance(node, ast.FunctionDef):
            own = owners.get(node, "")
            calls.setdefault((own, node.name), set()).update(
                callee for inner in ast.walk(node) if isinstance(inner, ast.Call)
                for callee in called(inner.func, own, classes, holding))
    try:
        TopologicalSorter(calls).prepare()
    except CycleError:
        return False
    return True


def kinds_of(value: ast.expr, classes: set[str], functions: set[str]) -> set[str]:
    """Names of classes that a value may be of: all of a file where it does not say; what is imported knows none."""
    if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id not in functions:
        return {value.func.id}
    return classes if isinstance(value, ast.Call | ast.Name | ast.Attribute) else set()


def called(function: ast.expr, own: str, classes: set[str],
           holding: dict[str, set[str]]) -> Iterator[tuple[str, str]]:
    """What a call in a class may go to: class, if it is a method, and name."""
    name = last_name(function)
    if not isinstance(function, ast.Attribute):
        yield (name, "__init__") if name in classes else ("", name)
    elif (owner := last_name(function.value)) == "self":
        yield own, name
    else:
        yield from ((kind, name) for kind in holding.get(owner, classes))


def last_name(node: ast.expr) -> str:
    """Last name of an attribute or a variable; empty of anything else."""
    return str(getattr(node, "attr", getattr(node, "id", "")))
