"""Random blocks of the language, as text, and their run in Python where a whole number beyond 64 bits is an error."""

import ast
import math
import struct
from collections.abc import Callable, Iterator
from functools import partial
from random import Random
from typing import Any

FLOATS = ("0.0", "-0.0", "1.0", "-2.5", "0.1", "3.0e300", "-1.0e-310", "7.0", "9.2e18")
WHOLES = ("0", "1", "2", "-1", "3", "5", "-7", "62", "4611686018427387904", "9223372036854775807",
          "-9223372036854775807", "3037000500", "9007199254740993")
CLASSES = '''\
import math
from math import ceil, copysign, degrees, fabs, floor, fmod, isfinite, isinf, isnan, radians, remainder, sqrt, trunc

TABLE_{n} = (0.5, -1.5, 2.0)
ORDER_{n} = (2, 0, 1)


def share_{n}(x, y=0.5, k=1):
    """Part of a number."""
    return x * y if k > 0 else x - y


def halves_{n}(x):
    return 0.5 * x, x < 0.0


class Part_{n}:
    def __init__(self, x, k):
        self.x = x
        self.k = k
        self.place = 2 * k
        self.double = [x, 2.0 * x, -x]

    def take(self, x):
        self.x = self.x + x
        self.k = (self.k + 1) % 3
        return self.x

    def pair(self, x):
        self.k = (self.k + 2) % 3
        return self.x - x, self.k


class Block_{n}:
    def __init__(self):
        self.a, self.b, self.struct = {floats}
        self.i, self.j, self.int64_t = {wholes}
        self.on, self.off = True, False
        self.xs = [0.25, -1.0, 2.0, 1.0e10]
        self.ks = [0, 2, 1]
        self.order = [3, 1]
        self.flags = [False, True]
        self.rows = [[1.0, 2.0], [3.0, 4.0]]
        self.parts = [Part_{n}(1.0, 0), Part_{n}(-2.0, 1)]

    def bump(self, d):
        self.i = (self.i + d) % 5
        self.a = self.a + 1.0
        return self.i

    def at(self, k):
        return self.xs[k]

    def put(self, xs, k, x):
        xs[k] = x

    def larger(self, xs):
        return max(xs[0], xs[1])

    def chosen(self, xs):
        ys = self.parts[0].double if self.off else xs
        return ys[1]

    def relay(self, x):
        return self.put(self.xs, 1, x)

    def side(self, x):
        if x < self.b:
            return -1.0
        else:
            return 1.0

    def climb(self, x):
        while True:
            self.b += 1.0
            if self.b > x:
                return self.b

    def leading(self):
        for each in self.xs:
            return 2.0 * each

    def above(self, x, k):
        if x > self.b:
            return 0.5 * x
        for n in range(k % 4):
            if self.xs[n] > x:
                return self.xs[n]
        return x

    def limited(self, x):
        if x > 1.0:
            return 1.0, True
        return x, False

    def flip(self, x):
        self.on = not self.on
        self.b = x
        return self.on

    def shift(self, x):
        self.j = (self.j + 1) % 4
        self.xs[self.j] = x
        return self.a + x

    def both(self, x, k):
        self.a = x
        self.j = k % 3
        self.off = not self.off
        return x * 0.5, k, x > 1.0

'''


