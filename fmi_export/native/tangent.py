"""Directional derivatives of a block: forward-mode differentiation of its Python, to be translated as the block is.

Every function that a method of the block calls gets a second one, with `_dot` after its name, that computes the same
and, beside each number, its derivative along a direction. The direction lies in a second block of the same class:
where a block has the number `own.y.position`, `own_dot.y.position` is its derivative. Each operation is differentiated
by its rule, so that the result is exact but for rounding; at a kink it is that of the branch that is taken.
"""

import ast
from collections.abc import Iterable, Mapping
from graphlib import TopologicalSorter
from math import pi
from typing import NamedTuple

from fmi_export.errors import ExportError

SUFFIX = "_dot"


def tangent_name(module: str) -> str:
    """Name of the module with the derivatives of a block, by that of the block's module."""
    return f"{module}_tangent"


# Derivative of a function at x, whose own is d and whose value there is f: of `math`, of which users' laws have more
# than ours, and elementary ones, whose steps are not those of a derivative.
RULES = {
    "sqrt": "0.5 * {d} / {f}", "fabs": "({d} if {x} >= 0.0 else -{d})", "fraction": "{d}",
    "sin": "cos({x}) * {d}", "cos": "-sin({x}) * {d}", "tan": "(1.0 + {f} * {f}) * {d}", "exp": "{f} * {d}",
    "log": "{d} / {x}", "atan": "{d} / (1.0 + {x} * {x})", "tanh": "(1.0 - {f} * {f}) * {d}",
    "exponential": "{f} * {d}", "exponential_minus_one": "({f} + 1.0) * {d}", "logarithm": "{d} / {x}",
    "logarithm_one_plus": "{d} / (1.0 + {x})", "arctangent": "{d} / (1.0 + {x} * {x})",
    "arctangent_integral": "arctangent({x}) * {d}",
    "sine_of_turns": f"{2.0 * pi!r} * sine_of_turns({{x}} + 0.25) * {{d}}"}
PAIR = "sine_cosine"   # has two values, each the other's derivative but for a sign


# Methods that keep what does not change along a direction, and so are called as they are.
KEEPING = ("Roughness.enter",)


class Blocks:
    """Classes, functions and constants of modules, by their names, which are unique."""

    def __init__(self, texts: Mapping[str, str]):
        self.module: dict[str, str] = {}
        self.functions: dict[str, ast.FunctionDef] = {}   # a method as Class.method
        self.attributes: dict[str, dict[str, str]] = {}   # types of a class's attributes
        self.constants: dict[str, str] = {}               # their types
        for name, text in texts.items():
            for node in ast.parse(text).body:
                if isinstance(node, ast.FunctionDef):
                    self.functions[node.name] = node
                    self.module[node.name] = name
                elif isinstance(node, ast.ClassDef):
                    self.add_class(node)
                    self.module[node.name] = name
                elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name):
                    self.constants[node.targets[0].id] = assigned(node.value, {})
                    self.module[node.targets[0].id] = name

    def add_class(self, node: ast.ClassDef) -> None:
        """Take in the methods of a class, and its attributes from what its constructor assigns."""
        self.attributes[node.name] = {}
        for method in (each for each in node.body if isinstance(each, ast.FunctionDef)):
            self.functions[f"{node.name}.{method.name}"] = method
            if method.name == "__init__":
                given = {each.arg: annotated(each.annotation) for each in method.args.args}
                for line in (each for each in method.body if isinstance(each, ast.Assign)):
                    for target in line.targets:
                        if isinstance(target, ast.Attribute) and isinstance(target.value, ast.Name):
                            self.attributes[node.name][target.attr] = assigned(line.value, given)


def annotated(node: ast.expr | None) -> str:
    """Type that an annotation says: float, bool, int, None, a class, or several in a tuple, with commas."""
    if isinstance(node, ast.Subscript) and isinstance(node.slice, ast.Tuple):
        return ",".join(annotated(each) for each in node.slice.elts)
    return ast.unparse(node) if node is not None else "None"


def assigned(value: ast.expr, given: Mapping[str, str]) -> str:
    """Type of a value in a constructor, whose parameters have types."""
    if isinstance(value, ast.Constant):
        return type(value.value).__name__
    if isinstance(value, ast.Name):
        return given.get(value.id, "float")
    if isinstance(value, ast.Call) and isinstance(value.func, ast.Name) and value.func.id[0].isupper():
        return value.func.id
    return "float"


