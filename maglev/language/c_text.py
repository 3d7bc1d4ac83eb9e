"""A typed program as C99: structs, static functions with the names of the Python, and the values that it starts with.

It needs <math.h>, <stdbool.h> and <stdint.h>, reserves no memory and has no variables but constants. Nothing of a
user's text gets into it but identifiers, and these only as identifiers.
"""

import re
from collections.abc import Mapping, Sequence
from math import isinf, isnan
from typing import Any

from maglev.language.constants import Place
from maglev.language.helpers import CHECKED, EXTREMES, HELPERS
from maglev.language.layout import LARGEST, Layout
from maglev.language.names import identifier
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
    Scalar,
    Statement,
    Struct,
    Type,
    While,
    functions_of,
)
from maglev.language.ranges import Ranges

SCALARS = {FLOAT: "double", INT: "int64_t", BOOL: "bool"}

# Precedence of C's operators; an operand of lower precedence gets parentheses.
UNARY, ATOM = 12, 14
BINDS = {"*": 11, "/": 11, "+": 10, "-": 10, "<<": 9, ">>": 9, "<": 8, "<=": 8, ">": 8, ">=": 8, "==": 7, "!=": 7,
         "&": 6, "^": 5, "|": 4, "and": 3, "or": 2, "?": 1}

COMPARISONS = ("==", "!=", "<", "<=", ">", ">=")


