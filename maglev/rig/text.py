"""Pieces of Python text that the writers of blocks share."""

from collections.abc import Iterable

from pmlsm.rig import Rig

LONGEST = 120   # characters of a line


def each(items: Iterable[str], text: str, between: str = "\n") -> str:
    """The text for each item, which stands in it as {0}."""
    return between.join(text.format(item) for item in items)


def times(factor: float, of: str) -> str:
    """Product, left out where the factor is 1."""
    return of if factor == 1.0 else f"{factor!r} * {of}"


def wrapped(line: str, between: str) -> str:
    """A line of terms, broken before `between` where it is too long; the first bracket says how far in."""
    if len(line) <= LONGEST:
        return line
    depth = len(line) - len(line.lstrip()) + 8
    lines, rest = [], line
    while len(rest) > LONGEST:
        cut = rest.rindex(between, 0, LONGEST)
        lines.append(rest[:cut].rstrip())
        rest = " " * depth + rest[cut:].lstrip()
    return "\n".join([*lines, rest])


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
    """Text of a module, without trailing spaces, with one line feed at its end."""
    return "\n".join(line.rstrip() for line in text.strip("\n").split("\n")) + "\n"
