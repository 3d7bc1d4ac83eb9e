"""A reference that a stage cannot reach, for its stops are in the way, is refused before the run."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from command_line import error_line
from command_line import maglev as command
from described_stages import SMALL, written
from facts import raises, require_facts
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from named_blocks import named_block
from packaged_plans import RUNS

import maglev
from maglev.descriptions.own_fmus import definition
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import ScenarioError
from maglev.fmi.definition import read
from maglev.runs.plan_check import Start, gaps_of, require_reachable
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import RunPlan
from maglev.scenario.settings import with_reference

pytestmark = pytest.mark.usefixtures("slow")   # it searches for long

SHORT = 'extends = "2dof-setpoints.toml"\nname = "short"\nstop_time = "0.2 s"\nclaims = []\n'
STUDY = """
name = "s"
scenario = "small-setpoints.toml"
[[vary]]
set = "plant.v.mass"
kind = "list"
values = [12.0]
"""


def starts_of(plan: RunPlan) -> Start:
    """Start values of a plan, or of the definitions of its FMUs."""
    def value(full: str) -> float | None:
        name, _, own = full.partition(".")
        fmu = plan.fmus[name]
        if own in fmu.start:
            return float(fmu.start[own].value)
        block = definition(str(fmu.model)).new_block()
        place = next((v.place for v in definition(str(fmu.model)).variables if v.name == own), None)
        if place is None:
            return None
        return float(read(block, place))

    return value


def references(plan: RunPlan, times: np.ndarray) -> dict[str, np.ndarray]:
    return {signal.to: signal.values_at(times) for signal in plan.signals}


@pytest.mark.thorough
def test_a_stage_whose_gap_was_edited_does_not_run_the_references_of_before(
        slow: None, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The scenario has setpoints about 20 mm; the description now says 3 mm."""
    monkeypatch.chdir(tmp_path)
    written(tmp_path / "small.toml", "2dof", SMALL)
    maglev.build(["PlantSmall", "RegulatorSmall"], stage="small.toml")
    scenario = tmp_path / "small-setpoints.toml"
    fixed = "".join(f'[[signals]]\nto = "controller.{axis}.reference"\nkind = "constant"\nvalue = "{value} mm"\n'
                    for axis, value in (("v", 20), ("h", 0)))
    text = re.sub("(?m)^signals = .*$", "", scenario.read_text(encoding="utf-8"))
    scenario.write_text(text + fixed, encoding="utf-8")
    (tmp_path / "study.toml").write_text(STUDY, encoding="utf-8")
    facts = ("small-setpoints.toml", "reference of v", "20 mm", "0 s", "1.5 mm", "5 mm", "3 mm")
    for words in (["run", "small-setpoints.toml"], ["report", "small-setpoints.toml"], ["study", "study.toml"],
                  ["compare", "small-setpoints.toml", "--controller", "RegulatorSmall"],
                  ["study", "small-setpoints.toml", "--vary", "plant.v.mass=12,13"]):
        refused = command(*words)
        assert refused.exit_code == 2
        require_facts(refused.stderr.splitlines()[-1], *facts)
    assert not list((tmp_path / "results").rglob("*.csv"))
    checked = command("check", "small-setpoints.toml", "--update", "--baselines", ".")
    assert checked.exit_code == 2
    require_facts(" ".join(checked.output.split()), *facts)
    with raises(ScenarioError, *facts):
        maglev.run("small-setpoints.toml")


def test_what_was_there_stays(fastest_fmus: Path, tmp_path: Path) -> None:
    path = tmp_path / "short.toml"
    path.write_text(SHORT, encoding="utf-8")
    assert command("run", path, "--fmus", fastest_fmus, "--out", tmp_path).exit_code == 0
    before = {file: file.read_bytes() for file in tmp_path.iterdir()}
    for value in ("28.1mm", "7.9mm"):
        set_to = f"reference.v.start={value}"
        said = error_line(command("run", path, "--fmus", fastest_fmus, "--out", tmp_path, "--set", set_to))
        require_facts(said, path, "reference of v", f"{value[:4].removesuffix('m')} mm", "0 s")
    assert command("run", path, "--fmus", fastest_fmus, "--out", tmp_path, "--set", "reference.v.start=28.1mm", "--set",
                   "plant.v.stop.upper=29mm").exit_code == 0
    assert json.loads(before[tmp_path / "short.json"])["name"] == "short"


@pytest.mark.usefixtures("slow")
def test_a_study_may_vary_what_is_within_reach(fastest_fmus: Path, tmp_path: Path) -> None:
    """Its samples are simulated as it asks; which of them touch a stop is what it finds."""
    path = tmp_path / "short.toml"
    path.write_text(SHORT, encoding="utf-8")
    study = maglev.study(path, vary={"reference.v.start": ["20 mm", "30 mm"]}, fmus=fastest_fmus, out=tmp_path)
    rows = study.to_arrow()
    assert rows["failure"].to_pylist() == [None, None]
    assert rows["passed"].to_pylist() == [True, False]
    assert [time < 0.2 for time in rows["stop contact time"].to_pylist()] == [False, True]


def test_packaged_runs_stay_within_their_stops() -> None:
    """And with a reference that is moved beyond a stop each of them is refused."""
    refused = looked_at = 0
    for plan in RUNS:
        times = np.linspace(0.0, plan.stop_time, 1001)
        start = starts_of(plan)
        require_reachable(plan, times, references(plan, times), start)
        steps = [signal.to for signal in plan.signals if signal.kind == "steps"]
        vertical = next((name for name, axis in plan.axes.items() if axis.vertical and axis.reference in steps), None)
        if vertical is not None:
            looked_at += 1
            moved = with_reference(plan, f"{vertical}.end", 0.05)
            with raises(ScenarioError) as refusal:
                require_reachable(moved, times, references(moved, times), start)
            assert f"reference of {vertical} = 50 mm" in str(refusal.value) or "gap at" in str(refusal.value)
            refused += 1
    assert refused == looked_at > 50


@settings(max_examples=25)
@given(y=st.floats(0.019, 0.033), roll=st.floats(-0.02, 0.02), pitch=st.floats(-0.02, 0.02))
def test_gaps_at_the_motors_are_those_of_the_plant(y: float, roll: float, pitch: float) -> None:
    plan = load_plan("5dof-setpoints")
    positions = {"y": y, "x": 0.0, "z": 0.0, "roll": roll, "pitch": pitch}
    plant = named_block("Plant5DOF")
    for axis, position in positions.items():
        getattr(plant, axis).position_start = position
    assume(plant.start() == 0)   # which refuses gaps beyond the field of the magnets
    stage = PACKAGED_STAGES["5dof"]
    mounts = [getattr(plant, f"{motor}_mount") for motor in stage.motor_names]
    gaps = gaps_of(stage, starts_of(plan)) @ [positions[axis] for axis in stage.axis_names]
    assert gaps == pytest.approx([mount.gap for mount in mounts], abs=1e-12)
    given = {plan.axes[axis].reference: np.full(2, position) for axis, position in positions.items()}
    within = all(mount.stop.lower <= mount.gap <= mount.stop.upper for mount in mounts)
    try:
        require_reachable(plan, np.array([0.0, 1.0]), given, starts_of(plan))
    except ScenarioError as error:
        assert not within and "by the references" in str(error)
    else:
        assert within
