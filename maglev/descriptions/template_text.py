"""Text of templates: terms, and Python with lines within their length."""

import re
from collections.abc import Iterable, Sequence
from itertools import accumulate
from textwrap import fill

LONGEST = 120   # characters of a line
UNBROKEN = re.compile(r" (?=[!=<>*/]=? )|(?<= [!=<>]=) |(?<= [<>*/+-]) |(?<= and) |(?<= or) |(?<=:) ")   # spaces


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
    """Text of a module in which brackets on lines of code that are too long continue below."""
    lines = text.split("\n")
    quotes = accumulate(line.count('"""') for line in lines)
    return "\n".join(line if len(line) <= LONGEST or '"""' in line or quoted % 2 else broken(line)
                     for line, quoted in zip(lines, quotes, strict=True))


def broken(line: str) -> str:
    """A line of code in lines within their length, if it is in one bracket from that bracket on; else as it is."""
    code, mark, comment = line.partition("   #")
    begin = min(filter(lambda place: place >= 0, map(code.find, "([{")), default=-1)
    depths = list(accumulate((letter in "([{") - (letter in ")]}") for letter in code.rstrip(":,")))
    if begin < 0 or 0 in depths[begin:-1]:
        return line
    return fill(UNBROKEN.sub("\N{NO-BREAK SPACE}", code), LONGEST, subsequent_indent=" " * (begin + 1), break_long_words=False,
                break_on_hyphens=False).replace("\N{NO-BREAK SPACE}", " ") + mark + comment
