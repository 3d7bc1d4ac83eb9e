"""Runs that start from the results of others: their order, what is handed on, and what is refused before they run."""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

from maglev.files.errors import ScenarioError
from maglev.runs.baseline_check import check_runs, update_all
from maglev.runs.chain import Ends, chained, needed, prepare_all, select, started
from maglev.runs.check_outcome import CheckResult, UpdateResult
from maglev.runs.execution import RunResult, execute_all
from maglev.scenario.layers import PACKAGED
from maglev.scenario.loading import load_plans
from maglev.scenario.run_plan import RunOutput, RunPlan
from maglev.scenario.settings import start_values

# Brackets hold the air gap; each run starts where the one that it names has ended.
CHAIN = """
extends = "{drive}"
name = "chain"
title = "A current drives the mover"
stop_time = "5 ms"
[fmus.controller.start]
"motor.i_q_reference" = "-2 A"
[fmus.plant.start]
"v.locked" = true
[check]
interval = "1 ms"
[check.signals]
"plant.h.position" = {{ absolute = "1 nm" }}
[variants.last.fmus.plant.start_from]
"h.position_start" = {{ run = "chain-middle", output = "plant.h.position" }}
[variants.middle.fmus.plant.start_from]
"h.position_start" = {{ run = "chain-first", output = "plant.h.position" }}
[variants.first]
[variants.alone]
"""


class Done(NamedTuple):
    """A task that is done; with what it was given."""

    ends: Mapping[str, float]
    given: Ends


class Batches:
    """Does tasks in this process, and keeps which were asked for side by side."""

    def __init__(self) -> None:
        self.names: list[list[str]] = []

    def side_by_side(self, tasks, jobs, died, watch, idle):
        self.names.append(list(tasks))
        return {name: task(lambda *_: None) for name, task in tasks.items()}


@pytest.fixture
def batches(monkeypatch: pytest.MonkeyPatch) -> Batches:
    made = Batches()
    monkeypatch.setattr("maglev.runs.chain.side_by_side", made.side_by_side)
    return made


def ordered(needs: Mapping[str, set[str]]) -> dict[str, Done]:
    """Tasks that end with their name's length, and keep what they were given."""
    return chained(needs, lambda name, ends: lambda _: Done({"out": float(len(name))}, ends), 2,
                   lambda name, message: pytest.fail(message), lambda *_: None)


@st.composite
def graphs(draw: st.DrawFn) -> dict[str, set[str]]:
    """Needs of some runs, without a cycle, in any order."""
    names = [f"run{'x' * k}" for k in range(draw(st.integers(1, 7)))]
    needs = {name: draw(st.sets(st.sampled_from(names[:k]))) if k else set() for k, name in enumerate(names)}
    return {name: needs[name] for name in draw(st.permutations(names))}


@given(needs=graphs())
def test_needed_runs_go_first_and_hand_on_their_ends(needs: dict[str, set[str]]) -> None:
    batches = Batches()
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("maglev.runs.chain.side_by_side", batches.side_by_side)
        done = ordered(needs)
    assert list(done) == list(needs)
    for name, result in done.items():
        assert result.given == {other: {"out": float(len(other))} for other in needs[name]}
    # Each goes as early as it can: with the batch after the last one that it needs.
    place = {name: k for k, names in enumerate(batches.names) for name in names}
    assert place == {name: max((place[other] + 1 for other in needs[name]), default=0) for name in needs}


def test_runs_that_need_nothing_go_side_by_side(batches: Batches) -> None:
    ordered({"last": {"first", "other"}, "first": set(), "other": set(), "free": set()})
    assert batches.names == [["first", "other", "free"], ["last"]]


@pytest.mark.parametrize(("needs", "missing"), [
    ({"a": {"b"}, "b": {"a"}}, "b"), ({"free": set(), "a": {"b", "free"}, "b": {"c"}, "c": {"a"}}, "b"),
    ({"a": {"a"}}, "a"), ({"a": {"nowhere"}}, "nowhere")])
