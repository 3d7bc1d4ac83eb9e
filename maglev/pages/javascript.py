"""Blocks in JavaScript: parts of a controller, and the one that users begin with, of the text that C is made of."""

import ast
import io
import json
import sys
import tokenize
from collections.abc import Iterable, Iterator
from importlib.util import find_spec
from pathlib import Path

from maglev.descriptions.writer import written_class
from maglev.files.errors import ControllerError
from maglev.language.sources import parsed
from pmlsm.stage_description import StageDescription

WIDTH = 118       # of a line
INDENT = "  "
MATH = {"sin", "cos", "tan", "atan", "sqrt", "exp", "expm1", "log", "sinh", "cosh", "tanh", "floor"}
CONSTANTS = {"pi": "Math.PI", "inf": "Infinity", "nan": "NaN"}
# Operators with their precedence: an operand of lower precedence is put into parentheses.
BINARY = {ast.BitAnd: ("&", 3), ast.LShift: ("<<", 4), ast.Add: ("+", 5), ast.Sub: ("-", 5), ast.Mult: ("*", 6),
          ast.Div: ("/", 6)}
COMPARED = {ast.Lt: "<", ast.LtE: "<=", ast.Gt: ">", ast.GtE: ">=", ast.Eq: "===", ast.NotEq: "!=="}
COMPARISON, UNARY, ATOM = 4, 7, 9
NAMED = {"isfinite": "Number.isFinite", "int": "Math.trunc", "float": "Number"}


def law_text(stage: StageDescription) -> str:
    """The controller of `maglev new controller` for a stage, in JavaScript."""
    text = python_law(stage)
    head = (f"// {(ast.get_docstring(parsed(text)) or '').splitlines()[0]}\n//\n"
            "// You can change all of it, but keep the tables of ports, and a step that gives the phase\n"
            "// currents. Names that it does not define are parts of the project's controllers, in JavaScript.\n")
    return head + "\n" + module_in_javascript(text)


def parts_text(texts: Iterable[str]) -> str:
    """Return the parts that Python texts import, with their own imports, each once and after the parts it needs."""
    modules: dict[str, str] = {}

    def collect(text: str) -> None:
        for node in parsed(text).body:
            if (isinstance(node, ast.ImportFrom) and node.module and node.module not in modules
                    and node.module.split(".")[0] not in sys.stdlib_module_names):
                spec = find_spec(node.module)
                assert spec is not None and spec.origin is not None
                source = Path(spec.origin).read_text(encoding="utf-8")
                collect(source)
                modules[node.module] = module_in_javascript(source)

    for text in texts:
        collect(text)
    return "\n".join(modules.values())


def python_law(stage: StageDescription) -> str:
    """Return the Python text that a user of a stage begins with."""
    return written_class("controller", stage, "Law", "law.py")


def module_in_javascript(source: str) -> str:
    """A module in the blocks' subset of Python as JavaScript, without imports; ControllerError of anything else."""
    text = "\n".join(broken_line(line.rstrip()) for line in Writer(source).lines) + "\n"
    return text.replace("{\n\n", "{\n")


def not_of_blocks(node: ast.AST) -> ControllerError:
    """Return an error for Python that is not in the blocks' subset."""
    return ControllerError(f"{ast.unparse(node)!r} cannot be put into JavaScript, expected what blocks are made of")


def broken_line(line: str) -> str:
    """A line broken after commas where it is too long."""
    code, mark, comment = line.partition(" // ")
    if len(code) <= WIDTH or code.lstrip().startswith(("//", "/*", "*")):
        return line
    indent = code[:len(code) - len(code.lstrip())] + 2 * INDENT
    lines = []
    while len(code) > WIDTH and (place := code.rfind(", ", 0, WIDTH)) > 0:
        lines.append(code[:place + 1])
        code = indent + code[place + 2:]
    return "\n".join([*lines, code + mark + comment])