class Writer:
    """Writes one program; `random` decides."""

    def __init__(self, random: Random, number: int):
        self.random = random
        self.number = number
        self.lines: list[str] = []
        self.loops = 0
        self.part = False   # whether the name `part` has a value

    def program(self) -> str:
        pick = self.random.choice
        head = CLASSES.format(n=self.number, floats=", ".join(pick(FLOATS) for _ in range(3)),
                              wholes=", ".join(pick(WHOLES) for _ in range(3)))
        self.out(1, "def step(self, t):")
        for name in ("x", "register"):
            self.out(2, f"{name} = {self.real(1, ())}")
        self.out(2, f"n = {pick(WHOLES)}")
        self.out(2, f"é = {pick(WHOLES)}")
        self.out(2, f"known = {self.truth(1, ())}")
        if pick((True, False)):
            self.out(2, "k = 1")
        self.body(2, 3, ("x", "register"), ("n", "é"), self.random.randint(3, 7))
        return head + "\n".join(self.lines) + "\n"

    def out(self, depth: int, line: str) -> None:
        self.lines.append("    " * depth + line)

    # Expressions

    def real(self, depth: int, floats: tuple[str, ...], wholes: tuple[str, ...] = ()) -> str:
        if depth <= 0 or self.random.random() < 0.2:
            return self.random.choice((*floats, "self.a", "self.b", "self.struct", "t", *FLOATS[:5],
                                       *(["part.x", "self.xs[part.place]"] if self.part else [])))
        real = partial(self.real, depth - 1, floats, wholes)
        whole = partial(self.whole, depth - 1, wholes, floats)
        truth = partial(self.truth, depth - 1, floats, wholes)
        kind = self.random.randrange(26)
        if kind < 5:
            return f"({real()} {self.random.choice('+-*/')} {real()})"
        return [lambda: f"({whole()} / {whole()})", lambda: f"({real()} {self.random.choice('+-*')} {whole()})",
                lambda: f"self.shift({real()})", lambda: f"self.parts[{whole()} % 2].take({real()})",
                lambda: f"self.xs[{self.index(whole(), 4)}]",
                lambda: f"self.rows[{whole()} % 2][{self.index(whole(), 2)}]",
                lambda: f"({real()} if {truth()} else {real()})",
                lambda: f"{self.random.choice(('min', 'max'))}({real()}, {real()}, {real()})",
                lambda: f"{self.random.choice(('abs', 'fabs', '-', 'sqrt'))}({real()})",
                lambda: f"copysign({real()}, {real()})", lambda: f"float({whole()})",
                lambda: f"TABLE_{self.number}[{self.index(whole(), 3)}]",
                lambda: f"self.parts[{whole()} % 2].double[{self.index(whole(), 3)}]",
                lambda: f"float({truth()})", lambda: f"self.at({self.index(whole(), 4)})",
                lambda: f"share_{self.number}({real()}, {self.random.choice(('', 'y='))}{real()})",
                lambda: f"share_{self.number}(k={whole()}, x={real()})",
                lambda: f"(self.parts[0] if {truth()} else self.parts[1]).x",
                lambda: f"{self.random.choice(('fmod', 'remainder'))}({real()}, {real()})",
                lambda: f"self.above({real()}, {whole()})",
                lambda: f"self.xs[self.order[{self.index(whole(), 2)}]]"][kind - 5]()

    def index(self, whole: str, length: int) -> str:
        """An index that is within a list, or seldom not."""
        within = f"{whole} % {length}" + self.random.choice(("", f" - {length}"))
        return whole if self.random.random() < 0.04 else within

    def whole(self, depth: int, wholes: tuple[str, ...], floats: tuple[str, ...] = ()) -> str:
        if depth <= 0 or self.random.random() < 0.25:
            return self.random.choice((*wholes, "self.i", "self.j", "self.int64_t", *WHOLES[:6], "self.parts[1].k",
                                       "len(self.parts)", *(["part.place"] if self.part else [])))
        real = partial(self.real, depth - 1, floats, wholes)
        whole = partial(self.whole, depth - 1, wholes, floats)
        truth = partial(self.truth, depth - 1, floats, wholes)
        kind = self.random.randrange(16)
        if kind < 6:
            return f"({whole()} {self.random.choice(('+', '-', '*', '//', '%', '&', '|', '^', '<<', '>>'))} {whole()})"
        forms: list[Callable[[], str]] = [
                lambda: f"self.bump({whole()})", lambda: f"self.ks[{self.index(whole(), 3)}]",
                lambda: f"{self.random.choice(('min', 'max'))}({whole()}, {whole()})",
                lambda: f"{self.random.choice(('abs', '-', '~', '+'))}({whole()})",
                lambda: f"({whole()} if {truth()} else {whole()})",
                lambda: f"{self.random.choice(('int', 'floor', 'ceil', 'trunc'))}({real()})",
                lambda: "len(self.xs)", lambda: "sum(self.ks)",
                lambda: f"int({truth()})",
                lambda: f"self.ks[ORDER_{self.number}[{self.index(whole(), 3)}]]"]
        return forms[kind - 6]()

    def truth(self, depth: int, floats: tuple[str, ...], wholes: tuple[str, ...] = ()) -> str:
        if depth <= 0 or self.random.random() < 0.15:
            return self.random.choice(("self.on", "self.off", "True", "False"))
        real = partial(self.real, depth - 1, floats, wholes)
        whole = partial(self.whole, depth - 1, wholes, floats)
        truth = partial(self.truth, depth - 1, floats, wholes)
        sign = self.random.choice(("<", "<=", ">", ">=", "==", "!="))
        forms: list[Callable[[], str]] = [
            lambda: f"({real()} {sign} {real()})", lambda: f"({whole()} {sign} {whole()})",
            lambda: f"({whole()} {sign} {real()})", lambda: f"({real()} < {real()} {sign} {real()} <= {whole()})",
            lambda: f"({whole()} <= {whole()} < {whole()})", lambda: f"({whole()} {sign} {whole()} != {real()})",
            lambda: f"({truth()} and {truth()} and {truth()})",
            lambda: f"({truth()} or {truth()})", lambda: f"(not {truth()})", lambda: f"self.flip({real()})",
            lambda: f"({truth()} {self.random.choice(('==', '!=', '&', '|', '^'))} {truth()})",
            lambda: f"isfinite({real()})", lambda: f"isnan({real()})", lambda: f"isinf({real()})",
            lambda: f"bool({whole()})", lambda: f"bool({real()})", lambda: f"self.flags[{self.index(whole(), 2)}]",
            lambda: f"any(each > {real()} for each in self.xs)", lambda: "all(self.flags)",
            lambda: f"all(one.x {sign} {real()} for one in self.parts)"]
        return self.random.choice(forms)()

    # Statements

    def body(self, depth: int, deep: int, floats: tuple[str, ...], wholes: tuple[str, ...], many: int,
             loop: bool = False) -> None:
        before = self.part
        for _ in range(many):
            self.statement(depth, deep, floats, wholes, loop)
        self.part = before

    def statement(self, depth: int, deep: int, floats: tuple[str, ...], wholes: tuple[str, ...], loop: bool) -> None:
        pick = self.random.choice
        real = partial(self.real, 2, floats, wholes)
        whole = partial(self.whole, 2, wholes, floats)
        truth = partial(self.truth, 2, floats, wholes)
        operator = pick(("=", "+=", "-=", "*=", "="))
        places = [*[name for name in floats if name != "each"], "self.a", "self.b",
                  f"self.xs[{self.index(whole(), 4)}]",
                  f"self.rows[{whole()} % 2][{whole()} % 2]", f"self.parts[{whole()} % 2].x",
                  f"self.parts[{whole()} % 2].double[{self.index(whole(), 3)}]"]
        inner = partial(self.body, depth + 1, deep - 1, floats, wholes, self.random.randint(1, 3), loop)
        kind = self.random.randrange(9 if deep <= 0 else 17)
        if kind < 3:
            self.out(depth, f"{pick(places)} {operator} {real()}")
        elif kind < 5:
            place = pick(["n", "é", "self.i", "self.j", f"self.ks[{self.index(whole(), 3)}]",
                          f"self.parts[{whole()} % 2].k"])
            self.out(depth, f"{place} {pick((operator, '//=', '%='))} {whole()}")
        elif kind == 5:
            flag = f"self.flags[{self.index(whole(), 2)}]"
            self.out(depth, f"{pick(('self.on', 'self.off', 'known', flag))} = {truth()}")
        elif kind == 6:
            self.out(depth, pick([f"{pick(places)}, {pick(places)} = {real()}, {real()}",
                                  f"self.b, n, self.on = self.both({real()}, {whole()})",
                                  f"{pick(places)}, self.i = self.parts[{whole()} % 2].pair({real()})",
                                  f"{pick(places)}, known = halves_{self.number}({real()})",
                                  f"{pick(places)}, self.on = self.limited({real()})",
                                  f"_, _, {pick(('known', 'self.off'))} = self.both({real()}, {whole()})",
                                  f"{pick(places)} = {pick(places)} = {real()}", f"self.a: float = {real()}"]))
        elif kind == 7:
            self.out(depth, f"part = self.parts[{self.index(whole(), 2)}]")
            self.part = True
        elif kind == 8:
            jumps = ("return", "continue", "break") if loop else ("return",)
            self.out(depth, pick(["self.flip(1.5)", f"self.bump({whole()})", *jumps]))
            if self.lines[-1].strip() in jumps:
                self.lines[-1:] = ["    " * depth + f"if {truth()}:", "    " + self.lines[-1]]
        elif kind < 12:
            self.out(depth, f"if {truth()}:")
            inner()
            if pick((True, False)):
                self.out(depth, f"elif {truth()}:")
                inner()
            if pick((True, False)):
                self.out(depth, "else:")
                inner()
        elif kind < 15:
            self.loop(depth, deep, floats, wholes)
        elif kind == 15:
            self.loops += 1
            local = f"list_{self.loops}"
            lists = ("self.xs", f"self.rows[{whole()} % 2]", f"self.parts[{whole()} % 2].double")
            self.out(depth, f"{local} = {pick(lists)}")
            self.out(depth, f"{local}[{whole()} % 2] {operator} {real()} + {local}[{self.index(whole(), 2)}]")
        else:
            self.loops += 1
            turns = f"turns_{self.loops}"
            self.out(depth, f"{turns} = 0")
            endless = pick((True, False))
            self.out(depth, "while True:" if endless else f"while {turns} < 4 and {truth()}:")
            self.out(depth + 1, f"{turns} += 1")
            if endless:
                self.out(depth + 1, f"if {turns} > 4 or {truth()}:")
                self.out(depth + 2, "break")
            self.body(depth + 1, deep - 1, floats, wholes, self.random.randint(1, 3), True)

    def loop(self, depth: int, deep: int, floats: tuple[str, ...], wholes: tuple[str, ...]) -> None:
        pick, name = self.random.choice, self.random.choice(("k", "m"))
        whole = self.whole(1, wholes, floats)
        head, floats_in, wholes_in = pick([
            (f"{name} in range({pick(('2', '3', '4'))})", floats, (*wholes, name)),
            (f"{name} in range({whole} % 6)", floats, (*wholes, name)),
            (f"{name} in range(-2, {whole} % 6, 2)", floats, (*wholes, name)),
            (f"{name} in range(3, -3, -1)", floats, (*wholes, name)),
            ("each in self.xs", (*floats, "each"), wholes),
            (f"each in self.rows[{whole} % 2]", (*floats, "each"), wholes),
            (f"{name}, each in enumerate(self.xs)", (*floats, "each"), (*wholes, name)),
            (f"each, {name} in zip(TABLE_{self.number}, self.ks)", (*floats, "each"), (*wholes, name)),
            ("part in self.parts", (*floats, "part.x"), (*wholes, "part.k", "part.place")),
            (f"{name}, part in enumerate(self.parts)", (*floats, "part.x"), (*wholes, name, "part.k")),
            (f"part, {name} in zip(self.parts, self.order)", (*floats, "part.x", f"self.xs[{name}]"), (*wholes, name)),
            (f"{name} in ORDER_{self.number}", (*floats, f"self.xs[{name}]"), (*wholes, name))])
        self.out(depth, f"for {head}:")
        self.body(depth + 1, deep - 1, floats_in, wholes_in, self.random.randint(1, 3), True)
        if pick((True, False)) and "range" in head:
            self.out(depth + 1, f"self.xs[{name}] = {self.real(1, floats_in, wholes_in)}")


