"""Procedures of which runs are missing or have failed: what rests on these is left out, and nothing else."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from identification_data import record
from motor import MOTOR
from report_runs import with_columns

from maglev.runs.execution import RunResult
from maglev.runs.procedures import evaluate_all, judge_procedure
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import StartValue
from pmlsm.gap_functions import gap_functions

Simulated = Callable[..., RunResult]

DT = {"2dof": 1e-3, "3dof": 0.5e-3}   # s
TIME = 1e-3 * np.arange(11)

EXCITATION, CURRENTS, OFFSET = "equilibrium-excitation", "equilibrium-currents", "cogging"
DESCRIPTION, MODEL = "identification-rig", "identification-model"
ALONE = {"2dof": "parabolas-20mm", "3dof": "parabolas-x-20mm"}
BOTH = "parabolas-both-20mm"


def needed(stage: str) -> dict[tuple[str, str], set[str]]:
    """Runs that each value of a procedure rests on."""
    alone = ALONE[stage]
    found = {("procedure-1", "thrust"): {alone}, ("procedure-1", "estimator_deviation"): {alone},
             ("procedure-1", "average_constant"): {alone}, ("procedure-1", "estimated_thrust"): {alone},
             ("procedure-2", "constant"): {EXCITATION}, ("procedure-2", "equilibrium_current"): {EXCITATION, CURRENTS},
             ("procedure-2", "equilibrium_deviation"): {EXCITATION, CURRENTS},
             ("procedure-3", "constant"): {OFFSET, EXCITATION}, ("procedure-3", "cogging_force"): {OFFSET, EXCITATION},
             ("procedure-4", "constant"): {DESCRIPTION}, ("procedure-4", "thrust"): {DESCRIPTION, alone},
             ("procedure-4", "position_deviation"): {DESCRIPTION, MODEL},
             ("procedure-4", "speed_deviation"): {DESCRIPTION, MODEL}}
    return found | ({("procedure-1", "simultaneous_deviation"): {alone, BOTH}} if stage == "3dof" else {})


def expected(present: set[str], stage: str) -> set[tuple[str, str]]:
    return {value for value, runs in needed(stage).items() if runs <= present}


@pytest.fixture(scope="module", params=["2dof", "3dof"])
def stage(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture(scope="module")
def results(stage: str, simulated: Simulated, staircase: Simulated, drive: Simulated) -> dict[str, RunResult]:
    """Completed runs of a stage, by their names without it."""
    data = record(stage, 0.6, DT[stage])
    recording = data.recording
    columns: dict[str, np.ndarray] = {}
    for k, axis in enumerate(recording.stage.axes):
        columns |= {f"{axis}.encoder": recording.positions[:, k], f"{axis}.position": recording.positions[:, k],
                    f"{axis}.velocity": data.velocity[:, k]}
    for k, motor in enumerate(recording.stage.motors):
        columns |= {f"{motor}.i_d": recording.i_d[:, k], f"{motor}.i_q": recording.i_q[:, k]}
    made = {EXCITATION: simulated(f"{stage}-{EXCITATION}", TIME, {}), CURRENTS: staircase(stage),
            OFFSET: simulated(f"{stage}-{OFFSET}", TIME, {}),
            DESCRIPTION: simulated(f"{stage}-{DESCRIPTION}", recording.time, columns),
            MODEL: simulated(f"{stage}-{MODEL}", recording.time, columns)}
    thrust = gap_functions(MOTOR, 0.02)[0]
    if stage == "2dof":
        made[ALONE[stage]] = drive(f"2dof-{ALONE[stage]}", {"h": 14.0 * thrust})
        made["forgetting"] = simulated("2dof-forgetting", 0.01 * np.arange(4001), {})
    else:
        made[ALONE[stage]] = drive(f"3dof-{ALONE[stage]}", {"x": thrust})
        made[BOTH] = drive(f"3dof-{BOTH}", {"x": thrust, "z": thrust})
    return made


def failed(result: RunResult) -> RunResult:
    return RunResult(result.plan, failure="it fell")


def found_in(results: list[RunResult]) -> set[tuple[str, str]]:
    """Procedure and name of every value; a claim is judged only where there is one."""
    found = set()
    completed = {result.plan.name for result in results if result.failure is None}
    for outcome in evaluate_all(results):
        names = {each.name for each in outcome.values}
        found |= {(outcome.settings.name[5:], name) for name in names}
        assert set(outcome.runs) <= completed
        for claim, result in zip(outcome.settings.claims, judge_procedure(outcome), strict=True):
            assert claim.quantity in names or result.verdict == "not run"
    return found


@pytest.mark.usefixtures("slow")
def test_with_every_run_every_value_is_there(stage: str, results: dict[str, RunResult]) -> None:
    assert found_in(list(results.values())) == set(needed(stage))
    named = {result.plan.procedure.name for result in results.values() if result.plan.procedure}
    assert len(named) == (5 if stage == "2dof" else 4)
    assert [outcome.settings.name for outcome in evaluate_all(list(results.values()))] == sorted(named)


@pytest.mark.few(1)
@pytest.mark.parametrize("fails", [True, False], ids=["failed", "missing"])
@pytest.mark.usefixtures("slow")
def test_what_rests_on_a_run_is_left_out_without_it(stage: str, results: dict[str, RunResult], fails: bool) -> None:
    for name, result in results.items():
        others = [other for other in results.values() if other is not result]
        found = found_in([*others, failed(result)] if fails else others)
        assert found == expected(set(results) - {name}, stage), name


@pytest.mark.few(1)
@pytest.mark.parametrize("fails", [True, False], ids=["failed", "missing"])
def test_a_run_alone_gives_what_rests_on_it_alone(stage: str, results: dict[str, RunResult], fails: bool) -> None:
    for name, result in results.items():
        others = [failed(other) for other in results.values() if other is not result] if fails else []
        assert found_in([result, *others]) == expected({name}, stage), name


def test_nothing_comes_of_failed_runs_alone_or_of_none(results: dict[str, RunResult]) -> None:
    assert found_in([failed(result) for result in results.values()]) == set()
    for outcome in evaluate_all([failed(result) for result in results.values()]):
        assert (outcome.runs, outcome.values, outcome.tables) == ((), (), ())
        assert {claim.verdict for claim in judge_procedure(outcome)} <= {"not run", "not testable"}
    assert evaluate_all([]) == []


def test_runs_of_no_procedure_have_no_outcome() -> None:
    assert evaluate_all([RunResult(load_plan("2dof-setpoints"))]) == []


def test_runs_that_others_only_start_from_do_not_make_a_procedure(stage: str, results: dict[str, RunResult]) -> None:
    """They are there for the procedure that was asked for."""
    both = [results[OFFSET], results[EXCITATION]]
    (found,) = evaluate_all(both, {results[OFFSET].plan.name})
    assert found.settings.name == f"{stage}-procedure-3"
    assert "cogging_force" in {each.name for each in found.values}
    assert [each.settings.name for each in evaluate_all(both)] == [f"{stage}-procedure-2", f"{stage}-procedure-3"]
    assert evaluate_all(both, set()) == []


@pytest.mark.parametrize(("part", "change", "words"), [
    ("2dof-parabolas-20mm", {"plant.motor.i_q": 0.0}, "axis h: i_q = 0 A, expected a current that drives it"),
    ("2dof-equilibrium-excitation", {}, "no estimator has epsilon = 0.01 s, expected one next to 0.001 s, 0.05 s"),
    ("2dof-identification-rig", {"plant.v.encoder": 0.02, "plant.h.encoder": 0.0}, "no axis is excited")])
def test_runs_from_which_nothing_can_be_found_are_a_note(stage: str, results: dict[str, RunResult], part: str,
                                                         change: dict[str, float], words: str) -> None:
    simulated = {run.plan.name: run for run in results.values()}
    if stage == "3dof":
        part = part.replace("2dof-parabolas", "3dof-parabolas-x").replace("2dof", "3dof")
        change = {name.replace(".h.", ".x.").replace(".v.", ".y.").replace(".motor.", ".alpha."): value
                  for name, value in change.items()}
        words = words.replace("axis h", "axis x")
        change |= {"plant.z.encoder": 0.0} if "plant.y.encoder" in change else {}
    run = simulated[part]
    columns = {**run.columns, **{name: np.full(len(run.time), value) for name, value in change.items()}}
    parameters = dict(run.parameters)
    if not change:
        del parameters["estimator_10ms.epsilon"]
    others = [other for name, other in simulated.items() if name != part and "parabolas" not in name]
    (outcome,) = evaluate_all([with_columns(run, columns, parameters=parameters), *others], {part})
    assert outcome.values == ()
    assert words in outcome.notes[0]
    assert {judged.verdict for judged in judge_procedure(outcome)} == {"not run"}


def test_a_held_axis_makes_no_parabola(results: dict[str, RunResult]) -> None:
    run = next(run for name, run in results.items() if "parabolas" in name)
    start = {**run.plan.fmus["plant"].start, **{f"{axis}.locked": StartValue(True, None, True) for axis in "hxz"}}
    fmus = {**run.plan.fmus, "plant": run.plan.fmus["plant"].model_copy(update={"start": start})}
    (outcome,) = evaluate_all([replace(run, plan=run.plan.model_copy(update={"fmus": fmus}))])
    assert outcome.values == outcome.charts == ()
