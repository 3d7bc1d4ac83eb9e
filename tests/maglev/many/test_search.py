"""Searches on a scenario of a fifth of a second: what is found, and what is refused before the first run."""

import re
import shutil
from collections.abc import Iterator
from contextlib import nullcontext
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from command_line import error_line
from command_line import maglev as command
from facts import raises
from tiny_study import experiment, simulate_samples
from tiny_study import scenario as tiny_scenario

import maglev
from maglev.cosim.lane_loop import DONE, LaneLoop, Taken
from maglev.files.errors import Interrupted, ScenarioError
from maglev.many import batches
from maglev.many.tuning_plan import FOLDER, PlannedTuning, load_tuning, plan_tuning, read_tuning
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan

pytestmark = pytest.mark.usefixtures("slow")

START = {"set": ["plant.h.position_start"], "low": "-1 mm", "high": "1 mm"}
POLES = {"of": ["controller.h"], "rate": {"low": 5, "high": 20}, "damping": {"low": 0.5, "high": 1}}
FRICTION = {"set": "plant.h.friction.coulomb", "kind": "percent", "percent": "20 %"}
GRID = {"set": "plant.h.friction.coulomb", "kind": "list", "values": [0.1, 0.2]}
CUBE = {"kind": "latin hypercube", "samples": 2}

# Where h starts, so that the mean square of its error, about 0 and then about 1 mm, is the least.
FILE = """
name = "tuned"
scenario = "tiny.toml"
minimise = ["rms error of h"]
population = 8
generations = 8
fresh = 3
[[search]]
set = ["plant.h.position_start"]
low = "-1 mm"
high = "1 mm"
[[vary]]
set = "plant.h.friction.coulomb"
kind = "percent"
percent = "20 %"
[design]
kind = "latin hypercube"
samples = 2
"""


@pytest.fixture(scope="module", autouse=True)
def two_batches() -> Iterator[None]:
    """Of a generation: each loads the FMUs, which takes longer than its samples."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(batches, "FEWEST_BATCHES", 2)
        yield


class Searched(NamedTuple):
    """A tuning file, and what it finds in one process."""

    file: Path
    whole: maglev.Tuned


@pytest.fixture(scope="module")
def searched(fastest_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Searched:
    folder = tmp_path_factory.mktemp("searched")
    tiny_scenario(folder)
    file = folder / "tuning.toml"
    file.write_text(FILE, encoding="utf-8")
    return Searched(file, maglev.tune(file, out=folder / "whole", fmus=fastest_fmus, jobs=1))


@pytest.fixture(scope="module")
def left(fastest_fmus: Path, searched: Searched, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder of parts that an interrupted search leaves."""
    folder = tmp_path_factory.mktemp("left")

    def interrupted(_name: str, done: int, _all: int) -> None:
        if done >= 40:   # of 8 candidates on 2 plants, in the third generation
            raise KeyboardInterrupt

    with raises(Interrupted, "tuned.parts", "resume"):
        maglev.tune(searched.file, out=folder, fmus=fastest_fmus, jobs=1, watch=lambda _: nullcontext(interrupted))
    return folder / "tuned.parts"


def test_candidates_run_side_by_side(native_fmus: Path, searched: Searched, tmp_path: Path,
                                     monkeypatch: pytest.MonkeyPatch) -> None:
    """The loop in lanes is compiled before the first generation, if the search is worth it; nothing of it changes."""
    lanes: list[int] = []
    run_in_lanes = LaneLoop.run

    def watched(loop: LaneLoop, taken: Taken, *given: Any) -> None:
        run_in_lanes(loop, taken, *given)
        lanes.append(taken.status.tolist().count(DONE))

    monkeypatch.setattr(LaneLoop, "run", watched)
    monkeypatch.setattr(batches, "WORTH_COMPILING", 150 * 400)   # of the steps of all runs
    tiny_scenario(tmp_path)
    shutil.copy(searched.file, tmp_path / "tuning.toml")
    found = maglev.tune(tmp_path / "tuning.toml", out=tmp_path / "whole", fmus=native_fmus, jobs=1)
    assert max(lanes) > 1
    assert found.parameters == searched.whole.parameters
    assert found.found.cost == searched.whole.found.cost


def planned(folder: Path, fmus: Path, **table: object) -> PlannedTuning:
    tuning = read_tuning({"name": "tuned", "scenario": "tiny.toml", "minimise": ["rms error of h"], **table},
                         Path("tuning.toml"))
    return plan_tuning(tuning, experiment(folder, fmus), "tuning.toml")