class Whole(int):
    """A whole number of 64 bits."""


def whole(value: Any) -> Any:
    if type(value) is bool or not isinstance(value, int):
        return value
    if not -2**63 <= value < 2**63:
        raise OverflowError
    return Whole(value)


def checked(name: str) -> Any:
    plain = getattr(int, name)

    def compute(*values: Any) -> Any:
        if name in ("__lshift__", "__rlshift__") and max(values) > 2**62 and 0 not in values:
            raise OverflowError
        if name in ("__lshift__", "__rlshift__"):
            value, by = values if name == "__lshift__" else values[::-1]
            if by > 70 and value:
                raise OverflowError
        result = plain(*map(int, values)) if all(isinstance(each, int) for each in values) else NotImplemented
        return result if result is NotImplemented else whole(result)
    return compute


for operator in ("add", "sub", "mul", "floordiv", "mod", "lshift", "rshift", "and", "or", "xor"):
    for form in (f"__{operator}__", f"__r{operator}__"):
        setattr(Whole, form, checked(form))
for operator in ("neg", "abs", "invert"):
    setattr(Whole, f"__{operator}__", checked(f"__{operator}__"))


class Checked(ast.NodeTransformer):
    """A program whose whole numbers are `Whole`."""

    def visit_Constant(self, node: ast.Constant) -> ast.expr:
        if type(node.value) is int:
            return ast.Call(ast.Name("Whole", ast.Load()), [node], [])
        return node


