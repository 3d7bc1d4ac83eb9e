"""Variants of a scenario, and files that extend several others."""

from pathlib import Path

import pytest
from facts import raises

from maglev.files.errors import ScenarioError
from maglev.scenario.loading import load_plan, load_plans

LOOP = """
step = "1 ms"
stop_time = "1 s"
[fmus.plant]
model = "Plant"
start = { mass = 1, bias = 0 }
"""
GAINS = """
[fmus.plant.start]
mass = 2
"""
EXPERIMENT = """
extends = ["loop.toml", "gains.toml"]
name = "hold"
title = "Hold"
[fmus.plant.start]
bias = 3
[[claims]]
text = "It holds"
source = "p. 1"
metric = "failed"
relation = "is"
target = false
[variants.light]
extends = "feather.toml"
title = "Hold what is light"
[[variants.light.claims]]
text = "It holds longer"
source = "p. 2"
metric = "trip_time"
relation = ">"
than = "hold-heavy"
[variants.heavy]
fmus.plant.start.mass = 9
"""


@pytest.fixture
def hold(tmp_path: Path) -> Path:
    """A scenario with two variants."""
    texts = {"loop": LOOP, "gains": GAINS, "feather": "[fmus.plant.start]\nmass = 0.1\nbias = 0.2", "hold": EXPERIMENT}
    for name, text in texts.items():
        (tmp_path / f"{name}.toml").write_text(text)
    return tmp_path / "hold.toml"


def test_a_variant_goes_over_the_scenario_and_that_over_what_it_extends(hold: Path) -> None:
    light, heavy = load_plans(hold)
    starts = [{name: start.value for name, start in run.fmus["plant"].start.items()} for run in (light, heavy)]
    assert starts == [{"mass": 0.1, "bias": 0.2}, {"mass": 9, "bias": 3}]
    assert [(run.name, run.title) for run in (light, heavy)] == [
        ("hold-light", "Hold what is light"), ("hold-heavy", "Hold")]
    assert [[claim.text for claim in run.claims] for run in (light, heavy)] == [
        ["It holds", "It holds longer"], ["It holds"]]


def test_later_files_of_a_list_go_over_earlier_ones(hold: Path) -> None:
    hold.write_text(EXPERIMENT.partition("[variants.light]")[0])
    run = load_plan(hold)
    assert run.name == "hold"
    assert run.fmus["plant"].start["mass"].value == 2
    hold.write_text(hold.read_text().replace('["loop.toml", "gains.toml"]', '["gains.toml", "loop.toml"]'))
    assert load_plan(hold).fmus["plant"].start["mass"].value == 1


def test_files_of_a_variant_lie_beside_the_file_that_names_them(hold: Path) -> None:
    hold.write_text(hold.read_text() + '[variants.other.fmus.plant]\nfile = "other.fmu"\n')
    hold.write_text(hold.read_text().replace('[fmus.plant.start]\nbias = 3\n', ""))
    assert [(run.fmus["plant"].model, run.fmus["plant"].file) for run in load_plans(hold)] == [
        ("Plant", None), ("Plant", None), (None, str(hold.parent / "other.fmu"))]
    (hold.parent / "loop.toml").write_text(LOOP.replace('model = "Plant"', 'file = "plant.fmu"'))
    assert [run.fmus["plant"].file for run in load_plans(hold)] == [
        str(hold.parent / name) for name in ("plant.fmu", "plant.fmu", "other.fmu")]


@pytest.mark.parametrize(("old", "new", "facts"), [
    ('than = "hold-heavy"', 'than = "hold-havy"', ["claims.than", "'hold-havy'", "'hold-heavy'"]),
    ("[variants.heavy]\n", "[variants.heavy]\ntitel = 3\n", ["titel", "'title'"]),
    ('"feather.toml"', '"fether.toml"', ["extends", "'fether.toml'", "'feather.toml'"]),
    ('"feather.toml"', '"hold.toml"', ["extends", "itself"]),
    ('["loop.toml", "gains.toml"]', '["loop.toml", 3]', ["extends", "['loop.toml', 3]", "relative path"])])
def test_refusals(hold: Path, old: str, new: str, facts: list[str]) -> None:
    assert hold.read_text().count(old) == 1
    hold.write_text(hold.read_text().replace(old, new))
    with raises(ScenarioError, hold, *facts):
        load_plans(hold)


@pytest.mark.parametrize("text", ["variants = 3", "[variants]\nfast = 3"])
def test_variants_are_tables(hold: Path, text: str) -> None:
    experiment = EXPERIMENT.partition("[variants.light]")[0]
    hold.write_text(f"{text}\n{experiment}" if text == "variants = 3" else f"{experiment}\n{text}\n")
    with raises(ScenarioError, "hold.toml", "variants", "3"):
        load_plans(hold)


def test_a_single_run_is_asked_for_by_its_name(hold: Path) -> None:
    with raises(ScenarioError, "hold.toml", "variants"):
        load_plan(hold)
    assert [run.name for run in load_plans("2dof-step-4")] == ["2dof-step-4-nonlinear", "2dof-step-4-linear",
                                                               "2dof-step-4-fed-forward"]
    assert load_plan("2dof-step-4-linear").fmus["controller"].model == "LinearRegulator2DOF"