def tangent_module(texts: Mapping[str, str], class_name: str, method: str) -> str:
    """Text of a module with the function `Class_method_dot(own, own_dot)`, and all that it calls.

    `texts` are, by dotted name, those of the modules that the class and what it uses are in. ExportError if there is
    something in it that is not known here.
    """
    blocks = Blocks(texts)
    waiting, written, calls = [f"{class_name}.{method}"], dict[str, str](), dict[str, list[str]]()
    functions, names = set[str](), set[str]()
    while waiting:
        key = waiting.pop()
        if key not in written:
            found = Differentiated(blocks, key)
            written[key] = found.text
            calls[key] = sorted(set(found.called))
            waiting.extend(found.called)
            functions |= found.math
            names |= found.names
    lines = ['"""Derivatives along a direction. Generated."""', ""]
    if functions:
        lines.append(f"from math import {', '.join(sorted(functions))}")
    callees_first = TopologicalSorter(dict(sorted(calls.items()))).static_order()
    of_module: dict[str, list[str]] = {}
    for name in sorted(names):
        of_module.setdefault(blocks.module[name], []).append(name)
    lines += [f"from {module} import {', '.join(members)}" for module, members in sorted(of_module.items())]
    return "\n".join([*lines, *(f"\n\n{written[key]}" for key in callees_first)]) + "\n"


def named(key: str) -> str:
    """Name of the differentiated function of one."""
    return key.replace(".", "_") + SUFFIX


class Value(NamedTuple):
    """An expression, its derivative, empty where that is zero whatever the direction, and its type."""

    text: str
    dot: str
    kind: str