def test_runs_that_need_each_other_or_none_that_is_there_are_refused(batches: Batches, needs: dict[str, set[str]],
                                                                    missing: str) -> None:
    with raises(ScenarioError, "a", "start_from", missing):
        ordered(needs)
    assert batches.names == []   # refused before anything ran


@pytest.fixture
def chain(tmp_path: Path) -> Path:
    """A scenario whose variants start from each other."""
    path = tmp_path / "chain.toml"
    path.write_text(CHAIN.format(drive=PACKAGED / "loops" / "2dof-drive.toml"))
    return path


def changed(path: Path, old: str, new: str) -> Path:
    assert path.read_text().count(old) == 1
    path.write_text(path.read_text().replace(old, new))
    return path


@pytest.fixture
def fmus(fastest_fmus: Path) -> Path:
    """What is handed on does not ask of which kind it is."""
    return fastest_fmus


def ran(runs: list[RunPlan], fmus: Path, out: Path, *settings: str) -> dict[str, RunResult]:
    experiments = prepare_all(runs, fmus, {}, start_values(settings))
    return {result.plan.name: result for result in execute_all(experiments, out, "csv", 1, lambda *_: None)}


def positions(result: RunResult) -> np.ndarray:
    return result.columns["plant.h.position"]


def test_a_run_starts_where_the_other_ended(fmus: Path, chain: Path, tmp_path: Path) -> None:
    results = ran(load_plans(chain), fmus, tmp_path)
    assert list(results) == ["chain-last", "chain-middle", "chain-first", "chain-alone"]
    assert [result.failure for result in results.values()] == [None] * 4
    first, middle, last = (results[f"chain-{name}"] for name in ("first", "middle", "last"))
    assert positions(first)[0] == 0.0
    assert positions(middle)[0] == positions(first)[-1] == first.ends["plant.h.position"]
    assert positions(last)[0] == positions(middle)[-1]
    assert positions(last)[-1] > positions(middle)[-1] > positions(first)[-1] > 1e-6
    assert middle.parameters["plant.h.position_start"] == positions(first)[-1]
    assert np.array_equal(positions(results["chain-alone"]), positions(first))


def test_a_set_value_goes_before_the_result(fmus: Path, chain: Path, tmp_path: Path) -> None:
    results = ran(load_plans(chain), fmus, tmp_path, "plant.h.position_start=3 mm")
    assert [positions(result)[0] for result in results.values()] == [0.003] * 4
    assert {tuple(result.plan.needs) for result in results.values()} == {()}


def test_a_run_whose_predecessor_fails_says_so_and_does_not_run(fmus: Path, chain: Path, tmp_path: Path) -> None:
    changed(chain, "[variants.first]\n", '[variants.first.fmus.plant.start]\n"v.mass" = -1\n')
    results = ran(load_plans(chain), fmus, tmp_path)
    failures = {name: result.failure for name, result in results.items()}
    assert "v.mass = -1.0 kg" in str(failures["chain-first"])
    assert failures["chain-middle"] == ("plant.h.position_start starts from plant.h.position of chain-first, which did "
                                        "not complete, or was not run to its end")
    assert "of chain-middle, which did not complete" in str(failures["chain-last"])
    assert failures["chain-alone"] is None
    assert sorted(path.name for path in tmp_path.glob("*.csv")) == ["chain-alone.csv"]
    assert results["chain-middle"].ends == {}


def test_needed_runs_are_found_through_others(chain: Path) -> None:
    assert [run.name for run in needed([load_plans(chain)[0]])] == ["chain-middle", "chain-first"]
    assert [run.name for run in needed(load_plans(chain)[:2])] == ["chain-first"]
    assert needed(load_plans(chain)) == []
    # The estimate between the slots starts from that at zero displacement, whose run has no needs.
    assert [run.name for run in needed(select(["2dof-cogging"]))] == ["2dof-equilibrium-excitation"]
    (replay,) = select(["2dof-identification-model"])
    assert [run.name for run in needed([replay])] == ["2dof-identification-rig"]


