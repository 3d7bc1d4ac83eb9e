"""Numbers that pages repeat: of runs, in texts as `make docs` looks for them, and of descriptions."""

import re
import runpy
import tomllib
from pathlib import Path

from maglev.descriptions.own_fmus import definition
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.scenario.layers import packaged_runs

ROOT = Path(__file__).parents[2]
TOOL = ROOT / "tools" / "page_numbers.py"


def words(page: Path) -> str:
    """Text of a page, whose lines are broken anywhere."""
    return " ".join(page.read_text(encoding="utf-8").split())


def test_numbers_of_runs_are_in_the_pages() -> None:
    """With any numbers: those are compared with runs by `make docs`."""
    value, runs = runpy.run_path(str(TOOL))["VALUE"], set(packaged_runs())
    for page, rows in tomllib.loads(TOOL.with_suffix(".toml").read_text(encoding="utf-8")).items():
        text = words(ROOT / "docs" / page)
        for template, *specifications in rows:
            pieces = re.split(r"\{:\.(\d)f\}", template)
            assert len(specifications) == len(pieces) // 2, template
            number = [rf"\d+\.\d{{{digits}}}" if digits != "0" else r"\d+" for digits in pieces[1::2]]
            pattern = zip(map(re.escape, pieces[::2]), [*number, ""], strict=True)
            assert re.search("".join(map("".join, pattern)), text), f"docs/{page}: {template}"
            for each in specifications:
                assert value.fullmatch(each)["run"] in runs, each


def test_pages_have_the_values_of_descriptions() -> None:
    two, three = PACKAGED_STAGES["2dof"], PACKAGED_STAGES["3dof"]
    one, other = (", ".join(f"{each.plant:g}" for each in stage.constants) for stage in (two, three))
    assert f"The plant has C1…C4 = {one} and C1…C5 = {other}." in words(ROOT / "docs" / "results_identification.md")
    v, h, y, x, z = (f"{axis.mass:{form}}" for stage, form in ((two, ".3f"), (three, ".1f")) for axis in stage.axes)
    assert f"on movers of {v} (v), {h} (h), {y} (y), {x} (x) and {z} kg (z)" in words(ROOT / "docs" / "model.md")
    assert f"{v} kg on v, {h} kg on h; {y} kg on y, {x} kg on x, {z} kg on z;" in words(
        ROOT / "plant_fmu" / "documentation" / "effects.html")
    models = [definition(f"Plant{stage.name.upper()}").continuous for stage in PACKAGED_STAGES.values()]
    states = [len(model.states) for model in models if model]
    assert "{} (2-DOF), {} (3-DOF), {} (5-DOF)".format(*states) in words(ROOT / "docs" / "fmi.md")


def test_the_number_of_all_runs() -> None:
    assert f"all {len(packaged_runs())} runs with their baselines" in words(ROOT / "docs" / "accuracy.md")