@pytest.mark.parametrize(("table", "facts"), [
    ({}, ["[[poles]]", "[[search]]"]),
    ({"search": [{**START, "set": ["plant.h.positon_start"]}]}, ["'h.positon_start'", "'h.position_start'"]),
    ({"search": [{"set": ["plant.h.mass"], "low": -1, "high": 1}]}, ["plant.h.mass", "1 of 2", "-1", "0.001"]),
    ({"search": [{**START, "high": "9 A"}]}, ["search[0]", "9 A", "m"]),
    ({"search": [{**START, "low": False}]}, ["search[0]", "False", "plant.h.position_start"]),
    ({"search": [{"set": ["controller.antiwindup"], "low": False, "high": True}]},
     ["search[0]", "controller.antiwindup", "Boolean"]),
    ({"search": [START, START]}, ["plant.h.position_start", "twice"]),
    ({"search": [{**START, "low": "1 mm"}]}, ["search[0].high", "low", "1 mm"]),
    ({"search": [START], "vary": [FRICTION]}, ["vary[0].kind", "grid", "list", "'grid'"]),
    ({"search": [START], "fresh": 3}, ["fresh", "3", "[[vary]]", "[design]"]),
    ({"search": [START], "vary": [GRID], "design": {"kind": "rows"}, "fresh": 2}, ["fresh", "2", "[design]"]),
    ({"search": [START], "vary": [FRICTION], "design": {"kind": "sobol", "samples": 2}, "fresh": 3},
     ["fresh", "3", "power of 2"]),
    ({"search": [START], "minimise": ["rms eror of h"]}, ["'rms eror of h'", "'rms error of h'"]),
    ({"search": [START], "times_before": {"overshot": 1}}, ["'overshot'"]),
    ({"search": [START], "population": "30"}, ["population", "'30'", "integer"]),
    ({"search": [START], "population": True}, ["population", "True", "integer"]),
    ({"search": [START], "population": 4}, ["population", "4", "5"]),
    ({"search": [START], "times_before": {"overshoot of h": "2"}}, ['times_before."overshoot of h"', "'2'", "number"]),
    ({"poles": [{**POLES, "of": ["plant.h"]}]}, ["'plant.h'", "output regulator"]),
    ({"poles": [{**POLES, "of": ["controller.g"]}]}, ["controller", "'g.k1'"]),
    ({"poles": [{**POLES, "rate": {"low": 5, "high": 5}}]}, ["poles[0].rate.high", "low", "5"]),
    ({"poles": [{**POLES, "rate": {"low": 0, "high": 5}}]}, ["poles[0].rate.low", "0"]),
    ({"poles": [{**POLES, "rate": {"low": "5 rad/s", "high": "9 Hz"}}]},
     ["poles[0].rate.high", "'9 Hz'", "1/s", "rad/s"]),
    ({"poles": [{**POLES, "damping": {"low": "1 mm", "high": 2}}]}, ["poles[0].damping.low", "'1 mm'", "number"])])
def test_refused(table: dict[str, object], facts: list[str], fastest_fmus: Path, tmp_path: Path) -> None:
    with raises(ScenarioError, "tuning.toml", *facts):
        planned(tmp_path, fastest_fmus, **table)


def test_a_candidate_is_run_with_its_gains_on_every_plant(fastest_fmus: Path, tmp_path: Path) -> None:
    plan = planned(tmp_path, fastest_fmus, poles=[POLES], vary=[FRICTION], design=CUBE)
    assert plan.nominal.tolist() == [-1182.0, -55.0, -154440.0, -45128.0, -11924.0]   # (4.17)
    gains = plan.unknowns.parameters(np.array([10.0, 10.0, 1.0, 10.0, 1.0]))
    values = plan.values(np.array([plan.nominal, gains]), plan.plants)
    found = simulate_samples(plan.job, 0, values).values[:, -1]
    for row, measured in zip(values, found, strict=True):
        set_there = dict(zip((target.name for target in plan.job.targets), row.tolist(), strict=True))
        run = maglev.run(tmp_path / "tiny.toml", set=set_there, fmus=fastest_fmus)
        assert run.metrics.rms_errors["h"] == measured
    assert len(set(found.tolist())) == 4