def test_a_run_of_the_package_can_be_started_from(fmus: Path, tmp_path: Path) -> None:
    text = CHAIN.format(drive=PACKAGED / "loops" / "2dof-drive.toml").partition("[variants")[0]
    path = tmp_path / "mine.toml"
    path.write_text(text.replace('"chain"', '"mine"') + '[fmus.plant.start_from]\n"h.position_start" = '
                    '{ run = "2dof-parabolas-10mm", output = "plant.h.position" }\n')
    (run,) = load_plans(path)
    (other,) = needed([run])
    assert other.name == "2dof-parabolas-10mm"
    short = other.model_copy(update={"stop_time": 0.005})
    results = ran([run, short], fmus, tmp_path)
    assert positions(results["mine"])[0] == positions(results["2dof-parabolas-10mm"])[-1] != -0.05


@pytest.mark.parametrize(("run", "other"), [
    ("chain-frist", "chain-first"), ("chain-middle", "chain-alone"),
    ("2dof-equilibrium-excitaton", "2dof-equilibrium-excitation")])
def test_an_unknown_run_and_the_run_itself_are_refused(chain: Path, run: str, other: str) -> None:
    with raises(ScenarioError, chain, "start_from.run", repr(run), repr(other)):
        load_plans(changed(chain, '"chain-first"', f'"{run}"'))


@pytest.mark.parametrize(("old", "new", "facts"), [
    ('run = "chain-first", output = "plant.h.position"', 'run = "chain-first", output = "plant.h.positon"',
     ["'plant.h.positon'", "chain-first", "'plant.h.position'"]),
    ('run = "chain-first", output = "plant.h.position"', 'run = "chain-first", output = "plant.h.mass"',
     ["'plant.h.mass'", "chain-first"]),
    ('run = "chain-first", output = "plant.h.position"', 'run = "chain-first", output = "plant.h.velocity"',
     ["'plant.h.velocity'", "m/s", "m", "plant.h.position_start"]),
    ('"h.position_start" = { run = "chain-first"', '"h.position_strat" = { run = "chain-first"',
     ["plant", "'h.position_strat'", "'h.position_start'"]),
    ('"h.position_start" = { run = "chain-first"', '"h.locked" = { run = "chain-first"',
     ["'h.locked'", "Boolean", "Real"]),
    ('"h.position_start" = { run = "chain-first"', '"h.velocity" = { run = "chain-first"',
     ["'h.velocity'", "output", "parameter", "input"])])
def test_what_no_output_or_variable_has_is_refused_before_anything_runs(fmus: Path, chain: Path, tmp_path: Path,
                                                                        monkeypatch: pytest.MonkeyPatch, old: str,
                                                                        new: str, facts: list[str]) -> None:
    runs = load_plans(changed(chain, old, new))
    with raises(ScenarioError, chain, *facts) as refusal:
        prepare_all(runs, fmus, {}, {})
    monkeypatch.setattr("maglev.api.running.execute_all", lambda *_: pytest.fail("it ran"))
    assert str(refusal.value) in error_line(maglev("run", chain, "--fmus", fmus, "--out", tmp_path))


def test_a_cycle_is_one_line(fmus: Path, chain: Path, tmp_path: Path) -> None:
    changed(chain, "[variants.first]\n", '[variants.first.fmus.plant.start_from]\n"h.position_start" = '
            '{ run = "chain-last", output = "plant.h.position" }\n')
    assert {run.name for run in needed([load_plans(chain)[0]])} == {"chain-middle", "chain-first"}
    line = error_line(maglev("run", chain, "--fmus", fmus, "--out", tmp_path))
    assert "chain-last: start_from needs chain-middle, expected a run that can go before it" in line


