"""Reads the statements of a function into a typed program."""

import ast
from collections.abc import Sequence

from maglev.language.calls import Calls
from maglev.language.expressions import writes
from maglev.language.program import (
    BOOL,
    FLOAT,
    INT,
    Assign,
    Call,
    Const,
    Expr,
    Field,
    For,
    Function,
    If,
    Item,
    Jump,
    List,
    Local,
    Operation,
    Perform,
    Return,
    Scalar,
    Statement,
    Struct,
    Type,
    While,
)
from maglev.language.reader import Reader
from maglev.language.sources import parsed_expression

# Statements that the language does not have, and their replacements.
STATEMENTS: dict[type[ast.AST], str] = {
    ast.Raise: "raise: expected a value that says so", ast.Try: "try: expected an if before it can fail",
    ast.With: "with: expected numbers only", ast.Assert: "assert: expected an if",
    ast.AsyncFunctionDef: "async: expected a def next to the class", ast.Global: "global: expected an attribute",
    ast.Nonlocal: "nonlocal: expected an attribute", ast.Match: "match: expected an if",
    ast.Delete: "del: expected an assignment", ast.FunctionDef: "a def in a function: expected it next to the class",
    ast.ClassDef: "a class in a function: expected it next to that of the block",
    ast.Import: "an import in a function: expected it at the top of the file",
    ast.ImportFrom: "an import in a function: expected it at the top of the file"}