class Writer:
    """Writes the statements of a module, with their comments."""

    def __init__(self, source: str):
        self.beside: dict[int, str] = {}   # comments by line: behind a statement
        self.alone: dict[int, str] = {}    # and on a line of their own
        for token in tokenize.generate_tokens(io.StringIO(source).readline):
            if token.type == tokenize.COMMENT and "noqa" not in token.string:
                place = self.alone if token.line.strip().startswith("#") else self.beside
                place[token.start[0]] = token.string.lstrip("# ").replace("self.", "this.")
        self.locals: set[str] = set()
        self.lines = self.body(parsed(source).body[1:], 0, "")   # without the docstring

    def body(self, statements: list[ast.stmt], after: int, indent: str) -> Iterator[str]:
        """Lines of statements that follow a line of the source."""
        for statement in statements:
            for line in sorted(line for line in self.alone if after < line < statement.lineno):
                yield f"{indent}// {self.alone.pop(line)}"
            lines = [indent + line for line in self.statement(statement)]
            comment = self.beside.get(statement.end_lineno or 0)
            if lines and comment and not isinstance(statement, (ast.ClassDef, ast.FunctionDef, ast.If, ast.For)):
                lines[-1] += f" // {comment}"
            yield from lines
            after = statement.end_lineno or after

    def block(self, head: str, statements: list[ast.stmt], after: int) -> Iterator[str]:
        yield f"{head} {{"
        yield from self.body(statements, after, INDENT)
        yield "}"

    def statement(self, node: ast.stmt) -> Iterator[str]:
        match node:
            case ast.Import() | ast.ImportFrom():
                return
            case ast.Assign(targets=[ast.Tuple(elts=elements)]) if 0 < sum(
                    isinstance(each, ast.Name) for each in elements) < len(elements):
                new = [each.id for each in elements if isinstance(each, ast.Name) and each.id not in self.locals]
                self.locals.update(new)
                yield from (f"let {name};" for name in new)
                yield f"{expression(node.targets[0])} = {expression(node.value)};"
            case ast.ClassDef():
                yield from documented(node)
                yield from self.block(f"class {node.name}", undocumented(node), node.lineno)
            case ast.FunctionDef():
                yield from self.function(node)
            case ast.Assign(targets=[target]) | ast.AnnAssign(target=target) if node.value is not None:
                yield f"{self.target(target, node.col_offset)} = {expression(node.value)};"
            case ast.AugAssign():
                yield f"{expression(node.target)} {BINARY[type(node.op)][0]}= {expression(node.value)};"
            case ast.If():
                yield from self.condition(node)
            case ast.For(iter=ast.Call(func=ast.Name(id="range"), args=[count])):
                name = expression(node.target)
                head = f"for (let {name} = 0; {name} < {expression(count)}; {name}++)"
                yield from self.block(head, node.body, node.lineno)
            case ast.For(iter=source, target=ast.Name(id=name)):
                yield from self.block(f"for (const {name} of {expression(source)})", node.body, node.lineno)
            case ast.While():
                yield from self.block(f"while ({expression(node.test)})", node.body, node.lineno)
            case ast.Return(value=None):
                yield "return;"
            case ast.Return(value=value) if value is not None:
                yield f"return {expression(value)};"
            case ast.Expr(value=ast.Call() as call):
                yield f"{expression(call)};"
            case ast.Expr(value=ast.Constant()) | ast.Pass():
                return
            case _:
                raise not_of_blocks(node)

    def function(self, node: ast.FunctionDef) -> Iterator[str]:
        names = [argument.arg for argument in node.args.args]
        method = names[:1] == ["self"]
        counted = {expression(loop.target) for loop in ast.walk(node) if isinstance(loop, ast.For)}
        # A name that is first set in an if is declared at the top, others where they are set.
        top = {name for statement in node.body if isinstance(statement, ast.Assign) for name in stored(statement)}
        self.locals = set(names) | (set(stored(node)) - top)
        hoisted = sorted(self.locals - set(names) - counted)
        yield from documented(node)
        name = "constructor" if node.name == "__init__" else node.name
        head = f"{'' if method else 'function '}{name}({', '.join(names[1:] if method else names)})"
        lines = self.block(head, undocumented(node), node.lineno)
        yield next(lines)
        if hoisted:
            yield f"{INDENT}let {', '.join(hoisted)};"
        yield from lines
        self.locals = set()

    def condition(self, node: ast.If, head: str = "if") -> Iterator[str]:
        lines = [*self.block(f"{head} ({expression(node.test)})", node.body, node.lineno)]
        yield from lines[:-1]
        match node.orelse:
            case []:
                yield "}"
            case [ast.If() as other]:
                yield from self.condition(other, "} else if")
            case others:
                yield from self.block("} else", others, node.body[-1].end_lineno or node.lineno)

    def target(self, node: ast.expr, column: int) -> str:
        """Return the target of an assignment, declared if it is new."""
        names = stored(node)
        new = [name for name in names if name not in self.locals]
        self.locals.update(new)
        if not new:
            return expression(node)
        if column and isinstance(node, ast.Name) and node.id in ("inputs", "outputs", "parameters"):
            self.locals -= set(new)
            return f"static {node.id}"
        if column == 0:
            self.locals -= set(new)
            return f"const {expression(node)}"
        if len(new) < (len(node.elts) if isinstance(node, ast.Tuple) else 1):   # JavaScript declares all or none
            raise not_of_blocks(node)
        return f"let {expression(node)}"


