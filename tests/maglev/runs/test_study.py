"""Many runs at once: each stands for itself, and comparative claims see the others."""

from pathlib import Path

import pytest
from facts import raises

from maglev.files.errors import ScenarioError
from maglev.runs.chain import compared_with, select
from maglev.runs.execution import execute_all, judge_all
from maglev.runs.preparation import prepare
from maglev.scenario.layers import packaged_runs
from maglev.scenario.loading import load_plan, load_plans
from maglev.scenario.settings import start_values

SHORT = {"stop_time": 0.2}   # s


def test_a_failed_run_leaves_the_others(fastest_fmus: Path, tmp_path: Path) -> None:
    good, other = (load_plan(name).model_copy(update=SHORT)
                   for name in ("2dof-smooth-nonlinear", "2dof-smooth-pid"))
    failing = good.model_copy(update={"name": "failing"})
    dead = good.model_copy(update={"name": "dead"})
    experiments = [prepare(good, fastest_fmus, {}, {}),
                   prepare(failing, fastest_fmus, {}, start_values({"plant.v.mass": -1})),
                   prepare(dead, tmp_path / "nowhere", {}, {}), prepare(other, fastest_fmus, {}, {})]
    reports: list[tuple[str, int, int]] = []
    results = execute_all(experiments, tmp_path, "csv", 2, lambda *report: reports.append(report))
    assert [result.plan.name for result in results] == ["2dof-smooth-nonlinear", "failing", "dead",
                                                           "2dof-smooth-pid"]
    assert [result.failure is None for result in results] == [True, False, False, True]
    assert "v.mass = -1.0 kg" in str(results[1].failure)
    assert "maglev build" in str(results[2].failure)
    assert len(results[0].time) == 201
    assert results[0].time[-1] == pytest.approx(0.2)
    assert len(results[1].time) == 0
    assert (tmp_path / "2dof-smooth-pid.csv").is_file()
    assert not (tmp_path / "failing.csv").exists()
    assert {name for name, done, steps in reports if done == steps} == {result.plan.name for result in results}


@pytest.mark.usefixtures("slow")
def test_selection() -> None:
    assert [run.name for run in select(["2dof-step-1", "2dof-step-1-linear", "3dof-setpoints"])] == [
        "2dof-step-1-nonlinear", "2dof-step-1-linear", "2dof-step-1-fed-forward", "3dof-setpoints"]
    assert {run.name for run in select(None)} == set(packaged_runs())


def test_two_scenarios_of_one_name_are_refused(tmp_path: Path) -> None:
    paths = [tmp_path / name for name in ("a.toml", "b.toml")]
    for path in paths:
        path.write_text('name = "same"\ntitle = "A"\nstep = 1\nstop_time = 1\n[fmus.plant]\nmodel = "Plant2DOF"\n')
    with raises(ScenarioError, paths[0], paths[1], "name", "'same'"):
        select([str(path) for path in paths])


def test_runs_that_claims_compare_with_are_run_too() -> None:
    linear = [load_plan("2dof-step-1-linear")]
    assert [run.name for run in compared_with(linear)] == ["2dof-step-1-nonlinear"]
    assert compared_with(load_plans("2dof-step-1")) == []
    assert [run.name for run in compared_with(load_plans("3dof-setpoints-improved"))] == ["3dof-setpoints"]


@pytest.mark.usefixtures("slow")
def test_claims_about_a_run_that_failed_are_not_run(tmp_path: Path) -> None:
    runs = [prepare(run, tmp_path / "nowhere", {}, {}) for run in load_plans("2dof-step-1")]
    verdicts = judge_all(execute_all(runs, tmp_path, "csv", 2, lambda *_: None))
    assert list(verdicts) == ["2dof-step-1-nonlinear", "2dof-step-1-linear", "2dof-step-1-fed-forward"]
    assert {claim.verdict for claims in verdicts.values() for claim in claims} == {"not run"}
    assert [{claim.counts for claim in claims} for claims in verdicts.values()] == [{True}, {True}, {False}]