class Statements(Calls):
    """The state of reading one function."""

    def block(self, nodes: Sequence[ast.stmt], body: list[Statement]) -> None:
        """Read statements into a body; statements behind a return have no effect, and are not read."""
        for node in nodes:
            if self.ended:
                return
            before, self.body = self.body, body
            self.statement(node)
            self.body = before

    def inner(self, nodes: Sequence[ast.stmt]) -> tuple[list[Statement], set[str], bool]:
        """Read a branch: its body, the names that have values at its end, and whether its end is never reached."""
        before = set(self.known), self.ended
        body: list[Statement] = []
        self.block(nodes, body)
        after = self.known, self.ended
        self.known, self.ended = before
        return body, *after

    def statement(self, node: ast.stmt) -> None:
        match node:
            case ast.Expr(value=ast.Constant()) | ast.Pass():
                return
            case ast.Expr(value=ast.Call() as call):
                self.performed(call)
            case ast.Assign(targets=[ast.Tuple() as target], value=value):
                self.unpack(target, value)
            case ast.Assign(targets=targets, value=value):
                result = self.expression(value)
                if len(targets) > 1 and not isinstance(result, Const | Local):
                    result = self.temporary(result)
                for each in targets:
                    self.assign(each, result)
            case ast.AnnAssign(target=target, value=ast.expr() as value):
                self.assign(target, self.expression(value))
            case ast.AugAssign(target=target, op=op, value=value):
                self.augmented(node, target, op, value)
            case ast.If(test=test, body=yes, orelse=no):
                self.condition(test, yes, no)
            case ast.While(test=test, body=inner, orelse=[]):
                self.loop_while(test, inner)
            case ast.For(target=target, iter=over, body=inner, orelse=[]):
                self.loop_over(node, target, over, inner)
            case ast.Return(value=value):
                self.leave(node, value)
            case ast.Break() | ast.Continue():
                self.body.append(Jump("break" if isinstance(node, ast.Break) else "continue"))
                self.jumps.append(set(self.known))
                self.ended = True
            case ast.For() | ast.While():
                raise self.refusal(node, "an else of a loop: expected an if behind the loop")
            case _:
                raise self.refusal(node, STATEMENTS.get(type(node), f"{ast.unparse(node).splitlines()[0]}: expected an "
                                                        "assignment, an if, a for, a while or a return"))

    def performed(self, node: ast.Call) -> None:
        """Read a call whose result nobody takes."""
        result = self.call(node, alone=True)
        if isinstance(result, Call):
            self.body.append(Perform(result))

    # Assignments

    def augmented(self, node: ast.AugAssign, target: ast.expr, op: ast.operator, value: ast.expr) -> None:
        """Read `place += value`: the place is found and read once, before the value is computed."""
        place = self.expression(self.loading(target))
        if any(isinstance(each, ast.Call) for each in ast.walk(node)) and isinstance(place, Field | Item):
            place = self.steady(place)
        before, (own, added) = place, self.aside(lambda: self.expression(value))
        if own or writes(added):
            before = self.kept(place)
        self.body += own
        result = self.operation(node, op, before, added)
        if isinstance(target, ast.Name):
            self.bind(target, result)
            return
        self.checked_place(target, place, result.type)
        if writes(result):
            result = self.temporary(result)
        self.body.append(Assign(place, result))

    def loading(self, target: ast.expr) -> ast.expr:
        loaded = ast.copy_location(parsed_expression(ast.unparse(target)), target)
        for each in ast.walk(loaded):
            ast.copy_location(each, target)
        return loaded

    def assign(self, target: ast.expr, value: Expr) -> None:
        """Add the assignment of a value."""
        if value.type is None:
            raise self.refusal(target, "a call that returns nothing has no value: expected a return in it")
        if isinstance(target, ast.Name):
            self.bind(target, value)
            return
        called = any(isinstance(each, ast.Call) for each in ast.walk(target))
        chosen = any(isinstance(each, ast.Subscript) for each in ast.walk(target))
        if (called or (chosen and writes(value))) and not isinstance(value, Const):   # the value comes first
            value = self.temporary(value)
        place = self.place(target, value.type)
        self.body.append(Assign(place, value))

    def bind(self, target: ast.Name, value: Expr) -> None:
        """Assign to a local name, which keeps its type."""
        name, kind = target.id, value.type
        self.declare(target, name, kind)
        if isinstance(kind, List | Struct):
            self.refers.setdefault(name, []).append(value)
            if name in self.function.changed:
                self.mark_changed(target, value)
        self.body.append(Assign(Local(name, kind), value))
        self.known.add(name)

    def declare(self, node: ast.AST, name: str, kind: Type) -> None:
        before = self.types.setdefault(name, kind)
        if before != kind:
            raise self.refusal(node, f"{name} is {self.words(before)} and becomes {self.words(kind)}: expected "
                                     f"{self.instead(before, kind)}")
        if name not in self.parameters:
            self.function.locals[name] = kind

    def place(self, target: ast.expr, kind: Type) -> Expr:
        """The attribute or element that a value of a type goes to."""
        if isinstance(target, ast.Starred):
            raise self.refusal(target, "*: expected every value by itself")
        place = self.expression(target)
        self.checked_place(target, place, kind)
        return place

    def checked_place(self, target: ast.expr, place: Expr, kind: Type) -> None:
        """Raise if a target cannot be assigned, and note what the assignment changes."""
        shown = ast.unparse(target)
        if not isinstance(place, Field | Item):
            raise self.refusal(target, f"{shown} cannot be assigned: expected an attribute that __init__ sets")
        if not isinstance(place.type, Scalar):
            raise self.refusal(target, f"{shown} is {self.words(place.type)}, which cannot be replaced: expected "
                                       "assignments to its attributes or elements")
        if place.type != kind:
            raise self.refusal(target, f"{shown} starts as {self.words(place.type)} and is assigned "
                                       f"{self.words(kind)}: expected {self.instead(place.type, kind)}")
        self.mark_changed(target, place)

    def unpack(self, target: ast.Tuple, value: ast.expr) -> None:
        """Read `a, b = …` with as many values, or of a call that returns them."""
        if isinstance(value, ast.Tuple):
            if len(value.elts) != len(target.elts):
                raise self.refusal(target, f"{len(value.elts)} values for {len(target.elts)} names: expected as many")
            results: list[Expr] = [each if isinstance(each, Const) else self.temporary(each)
                                   for each in self.in_order(value.elts)]
            for each, result in zip(target.elts, results, strict=True):
                self.assign(each, result)
            return
        call = self.call(value, alone=True) if isinstance(value, ast.Call) else None
        if not isinstance(call, Call) or len(call.function.results) != len(target.elts):
            raise self.refusal(value, f"{ast.unparse(value)} for {len(target.elts)} names: expected as many values")
        places: list[Expr] = []
        late: list[tuple[ast.expr, Expr]] = []
        for each, kind in zip(target.elts, call.function.results, strict=True):
            if isinstance(each, ast.Name) and each.id == "_":
                places.append(self.new_local(kind))
            elif isinstance(each, ast.Name) and not late:   # a later value may choose the element
                self.declare(each, each.id, kind)
                self.known.add(each.id)
                places.append(Local(each.id, kind))
            elif isinstance(each, ast.Attribute) and isinstance(each.value, ast.Name) and not late:
                places.append(self.place(each, kind))
            else:
                places.append(self.new_local(kind))
                late.append((each, places[-1]))
        self.body.append(Perform(call, tuple(places)))
        for each, result in late:
            self.assign(each, result)

    # Branches and loops

    def condition(self, test: ast.expr, yes: Sequence[ast.stmt], no: Sequence[ast.stmt]) -> None:
        condition = self.truth(test)
        body, known, ended = self.inner(yes)
        other, known_other, ended_other = self.inner(no)
        self.body.append(If(condition, body, other))
        self.known = known_other if ended else known if ended_other else known & known_other
        self.ended = ended and ended_other

    def loop_while(self, test: ast.expr, inner: Sequence[ast.stmt]) -> None:
        """Read a loop; statements that its condition needs are computed at its beginning, in each turn."""
        endless = isinstance(test, ast.Constant) and test.value is True
        before, known, self.jumps, outer = self.body, set(self.known), [], self.jumps
        head: list[Statement] = []
        self.body = head
        condition = self.truth(test)
        self.body = before
        body, _, _ = self.inner(inner)
        if head:
            stop = If(Operation("not", (condition,), BOOL), [Jump("break")], [])
            self.body.append(While(Const(True, BOOL), [*head, stop, *body]))
        else:
            self.body.append(While(condition, body))
        leaves = any(isinstance(each, ast.Break) for statement in inner for each in ast.walk(statement))
        self.ended = endless and not leaves
        self.known, self.jumps = known, outer

    def loop_over(self, node: ast.For, target: ast.expr, over: ast.expr, inner: Sequence[ast.stmt]) -> None:
        """Read a loop over a range, a list, or enumerate or zip of lists."""
        function = over.func.id if isinstance(over, ast.Call) and isinstance(over.func, ast.Name) else ""
        if function == "range":
            assert isinstance(over, ast.Call)
            self.loop_range(node, target, over, inner)
            return
        counter: ast.Name | None = None
        lists = [(target, over)]
        if function in ("zip", "enumerate"):
            assert isinstance(over, ast.Call)
            targets = list(target.elts) if isinstance(target, ast.Tuple) else []
            if function == "enumerate" and (len(over.args) != 1 or over.keywords):
                raise self.refusal(node, f"{ast.unparse(over)}: expected enumerate() of one list")
            if len(targets) != (2 if function == "enumerate" else len(over.args)):
                raise self.refusal(node, f"{ast.unparse(target)} in {ast.unparse(over)}: expected a name for each "
                                         "value")
            if function == "enumerate":
                if not isinstance(targets[0], ast.Name):
                    raise self.refusal(node, f"{ast.unparse(targets[0])}: expected a name for the number")
                counter, lists = targets[0], [(targets[1], over.args[0])]
            else:
                lists = list(zip(targets, over.args, strict=True))
        elif not isinstance(target, ast.Name) or isinstance(over, ast.Call):
            raise self.refusal(node, f"{ast.unparse(target)} in {ast.unparse(over)}: expected a name in range(), in a "
                                     "list, enumerate() or zip() of lists")
        sources = [self.steady(source) for source in self.in_order([each for _, each in lists])]
        for (_, written), source in zip(lists, sources, strict=True):
            if not isinstance(source.type, List):
                raise self.refusal(written, f"{ast.unparse(written)} is {self.words(source.type)}: expected range(), a "
                                            "list, enumerate() or zip() of lists")
        lengths = {source.type.length for source in sources if isinstance(source.type, List)}
        if len(lengths) > 1:
            many = " and ".join(map(str, sorted(lengths)))
            raise self.refusal(over, f"{ast.unparse(over)}: lists of {many} elements, expected equal lengths")
        length, = lengths
        if not length:
            return
        if counter is not None and self.own_counter(node, counter.id):
            index = Local(counter.id, INT)
            self.types[counter.id] = INT
            self.within[counter.id] = range(length)
            self.known.add(counter.id)
        else:
            index = self.new_counter()
        before, body = self.body, list[Statement]()
        self.body = body
        if counter is not None and index.name != counter.id:
            self.bind(counter, index)
        for (each, _), source in zip(lists, sources, strict=True):
            self.assign(each, self.element(source, index))
        self.body = before
        rest, known, ended = self.repeated(inner)
        body += rest
        self.body.append(For(index.name, Const(0, INT), Const(length, INT), 1, body))
        self.after_loop(known, ended, True)

    def loop_range(self, node: ast.For, target: ast.expr, over: ast.Call, inner: Sequence[ast.stmt]) -> None:
        if not isinstance(target, ast.Name) or not 1 <= len(over.args) <= 3 or over.keywords:
            raise self.refusal(node, f"{ast.unparse(target)} in {ast.unparse(over)}: expected a name, and one to three "
                                     "whole numbers")
        bounds = self.in_order(over.args)
        for written, bound in zip(over.args, bounds, strict=True):
            if bound.type != INT:
                raise self.refusal(written, f"{ast.unparse(written)} is {self.words(bound.type)}: expected a whole "
                                            "number")
        start, stop = (Const(0, INT), bounds[0]) if len(bounds) == 1 else bounds[:2]
        step = bounds[2] if len(bounds) == 3 else Const(1, INT)
        if not isinstance(step, Const) or step.value == 0:
            raise self.refusal(over, f"{ast.unparse(over)}: expected a step that is written there, other than 0")
        if not isinstance(stop, Const):
            stop = self.temporary(stop)   # it does not change while the loop continues
        turns = range(start.value, stop.value, step.value) if isinstance(start, Const) and isinstance(
            stop, Const) else None
        if turns is not None and not turns:
            return
        body: list[Statement] = []
        if self.own_counter(node, target.id):
            name = target.id
            self.types[name] = INT
            self.known.add(name)
        else:
            counter = self.new_counter()
            name = counter.name
            before, self.body = self.body, body
            self.bind(target, counter)
            self.body = before
        self.within.pop(target.id, None)
        if turns is not None:
            self.within[name] = turns
        rest, known, ended = self.repeated(inner)
        self.body.append(For(name, start, stop, step.value, [*body, *rest]))
        self.after_loop(known, ended, turns is not None)

    def repeated(self, inner: Sequence[ast.stmt]) -> tuple[list[Statement], set[str], bool]:
        outer, self.jumps = self.jumps, []
        rest, known, ended = self.inner(inner)
        for jumped in self.jumps:   # a turn may end, and the loop be left, at a break or continue
            known = jumped if ended else known & jumped
            ended = False
        self.jumps = outer
        return rest, known, ended

    def after_loop(self, known: set[str], ended: bool, turns: bool) -> None:
        """Update the known names behind a loop; `turns` is true if it has a turn for certain."""
        if turns and not ended:
            self.known |= known
        elif turns:
            self.ended = True

    def own_counter(self, node: ast.For, name: str) -> bool:
        """Return True if a loop's name is only read, and only within loops over this name."""
        if name in self.parameters:
            return False
        loops = [each for each in ast.walk(self.node) if isinstance(each, ast.For) and name in stored(each.target)]
        inside = {id(each) for loop in loops for part in (loop.target, *loop.body) for each in ast.walk(part)}
        everywhere = [each for each in ast.walk(self.node) if isinstance(each, ast.Name) and each.id == name]
        written = [each for each in everywhere if isinstance(each.ctx, ast.Store)]
        nested = any(other is not loop and any(each is other for part in loop.body for each in ast.walk(part))
                     for loop in loops for other in loops)
        return len(written) == len(loops) and not nested and all(id(each) in inside for each in everywhere)

    def leave(self, node: ast.Return, value: ast.expr | None) -> None:
        """Read a return, whose values have the types of every other one."""
        self.ended = True
        if value is None:
            values: tuple[Expr, ...] = ()
        elif isinstance(value, ast.Tuple):
            values = tuple(self.in_order(value.elts))
        elif isinstance(value, ast.Call) and isinstance(call := self.call(value, alone=True), Call):
            kinds = call.function.results
            if len(kinds) > 1:
                places = tuple(self.new_local(kind) for kind in kinds)
                self.body.append(Perform(call, places))
                values = places
            elif kinds:
                values = (call,)
            else:
                self.body.append(Perform(call))
                values = ()
        else:
            values = (call if isinstance(value, ast.Call) else self.expression(value),)
        types = tuple(each.type for each in values)
        if any(not isinstance(kind, Scalar) for kind in types):
            raise self.refusal(node, f"{ast.unparse(node)}: expected numbers or Booleans")
        if self.returned is not None and self.returned != types:
            raise self.refusal(node, f"{ast.unparse(node)} has {self.all_words(types)}, another return "
                                     f"{self.all_words(self.returned)}: expected the same"
                                     + (", such as 0.0 for 0" if {FLOAT, INT} <= {*types, *self.returned} else ""))
        self.returned = self.function.results = types
        self.body.append(Return(values))

    def all_words(self, types: Sequence[Type]) -> str:
        return " and ".join(map(self.words, types)) or "no value"


def stored(target: ast.expr) -> set[str]:
    return {each.id for each in ast.walk(target) if isinstance(each, ast.Name)}


class Program(Reader):
    """A block as a typed program, see `Reader`."""

    def read_body(self, function: Function, node: ast.FunctionDef) -> None:
        """Fill in the body of a function."""
        reader = Statements(self, function)
        if node.decorator_list:
            raise reader.refusal(node, f"a decorator of {node.name}: expected a plain def")
        reader.block(node.body, function.body)
        if function.results and not reader.ended:
            raise reader.refusal(node, f"{node.name} may end without a return: expected one on every way")
