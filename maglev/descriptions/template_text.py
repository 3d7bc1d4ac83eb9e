"""Text of templates: terms, and Python with lines within their length."""

import re
from collections.abc import Iterable, Sequence
from itertools import accumulate

LONGEST = 120   # characters of a line
BREAKS = re.compile(r" (?=(?:and|or) )"), re.compile(r" (?=[+-] )"), re.compile(", ")   # the best first
BRACKETLESS = re.compile(r"^(\s*(?:if not|if|return|[\w.]+ =) )(.+?)(:?)$")


def each(items: Iterable[str | tuple[str, ...]], text: str, between: str = ", ") -> str:
    """The text for each item, which stands in it as {0}, or whose parts do as {0}, {1} and so on."""
    return between.join(text.format(*((item,) if isinstance(item, str) else item)) for item in items)


def sum_text(items: Sequence[str], text: str = "{0}") -> str:
    """Sum of the text for each item, in brackets where there are several."""
    terms = each(items, text, " + ")
    return terms if len(items) == 1 else f"({terms})"


def factor(value: float) -> str:
    """Factor before a term, left out where it is 1."""
    return "" if value == 1.0 else f"{value!r} * "


def fitted(text: str) -> str:
    """Text of a module whose lines of code are within their length, as far as they can be broken."""
    lines = text.split("\n")
    quotes = accumulate(line.count('"""') for line in lines)
    fitting = []
    inside = 0   # brackets that are open
    for line, quoted in zip(lines, quotes, strict=True):
        if '"""' not in line and quoted % 2 == 0:
            code, mark, comment = line.partition("   #")
            if len(line) > LONGEST:
                code = broken(code, inside) or broken(BRACKETLESS.sub(r"\1(\2)\3", code), inside) or code
            inside += level(code)
            line = code + mark + comment
        fitting.append(line)
    return "\n".join(fitting)


def broken(code: str, inside: int) -> str:
    """A line, some brackets open before it, broken as far out as it can be; empty if it cannot be."""
    depth = len(code) - len(code.lstrip())
    done, rest = "", code
    while len(rest) > LONGEST:
        begin = len(rest) - len(rest.lstrip()) + 1
        cuts = [(inside + level(done + rest[:found.end()]), rank, -found.end())
                for rank, between in enumerate(BREAKS) for found in between.finditer(rest, begin, LONGEST)]
        cut = -min((each for each in cuts if each[0] > 0), default=(0, 0, 0))[2]
        columns = open_brackets(done + rest[:cut])
        indent = max(columns[-1] + 1, depth + 8) if columns else depth + 4
        if cut <= indent:
            return ""
        done += rest[:cut].rstrip() + "\n"
        rest = " " * indent + rest[cut:]
    return done + rest


def level(text: str) -> int:
    """Brackets that are open at the end of a text."""
    return sum((letter in "([{") - (letter in ")]}") for letter in text)


def open_brackets(text: str) -> list[int]:
    """Columns of the brackets of a text that are open at its end."""
    columns: list[int] = []
    for line in text.split("\n"):
        for column, letter in enumerate(line):
            if letter in "([{":
                columns.append(column)
            elif letter in ")]}":
                columns = columns[:-1]
    return columns
