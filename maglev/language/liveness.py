"""The local names of a function that are read after a statement before they get another value."""

from collections.abc import Iterator

from maglev.language.program import (
    Assign,
    Call,
    Choice,
    Expr,
    Field,
    For,
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
)

Names = frozenset[str]
NONE: Names = frozenset()


def parts_of(value: Expr) -> tuple[Expr, ...]:
    """The expressions that an expression is made of."""
    match value:
        case Field(base=base):
            return (base,)
        case Item(base=base, index=index):
            return base, index
        case Operation(operands=operands) | Logic(operands=operands):
            return operands
        case Choice(test=test, yes=yes, no=no):
            return test, yes, no
        case Call(arguments=arguments):
            return arguments
    return ()


def within(value: Expr) -> Iterator[Expr]:
    """An expression and all that it is made of."""
    yield value
    for part in parts_of(value):
        yield from within(part)


def names_in(*values: Expr) -> Names:
    return frozenset(each.name for value in values for each in within(value) if isinstance(each, Local))


class Liveness:
    """Names that are read later: `after` a statement, at the beginning of an `other` branch, at the `head` of a loop.

    All three are by the identity of a statement.
    """

    def __init__(self, body: list[Statement]):
        self.after: dict[int, Names] = {}
        self.other: dict[int, Names] = {}
        self.head: dict[int, Names] = {}
        self.before(body, NONE, NONE, NONE)

    def before(self, body: list[Statement], after: Names, left: Names, again: Names) -> Names:
        """Names that are read from the beginning of a body on; `left` after a break, `again` after a continue."""
        live = after
        for statement in reversed(body):
            self.after[id(statement)] = live
            match statement:
                case Assign(target=target, value=value):
                    live = self.given((target,), live) | names_in(value)
                case Perform(call=call, targets=targets):
                    live = self.given(targets, live) | names_in(call)
                case If(test=test, yes=yes, no=no):
                    self.other[id(statement)] = self.before(no, live, left, again)
                    live = self.before(yes, live, left, again) | self.other[id(statement)] | names_in(test)
                case While(test=test, body=inner):
                    live = self.loop(statement, inner, live, names_in(test), NONE)
                case For(name=name, start=start, stop=stop, body=inner):
                    live = self.loop(statement, inner, live, names_in(stop), frozenset({name})) | names_in(start)
                case Return(values=values):
                    live = names_in(*values)
                case Jump(word=word):
                    live = left if word == "break" else again
        return live

    def loop(self, loop: Statement, body: list[Statement], after: Names, tested: Names, counted: Names) -> Names:
        head = after | tested
        while True:
            more = head | (self.before(body, head, after, head) - counted)
            if more == head:
                self.head[id(loop)] = head
                return head
            head = more

    def given(self, targets: tuple[Expr, ...], live: Names) -> Names:
        """Names that are read before values go to targets, if `live` ones are after it."""
        own = frozenset(target.name for target in targets if isinstance(target, Local))
        return (live - own) | names_in(*(target for target in targets if not isinstance(target, Local)))
