"""Prints the statements of a function for lanes: an assignment goes to the lanes that are live, an `if` narrows them.

A mask is the name of a vector, or None while all lanes are live. Lanes that return, or leave a loop, while others
continue are noted. The code that follows excludes them, and needs no mask if there are none.
"""

from collections.abc import Sequence
from typing import Any

from maglev.language.c_text import SCALARS, declared
from maglev.language.clone import Clone
from maglev.language.lane_expressions import VECTORS, LaneExpressions, Value, item_type
from maglev.language.liveness import NONE, Liveness, Names, within
from maglev.language.names import identifier
from maglev.language.program import (
    BOOL,
    INT,
    Assign,
    Call,
    Const,
    Expr,
    For,
    If,
    Item,
    Jump,
    List,
    Local,
    Perform,
    Return,
    Scalar,
    Statement,
    Struct,
    Type,
    While,
    inner,
)

GONE = "_gone"        # lanes that have returned
ENTRY = "_live"       # lanes that are live when a function begins
NOWHERE = ""          # mask of code that is never reached


class Loop:
    """A loop whose lanes leave it one by one: the names of those that have, and of those that skip the present turn."""

    def __init__(self, number: int, mask: str | None):
        self.left, self.skipped = f"_left{number}", f"_skipped{number}"
        self.mask = mask   # at the beginning of a turn