def test_a_search_finds_the_least_whoever_runs(fastest_fmus: Path, searched: Searched, tmp_path: Path) -> None:
    tiny_scenario(tmp_path)
    tuned = maglev.tune(searched.file, fmus=fastest_fmus, out=tmp_path, jobs=2)
    plan, found = tuned.planned, tuned.found
    grid = np.linspace(-1e-3, 1e-3, 41)[:, None]
    values = simulate_samples(plan.job, 0, plan.values(grid, plan.plants)).values
    costs = plan.cost.of(values.reshape(len(grid), len(plan.plants), -1), found.before)
    assert found.cost <= costs.min() + 1e-6
    assert found.cost < found.cost_before
    assert abs(found.parameters["plant.h.position_start"] - grid[np.argmin(costs), 0]) < 1e-4
    assert found.fresh_after.shape == (3, len(plan.job.columns))
    assert not set(plan.fresh[:, 0]) & set(plan.plants[:, 0])
    assert searched.whole.found.parameters == found.parameters
    assert re.fullmatch(r"<Tuned tuned: plant.h.position_start = \S+, in .*tuned.toml>", repr(searched.whole))
    assert searched.whole.path.read_text() == tuned.path.read_text()
    # What was found, as a file that a scenario extends.
    extending = tmp_path / "extending.toml"
    extending.write_text('extends = ["tiny.toml", "tuned.toml"]\nname = "extending"\n', encoding="utf-8")
    assert maglev.run(extending, fmus=fastest_fmus)["plant.h.position"][0] == found.parameters["plant.h.position_start"]


@pytest.mark.thorough
def test_an_interrupted_search_goes_on_to_the_same_file(fastest_fmus: Path, searched: Searched, left: Path,
                                                        tmp_path: Path) -> None:
    """It runs nothing again; and it continues with more generations."""
    shutil.copytree(left, tmp_path / "tuned.parts")
    assert len(list(left.glob("runs-*.npy"))) == 3   # the scenario's own, and two generations
    with raises(ScenarioError, "resume"):
        maglev.tune(searched.file, out=tmp_path, fmus=fastest_fmus, jobs=1)
    shown: list[int] = []
    resumed = maglev.tune(searched.file, out=tmp_path, fmus=fastest_fmus, jobs=1, resume=True,
                          watch=lambda _: nullcontext(lambda _name, done, _all: shown.append(done)))
    assert resumed.path.read_bytes() == searched.whole.path.read_bytes()
    assert np.array_equal(resumed.found.fresh_after, searched.whole.found.fresh_after)
    assert min(shown) > 2 * (1 + 2 * 8)   # what is kept is not run
    assert not (tmp_path / "tuned.parts").exists()


def test_the_command_says_what_it_found_or_what_is_wrong(fastest_fmus: Path, tmp_path: Path) -> None:
    tiny_scenario(tmp_path)
    path = tmp_path / "tuning.toml"
    path.write_text(FILE.replace("= 8", "= 5"), encoding="utf-8")
    result = command("tune", path, "--fmus", fastest_fmus, "--out", tmp_path, "--jobs", "1")
    assert result.exit_code == 0, result.output
    for words in ("the 2 plants of the search", "3 other plants", "plant.h.position_start = ", "tuned.toml"):
        assert words in result.output
    assert "there is no tuning file 'horizontal'; nearest is 'horizontal-3dof'" in error_line(
        command("tune", "horizontal"))


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_tuning_files_of_the_package(path: Path, fastest_fmus: Path) -> None:
    tuning, _ = load_tuning(path.stem)
    assert tuning.name == path.stem
    scenario = path.parent / tuning.scenario if tuning.scenario.endswith(".toml") else tuning.scenario
    plan_tuning(tuning, prepare(load_plan(scenario), fastest_fmus, {}, {}), path.name)


@pytest.mark.thorough
def test_a_broken_generation_is_run_again(fastest_fmus: Path, searched: Searched, left: Path, tmp_path: Path) -> None:
    parts = tmp_path / "tuned.parts"
    shutil.copytree(left, parts)   # with the times of the files
    _, first, second = sorted(parts.glob("runs-*.npy"), key=lambda path: path.stat().st_mtime_ns)
    first.write_bytes(second.read_bytes())   # of the right shape
    said: list[str] = []
    resumed = maglev.tune(searched.file, out=tmp_path, fmus=fastest_fmus, jobs=1, resume=True, say=said.append)
    assert resumed.path.read_bytes() == searched.whole.path.read_bytes()
    assert said == [f"{parts}: 1 of the parts are changed and run again"]


def test_a_tuning_whose_runs_all_end_early(fastest_fmus: Path, tmp_path: Path) -> None:
    tiny_scenario(tmp_path)
    path = tmp_path / "tuning.toml"
    path.write_text('set = { "controller.sample_time" = "0.7 ms" }\n' + FILE, encoding="utf-8")
    line = error_line(command("tune", path, "--fmus", fastest_fmus, "--out", tmp_path, "--jobs", "1"))
    assert "tuned: with the scenario's own values no run is completed: " in line
    assert "sample_time" in line
    assert not (tmp_path / "tuned.toml").exists()
