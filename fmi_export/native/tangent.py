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
    "arctangent_integral": "arctangent({x}) * {d}"}
TURNED = "sine_of_turns"
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
            kind = key.partition(".")[0] if own else annotated(argument.annotation)
            self.types[name] = kind
            parameters.append(f"{name}: {self.imported(kind)}")
            if kind not in ("bool", "int"):
                parameters.append(f"{name}{SUFFIX}: {kind}")
        self.returned = annotated(self.node.returns)
        for statement in self.node.body:
            self.statement(statement)
        kinds = [part for kind in self.returned.split(",") for part in ([kind, kind] if kind == "float" else [kind])]
        result = kinds[0] if len(kinds) == 1 else f"tuple[{', '.join(kinds)}]"
        body = self.lines or ["    pass"]
        self.text = "\n".join([f"def {named(key)}({', '.join(parameters)}) -> {result}:", *body])

    def unknown(self, node: ast.AST) -> ExportError:
        return ExportError(f"{self.key}: no derivative of {ast.unparse(node)!r}")

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
                sine, cosine, derivative = self.turned(node.value)
                (s, s_dot), (c, c_dot) = (self.places(target, "float") for target in node.targets[0].elts)
                self.emit(f"{s}, {s_dot}, {c}, {c_dot} = "
                          f"{sine}, {cosine} * {derivative}, {cosine}, -{sine} * {derivative}")
                return
            text, kinds = self.call(node.value)
            targets = [part for target, kind in zip(node.targets[0].elts, kinds, strict=True)
                       for part in self.places(target, kind)]
            self.emit(f"{', '.join(targets)} = {text}")
        elif isinstance(node, ast.Assign):
            self.assign(node.targets[0], node.value)
        elif isinstance(node, ast.If):
            self.emit(f"if {self.plain(node.test)}:")
            self.block(node.body)
            if node.orelse:
                self.emit("else:")
                self.block(node.orelse)
        elif isinstance(node, ast.For) and isinstance(node.target, ast.Name) and isinstance(node.iter, ast.Call):
            self.types[node.target.id] = "int"
            self.emit(f"for {node.target.id} in range({', '.join(self.plain(each) for each in node.iter.args)}):")
            self.block(node.body)
        elif isinstance(node, ast.Return):
            parts = [] if node.value is None else node.value.elts if isinstance(node.value, ast.Tuple) else [node.value]
            found = [part for value in parts for part in self.pair(value)]
            self.emit(f"return {', '.join(found)}".rstrip())
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
        return [place] if kind in ("bool", "int") else [place, self.path(target, SUFFIX)]

    def assign(self, target: ast.expr, value: ast.expr) -> None:
        """Add an assignment: the derivative first, which may need what is there."""
        kind = self.kind(value)
        if kind == "float":
            text, derivative = self.number(value)
            derivative = derivative or "0.0"
        else:
            text = self.path(value) if self.imported(kind) in self.blocks.attributes else self.plain(value)
            derivative = self.path(value, SUFFIX) if kind in self.blocks.attributes else ""
        place = self.places(target, kind)
        if len(place) == 2:
            self.emit(f"{place[1]} = {derivative}")
        self.emit(f"{place[0]} = {text}")

    def path(self, node: ast.expr, suffix: str = "") -> str:
        """A name or an attribute path, from `own` or another object, or from the one that has the derivatives."""
        if isinstance(node, ast.Attribute):
            return f"{self.path(node.value, suffix)}.{node.attr}"
        if not isinstance(node, ast.Name):
            raise self.unknown(node)
        return ("own" if node.id == "self" else node.id) + suffix

    def kind(self, node: ast.expr) -> str:
        if isinstance(node, ast.Constant):
            return type(node.value).__name__
        if isinstance(node, ast.Name):
            return self.types.get("own" if node.id == "self" else node.id, self.blocks.constants.get(node.id, "float"))
        if isinstance(node, ast.Attribute):
            kinds = self.blocks.attributes.get(self.kind(node.value), {})
            if node.attr not in kinds:
                raise self.unknown(node)
            return kinds[node.attr]
        if isinstance(node, ast.Call):
            return annotated(self.function_of(node).returns) if self.callee(node) else "float"
        if isinstance(node, (ast.Compare, ast.BoolOp)) or isinstance(getattr(node, "op", None), ast.Not):
            return "bool"
        if isinstance(node, ast.UnaryOp):
            return self.kind(node.operand)
        if isinstance(node, ast.BinOp):
            return "int" if self.kind(node.left) == self.kind(node.right) == "int" else "float"
        return self.kind(node.body) if isinstance(node, ast.IfExp) else "float"

    def pair(self, node: ast.expr) -> list[str]:
        """An expression, and its derivative if it is a number that has one."""
        if self.kind(node) != "float":
            return [self.plain(node)]
        value, derivative = self.number(node)
        return [value, derivative or "0.0"]

    def plain(self, node: ast.expr) -> str:
        """A condition, or something else without a derivative."""
        if isinstance(node, ast.BoolOp):
            word = " and " if isinstance(node.op, ast.And) else " or "
            return f"({word.join(self.plain(each) for each in node.values)})"
        if isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Not):
            return f"(not {self.plain(node.operand)})"
        if isinstance(node, ast.Compare):
            parts = [self.plain(node.left)]
            for operator, value in zip(node.ops, node.comparators, strict=True):
                parts += [ast.unparse(ast.Compare(ast.Name("a"), [operator], [ast.Name("b")]))[2:-2], self.plain(value)]
            return " ".join(parts)
        if isinstance(node, ast.Call) and self.callee(node):
            text, kinds = self.call(node)
            return self.kept(text, kinds)[0]
        return self.number(node)[0]

    def kept(self, text: str, kinds: list[str]) -> list[str]:
        """Temporary names of what a call returns."""
        self.temporaries += 1
        names = [f"part_{self.temporaries}", f"part_{self.temporaries}{SUFFIX}"][:2 if kinds == ["float"] else 1]
        self.emit(f"{', '.join(names)} = {text}")
        return names

    def callee(self, node: ast.Call) -> str:
        """Function of the block's modules that is called, or nothing."""
        if isinstance(node.func, ast.Attribute):
            return f"{self.kind(node.func.value)}.{node.func.attr}"
        name = node.func.id if isinstance(node.func, ast.Name) else ""
        return name if name in self.blocks.functions and name not in (*RULES, PAIR, TURNED) else ""

    def function_of(self, node: ast.Call) -> ast.FunctionDef:
        """The function that is called; ExportError if it is in none of the modules."""
        found = self.blocks.functions.get(self.callee(node))
        if found is None:
            raise self.unknown(node)
        return found

    def call(self, node: ast.Call) -> tuple[str, list[str]]:
        """Call of a differentiated function, and the types of what the original returns."""
        key = self.callee(node)
        self.called.append(key)
        arguments = []
        if isinstance(node.func, ast.Attribute):
            arguments += [self.path(node.func.value), self.path(node.func.value, SUFFIX)]
        for each in node.args:
            kind = self.kind(each)
            arguments += [self.path(each), self.path(each, SUFFIX)] if kind in self.blocks.attributes \
                else self.pair(each)
        return f"{named(key)}({', '.join(arguments)})", annotated(self.function_of(node).returns).split(",")

    def undifferentiated(self, node: ast.Call) -> str:
        return f"{self.path(node.func)}({', '.join(self.plain(each) for each in node.args)})"

    def number(self, node: ast.expr) -> tuple[str, str]:
        """A number and its derivative, which is empty where it is zero whatever the direction."""
        if isinstance(node, ast.Constant):
            return repr(node.value), ""
        if isinstance(node, ast.Name) and node.id not in self.types:
            if node.id in self.blocks.constants:
                self.names.add(node.id)
            else:
                self.math.add(node.id)
            return node.id, ""
        if isinstance(node, (ast.Name, ast.Attribute)):
            return self.path(node), self.path(node, SUFFIX) if self.kind(node) == "float" else ""
        if isinstance(node, ast.UnaryOp):
            value, derivative = self.number(node.operand)
            return f"(-{value})", f"(-{derivative})" if derivative else ""
        if isinstance(node, ast.IfExp):
            (yes, yes_dot), (no, no_dot) = self.number(node.body), self.number(node.orelse)
            test = self.plain(node.test)
            return f"({yes} if {test} else {no})", f"({yes_dot or '0.0'} if {test} else {no_dot or '0.0'})"
        if isinstance(node, ast.Call):
            return self.function(node)
        if isinstance(node, ast.BinOp):
            return self.operation(node)
        raise self.unknown(node)

    def short(self, node: ast.expr) -> tuple[str, str]:
        """A number and its derivative; what is more than a name is computed before, as the rule needs it twice."""
        value, derivative = self.number(node)
        if derivative and not isinstance(node, (ast.Name, ast.Attribute)):
            value, derivative = self.kept(f"{value}, {derivative}", ["float"]) if not value.startswith("part_") \
                else (value, derivative)
        return value, derivative

    def function(self, node: ast.Call) -> tuple[str, str]:
        """Call of a function of the block's modules, or of one that has a rule."""
        if self.callee(node):
            text, kinds = self.call(node)
            names = self.kept(text, kinds)
            return names[0], names[1]
        if not (isinstance(node.func, ast.Name) and node.func.id in (*RULES, TURNED)):
            raise self.unknown(node)
        if node.func.id == TURNED:
            value, derivative = self.short(node.args[0])
            self.names.add(TURNED)
            return f"{TURNED}({value})", derivative and f"({2.0 * pi!r} * {TURNED}({value} + 0.25) * {derivative})"
        name = node.func.id
        value, derivative = self.short(node.args[0])
        (self.names if name in self.blocks.functions else self.math).add(name)
        if not derivative:
            return f"{name}({value})", ""
        for other in (each for each in RULES if f"{each}(" in RULES[name]):
            (self.names if other in self.blocks.functions else self.math).add(other)
        found = self.kept(f"{name}({value})", [])[0] if "{f}" in RULES[name] else f"{name}({value})"
        return found, f"({RULES[name].format(x=value, d=derivative, f=found)})"

    def turned(self, node: ast.Call) -> tuple[str, str, str]:
        """Names of sine and cosine of an angle, and the angle's derivative."""
        value, derivative = self.short(node.args[0])
        self.names.add(PAIR)
        self.temporaries += 1
        names = f"part_{self.temporaries}_sine", f"part_{self.temporaries}_cosine"
        self.emit(f"{', '.join(names)} = {PAIR}({value})")
        return *names, derivative or "0.0"

    def operation(self, node: ast.BinOp) -> tuple[str, str]:
        """Sum, difference, product or quotient."""
        linear = isinstance(node.op, (ast.Add, ast.Sub))
        (a, a_dot), (b, b_dot) = (self.number(each) if linear else self.short(each) for each in (node.left, node.right))
        if isinstance(node.op, ast.Add):
            return f"({a} + {b})", f"({a_dot} + {b_dot})" if a_dot and b_dot else a_dot or b_dot
        if isinstance(node.op, ast.Sub):
            taken = f"(-{b_dot})" if b_dot else ""
            return f"({a} - {b})", f"({a_dot} - {b_dot})" if a_dot and b_dot else a_dot or taken
        if isinstance(node.op, ast.Mult):
            terms = [f"{a_dot} * {b}"] if a_dot else []
            terms += [f"{a} * {b_dot}"] if b_dot else []
            return f"({a} * {b})", f"({' + '.join(terms)})" if terms else ""
        if isinstance(node.op, ast.Div):
            if not b_dot:
                return f"({a} / {b})", f"({a_dot} / {b})" if a_dot else ""
            above = f"({a_dot} - {a} / {b} * {b_dot})" if a_dot else f"(-{a} / {b} * {b_dot})"
            return f"({a} / {b})", f"({above} / {b})"
        raise self.unknown(node)