def c_literal(value: float | int | bool) -> str:
    """C literal of a number, with the same value."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, float):
        if isinf(value):
            return "INFINITY" if value > 0.0 else "-INFINITY"
        return "NAN" if isnan(value) else repr(value)
    if value == -2**63:
        return "INT64_MIN"
    return str(value) if abs(value) < 2**31 else f"INT64_C({value})"


def declared(kind: Type, name: str, constant: bool = False) -> str:
    """Declaration of a member or a variable that holds a value."""
    if isinstance(kind, List):
        assert kind.item is not None
        return declared(kind.item, f"{name}[{kind.length}]", constant)
    word = f"struct {kind.name}" if isinstance(kind, Struct) else SCALARS[kind]
    return f"{'const ' if constant else ''}{word} {name}"


def referred(kind: Type, name: str, constant: bool = False) -> str:
    """Declaration of a parameter or a local name: of objects and lists a pointer."""
    if isinstance(kind, Struct):
        return f"struct {kind.name} *{name}"
    if isinstance(kind, List):
        inner = kind.item
        assert inner is not None
        constant = constant and of_numbers(inner)   # the object behind a pointer can change
        return declared(inner, f"(*{name})" if isinstance(inner, List) else f"*{name}", constant)
    return declared(kind, name)


def of_numbers(kind: Type) -> bool:
    """Return True if values of a type are numbers or Booleans, or lists of them."""
    return isinstance(kind, Scalar) or (isinstance(kind, List) and kind.item is not None and of_numbers(kind.item))


class CText:
    """The C of functions, and of all that they call.

    `constants` has the values of attributes that never change. Those that all objects share are printed as values.
    """

    def __init__(self, layout: Layout, roots: Sequence[Function],
                 constants: Mapping[Place, Sequence[Any]] | None = None):
        self.layout = layout
        self.constant_attributes = constants or {}
        self.roots = roots
        self.functions = functions_of(list(roots))
        self.ranges = Ranges(self.functions, roots, self.constant_attributes)
        self.helpers: set[str] = set()
        self.library: set[str] = set()   # functions of <math.h>
        self.lists: dict[str, tuple[ConstList, str]] = {}   # of modules, by their text
        self.noting = {id(root) for root in roots if root.fails}   # functions with a parameter `failure`
        self.code = "\n".join(FunctionText(self, function).text() for function in self.functions)

    def structs(self) -> str:
        """Structs, each after those that it is made of."""
        return "\n".join(map(self.struct, self.layout.fields))

    def functions_text(self) -> str:
        """Constants, helpers and functions, each after those that it calls."""
        return "\n".join(filter(None, [self.constants(), self.helper_code(), self.code]))

    def struct(self, name: str) -> str:
        members = [f"    {declared(kind, identifier(part))};\n" for part, kind in self.layout.fields[name].items()
                   if filled(kind)]
        return f"struct {name} {{\n{''.join(members) or '    char nothing;' + chr(10)}}};\n"

    def constants(self) -> str:
        return "".join(f"static {declared(each.type, name, True)} = {constant_text(each.values)};\n"
                       for each, name in self.lists.values())

    def helper_code(self) -> str:
        wanted = set(self.helpers)
        if any("note_failure(" in HELPERS[name] for name in wanted):
            wanted.add("note_failure")
        return "\n".join(text for name, text in HELPERS.items() if name in wanted)

    def list_name(self, constant: ConstList) -> str:
        text = f"{constant.name} {constant.type} {constant.values!r}"
        if text not in self.lists:
            self.lists[text] = constant, f"{identifier(constant.name)}__{len(self.lists) + 1}"
        return self.lists[text][1]

    def initial(self, block: Any, name: str) -> str:
        """Definition of a constant with the values that a block has."""
        root = self.layout.root
        return (f"const struct {root.name} {name} = "
                f"{self.value_text(self.layout.value_of(block, root), root)};\n")

    def value_text(self, value: Any, kind: Type, depth: int = 1) -> str:
        if isinstance(kind, Struct):
            pad = "    " * depth
            members = [f"{pad}.{identifier(name)} = {self.value_text(value[name], part, depth + 1)},\n"
                       for name, part in self.layout.fields[kind.name].items() if filled(part)]
            return f"{{\n{''.join(members) or pad + '.nothing = 0,' + chr(10)}{'    ' * (depth - 1)}}}"
        if isinstance(kind, List):
            assert kind.item is not None
            return "{" + ", ".join(self.value_text(each, kind.item, depth + 1) for each in value) + "}"
        return c_literal(value)


def filled(kind: Type) -> bool:
    """Return True if a member of a type takes memory: a list without elements takes no memory."""
    return not isinstance(kind, List) or (kind.length > 0 and kind.item is not None and filled(kind.item))


def constant_text(values: Sequence[Any]) -> str:
    return "{" + ", ".join(constant_text(each) if isinstance(each, tuple) else c_literal(each) for each in values) + "}"


class FunctionText:
    """The C of one function."""

    def __init__(self, whole: CText, function: Function):
        self.whole = whole
        self.function = function
        self.lines: list[str] = []

    def text(self) -> str:
        function = self.function
        self.block(function.body, 1)
        body = "\n".join(self.lines)
        used = set(re.findall(r"\w+", re.sub(r"/\*.*?\*/", "", body)))
        local = [f"    {referred(kind, identifier(name), isinstance(kind, List) and name not in function.changed)};"
                 for name, kind in function.locals.items() if identifier(name) in used]
        unread = [f"    (void){identifier(name)};" for name, _ in function.parameters if identifier(name) not in used]
        unread += [f"    (void)out_{k};" for k in range(len(function.results)) if len(function.results) > 1
                   and f"out_{k}" not in used]
        if "failure" in used:
            self.whole.noting.add(id(function))
        elif id(function) in self.whole.noting:
            unread.append("    (void)failure;")
        where = re.sub(r"[^\w./ -]", "_", function.file, flags=re.ASCII)
        if len(function.results) == 1 and not isinstance(function.body[-1], Return):
            body += "\n    return 0;"   # where a failure has ended a loop that has no other end
        inside = [*local, *unread, body] if body else [*local, *unread]
        return (f"/* {where}, line {function.line} */\n{self.head()}\n{{\n"
                + "".join(f"{line}\n" for line in inside) + "}\n")

    def head(self) -> str:
        """Declaration of the function, without its semicolon."""
        function, results = self.function, self.function.results
        outs = [f"{SCALARS[kind]} *out_{k}" for k, kind in enumerate(results)] if len(results) > 1 else []   # type: ignore[index]
        parameters = [referred(kind, identifier(name), isinstance(kind, List) and name not in function.changed)
                      for name, kind in function.parameters if filled(kind)]
        failing = ["int64_t *failure"] if id(function) in self.whole.noting else []
        word = SCALARS[results[0]] if len(results) == 1 else "void"   # type: ignore[index]
        static = "static" if function in self.whole.roots else "static inline"
        return f"{static} {word} {function.name}({', '.join([*parameters, *outs, *failing]) or 'void'})"

    def out(self, depth: int, text: str) -> None:
        self.lines.append("    " * depth + text)

    def block(self, body: Sequence[Statement], depth: int) -> None:
        for statement in body:
            self.statement(statement, depth)

    def statement(self, statement: Statement, depth: int) -> None:
        match statement:
            case Assign(target=target, value=value):
                text = self.pointer(value) if isinstance(value.type, Struct) else self.expression(value)
                self.out(depth, f"{self.expression(target)} = {text};")
            case Perform(call=call, targets=targets):
                several = len(call.function.results) > 1
                outs = [f"&{self.expression(target, UNARY)}" for target in targets] if several else []
                if several and not targets:
                    outs = ["&(double){0.0}" if kind == FLOAT else f"&({SCALARS[kind]}){{0}}"  # type: ignore[index]
                            for kind in call.function.results]
                text = self.call(call, outs)
                if len(targets) == 1 == len(call.function.results):
                    text = f"{self.expression(targets[0])} = {text}"
                self.out(depth, f"{'(void)' if call.function.results and not targets and not outs else ''}{text};")
            case If(test=test, yes=yes, no=no):
                self.branch(test, yes, no, depth, "if")
            case While(test=test, body=body):
                condition = self.expression(test, BINDS["and"] if self.function.fails else 0)
                stops = "*failure == 0 && " if self.function.fails else ""
                self.out(depth, f"while ({stops}{condition if condition != 'true' or not stops else '1'}) {{")
                self.block(body, depth + 1)
                self.out(depth, "}")
            case For():
                self.loop(statement, depth)
            case Return(values=values):
                self.leave(values, depth)
            case Jump(word=word):
                self.out(depth, f"{word};")

    def branch(self, test: Expr, yes: Sequence[Statement], no: Sequence[Statement], depth: int, word: str) -> None:
        if not yes and no:
            test, yes, no = Operation("not", (test,), BOOL), no, []
        self.out(depth, f"{word} ({self.expression(test)}) {{")
        self.block(yes, depth + 1)
        if len(no) == 1 and isinstance(no[0], If):
            self.branch(no[0].test, no[0].yes, no[0].no, depth, "} else if")
            return
        if no:
            self.out(depth, "} else {")
            self.block(no, depth + 1)
        self.out(depth, "}")

    def loop(self, loop: For, depth: int) -> None:
        name = identifier(loop.name)
        sign = "<" if loop.step > 0 else ">"
        count = f"++{name}" if loop.step == 1 else f"--{name}" if loop.step == -1 else f"{name} += {loop.step}"
        stop = self.expression(loop.stop, BINDS["<"] + 1)
        if abs(loop.step) > 1 and not (isinstance(loop.stop, Const) and abs(loop.stop.value + loop.step) < LARGEST):
            self.whole.helpers.add("next_turn")
            count = f"{name} = next_turn({name}, {c_literal(loop.step)}, {stop})"
        self.out(depth, f"for (int64_t {name} = {self.expression(loop.start)}; {name} {sign} {stop}; {count}) {{")
        self.block(loop.body, depth + 1)
        self.out(depth, "}")

    def leave(self, values: Sequence[Expr], depth: int) -> None:
        if len(values) == 1:
            self.out(depth, f"return {self.expression(values[0])};")
            return
        names = []
        for k, value in enumerate(values):   # all are computed before the first is given
            text = self.expression(value)
            simple = isinstance(value, Const) or (isinstance(value, Local) and len(values) > 1)
            names.append(text if simple else f"result_{k}")
            if not simple:
                self.out(depth, f"const {SCALARS[value.type]} result_{k} = {text};")   # type: ignore[index]
        for k, name in enumerate(names):
            self.out(depth, f"*out_{k} = {name};")
        self.out(depth, "return;")

    # Expressions

    def expression(self, value: Expr, within: int = 0) -> str:
        """Return an expression, in parentheses if it binds less closely than the expression around it."""
        text, binds = self.bound(value)
        return f"({text})" if binds < within else text

    def pointer(self, value: Expr) -> str:
        """A pointer to an object."""
        if isinstance(value, Local):
            return identifier(value.name)
        if isinstance(value, Choice):
            return (f"({self.expression(value.test, 2)} ? {self.pointer(value.yes)} : {self.pointer(value.no)})")
        if isinstance(value, Item):
            return f"&{self.expression(value)}"
        return f"&{self.expression(value, UNARY)}"

    def bound(self, value: Expr) -> tuple[str, int]:
        match value:
            case Const():
                text = c_literal(value.value)
                shown = f"{text} /* {identifier(value.name)} */" if value.name else text
                return shown, UNARY if text.startswith("-") else ATOM
            case ConstList():
                return self.whole.list_name(value), ATOM
            case Local():
                return identifier(value.name), ATOM
            case Field() if (known := self.known(value)) is not None:
                return self.bound(known)
            case Field(base=base, name=name):
                if isinstance(base, Local):
                    return f"{identifier(base.name)}->{identifier(name)}", ATOM
                if isinstance(base, Choice):
                    return f"{self.pointer(base)}->{identifier(name)}", ATOM
                return f"{self.expression(base, ATOM)}.{identifier(name)}", ATOM
            case Item(base=base, index=index, site=site):
                text = self.expression(index)
                assert isinstance(base.type, List)
                if site is not None and not self.is_within(index, base.type.length):
                    text = self.helper("element", text, str(base.type.length), site.number)
                return f"{self.expression(base, ATOM)}[{text}]", ATOM
            case Logic(name=name, operands=operands):
                sign, binds = (" && ", BINDS["and"]) if name == "and" else (" || ", BINDS["or"])
                return sign.join(self.expression(each, BINDS["and"] + 1) for each in operands), binds
            case Choice(test=test, yes=yes, no=no):
                if isinstance(value.type, Struct):
                    return f"*{self.pointer(value)}", UNARY
                return f"{self.expression(test, 2)} ? {self.expression(yes, 2)} : {self.expression(no, 1)}", BINDS["?"]
            case Call():
                return self.call(value), ATOM
        return self.operation(value)

    def known(self, value: Expr) -> Const | ConstList | None:
        """The value of an attribute that never changes, None of any other expression."""
        if not isinstance(value, Field) or not isinstance(value.base.type, Struct):
            return None
        values = self.whole.constant_attributes.get((value.base.type.name, value.name), ())
        if not values or any(each != values[0] for each in values):
            return None
        return (ConstList(value.name, values[0], value.type) if isinstance(value.type, List) else
                Const(values[0], value.type, value.name))

    def is_within(self, index: Expr, length: int) -> bool:
        """Return True if an index is that of an element of a list, whatever the values."""
        found = self.whole.ranges.of(self.function, index)
        return found is not None and found[0] >= 0 and found[1] < length

    def call(self, call: Call, outs: Sequence[str] = ()) -> str:
        arguments = [self.pointer(each) if isinstance(each.type, Struct) else self.expression(each, 1)
                     for each in call.arguments if filled(each.type)]
        failing = ["failure"] if id(call.function) in self.whole.noting else []
        return f"{call.function.name}({', '.join([*arguments, *outs, *failing])})"

    def helper(self, name: str, *arguments: str | int) -> str:
        """Call of a helper whose last argument is the number of the place that can fail."""
        self.whole.helpers.add(name)
        *values, place = arguments
        return f"{name}({', '.join(map(str, values))}, {'failure' if place else 0}, {place})"   # 0: it cannot fail

    def operation(self, value: Operation) -> tuple[str, int]:
        name, operands, site = value.name, value.operands, value.site
        if name in ("+", "-", "*", "neg") and self.whole.ranges.of(self.function, value) is not None:
            site = None
        if name == "not":
            return f"!{self.expression(operands[0], UNARY)}", UNARY
        if name == "neg":
            if site is not None:
                return self.helper("difference", "0", self.expression(operands[0], 1), site.number), ATOM
            return f"-{self.expression(operands[0], UNARY + 1)}", UNARY
        if name == "~":
            return f"~{self.expression(operands[0], UNARY)}", UNARY
        if name == "float":
            return f"(double){self.expression(operands[0], UNARY)}", UNARY
        if name in COMPARISONS and {each.type for each in operands} == {INT, FLOAT}:
            return self.mixed(name, operands)
        whole_quotient = name in ("//", "%") or (name == "/" and operands[0].type == INT)
        if name in BINDS and site is None and not whole_quotient:
            return self.infix(name, operands)
        texts = [self.expression(each, 1) for each in operands]
        if name in ("floor", "ceil", "trunc"):
            assert site is not None
            if name != "trunc":
                self.whole.library.add(name)
            inner = texts[0] if name == "trunc" else f"{name}({texts[0]})"
            return self.helper("whole", inner, site.number), ATOM
        if name in ("min", "max"):
            helper = EXTREMES[name, value.type]   # type: ignore[index]
            self.whole.helpers.add(helper)
            return f"{helper}({', '.join(texts)})", ATOM
        if name == "abs":
            assert site is not None
            return self.helper("absolute", *texts, site.number), ATOM
        if name == "/" and (site is not None or operands[0].type == INT):
            helper = "quotient_of_wholes" if operands[0].type == INT else "quotient"
            return self.helper(helper, *texts, 0 if site is None else site.number), ATOM
        if name in CHECKED and value.type == INT and (site is not None or name in ("//", "%")):
            return self.helper(CHECKED[name], *texts, 0 if site is None else site.number), ATOM
        self.whole.library.add(name)
        text = f"{name}({', '.join(texts)})"
        if site is not None:
            return self.helper("computed", text, texts[0], texts[-1], site.number), ATOM
        return text, ATOM

    def mixed(self, name: str, operands: Sequence[Expr]) -> tuple[str, int]:
        """Comparison of a whole number with a float, by their exact values."""
        self.whole.helpers.add("order_of")
        a, b = (self.expression(each, 1) for each in operands)
        ordered = f"order_of({a}, {b}) {name} 0.0" if operands[0].type == INT else f"0.0 {name} order_of({b}, {a})"
        return ordered, BINDS[name]

    def infix(self, name: str, operands: Sequence[Expr]) -> tuple[str, int]:
        """Two operands with an operator of C between them."""
        binds = BINDS[name]
        left, right = binds, binds + 1
        if name in ("and", "or"):   # of two Booleans that are both computed
            name, binds, left, right = {"and": "&", "or": "|"}[name], BINDS["&"], UNARY, UNARY
        elif name in ("<<", ">>", "&", "^", "|"):
            left = right = UNARY
        elif name in COMPARISONS:
            left = right = BINDS["<<"]
        return f"{self.expression(operands[0], left)} {name} {self.expression(operands[1], right)}", binds