def test_start_values_of_a_result_take_the_place_of_the_reference(chain: Path) -> None:
    """And that of a start value of the same name; others stay, and what was needed is needed no more."""
    middle = load_plans(changed(chain, '"v.locked" = true', '"v.locked" = true\n"h.position_start" = "1 mm"'))[1]
    ready = started(middle, {"chain-first": {"plant.h.position": 0.25, "plant.v.position": 0.5}})
    assert {name: start.value for name, start in ready.fmus["plant"].start.items()} == {
        "v.locked": True, "h.position_start": 0.25}
    assert ready.needs == set()
    assert middle.needs == {"chain-first"}
    assert middle.fmus["plant"].start_from["h.position_start"] == RunOutput(run="chain-first",
                                                                           output="plant.h.position")


def checked(chain: Path, fmus: Path, *settings: str) -> dict[str, CheckResult]:
    experiments = prepare_all(load_plans(chain), fmus, {}, start_values(settings))
    return {result.name: result for result in check_runs(experiments, chain.parent / "baselines", 1, lambda *_: None)}


def updated(chain: Path, fmus: Path, plans: list[RunPlan], *settings: str) -> list[UpdateResult]:
    experiments = prepare_all(plans, fmus, {}, start_values(settings))
    return update_all(experiments, chain.parent / "baselines", 1, lambda *_: None)


def test_check_and_update_hand_on_ends(fmus: Path, chain: Path) -> None:
    new = updated(chain, fmus, load_plans(chain))
    assert [result.status for result in new] == ["new"] * 4
    assert new[0].ends["plant.h.position"] > new[1].ends["plant.h.position"] > 1e-6
    results = checked(chain, fmus)
    assert {result.status for result in results.values()} == {"passed"}
    assert {name: result.ends for name, result in results.items()} == {result.name: result.ends for result in new}
    # What changes the first run changes those that start from it, too.
    results = checked(chain, fmus, "plant.C1=15")
    assert {result.status for result in results.values()} == {"deviated"}
    assert results["chain-last"].worst["plant.h.position"].difference > (
        2.0 * results["chain-alone"].worst["plant.h.position"].difference)


def test_a_baseline_that_is_shorter_than_the_run_hands_on_nothing(fmus: Path, chain: Path) -> None:
    whole = load_plans(chain)
    short = [run.model_copy(update={"stop_time": 0.004}) if run.name == "chain-first" else run for run in whole]
    updated(chain, fmus, short)
    results = checked(chain, fmus)
    assert results["chain-first"].status == "error"
    assert "ends at t = 0.004 s, expected samples to 0.005 s" in results["chain-first"].message
    assert results["chain-first"].ends == {}
    assert results["chain-middle"].status == results["chain-last"].status == "error"
    assert "of chain-first, which did not complete" in results["chain-middle"].message
    assert results["chain-alone"].status == "passed"


def test_a_check_takes_a_set_value_before_a_result_that_is_not_there(fmus: Path, chain: Path) -> None:
    changed(chain, "[variants.first]\n", '[variants.first.fmus.plant.start]\n"v.mass" = -1\n')
    updated(chain, fmus, load_plans(chain), "plant.h.position_start=1mm")
    statuses = {name: each.status for name, each in checked(chain, fmus, "plant.h.position_start=1mm").items()}
    assert (statuses["chain-first"], statuses["chain-last"]) == ("error", "passed")


def test_a_failed_run_hands_on_nothing_to_an_update(fmus: Path, chain: Path) -> None:
    changed(chain, "[variants.first]\n", '[variants.first.fmus.plant.start]\n"v.mass" = -1\n')
    results = updated(chain, fmus, load_plans(chain))
    assert [result.status for result in results] == ["error", "error", "error", "new"]
    assert sorted(path.name for path in (chain.parent / "baselines").iterdir()) == [
        "chain-alone_ref.csv", "digests.txt"]
