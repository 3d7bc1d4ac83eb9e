"""A stage follows from its description: nothing else decides by its name, or by names of its FMUs and motors."""

import ast
import re
from pathlib import Path

import pytest

from maglev.descriptions.names import TEMPLATES
from maglev.descriptions.packaged import PACKAGED_STAGES, best_stage
from maglev.descriptions.registry import definitions
from maglev.descriptions.writer import PAGES
from maglev.files.packages import PACKAGES
from maglev.scenario.layers import packaged_files, packaged_runs

ROOT = Path(__file__).parents[3]
GENERATED = {ROOT / path.format(name) for path in PAGES for name in PACKAGED_STAGES}
EXAMPLE = ROOT / "maglev" / "descriptions" / "__init__.py"   # names the stage of new files, where none is given
NAMES = {name
         for stage in PACKAGED_STAGES.values()
         for name in (stage.name, stage.suffix, *stage.motor_names, *definitions(stage))
         if name != "motor"}   # a word of its own, and the one motor of a stage
EXPERIMENTS = {*packaged_files(), *packaged_runs()}


def texts(source: str) -> list[tuple[int, str]]:
    """Lines and values of the strings of a module that are no docstrings."""
    tree = ast.parse(source)
    documentation = {id(node.value) for node in ast.walk(tree) if isinstance(node, ast.Expr)}
    return [(node.lineno, node.value) for node in ast.walk(tree)
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in documentation]


def named(text: str) -> set[str]:
    """Names of stages, FMUs and motors in a text; none in a sentence, which decides nothing, nor in an experiment's."""
    return {word for word in re.findall(r"[\w-]+", text) if " " not in text and word not in EXPERIMENTS
            and (word in NAMES or re.search(r"\ddof|\bdof", word, re.IGNORECASE))}


@pytest.mark.usefixtures("slow")
def test_no_module_decides_by_the_name_of_a_stage() -> None:
    assert [named(text) for text in ("3dof-setpoints", "3dof", "([23])dof", "fmus/Plant2DOF.fmu", "alpha.i_d")] == [
        set(), {"3dof"}, {"dof"}, {"Plant2DOF"}, {"alpha"}]
    sources = {path: path.read_text(encoding="utf-8") for package in PACKAGES
               for path in (ROOT / package).rglob("*.py") if path not in GENERATED and path != EXAMPLE}
    assert len(sources) > 100
    found = [f"{path.relative_to(ROOT)}:{line}: {words}" for path, source in sources.items()
             if named(source.replace(" ", "\n"))   # in whatever is no string: those take long to find
             for line, text in texts(source) for words in sorted(named(text))]
    assert found == []


def test_no_template_names_a_stage() -> None:
    files = list(TEMPLATES.rglob("*.j2"))
    assert len(files) > 15
    found = [f"{path.relative_to(TEMPLATES)}: {word}" for path in files
             # except for the letters of TeX
             for word in re.findall(r"(?<![\\\w])\w+", path.read_text(encoding="utf-8"))
             if word in NAMES or re.search(r"\ddof", word, re.IGNORECASE)]
    assert found == []


def test_a_run_is_about_the_stage_of_its_fmus_or_else_of_its_axes() -> None:
    shared = {"y", "x", "z", "C1"}
    found = [best_stage(["Plant5DOF", "Mine"], shared), best_stage(["Mine"], shared),
             best_stage([], PACKAGED_STAGES["5dof"].axis_names)]
    assert [stage.name for stage in found if stage is not None] == ["5dof", "3dof", "5dof"]
    assert best_stage(["Mine"], {"x", "z"}) is None
    # by a law that knows of no tilt
    guided = best_stage(["Regulator3DOF", "Plant5DOF"], PACKAGED_STAGES["5dof"].axis_names)
    assert guided is not None and guided.name == "5dof"
