"""Prints the expressions of a function for lanes: a vector where lanes differ, a scalar where they have it in common.

An expression that is computed in some lanes only, and can fail or calls a function, becomes a statement before the
present one.
"""

from collections.abc import Sequence
from typing import Any, NamedTuple

from maglev.language.c_text import COMPARISONS, SCALARS, c_literal, filled, of_numbers
from maglev.language.clone import Clone
from maglev.language.expressions import writes
from maglev.language.helpers import CHECKED, EXTREMES
from maglev.language.liveness import within
from maglev.language.names import identifier
from maglev.language.program import (
    BOOL,
    FLOAT,
    INT,
    Call,
    Choice,
    Const,
    ConstList,
    Expr,
    Field,
    Function,
    Item,
    List,
    Local,
    Logic,
    Operation,
    Scalar,
    Struct,
    Type,
)

ALL = "LANES_ALL"
VECTORS = {FLOAT: "lanes_float", INT: "lanes_int", BOOL: "lanes_int"}


class Value(NamedTuple):
    """C of a value, and whether lanes differ in it."""

    text: str
    varies: bool


class Place(NamedTuple):
    """The C of a place, and whether each lane has its own, which is then that of `_lane`."""

    text: str
    apart: bool


def plain(value: Expr) -> bool:
    """Return True if a value can be computed where it is not needed: it calls no function, and no part can fail."""
    return not any(isinstance(each, Call) or getattr(each, "site", None) is not None for each in within(value))


def item_type(kind: Type) -> Type:
    """Type of the elements of a list, of those of its elements where these are lists."""
    while isinstance(kind, List):
        assert kind.item is not None
        kind = kind.item
    return kind