class Differentiated:
    """A function or method and its derivative, as the text of one function."""

    def __init__(self, blocks: Blocks, key: str):
        self.blocks = blocks
        self.key = key
        self.called: list[str] = []
        self.math: set[str] = set()
        self.names: set[str] = set()          # to import
        self.types: dict[str, str] = {}       # of parameters and local names
        self.lines: list[str] = []
        self.depth = 1
        self.temporaries = 0
        if key not in blocks.functions:
            raise ExportError(f"{key} has no derivative, expected a function of the block's modules")
        self.node = blocks.functions[key]
        parameters = []
        for argument in self.node.args.args:
            own = argument.arg == "self"
            name = "own" if own else argument.arg
            kind = self.types[argument.arg] = key.partition(".")[0] if own else annotated(argument.annotation)
            parameters.append(f"{name}: {self.imported(kind)}")
            if self.varies(kind):
                parameters.append(f"{name}{SUFFIX}: {kind}")
        for statement in self.node.body:
            self.statement(statement)
        kinds = [part for kind in annotated(self.node.returns).split(",")
                 for part in ([kind, kind] if kind == "float" else [kind])]
        result = kinds[0] if len(kinds) == 1 else f"tuple[{', '.join(kinds)}]"
        body = self.lines or ["    pass"]
        self.text = "\n".join([f"def {named(key)}({', '.join(parameters)}) -> {result}:", *body])

    def unknown(self, node: ast.AST) -> ExportError:
        return ExportError(f"{self.key}: no derivative of {ast.unparse(node)!r}")

    def varies(self, kind: str) -> bool:
        """Whether a type has a derivative: a number, or an object with numbers."""
        return kind == "float" or kind in self.blocks.attributes

    def imported(self, kind: str) -> str:
        """A type, which is imported if it is a class."""
        if kind in self.blocks.attributes:
            self.names.add(kind)
        return kind

    def emit(self, line: str) -> None:
        self.lines.append("    " * self.depth + line)

    def statement(self, node: ast.stmt) -> None:
        """Add a statement, and what differentiates it."""
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Constant):
            return
        if isinstance(node, ast.Expr) and isinstance(node.value, ast.Call):
            keeping = self.callee(node.value) in KEEPING
            self.emit(self.undifferentiated(node.value) if keeping else self.call(node.value)[0])
        elif isinstance(node, ast.AugAssign):
            self.assign(node.target, ast.BinOp(ast.parse(ast.unparse(node.target), mode="eval").body, node.op,
                                               node.value))
        elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Tuple):
            if not isinstance(node.value, ast.Call):
                raise self.unknown(node)
            if isinstance(node.value.func, ast.Name) and node.value.func.id == PAIR:
                text, kinds = self.turned(node.value), "float,float"
            else:
                text, kinds = self.call(node.value)
            targets = [part for target, kind in zip(node.targets[0].elts, kinds.split(","), strict=True)
                       for part in self.places(target, kind)]
            self.emit(f"{', '.join(targets)} = {text}")
        elif isinstance(node, ast.Assign):
            self.assign(node.targets[0], node.value)
        elif isinstance(node, ast.If):
            self.emit(f"if {self.value(node.test).text}:")
            self.block(node.body)
            if node.orelse:
                self.emit("else:")
                self.block(node.orelse)
        elif isinstance(node, ast.For) and isinstance(node.target, ast.Name) and isinstance(node.iter, ast.Call):
            self.types[node.target.id] = "int"
            self.emit(f"for {node.target.id} in range({', '.join(self.value(each).text for each in node.iter.args)}):")
            self.block(node.body)
        elif isinstance(node, ast.Return):
            parts = [] if node.value is None else node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            self.emit(f"return {self.both(parts)}".rstrip())
        else:
            raise self.unknown(node)

    def block(self, body: Iterable[ast.stmt]) -> None:
        """Add the statements of a branch."""
        self.depth += 1
        for statement in body:
            self.statement(statement)
        self.depth -= 1

    def places(self, target: ast.expr, kind: str) -> list[str]:
        """Where a value of a type goes: a name or an attribute, and the same for its derivative."""
        if isinstance(target, ast.Name):
            self.types[target.id] = kind
        place = self.path(target)
        return [place, self.path(target, SUFFIX)] if self.varies(kind) else [place]

    def assign(self, target: ast.expr, node: ast.expr) -> None:
        """Add an assignment: the derivative first, which may need what is there."""
        value = self.value(node)
        self.imported(value.kind)
        place, *dot = self.places(target, value.kind)
        for each in dot:
            self.emit(f"{each} = {value.dot or '0.0'}")
        self.emit(f"{place} = {value.text}")

    def path(self, node: ast.expr, suffix: str = "") -> str:
        """A name or an attribute path, from `own` or another object, or from the one that has the derivatives."""
        if isinstance(node, ast.Attribute):
            return f"{self.path(node.value, suffix)}.{node.attr}"
        if not isinstance(node, ast.Name):
            raise self.unknown(node)
        return ("own" if node.id == "self" else node.id) + suffix

    def both(self, nodes: Iterable[ast.expr]) -> str:
        """Values in a row, each with its derivative if it is of a type that has one."""
        values = [self.value(node) for node in nodes]
        return ", ".join(part for value in values for part in (
            [value.text, value.dot or "0.0"] if self.varies(value.kind) else [value.text]))

    def kept(self, text: str, kind: str) -> Value:
        """A value under a temporary name and, if it is a number, its derivative under another one."""
        self.temporaries += 1
        name = f"part_{self.temporaries}"
        dot = f"{name}{SUFFIX}" if kind == "float" else ""
        self.emit(f"{name}{dot and f', {dot}'} = {text}")
        return Value(name, dot, kind)

    def callee(self, node: ast.Call) -> str:
        """Function of the block's modules that is called, or nothing."""
        if isinstance(node.func, ast.Attribute):
            return f"{self.value(node.func.value).kind}.{node.func.attr}"
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        return name if name in self.blocks.functions and name not in (*RULES, PAIR) else ""

    def call(self, node: ast.Call) -> tuple[str, str]:
        """Call of a differentiated function, and the type of what it returns."""
        key = self.callee(node)
        if key not in self.blocks.functions:
            raise self.unknown(node)
        self.called.append(key)
        given = [node.func.value, *node.args] if isinstance(node.func, ast.Attribute) else node.args
        return f"{named(key)}({self.both(given)})", annotated(self.blocks.functions[key].returns)

    def undifferentiated(self, node: ast.Call) -> str:
        return f"{self.path(node.func)}({', '.join(self.value(each).text for each in node.args)})"

    def value(self, node: ast.expr) -> Value:
        """An expression; what of it is computed before is added."""
        if isinstance(node, ast.Constant):
            return Value(repr(node.value), "", type(node.value).__name__)
        if isinstance(node, ast.Name) and node.id not in self.types:
            (self.names if node.id in self.blocks.constants else self.math).add(node.id)
            return Value(node.id, "", self.blocks.constants.get(node.id, "float"))
        if isinstance(node, (ast.Name, ast.Attribute)):
            known, name = (self.types, node.id) if isinstance(node, ast.Name) else (
                self.blocks.attributes.get(self.value(node.value).kind, {}), node.attr)
            if name not in known:
                raise self.unknown(node)
            kind = known[name]
            return Value(self.path(node), self.path(node, SUFFIX) if self.varies(kind) else "", kind)
        if isinstance(node, ast.BoolOp):
            word = " and " if isinstance(node.op, ast.And) else " or "
            return Value(f"({word.join(self.value(each).text for each in node.values)})", "", "bool")
        if isinstance(node, ast.Compare):
            parts = [self.value(node.left).text]
            for operator, other in zip(node.ops, node.comparators, strict=True):
                parts += [ast.unparse(ast.Compare(ast.Name("a"), [operator], [ast.Name("b")]))[2:-2],
                          self.value(other).text]
            return Value(" ".join(parts), "", "bool")
        if isinstance(node, ast.UnaryOp):
            text, dot, kind = self.value(node.operand)
            return Value(f"(not {text})", "", "bool") if isinstance(node.op, ast.Not) else Value(
                f"(-{text})", dot and f"(-{dot})", kind)
        if isinstance(node, ast.IfExp):
            yes, no, test = (self.value(each) for each in (node.body, node.orelse, node.test))
            dot = f"({yes.dot or '0.0'} if {test.text} else {no.dot or '0.0'})" if self.varies(yes.kind) else ""
            return Value(f"({yes.text} if {test.text} else {no.text})", dot, yes.kind)
        if isinstance(node, ast.Call):
            return self.function(node)
        if isinstance(node, ast.BinOp):
            return self.operation(node)
        raise self.unknown(node)

    def short(self, node: ast.expr) -> Value:
        """A number; what is more than a name is computed before, as the rule needs it twice."""
        value = self.value(node)
        if value.dot and not isinstance(node, (ast.Name, ast.Attribute)) and not value.text.startswith("part_"):
            return self.kept(f"{value.text}, {value.dot}", "float")
        return value

    def function(self, node: ast.Call) -> Value:
        """Call of a function of the block's modules, or of one that has a rule."""
        if self.callee(node):
            text, kind = self.call(node)
            if kind in self.blocks.attributes:   # nobody says where its derivatives are
                raise self.unknown(node)
            return self.kept(text, kind)
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        if name not in RULES:
            raise self.unknown(node)
        x, d, _ = self.short(node.args[0])
        for other in (name, *(each for each in RULES if d and f"{each}(" in RULES[name])):
            (self.names if other in self.blocks.functions else self.math).add(other)
        if not d:
            return Value(f"{name}({x})", "", "float")
        found = self.kept(f"{name}({x})", "").text if "{f}" in RULES[name] else f"{name}({x})"
        return Value(found, f"({RULES[name].format(x=x, d=d, f=found)})", "float")

    def turned(self, node: ast.Call) -> str:
        """Sine and cosine of an angle, each with its derivative."""
        angle, by, _ = self.short(node.args[0])
        self.names.add(PAIR)
        self.temporaries += 1
        sine, cosine = (f"part_{self.temporaries}_{name}" for name in ("sine", "cosine"))
        self.emit(f"{sine}, {cosine} = {PAIR}({angle})")
        return f"{sine}, {cosine} * {by or '0.0'}, {cosine}, -{sine} * {by or '0.0'}"

    def operation(self, node: ast.BinOp) -> Value:
        """Sum, difference, product or quotient."""
        linear = isinstance(node.op, (ast.Add, ast.Sub))
        (a, a_dot, kind), (b, b_dot, other) = (self.value(each) if linear else self.short(each)
                                               for each in (node.left, node.right))
        if isinstance(node.op, ast.Mult):
            terms = [*([f"{a_dot} * {b}"] if a_dot else ()), *([f"{a} * {b_dot}"] if b_dot else ())]
            text, dot = f"({a} * {b})", f"({' + '.join(terms)})" if terms else ""
        elif isinstance(node.op, ast.Div):
            above = a_dot if not b_dot else f"({a_dot} - {a} / {b} * {b_dot})" if a_dot else f"(-{a} / {b} * {b_dot})"
            text, dot = f"({a} / {b})", above and f"({above} / {b})"
        elif linear:
            sign, alone = ("+", b_dot) if isinstance(node.op, ast.Add) else ("-", b_dot and f"(-{b_dot})")
            text, dot = f"({a} {sign} {b})", f"({a_dot} {sign} {b_dot})" if a_dot and b_dot else a_dot or alone
        else:
            raise self.unknown(node)
        return Value(text, dot, "int" if kind == other == "int" else "float")
