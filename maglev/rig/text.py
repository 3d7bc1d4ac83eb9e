"""Pieces of Python text that the writers of blocks share."""

import re
from collections.abc import Iterable
from itertools import accumulate

from pmlsm.rig import Rig

LONGEST = 120   # characters of a line
BREAKS = re.compile(r" (?=(?:and|or) )"), re.compile(r" (?=[+-] )"), re.compile(", ")   # the best first
BRACKETLESS = re.compile(r"^(\s*(?:if not|if|return|[\w.]+ =) )(.+?)(:?)$")


def each(items: Iterable[str], text: str, between: str = "\n") -> str:
    """The text for each item, which stands in it as {0}."""
    return between.join(text.format(item) for item in items)


def times(factor: float, of: str) -> str:
    """Product, left out where the factor is 1."""
    return of if factor == 1.0 else f"{factor!r} * {of}"


def fitted(line: str) -> str:
    """A line of code, broken before an operator or after a comma, within brackets, where it is too long."""
    depth = len(line) - len(line.lstrip())
    done, rest = "", line
    while len(rest) > LONGEST:
        begin = len(rest) - len(rest.lstrip()) + 1
        cuts = ([found.end() for found in each.finditer(rest.partition("  #")[0], begin, LONGEST)] for each in BREAKS)
        cut = next((each[-1] for each in cuts if each), 0)
        bracket = open_bracket(done + rest[:cut])
        if bracket < 0:
            bracketed = BRACKETLESS.sub(r"\1(\2)\3", rest)
            if cut == 0 or bracketed == rest:
                break
            rest = bracketed
            continue
        done += rest[:cut].rstrip() + "\n"
        rest = " " * max(bracket + 1, depth + 8) + rest[cut:]
    return done + rest


def open_bracket(text: str) -> int:
    """Column of the innermost bracket that is open at the end of a text; -1 if none is."""
    columns, begin = [], 0
    for place, letter in enumerate(text):
        if letter in "([{":
            columns.append(place - begin)
        elif letter in ")]}":
            columns.pop()
        elif letter == "\n":
            begin = place + 1
    return columns[-1] if columns else -1


def commented(assignments: Iterable[tuple[str, str]]) -> str:
    """Assignments in a constructor, with their comments below each other."""
    pairs = list(assignments)
    width = max(len(code) for code, _ in pairs) + 2
    return "\n".join(f"        {f'{code:<{width}}# {comment}' if comment else code}".rstrip() for code, comment in pairs)


def unit_words(unit: str) -> str:
    """Unit as a comment has it, "m/(s² T²)" for "m/(s2.T2)"."""
    words = unit.replace(".", " ")
    for power, raised in (("s2", "s²"), ("T2", "T²"), ("A2", "A²"), ("T4", "T⁴"), ("A4", "A⁴")):
        words = words.replace(power, raised)
    return words


def constants(rig: Rig, which: str) -> list[tuple[str, str]]:
    """Assignments of the constants: those of the "stage", or of the "model" of the controllers."""
    return [(f"self.{each.name} = {getattr(each, which)!r}", f"{unit_words(each.unit)}, parameter: "
             f"{each.meaning.removesuffix(rig.equation).strip()}") for each in rig.constants]


def geometry(rig: Rig) -> list[tuple[str, str]]:
    """Assignments of the motor's geometry, as far as it is not that of the thesis."""
    return [("self.geometry = MotorGeometry()", ""),
            *((f"self.geometry.{path} = {value!r}", "") for path, value in rig.geometry.items())]


def vertical_constants(rig: Rig) -> tuple[str, str, str]:
    """Names of the constants of the vertical row: attraction, coils, iron."""
    attraction, coils, iron = rig.constants_of(rig.vertical.name)
    return attraction, coils, iron


def thrust_constant(rig: Rig, axis: str) -> str:
    """Name of the constant in the row of a horizontal axis."""
    return rig.constants_of(axis)[0]


def module(text: str) -> str:
    """Text of a module, without trailing spaces, with one line feed at its end; lines of code within their length."""
    lines = [line.rstrip() for line in text.strip("\n").split("\n")]
    if not lines[0].startswith('"""'):
        return "\n".join(lines) + "\n"
    quotes = list(accumulate(line.count('"""') for line in lines))
    return "\n".join(line if '"""' in line or quoted % 2 else fitted(line)
                     for line, quoted in zip(lines, quotes, strict=True)) + "\n"
