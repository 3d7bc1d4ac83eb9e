"""What is committed of a stage is what its description writes."""

import ast
from dataclasses import replace
from pathlib import Path

import pytest
from facts import raises
from jinja2 import UndefinedError
from jinja2.meta import find_referenced_templates

from maglev.api.repository import FILES as REPOSITORY
from maglev.descriptions.description_file import PACKAGED, read_stage
from maglev.descriptions.names import TEMPLATES, own_names
from maglev.descriptions.own_fmus import DEFINITIONS
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.writer import (
    LONGEST,
    PAGES,
    environment,
    page_texts,
    paths,
    template,
    written_class,
)
from pmlsm.stage_description import StageDescription, StageMotor

ROOT = PACKAGED.parent


def crowded(stage: StageDescription) -> StageDescription:
    """A stage with more motors, of longer names, than any of ours."""
    motors = tuple(StageMotor(f"{axis.name}_motor_number_{k}", axis.name, stage.motors[0].amplifier, 0.1 * k,
                              0.3 - 0.1 * k)
                   for axis in stage.horizontal for k in range(4))
    return replace(stage, name="crowded", motors=motors, sharing=1.0)


@pytest.mark.parametrize("name", PACKAGED_STAGES)
def test_modules_are_as_written(name: str) -> None:
    different = {path for path, text in page_texts(read_stage(PACKAGED / f"{name}.toml")).items()
                 if (ROOT / path).read_text(encoding="utf-8") != text}
    assert not different, "run make generate"


@pytest.mark.parametrize("name", PACKAGED_STAGES)
def test_every_description_of_this_project_fits_together(name: str) -> None:
    assert read_stage(PACKAGED / f"{name}.toml") == PACKAGED_STAGES[name] and PACKAGED_STAGES[name].name == name


@pytest.mark.parametrize("path", PAGES)
def test_no_module_of_a_stage_is_left_over(path: str) -> None:
    """A stage that is gone, or a module that has another name now, leaves no module behind."""
    folder, stem = Path(path).parent, Path(path).name.partition("{}")
    found = {file.name for file in (ROOT / folder).glob(f"{stem[0]}[0-9]dof{stem[2]}")}
    assert found == {f"{stem[0]}{name}{stem[2]}" for name, stage in PACKAGED_STAGES.items() if path in paths(stage)}


def test_no_template_is_left_over() -> None:
    used = {template(path, tilting) for path in PAGES for tilting in (False, True)}
    used |= {f"new/{what}.j2" for what in (
        "controller.py", "controller_tilting.py", "plant.py", "plant_tilting.py", "stage.toml", "scenario.toml",
        "study.toml", "tuning.toml", *(f"repository/{name}" for name in REPOSITORY))}
    used.add("written/definition.py.j2")   # around classes of users
    reached: set[str] = set()
    while used - reached:
        name = (used - reached).pop()
        reached.add(name)
        used |= set(filter(None, find_referenced_templates(environment().parse((TEMPLATES / name).read_text("utf-8")))))
    assert reached == {path.relative_to(TEMPLATES).as_posix() for path in TEMPLATES.rglob("*") if path.is_file()}


def test_a_name_that_a_template_does_not_know_is_an_error() -> None:
    with raises(UndefinedError, "'moters'"):
        environment().from_string("{% for motor in moters %}{% endfor %}").render(motors=["alpha"])


@pytest.mark.parametrize("name", PACKAGED_STAGES)
def test_no_axis_or_motor_can_have_a_name_with_which_variables_begin(name: str) -> None:
    stage = PACKAGED_STAGES[name]
    own = {*stage.axis_names, *stage.motor_names, *(constant.name for constant in stage.constants)}
    first = {variable.name.partition(".")[0] for variable in DEFINITIONS[f"Plant{stage.suffix}"].value().variables}
    assert len(first - own) > 5
    assert first - own <= own_names()


@pytest.mark.parametrize("name", PACKAGED_STAGES)
def test_lines_of_code_are_within_their_length_for_any_number_of_motors(name: str) -> None:
    stage = crowded(PACKAGED_STAGES[name])
    modules = {kind: written_class(kind, stage, "Mine", "mine.py") for kind in ("controller", "plant")}
    for path, text in modules.items():
        documentation = {line for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Expr)
                         and isinstance(node.value, ast.Constant)
                         for line in range(node.lineno, (node.end_lineno or node.lineno) + 1)}
        long = {line: code for line, code in enumerate(text.splitlines(), 1)
                if len(code) > LONGEST and line not in documentation and not code.lstrip().startswith("#")}
        assert not long, path