def stored(node: ast.AST) -> list[str]:
    return [name.id for name in ast.walk(node) if isinstance(name, ast.Name) and isinstance(name.ctx, ast.Store)]


def documented(node: ast.ClassDef | ast.FunctionDef) -> Iterator[str]:
    """An empty line, and the docstring as a comment."""
    yield ""
    lines = (ast.get_docstring(node) or "").splitlines()
    if len(lines) == 1:
        yield f"/** {lines[0]} */"
    elif lines:
        yield f"/** {lines[0]}"
        yield from (f" * {line}".rstrip() for line in lines[1:])
        yield " */"


def undocumented(node: ast.ClassDef | ast.FunctionDef) -> list[ast.stmt]:
    return node.body[1:] if ast.get_docstring(node) is not None else node.body


def expression(node: ast.expr, within: int = 0) -> str:
    """Return an expression, in parentheses if it binds less closely than the one around it."""
    text, binds = expression_text(node)
    return f"({text})" if binds < within else text


def expression_text(node: ast.expr) -> tuple[str, int]:
    """Text of an expression, and how closely its outermost operator binds."""
    match node:
        case ast.Constant(value=bool() as value):
            return str(value).lower(), ATOM
        case ast.Constant(value=value):
            return json.dumps(value), ATOM
        case ast.Name(id=name):
            return CONSTANTS.get(name, "this" if name == "self" else name), ATOM
        case ast.Attribute(value=owner, attr=name):
            return f"{expression(owner, ATOM)}.{name}", ATOM
        case ast.BinOp(op=op) if type(op) in BINARY:
            sign, binds = BINARY[type(op)]
            return f"{expression(node.left, binds)} {sign} {expression(node.right, binds + 1)}", binds
        case ast.UnaryOp(op=ast.USub()):
            return f"-{expression(node.operand, UNARY)}", UNARY
        case ast.UnaryOp(op=ast.Not()):
            return f"!{expression(node.operand, UNARY)}", UNARY
        case ast.Compare():
            sides = [expression(side, COMPARISON + 1) for side in (node.left, *node.comparators)]
            pairs = [f"{left} {COMPARED[type(op)]} {right}" for left, op, right in
                     zip(sides, node.ops, sides[1:], strict=False)]
            return " && ".join(pairs), COMPARISON if len(pairs) == 1 else 2
        case ast.BoolOp(op=op):
            binds = 2 if isinstance(op, ast.And) else 1
            return (" && " if binds == 2 else " || ").join(expression(part, binds + 1) for part in node.values), binds
        case ast.IfExp():
            return f"{expression(node.test, 1)} ? {expression(node.body, 1)} : {expression(node.orelse)}", 0
        case ast.Call(func=ast.Name(id="len"), args=[argument]):
            return f"{expression(argument, ATOM)}.length", ATOM
        case ast.Call(func=ast.Name(id=name), keywords=[]):
            called = (f"Math.{name}" if name in MATH else f"new {name}" if name[0].isupper() else NAMED.get(name, name))
            return f"{called}({', '.join(map(expression, node.args))})", ATOM
        case ast.Call(func=ast.Attribute() as method, keywords=[]):
            return f"{expression(method, ATOM)}({', '.join(map(expression, node.args))})", ATOM
        case ast.Subscript(value=base, slice=index):
            return f"{expression(base, ATOM)}[{expression(index)}]", ATOM
        case ast.Tuple(elts=elements) | ast.List(elts=elements):
            return f"[{', '.join(map(expression, elements))}]", ATOM
        case ast.Dict(keys=keys, values=values):
            pairs = [f"{expression(key)}: {expression(value)}" for key, value in zip(keys, values, strict=True) if key]
            return f"{{{', '.join(pairs)}}}", ATOM
    raise not_of_blocks(node)
