"""Writes pages of a stage, and files for its user: templates that look like their results, with its names in them."""

from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from maglev.descriptions import template_text as text
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


@cache
def environment() -> "Environment":
    """Environment of the templates: a name that is not known is an error, and lines of control leave no trace."""
    from jinja2 import Environment, FileSystemLoader, StrictUndefined  # only where something is written

    made = Environment(loader=FileSystemLoader(TEMPLATES), undefined=StrictUndefined, trim_blocks=True,
                       lstrip_blocks=True, keep_trailing_newline=True)
    made.filters |= {
        "cited": tex.cited, "each": text.each, "line": in_one_line, "page_text": page_text, "quoted": quoted,
        "sentence": tex.tex_sentence, "total": text.sum_text}
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
        # Of y, x, z, roll, pitch where the platform tilts; directions that guides hold have any.
        "masses": [stage.vertical.mass, *(axis.mass for axis in stage.horizontal), *([1.0] if single else []),
                   *(axis.mass for axis in stage.rotations), *([1.0] if single else [])],
        "stopped": [axis.name for axis in stage.axes if axis.stop is not None],
        "motors": list(stage.motor_names), "drives": [(motor.name, motor.drives) for motor in stage.motors],
        "motors_of": motors_of,
        "driving": {axis: text.factor(stage.sharing * len(names)) for axis, names in motors_of.items()},
        "n": text.factor(stage.sharing), "all": text.factor(stage.carrying),
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
    return text.fitted(render(template(f"new/{kind}_{{}}.py", bool(stage.rotations)), stage, name=name, file=file))


def page_texts(stage: StageDescription) -> dict[str, str]:
    """Text of every page of a stage, by its path from the folder of the packages."""
    return {path.format(stage.name): written_page(path, stage) for path in paths(stage)}


def write(stage: StageDescription, root: Path) -> None:
    """Write the pages of a stage below a folder that holds the packages."""
    for path, content in page_texts(stage).items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(content, encoding="utf-8")
