"""Text of templates of Python modules: terms, imports, comments below each other, lines within their length."""

import re
from collections.abc import Iterable, Sequence
from dataclasses import MISSING, fields
from itertools import accumulate
from typing import Any

from pmlsm.stage_description import Mode, Ripple, Roughness, Stop

LONGEST = 120   # characters of a line
BREAKS = re.compile(r" (?=(?:and|or) )"), re.compile(r" (?=[+-] )"), re.compile(", ")   # the best first
BRACKETLESS = re.compile(r"^(\s*(?:if not|if|return|[\w.]+ =) )(.+?)(:?)$")
NO_STOP = Stop(-10.0, 10.0, 0.0, 0.0)   # of an axis whose stops are at the motors


def each(items: Iterable[str | tuple[str, ...]], text: str, between: str = ", ") -> str:
    """The text for each item, which stands in it as {0}, or whose parts do as {0}, {1} and so on."""
    return between.join(text.format(*((item,) if isinstance(item, str) else item)) for item in items)


def sum_text(items: Sequence[str], text: str = "{0}") -> str:
    """Sum of the text for each item, in brackets where there are several."""
    terms = each(items, text, " + ")
    return terms if len(items) == 1 else f"({terms})"


def mean(items: Sequence[str], text: str) -> str:
    return factor(1.0 / len(items)) + sum_text(items, text)


def factor(value: float) -> str:
    """Factor before a term, left out where it is 1."""
    return "" if value == 1.0 else f"{value!r} * "


def stated(part: Any) -> dict[str, Any]:
    """Names and values of a description's dataclass that have no default, or are not as their class has them."""
    values = {member.name: getattr(part, member.name) for member in fields(part)}
    return {member.name: values[member.name] for member in fields(part) if values[member.name] != (
        member.default if member.default_factory is MISSING else member.default_factory())}


def not_default(part: Ripple | Roughness | Stop | Mode) -> list[tuple[str, float]]:
    """Names and values that the constructor of an axis does not take and that differ from its defaults."""
    return [(name, value) for name, value in stated(part).items() if hasattr(type(part), name)]   # a default is there


def sorted_imports(text: str) -> str:
    """Imports in their order, those of one module together; a line for each member where they are too many for one."""
    members: dict[str, set[str]] = {}
    for module, names in re.findall(r"^from (\S+) import (.+)$", text, re.MULTILINE):
        members.setdefault(module, set()).update(names.split(", "))
    written = ""
    for module, unsorted in sorted(members.items()):
        names = sorted(unsorted, key=lambda name: (not name.isupper(), not name[0].isupper(), name.lower()))
        line = f"from {module} import {', '.join(names)}"
        if len(line) > LONGEST:
            line = f"from {module} import (\n" + "".join(f"    {name},\n" for name in names) + ")"
        written += line + "\n"
    return written


def aligned_comments(text: str) -> str:
    """Assignments with their comments below each other."""
    pairs = [line.partition("  # ") for line in text.splitlines()]
    width = max(len(code) for code, _, _ in pairs) + 2
    return "".join(f"{f'{code:<{width}}# {comment}' if comment else code}\n" for code, _, comment in pairs)


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
