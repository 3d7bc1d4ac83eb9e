"""Writes modules and pages of a stage: templates that look like their results, with the stage's names in them."""

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
        "aligned": text.aligned_comments, "cited": tex.cited, "each": text.each,
        "imports": text.sorted_imports, "line": in_one_line, "mean": text.mean,
        "not_default": text.not_default, "page_text": page_text, "quoted": quoted, "sentence": tex.tex_sentence,
        "stop": lambda axis: axis.stop or text.NO_STOP, "total": text.sum_text}
    return made


def render(template: str, stage: StageDescription, **more: Any) -> str:
    """Text by a template; in the equations of a page, the names are in TeX."""
    page = template.endswith(".html.j2")
    return environment().get_template(template).render(template_values(stage) | (tex.tex(stage) if page else {}) | more)


def template_values(stage: StageDescription) -> dict[str, Any]:
    """Values for the templates of a stage.

    `y` is the name of the vertical axis, `x`, `z`, `roll` and `pitch` are those of the others where the platform tilts.
    With one horizontal axis there is no `z`, and guides hold `pitch` (`single`). `stopped` are those that have stops.
    `attraction`, `coils` and `iron` are the constants in the row of the vertical axis, `carried` all three with one
    direct current in all motors. Factors before a term are `n`, motors that share a current, and `all` motors. By
    horizontal axis: `thrust`, the constant in its row, `motors_of`, the motors that drive it, and `driving`, their
    number as a factor. `drives` has each motor with the axis that it drives, `place` by axis the position with which
    its motors commutate, `driven` the axes, each as often as motors drive it. `unlike` are the motors of another kind;
    `its` is the name of a motor's geometry in loops over motors. `kinds` has each motor with its geometry, `angles`
    each electrical angle with its geometry and displacement, `turning` each motor with its angle. `carries` has by
    motor the value of `carried` if all motors were like this one, `linears` the linearisation of each. `held_tilts` are
    the initial values of tilts that are not 0, and `added` is by axis the way in which an estimator takes in its
    motors.
    """
    horizontal = [axis.name for axis in stage.horizontal]
    single = len(horizontal) == 1
    tilts = [axis.name for axis in stage.rotations]
    attraction, coils, iron = stage.constants_of(stage.vertical.name)
    motors_of = {axis: [motor.name for motor in stage.motors_of(axis)] for axis in horizontal}
    unlike = [motor.name for motor in stage.unlike]
    place = {axis: f"{names[0]}_mount.displacement" if tilts else f"{axis}.position"
             for axis, names in motors_of.items()}
    rows = {"attraction": attraction, "coils": coils, "iron": iron}
    return {
        "stage": stage, "tilting": bool(tilts), "schedule": stage.design.schedule,
        "table": stage.design.table,
        "y": stage.vertical.name,
        **(dict(zip(("x", "z", "roll", "pitch"), [*horizontal, "", *tilts, HELD] if single else horizontal + tilts,
                    strict=True)) if tilts else {}),
        "single": single,
        "axes": list(stage.axis_names), "horizontal": horizontal, "tilts": tilts,
        # Of y, x, z, roll, pitch where the platform tilts; directions that guides hold have any.
        "masses": [stage.vertical.mass, *(axis.mass for axis in stage.horizontal), *([1.0] if single else []),
                   *(axis.mass for axis in stage.rotations), *([1.0] if single else [])],
        "stopped": [axis.name for axis in stage.axes if axis.stop is not None],
        "motors": list(stage.motor_names), "drives": [(motor.name, motor.drives) for motor in stage.motors],
        "place": place,
        "motors_of": motors_of,
        "driving": {axis: text.factor(stage.sharing * len(names)) for axis, names in motors_of.items()},
        "driven": [axis for axis, names in motors_of.items() for _ in names],
        "n": text.factor(stage.sharing), "all": text.factor(stage.carrying),
        **rows,
        "thrust": {axis: stage.constants_of(axis)[0] for axis in horizontal},
        "carried": text.each(rows.values(), text.factor(stage.carrying) + "self.{0}"),
        "carries": {motor: text.each(rows.items(), f"{text.factor(stage.carrying)}self.{motor}_ratio.{{0}} * self.{{1}}"
                                     if motor in unlike else text.factor(stage.carrying) + "self.{1}")
                    for motor in stage.motor_names},
        "unlike": unlike, "its": "geometry" if unlike else "self.geometry",
        "kinds": [(motor, f"self.{motor}_geometry" if motor in unlike else "self.geometry")
                  for motor in stage.motor_names],
        "angles": [*((axis, "geometry", place[axis]) for axis in horizontal if not {*motors_of[axis]} <= {*unlike}),
                   *((motor.name, f"self.{motor.name}_geometry", place[motor.drives]) for motor in stage.unlike)],
        "held_tilts": dict(zip(tilts, ("tilts.roll", "tilts.pitch"), strict=False)) if unlike else {},
        "linears": [f"self.{motor}_linear" if motor in unlike else "self.linear" for motor in stage.motor_names],
        "added": {axis: [f"rows.add_kind({motor}_geometry, {motor}_ratio, {gap}, self.{motor})"
                         if motor in unlike else f"rows.add(geometry, {gap}, self.{motor})"
                         for motor in names for gap in [f"self.{motor}_place.gap_measured" if tilts else
                                                        f"{stage.vertical.name}.measured"]]
                  for axis, names in motors_of.items()},
        "turning": [(motor.name, motor.name if motor.kind else motor.drives) for motor in stage.motors],
        "meaning": {constant.name: constant.meaning.removesuffix(stage.equation).strip()
                    for constant in stage.constants}}


def paths(stage: StageDescription) -> tuple[str, ...]:
    return () if stage.rotations else PAGES


def module_template(path: str, tilting: bool) -> str:
    """Template of a module, by its path; users' modules have one, too."""
    own = path.replace("{}", "tilting") + ".j2"
    return own if tilting and (TEMPLATES / own).is_file() else path.replace("_{}", "") + ".j2"


def module(path: str, stage: StageDescription) -> str:
    content = render(module_template(path, bool(stage.rotations)), stage)
    return text.fitted(content) if path.endswith(".py") else content


def written_class(kind: str, stage: StageDescription, name: str, file: str) -> str:
    """Text of a "controller" or a "plant" for a user of a stage to begin with: a class of a name, in a file."""
    return text.fitted(render(module_template(f"new/{kind}_{{}}.py", bool(stage.rotations)), stage, name=name,
                              file=file))


def module_texts(stage: StageDescription) -> dict[str, str]:
    """Text of every module of a stage, by its path from the folder of the packages."""
    return {path.format(stage.name): module(path, stage) for path in paths(stage)}


def write(stage: StageDescription, root: Path) -> None:
    """Write the modules of a stage below a folder that holds the packages."""
    for path, content in module_texts(stage).items():
        (root / path).parent.mkdir(parents=True, exist_ok=True)
        (root / path).write_text(content, encoding="utf-8")