def leaves(value: Any) -> Iterator[str]:
    """Numbers of a block in their order, floats by their bits."""
    if isinstance(value, int):
        yield str(int(value))
    elif isinstance(value, float):
        yield "nan" if math.isnan(value) else struct.pack(">d", value).hex()
    else:
        for each in value if isinstance(value, list) else vars(value).values():
            yield from leaves(each)


def write_program(random: Random, number: int) -> str:
    """Write a program, seldom one that fails in its first step."""
    while True:
        text = Writer(random, number).program()
        if random.random() < 0.1 or run(text, number, 1) != ["refused"]:
            return text


def run(text: str, number: int, steps: int) -> list[str]:
    """State after each step, as words, and "refused" for the last one where Python raises."""
    names: dict[str, Any] = {
        "Whole": Whole, "range": lambda *bounds: map(Whole, range(*bounds)), "len": lambda each: Whole(len(each)),
        "enumerate": lambda each: ((Whole(k), value) for k, value in enumerate(each)), "int": lambda x: whole(int(x))}
    tree = ast.fix_missing_locations(Checked().visit(ast.parse(text)))
    exec(compile(tree, "program.py", "exec"), names)
    names |= {"floor": lambda x: whole(math.floor(x)), "ceil": lambda x: whole(math.ceil(x)),
              "trunc": lambda x: whole(math.trunc(x))}
    block = names[f"Block_{number}"]()
    states: list[str] = []
    for k in range(steps):
        try:
            block.step(0.125 * k)
        except (ZeroDivisionError, IndexError, OverflowError, ValueError):
            return [*states, "refused"]
        states.append(" ".join(leaves(block)))
    return states