class LaneExpressions:
    """The expressions of one clone of a function, and the statements before them."""

    def __init__(self, whole: Any, clone: Clone):
        self.whole = whole
        self.clone = clone
        self.function: Function = clone.function
        self.lines: list[str] = []
        self.depth = 1
        self.numbers = 0
        self.counters: dict[str, bool] = {}   # names of the loops around, true if lanes differ in them

    def out(self, text: str, deeper: int = 0) -> None:
        self.lines.append("    " * (self.depth + deeper) + text)

    def new(self, name: str) -> str:
        """A name that no name of the Python becomes."""
        self.numbers += 1
        return f"_{name}{self.numbers}"

    # Values

    def lifted(self, value: Value, kind: Type) -> str:
        """C of a value as a vector."""
        if value.varies:
            return value.text
        return f"lanes_of_{kind.name}({value.text})"   # type: ignore[union-attr]

    def kept(self, value: Value, kind: Type, name: str = "part") -> str:
        """Name of a constant vector that has a value from here on."""
        made = self.new(name)
        self.out(f"const {VECTORS[kind]} {made} = {self.lifted(value, kind)};")   # type: ignore[index]
        return made

    def select(self, kind: Type, mask: str, yes: str, no: str) -> str:
        return f"lanes_select{'' if kind == FLOAT else '_int'}({mask}, {yes}, {no})"

    def expression(self, value: Expr, mask: str | None) -> Value:
        match value:
            case Const():
                text = c_literal(value.value)
                return Value(f"({text})" if text.startswith("-") else text, False)
            case Local():
                return Value(identifier(value.name), self.counters.get(value.name, self.clone.varies(value.name)))
            case Field() | Item():
                return self.read(value, mask)
            case Logic():
                return self.logic(value, mask)
            case Choice():
                return self.choice(value, mask)
            case Call():
                return self.call(value, mask)[0]
            case Operation():
                return self.operation(value, mask)
        raise AssertionError(value)

    def read(self, value: Field | Item, mask: str | None) -> Value:
        place, varies = self.place(value, mask), self.varies_in(value)
        if not place.apart:
            return Value(place.text, varies)
        made, kind = self.new("read"), value.type
        self.out(f"{VECTORS[kind]} {made} = {{0}};")   # type: ignore[index]
        one = f"{place.text}[_lane]" if varies else f"-(int64_t){place.text}" if kind == BOOL else place.text
        self.each_lane(mask, f"{made}[_lane] = {one};")
        return Value(made, True)

    def each_lane(self, mask: str | None, *lines: str) -> None:
        """Statements for each lane of a mask."""
        self.out("LANES_LOOP {")
        if mask is not None:
            self.out(f"if (!{mask}[_lane]) continue;", 1)
        for line in lines:
            self.out(line, 1)
        self.out("}")

    # Places

    def varies_in(self, place: Expr) -> bool:
        """Return True if lanes differ in the numbers at a place, or in those of the list there."""
        match place:
            case Field(base=base, name=name):
                return bool(self.whole.is_varying(base.type, name))
            case Item(base=base):
                return self.varies_in(base)
            case Local(name=name):
                return self.clone.elements_vary(name)
            case Choice(yes=yes, no=no):
                return self.varies_in(yes) or self.varies_in(no)
        return False   # of a constant

    def make_vary(self, place: Expr) -> None:
        """Note that lanes differ in the numbers at a place."""
        match place:
            case Field(base=base, name=name):
                self.whole.make_vary(base.type, name)
            case Item(base=base):
                self.make_vary(base)
            case Local(name=name):
                self.clone.make_elements_vary(name)
            case Choice(yes=yes, no=no):
                self.make_vary(yes)
                self.make_vary(no)

    def place(self, value: Expr, mask: str | None) -> Place:
        """C of a place, of an object or of a list."""
        match value:
            case Local(name=name, type=kind):
                apart = self.clone.varies(name)
                text = f"{identifier(name)}[_lane]" if apart else identifier(name)
                return Place(f"(*{text})" if isinstance(kind, Struct) else text, apart)
            case Field(base=base, name=name):
                owner = self.place(base, mask)
                return Place(f"{owner.text}.{identifier(name)}", owner.apart)
            case Item(base=base):
                owner, k = self.place(base, mask), self.index(value, mask)
                if k.varies:
                    return Place(f"{owner.text}[{k.text}[_lane]]", True)
                return Place(f"{owner.text}[{k.text}]", owner.apart)
            case ConstList():
                return Place(self.whole.list_name(value, False), False)
            case Choice(test=test, yes=yes, no=no):
                condition = self.settled(test, self.expression(test, mask), True)
                truth = self.lifted(condition, BOOL)
                a = self.place(yes, mask if plain(yes) else self.narrowed(mask, truth))
                b = self.place(no, mask if plain(no) else self.narrowed(mask, f"~{truth}"))
                if condition.varies:
                    condition = Value(f"{condition.text}[_lane]", True)
                refer = "&" if isinstance(value.type, Struct) else ""
                text = f"({condition.text} ? {refer}{a.text} : {refer}{b.text})"
                return Place(f"(*{text})" if refer else text, condition.varies or a.apart or b.apart)
        raise AssertionError(value)

    def index(self, item: Item, mask: str | None) -> Value:
        """Index of an element, of all lanes or as the name of a vector."""
        index = self.expression(item.index, mask)
        if item.site is not None:
            assert isinstance(item.base.type, List)
            index = self.failing("element", (index, Value(str(item.base.type.length), False)), (INT, INT), INT,
                                 item.site.number, mask)
        if index.varies:
            return Value(self.kept(index, INT, "index"), True)
        if not isinstance(item.index, Const | Local) or item.site is not None:
            made = self.new("index")
            self.out(f"const int64_t {made} = {index.text};")
            return Value(made, False)
        return index

    def pointer(self, value: Expr, mask: str | None, varying: bool) -> Place:
        """A pointer to an object or to a list, whose numbers are of lanes if `varying`."""
        if isinstance(value, ConstList):
            return Place(self.whole.list_name(value, varying), False)
        if isinstance(value.type, List):
            if isinstance(value, Choice) and varying:
                self.make_vary(value)
            if isinstance(item_type(value.type), Scalar) and varying and not self.varies_in(value):
                self.make_vary(value)
            return self.place(value, mask)
        place = self.place(value, mask)
        return Place(f"&{place.text}", place.apart)

    # Operations

    def whole_helper(self, name: str) -> str:
        self.whole.helpers.add(name)
        return f"lanes_{name}"

    def failing(self, name: str, operands: Sequence[Value], kinds: Sequence[Type], result: Type, place: int,
                mask: str | None) -> Value:
        """A helper that can fail in lanes of a mask; place 0 if it cannot."""
        varies = any(each.varies for each in operands)
        texts = [self.lifted(each, kind) for each, kind in zip(operands, kinds, strict=True)] if varies else [
            each.text for each in operands]
        function = self.whole_helper(name if varies else f"common_{name}")
        return Value(f"{function}({', '.join(texts)}, {mask or ALL}, {'failure' if place else 0}, {place})", varies)

    def operation(self, value: Operation, mask: str | None) -> Value:
        name, site = value.name, value.site
        kinds = [each.type for each in value.operands]
        given = [self.expression(each, mask) for each in value.operands]
        place = 0 if site is None else site.number
        varies = any(each.varies for each in given)
        if name == "neg" and site is not None:
            return self.failing("difference", (Value("0", False), *given), (INT, INT), INT, place, mask)
        if name in ("floor", "ceil", "trunc"):
            inner = given if name == "trunc" else [self.of_math(name, given)]
            return self.failing("whole", inner, (FLOAT,), INT, place, mask)
        if name == "abs":
            return self.failing("absolute", given, kinds, INT, place, mask)
        if name in CHECKED and value.type == INT and (site is not None or name in ("//", "%")):
            return self.failing(CHECKED[name], given, kinds, INT, place, mask)
        if name == "/" and kinds[0] == INT:
            return self.failing("quotient_of_wholes", given, kinds, FLOAT, place, mask)
        if name == "/" and site is not None:
            return self.failing("quotient", given, kinds, FLOAT, place, mask)
        if name in COMPARISONS and set(kinds) == {INT, FLOAT}:
            return self.mixed(name, given, kinds)
        if not varies:
            return Value(self.in_common(name, [each.text for each in given], value.type, place, mask), False)
        texts = [self.lifted(each, kind) for each, kind in zip(given, kinds, strict=True)]
        if name == "float":
            return Value(f"__builtin_convertvector({texts[0]}, lanes_float)", True)
        if name in ("min", "max"):
            a, b = (self.kept(Value(text, True), value.type) for text in texts)
            return Value(self.select(value.type, f"({b} {'<' if name == 'min' else '>'} {a})", b, a), True)
        if name in ("fabs", "copysign", "isnan", "isfinite", "isinf"):
            return Value(f"lanes_{name}({', '.join(texts)})", True)
        if name in UNARY:
            return Value(f"({UNARY[name]}{texts[0]})", True)
        if name in ("and", "or"):
            return Value(f"({texts[0]} {'&' if name == 'and' else '|'} {texts[1]})", True)
        if kinds[0] == BOOL:   # of two Booleans
            return Value(f"({'~' if name == '==' else ''}({texts[0]} ^ {texts[1]}))", True)
        if name in INFIX:
            return Value(f"({texts[0]} {name} {texts[1]})", True)
        if site is None:
            return self.of_math(name, given)
        operands = [Value(self.kept(each, FLOAT), True) for each in given]
        return self.failing("computed", (self.of_math(name, operands), operands[0], operands[-1]), (FLOAT,) * 3,
                            FLOAT, place, mask)

    def in_common(self, name: str, texts: Sequence[str], result: Type, place: int, mask: str | None) -> str:
        """An operation on values that all lanes have in common."""
        if name == "float":
            return f"((double){texts[0]})"
        if name in ("min", "max"):
            helper = EXTREMES[name, result]   # type: ignore[index]
            self.whole.scalar_helpers.add(helper)
            return f"{helper}({', '.join(texts)})"
        if name in UNARY:
            return f"({'!' if name == 'not' else UNARY[name]}{texts[0]})"
        if name in ("and", "or"):
            return f"({texts[0]} {'&' if name == 'and' else '|'} {texts[1]})"
        if name in INFIX:
            return f"({texts[0]} {name} {texts[1]})"
        text = f"{name}({', '.join(texts)})"
        if place == 0:
            return text
        return self.failing("computed", [Value(each, False) for each in (text, texts[0], texts[-1])], (FLOAT,) * 3,
                            FLOAT, place, mask).text

    def of_math(self, name: str, given: Sequence[Value]) -> Value:
        """A function of <math.h>."""
        if not any(each.varies for each in given):
            return Value(f"{name}({', '.join(each.text for each in given)})", False)
        function = self.whole_helper(name)
        return Value(f"{function}({', '.join(self.lifted(each, FLOAT) for each in given)})", True)

    def mixed(self, name: str, given: Sequence[Value], kinds: Sequence[Type]) -> Value:
        """Comparison of a whole number with a float, by their exact values."""
        self.whole.scalar_helpers.add("order_of")
        whole = 0 if kinds[0] == INT else 1
        varies = any(each.varies for each in given)
        texts = [self.lifted(each, kind) if varies else each.text for each, kind in zip(given, kinds, strict=True)]
        function = self.whole_helper("order_of") if varies else "order_of"
        order = f"{function}({texts[whole]}, {texts[1 - whole]})"
        zero = "lanes_of_float(0.0)" if varies else "0.0"
        return Value(f"({order} {name} {zero})" if whole == 0 else f"({zero} {name} {order})", varies)

    # Values that only some lanes compute

    def aside(self, value: Expr, mask: str | None) -> tuple[list[str], Value]:
        """The statements before a value, one level deeper, and the value."""
        before, self.lines = self.lines, []
        self.depth += 1
        result = self.expression(value, mask)
        self.depth -= 1
        own, self.lines = self.lines, before
        return own, result

    def narrowed(self, mask: str | None, by: str) -> str:
        """Name of a mask with the lanes of another in which a Boolean is true."""
        made = self.new("live")
        self.out(f"const lanes_int {made} = {by if mask is None else f'{mask} & {by}'};")
        return made

    def settled(self, written: Expr, value: Value, always: bool = False) -> Value:
        """A Boolean that is computed before the following code, where that matters."""
        if not always and not writes(written):
            return value
        if value.varies:
            return Value(self.kept(value, BOOL, "truth"), True)
        made = self.new("truth")
        self.out(f"const bool {made} = {value.text};")
        return Value(made, False)

    def logic(self, value: Logic, mask: str | None) -> Value:
        """`and` or `or`: operands are computed where those before do not decide."""
        sign, both = ("&&", "&") if value.name == "and" else ("||", "|")
        result = self.settled(value.operands[0], self.expression(value.operands[0], mask))
        for operand in value.operands[1:]:
            if result.varies:
                if plain(operand):
                    other = self.expression(operand, mask)
                    result = Value(f"({result.text} {both} {self.lifted(other, BOOL)})", True)
                    continue
                made = self.new("truth")
                self.out(f"lanes_int {made} = {result.text};")
                where = self.narrowed(mask, made if value.name == "and" else f"~{made}")
                own, other = self.aside(operand, where)
                self.out(f"if (lanes_any({where})) {{")
                self.lines += own
                text = self.lifted(other, BOOL)
                self.out(f"{made} = {made} & (~{where} | {text});" if value.name == "and" else
                         f"{made} = {made} | ({where} & {text});", 1)
                self.out("}")
                result = Value(made, True)
                continue
            own, other = self.aside(operand, mask)
            if not own and not other.varies:
                result = Value(f"({result.text} {sign} {other.text})", False)
                continue
            made, first = self.new("truth"), self.new("truth")
            self.out(f"const bool {first} = {result.text};")
            kind = "lanes_int" if other.varies else "bool"
            self.out(f"{kind} {made} = {self.lifted(Value(first, False), BOOL) if other.varies else first};")
            self.out(f"if ({'' if value.name == 'and' else '!'}{first}) {{")
            self.lines += own
            self.out(f"{made} = {other.text};", 1)
            self.out("}")
            result = Value(made, other.varies)
        return result

    def choice(self, value: Choice, mask: str | None) -> Value:
        kind = value.type
        test = self.settled(value.test, self.expression(value.test, mask))
        if not test.varies:
            (own_yes, yes), (own_no, no) = (self.aside(each, mask) for each in (value.yes, value.no))
            varies = yes.varies or no.varies
            a, b = (self.lifted(each, kind) if varies else each.text for each in (yes, no))
            if not own_yes and not own_no:
                return Value(f"({test.text} ? {a} : {b})", varies)
            made = self.new("choice")
            self.out(f"{(VECTORS if varies else SCALARS)[kind]} {made};")   # type: ignore[index]
            self.out(f"if ({test.text}) {{")
            self.lines += own_yes
            self.out(f"{made} = {a};", 1)
            self.out("} else {")
            self.lines += own_no
            self.out(f"{made} = {b};", 1)
            self.out("}")
            return Value(made, varies)
        if plain(value.yes) and plain(value.no):
            given = [self.lifted(self.expression(each, mask), kind) for each in (value.yes, value.no)]
            return Value(self.select(kind, test.text, *given), True)
        condition, made = self.kept(test, BOOL, "truth"), self.new("choice")
        self.out(f"{VECTORS[kind]} {made} = {{0}};")   # type: ignore[index]
        for part, where in ((value.yes, condition), (value.no, f"~{condition}")):
            live = self.narrowed(mask, where)
            own, result = self.aside(part, live)
            self.out(f"if (lanes_any({live})) {{")
            self.lines += own
            self.out(f"{made} = {self.select(kind, live, self.lifted(result, kind), made)};", 1)
            self.out("}")
        return Value(made, True)

    # Calls

    def call(self, call: Call, mask: str | None) -> list[Value]:
        """Perform a call; return its results, a single one as an expression if lanes need no distinction."""
        scalars = {k: self.expression(each, mask) for k, each in enumerate(call.arguments)
                   if isinstance(each.type, Scalar)}
        varying = [scalars[k].varies if k in scalars else of_numbers(each.type) and self.varies_in(each)
                   for k, each in enumerate(call.arguments)]
        needs = self.whole.lists_needed(call.function, varying)
        varying = [each or needed for each, needed in zip(varying, needs, strict=True)]
        places = {k: self.pointer(each, mask, varying[k]) for k, each in enumerate(call.arguments)
                  if k not in scalars and filled(each.type)}
        apart = any(each.apart for each in places.values())
        masked = (mask is not None or apart) and not self.whole.harmless(call.function)
        clone = self.whole.clone(call.function, tuple(varying), masked)
        texts = [scalars[k].text if k in scalars else places[k].text for k, each in enumerate(call.arguments)
                 if filled(each.type)]
        results = call.function.results
        several = len(results) > 1
        own = [self.new("result") for _ in results]
        after = [*(f"&{name}" for name in own if several), *(["_live"] if masked else []),
                 *(["failure"] if call.function.fails else [])]
        kinds = [(VECTORS if clone.results_vary[k] else SCALARS)[kind] for k, kind in enumerate(results)]   # type: ignore[index]
        if not apart:
            after = [mask if each == "_live" else each for each in after]   # type: ignore[misc]
            text = f"{clone.name}({', '.join([*texts, *after])})"
            if len(results) == 1:
                return [Value(text, clone.results_vary[0])]
            for kind, name in zip(kinds, own, strict=True):
                self.out(f"{kind} {name};")
            self.out(f"{text};")
            return [Value(name, varies) for name, varies in zip(own, clone.results_vary, strict=True)]
        merged = [self.new("result") for _ in results]
        for result, name in zip(results, merged, strict=True):
            self.out(f"{VECTORS[result]} {name} = {{0}};")   # type: ignore[index]
        after = ["_one" if each == "_live" else each for each in after]
        text = f"{clone.name}({', '.join([*texts, *after])})"
        lines = ["const lanes_int _one = lanes_only(_lane);"] if masked or results else []
        lines += [f"{kind} {name}{'' if several else f' = {text}'};" for kind, name in zip(kinds, own, strict=True)]
        if several or not results:
            lines.append(f"{text};")
        lines += [f"{name} = {self.select(result, '_one', self.lifted(Value(one, varies), result), name)};"
                  for result, name, one, varies in zip(results, merged, own, clone.results_vary, strict=True)]
        self.each_lane(mask, *lines)
        return [Value(name, True) for name in merged]


UNARY = {"not": "~", "neg": "-", "~": "~"}
INFIX = {"+", "-", "*", "/", "<<", ">>", "&", "^", "|", *COMPARISONS}