class LaneStatements(LaneExpressions):
    """The statements of one clone of a function."""

    def __init__(self, whole: Any, clone: Clone):
        super().__init__(whole, clone)
        self.liveness = Liveness(self.function.body)
        self.entry = ENTRY if clone.masked else None
        self.kept_names: Names = NONE    # of other lanes, which an assignment leaves alone
        self.left_names: Names = NONE    # the same, of lanes that have left a loop
        self.loops: list[Loop] = []
        self.leaving: set[str] = set()   # names of lanes that left while a statement was printed
        self.loop_keys: list[int] = []

    def text(self) -> str:
        """The function."""
        function, clone = self.function, self.clone
        end = self.block(function.body, self.entry)
        results = [("_result" if len(function.results) == 1 else f"_result_{k}") for k in range(len(function.results))]
        if clone.partial and len(results) == 1:
            self.out("return _result;")
        elif clone.partial:
            for k, name in enumerate(results):
                self.out(f"*_out_{k} = {name};")
        elif len(results) == 1 and end != NOWHERE:   # where a failure has ended a loop that has no other end
            self.out(f"return ({VECTORS[function.results[0]]}){{0}};" if clone.results_vary[0] else "return 0;")  # type: ignore[index]
        before = []
        if clone.partial:
            before = [f"    lanes_int {GONE} = {{0}};"]
            before += [f"    {VECTORS[kind]} {name} = {{0}};"   # type: ignore[index]
                       for kind, name in zip(function.results, results, strict=True)]
        local = [f"    {self.declared_local(name, kind)};" for name, kind in function.locals.items()
                 if self.whole.takes_room(kind)]
        copies = [f"    {VECTORS[kind]} {identifier(name)} = "   # type: ignore[index]
                  f"{self.lifted(Value(f'_given_{identifier(name)}', given), kind)};"
                  for (name, kind), given in zip(function.parameters, clone.varying, strict=True)
                  if self.is_copied(name, kind, given)]
        code = "\n".join([*local, *copies, *before, *self.lines])
        return f"{self.head()}\n{{\n{code}\n}}\n"

    def is_copied(self, name: str, kind: Type, given: bool) -> bool:
        """Return True if a parameter that lanes have in common becomes one that they differ in."""
        return isinstance(kind, Scalar) and self.clone.varies(name) and not given

    def head(self) -> str:
        """Declaration of the function."""
        clone, function = self.clone, self.function
        given = []
        for (name, kind), varies in zip(function.parameters, clone.varying, strict=True):
            if isinstance(kind, Scalar):
                word = (VECTORS if varies else SCALARS)[kind]
                given.append(f"{word} {'_given_' if self.is_copied(name, kind, varies) else ''}{identifier(name)}")
            elif self.whole.takes_room(kind):
                given.append(self.referred(kind, identifier(name), varies, name not in function.changed))
        results = [(VECTORS if varies else SCALARS)[kind]   # type: ignore[index]
                   for kind, varies in zip(function.results, clone.results_vary, strict=True)]
        if len(results) > 1:
            given += [f"{word} *_out_{k}" for k, word in enumerate(results)]
        given += [f"const lanes_int {ENTRY}"] * clone.masked + ["lanes_int *failure"] * function.fails
        return f"static {results[0] if len(results) == 1 else 'void'} {clone.name}({', '.join(given) or 'void'})"

    def referred(self, kind: Type, name: str, varies: bool, constant: bool) -> str:
        """Declaration of a pointer to an object or to a list, whose numbers are of lanes if they vary."""
        if isinstance(kind, Struct):
            return f"struct {self.whole.struct_name(kind)} *{name}"
        assert isinstance(kind, List) and kind.item is not None
        made = self.whole.declared(kind.item, f"(*{name})" if isinstance(kind.item, List) else f"*{name}", varies)
        return f"const {made}" if constant and isinstance(item_type(kind), Scalar) else made

    def declared_local(self, name: str, kind: Type) -> str:
        shown = identifier(name)
        if isinstance(kind, Scalar):
            return f"{VECTORS[kind]} {shown} = {{0}}" if self.clone.varies(name) else f"{declared(kind, shown)} = 0"
        apart = self.clone.varies(name)
        return self.referred(kind, f"{shown}[LANES]" if apart else shown, self.clone.elements_vary(name),
                             name not in self.function.changed) + (" = {0}" if apart else "")

    # Bodies

    def block(self, body: Sequence[Statement], mask: str | None) -> str | None:
        """Print statements; the mask after them, NOWHERE if none gets there."""
        for number, statement in enumerate(body):
            outer, self.leaving = self.leaving, set()
            after = self.statement(statement, mask)
            left, self.leaving = self.leaving, self.leaving | outer
            if after == NOWHERE:
                return NOWHERE
            rest = body[number + 1:]
            if left and mask is None and self.is_long(rest):
                self.out(f"if (!lanes_any({' | '.join(sorted(left))})) {{")
                self.depth += 1
                self.block(rest, None)
                self.depth -= 1
                self.out("} else {")
                self.depth += 1
                self.block(rest, self.remaining(None, left))
                self.depth -= 1
                self.out("}")
                return mask
            if left:
                mask = self.remaining(mask, left)
        return mask

    def is_long(self, body: Sequence[Statement]) -> bool:
        """Return True if statements are worth printing twice: with a mask and without one."""
        return any(isinstance(each, While | For | Perform) or calls(each) for each in inner(list(body)))

    def remaining(self, mask: str | None, left: set[str]) -> str:
        return self.narrowed(mask, " & ".join(f"~{name}" for name in sorted(left)))

    def inside(self, body: Sequence[Statement], mask: str | None) -> None:
        self.depth += 1
        self.block(body, mask)
        self.depth -= 1

    def statement(self, statement: Statement, mask: str | None) -> str | None:
        match statement:
            case Assign(target=target, value=value):
                self.assign(target, value, mask)
            case Perform(call=call, targets=targets):
                results = self.call(call, mask)
                if len(call.function.results) == 1 and not targets:
                    self.out(f"(void){results[0].text};")
                for target, result in zip(targets, results, strict=False):
                    self.give(target, result, mask)
            case If(test=test, yes=yes, no=no):
                self.branch(statement, test, yes, no, mask)
            case While(test=test, body=body):
                self.loop_while(statement, test, body, mask)
            case For():
                self.loop_over(statement, mask)
            case Return(values=values):
                self.leave(values, mask)
                return NOWHERE
            case Jump(word=word):
                loop = self.loops[-1]
                if mask == loop.mask:
                    self.out(f"{word};")
                else:
                    name = loop.left if word == "break" else loop.skipped
                    self.out(f"{name} = {name} | {mask};")
                    self.leaving.add(name)
                    self.clone.note_leaving(self.loop_keys[-1])
                return NOWHERE
        return mask

    # Assignments

    def assign(self, target: Expr, value: Expr, mask: str | None) -> None:
        if isinstance(value.type, Struct | List):
            assert isinstance(target, Local)
            self.refer(target, value, mask)
        else:
            self.give(target, self.expression(value, mask), mask)

    def refer(self, target: Local, value: Expr, mask: str | None) -> None:
        """Let a local name stand for an object or a list."""
        name, listed = target.name, isinstance(item_type(value.type), Scalar)
        if listed and self.varies_in(value):
            self.clone.make_elements_vary(name)
        pointer = self.pointer(value, mask, self.clone.elements_vary(name))
        if not self.whole.takes_room(value.type):
            return
        if pointer.apart or (mask is not None and name in self.kept_names):
            self.clone.make_vary(name)
        if self.clone.varies(name):
            self.each_lane(mask if name in self.kept_names or pointer.apart else None,
                           f"{identifier(name)}[_lane] = {pointer.text};")
        else:
            self.out(f"{identifier(name)} = {pointer.text};")

    def give(self, target: Expr, value: Value, mask: str | None) -> None:
        """Give a number to a local name, an attribute or an element."""
        kind = target.type
        if isinstance(target, Local):
            masked = mask if target.name in self.kept_names else None
            if value.varies or masked is not None:
                self.clone.make_vary(target.name)
            self.store(identifier(target.name), value, kind, self.clone.varies(target.name), masked)
            return
        if any(isinstance(each, Item) and not isinstance(each.index, Const) for each in within(target)):
            value = self.before(value, kind)
        place = self.place(target, mask)
        if value.varies or mask is not None or place.apart:
            self.make_vary(target)
        varies = self.varies_in(target)
        if place.apart:
            lifted = self.kept(value, kind)
            self.each_lane(mask, f"{place.text}{'[_lane]' if varies else ''} = {lifted}[_lane];")
        else:
            self.store(place.text, value, kind, varies, mask)

    def before(self, value: Value, kind: Type) -> Value:
        """A value that is computed before its place."""
        if value.varies:
            return Value(self.kept(value, kind), True)
        made = self.new("part")
        self.out(f"const {SCALARS[kind]} {made} = {value.text};")   # type: ignore[index]
        return Value(made, False)

    def store(self, place: str, value: Value, kind: Type, varies: bool, mask: str | None) -> None:
        text = self.lifted(value, kind) if varies else value.text
        self.out(f"{place} = {text if mask is None or not varies else self.select(kind, mask, text, place)};")

    # Branches and loops

    def branch(self, statement: Statement, test: Expr, yes: Sequence[Statement], no: Sequence[Statement],
               mask: str | None) -> None:
        condition = self.expression(test, mask)
        if not condition.varies:
            self.out(f"if ({condition.text}) {{")
            self.inside(yes, mask)
            if no:
                self.out("} else {")
                self.inside(no, mask)
            self.out("}")
            return
        truth = self.kept(condition, BOOL, "truth")
        outer = self.kept_names
        after = self.liveness.after[id(statement)]
        for body, where, others in ((yes, truth, self.liveness.other[id(statement)]), (no, f"~{truth}", NONE)):
            if body:
                live = self.narrowed(mask, where)
                self.kept_names = after | others | self.left_names
                self.out(f"if (lanes_any({live})) {{")
                self.inside(body, live)
                self.out("}")
        self.kept_names = outer

    def leave(self, values: Sequence[Expr], mask: str | None) -> None:
        """Return, in some lanes while others continue."""
        clone = self.clone
        given = [self.expression(each, mask) for each in values]
        whole = mask == self.entry
        for k, value in enumerate(given):
            if value.varies or clone.partial or not whole:
                clone.make_result_vary(k)
        if whole:
            texts = [self.lifted(value, kind) if clone.results_vary[k] else value.text
                     for k, (value, kind) in enumerate(zip(given, self.function.results, strict=True))]
            if len(texts) == 1:
                self.out(f"return {texts[0]};")
                return
            names = []
            for k, text in enumerate(texts):   # all are computed before the first is given
                word = (VECTORS if clone.results_vary[k] else SCALARS)[self.function.results[k]]   # type: ignore[index]
                names.append(self.new("result"))
                self.out(f"const {word} {names[-1]} = {text};")
            for k, name in enumerate(names):
                self.out(f"*_out_{k} = {name};")
            self.out("return;")
            return
        clone.make_partial()
        made = [self.kept(value, kind) for value, kind in zip(given, self.function.results, strict=True)]
        for k, (kind, name) in enumerate(zip(self.function.results, made, strict=True)):
            result = "_result" if len(made) == 1 else f"_result_{k}"
            self.out(f"{result} = {self.select(kind, str(mask), name, result)};")
        self.out(f"{GONE} = {GONE} | {mask};")
        self.leaving.add(GONE)
        for key in self.loop_keys:
            clone.note_leaving(key)

    def loop_while(self, statement: Statement, test: Expr, body: Sequence[Statement], mask: str | None) -> None:
        before, self.lines = self.lines, []
        self.depth += 1
        condition = self.expression(test, mask)
        self.depth -= 1
        own, self.lines = self.lines, before
        apart = condition.varies or self.function.fails or self.clone.leaves(id(statement))
        if not apart:
            self.out("for (;;) {" if own else f"while ({condition.text}) {{")
            if own:
                self.lines += own
                self.out(f"if (!({condition.text})) break;", 1)
            self.turn(statement, body, mask, None)
            self.out("}")
            return
        loop = self.begun(statement, mask)
        self.out("for (;;) {")
        self.depth += 1
        live = self.turn_mask(loop, mask)
        if self.function.fails:
            live = self.narrowed(live, "(*failure == 0)")
        condition = self.expression(test, live)
        live = self.narrowed(live, self.lifted(condition, BOOL))
        self.out(f"{loop.left} = {loop.left} | ~{live};")
        self.out(f"if (!lanes_any({live})) break;")
        self.depth -= 1
        self.turn(statement, body, live, loop)
        self.out("}")
        self.ended(loop)

    def begun(self, statement: Statement, mask: str | None) -> Loop:
        """A loop that lanes leave one by one."""
        self.numbers += 1
        loop = Loop(self.numbers, mask)
        self.out(f"lanes_int {loop.left} = {{0}};")
        return loop

    def turn_mask(self, loop: Loop, mask: str | None) -> str:
        """Name of the lanes that take part in a turn."""
        self.out(f"lanes_int {loop.skipped} = {{0}};")
        self.out(f"(void){loop.skipped};")
        return self.narrowed(mask, f"~{loop.left}" + (f" & ~{GONE}" if self.clone.partial else ""))

    def ended(self, loop: Loop) -> None:
        self.leaving -= {loop.left, loop.skipped}

    def turn(self, statement: Statement, body: Sequence[Statement], mask: str | None, loop: Loop | None) -> None:
        """The statements of a turn, of `loop` if lanes leave it one by one."""
        one = loop or Loop(0, mask)
        one.mask = mask
        outer = self.kept_names, self.left_names
        if loop is not None:
            others = self.liveness.after[id(statement)] | self.liveness.head[id(statement)]
            self.kept_names = self.left_names = others | self.left_names
        self.loops.append(one)
        self.loop_keys.append(id(statement))
        self.inside(body, mask)
        self.loop_keys.pop()
        self.loops.pop()
        self.kept_names, self.left_names = outer

    def loop_over(self, loop: For, mask: str | None) -> None:
        name = identifier(loop.name)
        start, stop = self.expression(loop.start, mask), self.expression(loop.stop, mask)
        sign = "<" if loop.step > 0 else ">"
        varies = start.varies or stop.varies
        leaves = self.clone.leaves(id(loop))
        if not varies and not leaves:
            self.out(f"for (int64_t {name} = {start.text}; {name} {sign} {stop.text}; {name} += {loop.step}) {{")
            self.counted(loop, start.varies, mask, None)
            self.out("}")
            return
        made = self.begun(loop, mask)
        if start.varies:
            self.out(f"lanes_int {name} = {start.text}, {made.left}_turn = {{0}};")
            self.out(f"for (;; {name} = {name} + ({made.left}_turn & {loop.step})) {{")
        else:
            test = "" if stop.varies else f"{name} {sign} {stop.text}"
            self.out(f"for (int64_t {name} = {start.text}; {test}; {name} += {loop.step}) {{")
        self.depth += 1
        live = self.turn_mask(made, mask)
        if varies:
            live = self.narrowed(live, f"({self.lifted(Value(name, start.varies), INT)} {sign} "
                                       f"{self.lifted(stop, INT)})")
            self.out(f"{made.left} = {made.left} | ~{live};")
        if start.varies:
            self.out(f"{made.left}_turn = {live};")
        self.out(f"if (!lanes_any({live})) break;")
        if mask is None and not varies and self.is_long(loop.body):
            self.out(f"if (!lanes_any(~{live})) {{")
            self.counted(loop, start.varies, None, made)
            self.out("} else {")
            self.counted(loop, start.varies, live, made)
            self.out("}")
            self.depth -= 1
        else:
            self.depth -= 1
            self.counted(loop, start.varies, live, made)
        self.out("}")
        self.ended(made)

    def counted(self, loop: For, varies: bool, mask: str | None, made: Loop | None) -> None:
        """A turn of a loop whose number has a name."""
        outer = self.counters
        self.counters = {**outer, loop.name: varies}
        self.turn(loop, loop.body, mask, made)
        self.counters = outer


def calls(statement: Statement) -> bool:
    """Return True if a function is called in a statement."""
    values: tuple[Expr, ...] = ()
    match statement:
        case Assign(target=target, value=value):
            values = (target, value)
        case If(test=test):
            values = (test,)
        case Return(values=given):
            values = given
    return any(isinstance(each, Call) for value in values for each in within(value))
