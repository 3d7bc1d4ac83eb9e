"""Scenarios and studies to begin with: as they are, and with what stands in their comments."""

import re
from pathlib import Path

import pytest
from command_line import error_line
from command_line import maglev as command

import maglev
from maglev.api.options import experiments_of
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.many.study_file import load_study
from maglev.many.study_plan import plan_study
from maglev.scenario.loading import load_plan, load_plans


def with_comments(text: str) -> str:
    """A file with the lines of TOML in its comments."""
    return re.sub(r'^# (?=\[|[\w"-]+ = |"[\w.]+" = )', "", text, flags=re.MULTILINE)


@pytest.mark.parametrize("stage", PACKAGED_STAGES)
def test_a_scenario_is_read_with_all_that_it_shows(tmp_path: Path, stage: str) -> None:
    path = maglev.new_scenario(tmp_path / "mine", stage)
    assert path == tmp_path / "mine.toml"
    plan = load_plan(path)
    assert plan.stage is PACKAGED_STAGES[stage]
    assert len(plan.signals) == len(PACKAGED_STAGES[stage].axes) and len(plan.claims) == 2
    text = with_comments(path.read_text()).replace('model = "PID', '# model = "PID')
    assert text.count("[[events]]") == 1 and text.count("[check]") == 1
    path.write_text(text)
    plain, heavy = load_plans(path)
    assert (plain.fmus["controller"].file, plain.fmus["sensor"].file) == tuple(
        str(tmp_path / name) for name in ("lqi.py", "sensor.py"))
    assert heavy.fmus["plant"].start != plain.fmus["plant"].start
    assert f"{PACKAGED_STAGES[stage].sample_time / 2:g}" == f"{plain.step:g}"


def test_a_scenario_of_a_stage_of_ones_own_names_its_description(tmp_path: Path) -> None:
    description, _ = maglev.new_stage(tmp_path / "mine.toml", like="2dof")
    beside = maglev.new_scenario(tmp_path / "steps.toml", description)
    assert 'stage = "mine.toml"' in beside.read_text()
    (tmp_path / "other").mkdir()
    elsewhere = maglev.new_scenario(tmp_path / "other" / "steps.toml", description)
    for path in (beside, elsewhere):
        plan = load_plan(path)
        assert plan.stage is not None and plan.stage.name == "mine"


def test_they_run(fastest_fmus: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scenario as it is meets what it claims; a study of it has nothing that a study refuses before it runs."""
    monkeypatch.chdir(tmp_path)
    assert command("new", "scenario", "mine", "--stage", "2dof").exit_code == 0
    result = command("run", "mine.toml", "--fmus", fastest_fmus, "--out", tmp_path, "--fail-on-claims")
    assert result.exit_code == 0, result.output
    assert "2 of 2 met" in result.output
    assert command("new", "study", "robust", "--scenario", "mine.toml").exit_code == 0
    for text in ((tmp_path / "robust.toml").read_text(), with_comments((tmp_path / "robust.toml").read_text())):
        (tmp_path / "robust.toml").write_text(text)
        study, path = load_study("robust.toml")
        experiment, = experiments_of([load_plan(tmp_path / study.scenario)], {"fmus": fastest_fmus})
        assert len(plan_study(study, experiment, str(path), tmp_path, {}).values) == 16
    assert study.controller == "lqi.py" and study.keep == ["plant.v.position"]


def test_nothing_is_overwritten(tmp_path: Path) -> None:
    path = maglev.new_scenario(tmp_path / "mine.toml", "2dof")
    assert "already exists" in error_line(command("new", "scenario", path))
    assert "already exists" in error_line(command("new", "study", path, "--scenario", "2dof-setpoints"))
    assert "does not exist" in error_line(command("new", "scenario", tmp_path / "no" / "mine"))
    assert "expected a name of letters" in error_line(command("new", "scenario", tmp_path / "4 mm"))
    assert "nearest is" in error_line(command("new", "scenario", tmp_path / "other", "--stage", "4dof"))


@pytest.mark.parametrize(("kind", "suffix"), [("stage", ".toml"), ("controller", ".py"), ("scenario", ".toml"),
                                              ("study", ".toml")])
def test_a_name_may_lack_its_suffix(tmp_path: Path, kind: str, suffix: str) -> None:
    assert command("new", kind, tmp_path / "mine").exit_code == 0
    assert "already exists" in error_line(command("new", kind, tmp_path / f"mine{suffix}"))
