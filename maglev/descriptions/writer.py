"""Writes pages of a stage, and files for its user: templates that look like their results, with its names in them."""

import re
from collections.abc import Iterable, Sequence
from functools import cache
from itertools import accumulate
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING, Any

from maglev.descriptions import tex
from maglev.descriptions.names import HELD, TEMPLATES
from maglev.files.errors import in_one_line, quoted
from maglev.fmi.escapes import page_text
from pmlsm.stage_description import StageDescription

if TYPE_CHECKING:
    from jinja2 import Environment

# By path, in which {} is the name of the stage: equations, which are the same for all stages whose platform tilts.
PAGES = (
    "plant_fmu/documentation/stage_{}.html",
    "controller_fmu/documentation/linearisation_{}.html",
    "controller_fmu/documentation/setpoint_{}.html",
    "controller_fmu/documentation/rows_{}.html")

LONGEST = 120   # characters of a line
UNBROKEN = re.compile(r" (?=[!=<>*/]=? )|(?<= [!=<>]=) |(?<= [<>*/+-]) |(?<= and) |(?<= or) |(?<=:) ")   # spaces


@cache
def environment() -> "Environment":
    """Environment of the templates: a name that is not known is an error, and lines of control leave no trace."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # only where something is written

    made = Environment(loader=FileSystemLoader(TEMPLATES), undefined=StrictUndefined, trim_blocks=True,
                       lstrip_blocks=True, keep_trailing_newline=True)
    made.filters |= {
        "cited": tex.cited, "each": each, "line": in_one_line, "page_text": page_text, "quoted": quoted,
        "sentence": tex.tex_sentence, "total": sum_text}
    return made


def render(path: str, stage: StageDescription, **more: Any) -> str:
    """Text by a template; in the equations of a page, the names are in TeX."""
    in_tex = path.endswith(".html.j2")
    return environment().get_template(path).render(template_values(stage) | (tex.tex(stage) if in_tex else {}) | more)


def template_values(stage: StageDescription) -> dict[str, Any]:
    """Values for the templates of a stage.

    `y` is the name of the vertical axis, `x`, `z`, `roll` and `pitch` are those of the others where the platform tilts.
    With one horizontal axis there is no `z`, and guides hold `pitch` (`single`). `stopped` are those that have stops.
    `attraction`, `coils` and `iron` are the constants in the row of the vertical axis. Factors before a term are `n`,
    motors that share a current, and `all` motors. By horizontal axis: `thrust`, the constant in its row, `motors_of`,
    the motors that drive it, and `driving`, their number as a factor. `drives` has each motor with the axis that it
    drives. `unlike` are the motors of another kind; `its` is the name of a motor's geometry in loops over motors, and
    `kinds` has each motor with its geometry.
    """
    horizontal = [axis.name for axis in stage.horizontal]
    single = len(horizontal) == 1
    tilts = [axis.name for axis in stage.rotations]
    attraction, coils, iron = stage.constants_of(stage.vertical.name)
    motors_of = {axis: [motor.name for motor in stage.motors_of(axis)] for axis in horizontal}
    unlike = [motor.name for motor in stage.unlike]
    return {
        "stage": stage, "tilting": bool(tilts), "y": stage.vertical.name,
        **(dict(zip(("x", "z", "roll", "pitch"), [*horizontal, "", *tilts, HELD] if single else horizontal + tilts,
                    strict=True)) if tilts else {}),
        "single": single,
        "axes": list(stage.axis_names), "horizontal": horizontal, "tilts": tilts,
        # Values of y, x, z, roll, pitch where the platform tilts; directions that guides hold have any value.
        "masses": [stage.vertical.mass, *(axis.mass for axis in stage.horizontal), *([1.0] if single else []),
                   *(axis.mass for axis in stage.rotations), *([1.0] if single else [])],
        "stopped": [axis.name for axis in stage.axes if axis.stop is not None],
        "motors": list(stage.motor_names), "drives": [(motor.name, motor.drives) for motor in stage.motors],
        "motors_of": motors_of,
        "driving": {axis: factor(stage.sharing * len(names)) for axis, names in motors_of.items()},
        "n": factor(stage.sharing), "all": factor(stage.carrying),
        "attraction": attraction, "coils": coils, "iron": iron,
        "thrust": {axis: stage.constants_of(axis)[0] for axis in horizontal},
        "unlike": unlike, "its": "geometry" if unlike else "self.geometry",
        "kinds": [(motor, f"self.{motor}_geometry" if motor in unlike else "self.geometry")
                  for motor in stage.motor_names]}


def paths(stage: StageDescription) -> tuple[str, ...]:
    return () if stage.rotations else PAGES


def template(path: str, tilting: bool) -> str:
    """Template of a file by its path; there may be one of its own where the platform tilts."""
    own = path.replace("{}", "tilting") + ".j2"
    return own if tilting and (TEMPLATES / own).is_file() else path.replace("_{}", "") + ".j2"


def written_page(path: str, stage: StageDescription) -> str:
    """Text of a page of a stage, by one of the paths in `PAGES`."""
    return render(template(path, bool(stage.rotations)), stage)


def written_class(kind: str, stage: StageDescription, name: str, file: str) -> str:
    """Text of a "controller" or a "plant" for a user of a stage to begin with: a class of a name, in a file."""
    return fitted(render(template(f"new/{kind}_{{}}.py", bool(stage.rotations)), stage, name=name, file=file))


def page_texts(stage: StageDescription) -> dict[str, str]:
    """Text of every page of a stage, by its path from the folder of the packages."""
    return {path.format(stage.name): written_page(path, stage) for path in paths(stage)}


def write(stage: StageDescription, root: Path) -> None:
    """Write the pages of a stage below a folder that holds the packages."""
    for path, content in page_texts(stage).items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(content, encoding="utf-8")


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
    """A line of code in lines within their length, if it is in one bracket from that bracket on; else as it is.

    A line without brackets that ends with a comma is in one that is open already.
    """
    code, mark, comment = line.partition("   #")
    begin = min(filter(lambda place: place >= 0, map(code.find, "([{")), default=-1)
    depths = list(accumulate((letter in "([{") - (letter in ")]}") for letter in code.rstrip(":,")))
    if begin < 0 and code.endswith(","):
        begin = len(code) - len(code.lstrip()) - 1
    elif begin < 0 or 0 in depths[begin:-1]:
        return line
    return fill(UNBROKEN.sub("\N{NO-BREAK SPACE}", code), LONGEST, subsequent_indent=" " * (begin + 1),
                break_long_words=False, break_on_hyphens=False).replace("\N{NO-BREAK SPACE}", " ") + mark + comment
