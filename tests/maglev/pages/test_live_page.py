"""The live page: one file with everything in it, of the packaged runs and the modules as they are built."""

import base64
import gzip
import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import error_line, maglev
from facts import raises, require_facts
from motor import MOTOR
from packaged_plans import RUNS

from maglev.descriptions.own_fmus import definition, installed
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.registry import known_stages
from maglev.files.errors import FmuError, ScenarioError
from maglev.fmi.model_description import model_description
from maglev.fmi.native_build import made_of
from maglev.linear.parameters import linear_names
from maglev.pages.live_content import (
    can_run_live,
    gap_table,
    live_runs,
    modules_of,
    not_live,
    page_data,
    places,
    visible_tilts,
)
from maglev.pages.live_page import FOLDER, SCRIPTS, WORKER, live_page, plans_of, reasons, write_live
from maglev.pages.panels import PANELS
from maglev.pages.shell import COMMENT, scene
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import RunPlan
from maglev.user.adoption import know_stage
from maglev.user.new_stage import new_stage
from plant_fmu.axis import Axis
from plant_fmu.motor_mount import MotorMount
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import Stop

MODULES = tuple(name for stage in PACKAGED_STAGES.values() for name in modules_of(stage))
LARGEST = 1_350_000   # bytes of the page with three stages


def element(page: str, name: str) -> bytes:
    """What an element of the page holds, unpacked."""
    found = re.search(rf'<script type="text/plain" id="{name}">([^<]*)</script>', page)
    assert found is not None, name
    return gzip.decompress(base64.b64decode(found[1]))


@pytest.fixture(scope="module")
def runs(slow: None) -> list[RunPlan]:
    """What can run in it; to find out all scenarios are read."""
    return live_runs()


@pytest.fixture(scope="module")
def page(wasm_fmus: Path, runs: list[RunPlan]) -> str:
    return live_page(wasm_fmus, runs)


@pytest.fixture(scope="module")
def data(page: str) -> Any:
    return json.loads(element(page, "data"))


def test_the_page_is_small_and_the_same_again(page: str, wasm_fmus: Path, runs: list[RunPlan]) -> None:
    assert len(page.encode()) < LARGEST
    assert live_page(wasm_fmus, runs) == page
    said = re.findall(r"(\d+) kB", (FOLDER.parents[2] / "docs" / "live.md").read_text(encoding="utf-8"))
    assert [float(size) for size in said] == [pytest.approx(len(page.encode()) / 1e3, rel=0.02)]


def test_the_page_needs_nothing_else(page: str) -> None:
    assert re.findall(r"""(?:src|href)\s*=\s*["'](?!#|data:)|https?://(?!www\.w3\.org)|@import|url\(""", page) == []
    assert "default-src 'none'" in page


def test_the_modules_are_those_that_were_built(page: str, wasm_fmus: Path) -> None:
    for name in MODULES:
        assert element(page, f"fmu-{name}") == (wasm_fmus / f"{name}.wasm").read_bytes()


def test_every_script_is_in_it_once(page: str) -> None:
    scripts = sorted(path.name for path in FOLDER.glob("*.js"))
    assert sorted((*WORKER, *SCRIPTS)) == scripts
    worker = element(page, "worker").decode()
    for name in scripts:
        text = (FOLDER / name).read_text(encoding="utf-8")
        assert (worker if name in WORKER else page).count(COMMENT.sub("", text)) == 1
        assert len(text.splitlines()) < 300, name
    assert page.count(COMMENT.sub("", scene())) == 1


def test_plans_are_those_of_the_scenarios(data: Any) -> None:
    """Start values and references, looked up in the scenario files' plans."""
    run = data["runs"]["3dof-tracking-nonlinear"]
    plan = load_plan("3dof-tracking-nonlinear")
    assert run["fmus"]["plant"]["start"]["y.stop.lower"] == 0.015
    assert run["fmus"]["controller"]["start"] == {key: start.value for key, start in
                                                  plan.fmus["controller"].start.items()}
    assert list(run["fmus"]) == ["controller", "plant"]
    assert [tuple(wire) for wire in run["wires"]] == list(plan.wires.values())
    vertical = next(signal for signal in run["signals"] if signal["to"] == "controller.y.reference")
    assert vertical["rate_to"] == "controller.y.reference_rate"
    assert vertical["terms"] == [{"amplitude": 0.005, "omega": 1.5 * np.pi, "phase": 0.0}]
    assert (vertical["offset"], vertical["ramp"]) == (0.025, 2.0)


def test_every_experiment_with_one_controller_is_in_it(data: Any) -> None:
    """Those of figures, except for identification, which runs estimators or starts from other runs."""
    shown = {plan.name for plan in RUNS
             if plan.figures and plan.procedure is None and not plan.needs
             and set(plan.fmus) == {"controller", "plant"}}
    assert shown and shown <= set(data["runs"])
    assert {run["fmus"]["controller"]["model"] for run in data["runs"].values()} <= {*MODULES}
    assert {run["plant"]
            for run in data["runs"].values()} == {linear_names(stage)[0] for stage in PACKAGED_STAGES.values()}
    for run in data["runs"].values():   # also those that no run begins with can be swapped in
        assert [run["plant"], *run["laws"]] == linear_names(PACKAGED_STAGES[run["stage"]])


def test_runs_that_it_cannot_run_are_not_in_it(runs: list[RunPlan]) -> None:
    assert not can_run_live(load_plan("2dof-identification-rig"))   # estimators
    assert not can_run_live(load_plan("3dof-laws-nonlinear"))       # for the check alone
    assert not can_run_live(load_plan("5dof-guided-first-linear"))   # a controller of another stage
    said = {name: why for why, names in not_live().items() for name in names}
    assert "Plant5DOF (a law without references of roll and pitch), expected" in said["5dof-guided-first-linear"]
    judged = {plan.name for plan in RUNS if not plan.check_only}
    assert said.keys() == judged - {plan.name for plan in runs}
    assert f"<li>2dof-cogging: {said['2dof-cogging']}</li>" in reasons({said["2dof-cogging"]: ["2dof-cogging"]})
    assert all(plan.fmus["plant"].model in MODULES for plan in runs)


def test_tilts_are_seen_from_the_side_that_the_gap_grows_to() -> None:
    """Against the block that places the motors; stages whose guides hold the tilts have none."""
    seen = {name: visible_tilts(stage) for name, stage in PACKAGED_STAGES.items() if visible_tilts(stage)}
    assert list(seen) == [name for name, stage in PACKAGED_STAGES.items() if stage.rotations]
    for name, sides in seen.items():
        stage = PACKAGED_STAGES[name]
        assert {side["axis"] for side in sides.values()} == {axis.name for axis in stage.rotations}
        for side in sides.values():
            at = {"x": 0.0, "z": 0.0, side["place"]: 0.1}
            mount = MotorMount(at["x"], at["z"], 1, Stop(0.01, 0.03, 1.0, 1.0))
            gap, about_x, about_z = (Axis(1.0, 0.0, 0.0, 1.0, 0.0, -1.0, 1.0, 0.0) for _ in range(3))
            tilt = {stage.rotations[0].name: about_x, stage.rotations[1].name: about_z}[side["axis"]]
            gap.position, tilt.position = 0.02, 5e-3
            mount.place(gap, about_x, about_z)
            assert mount.gap - 0.02 == pytest.approx(side["sign"] * 0.1 * 5e-3)


def test_motors_are_drawn_where_they_are() -> None:
    """Of the description where the platform tilts; else on both sides of it, and alone in the middle."""
    for stage in PACKAGED_STAGES.values():
        found = places(stage)
        assert {name: len(at) for name, at in found.items()} == dict.fromkeys(stage.motor_names, int(stage.sharing))
        for motor in stage.motors if stage.rotations else ():
            assert found[motor.name] == [(motor.x, motor.z)]
        if not stage.rotations:   # its force goes through the middle
            for axis in stage.horizontal:
                at = [place for motor in stage.motors_of(axis.name) for place in found[motor.name]]
                assert np.sum(at, axis=0) == pytest.approx([0.0, 0.0]) and len(set(at)) == len(at)
    assert places(PACKAGED_STAGES["2dof"]) == {"motor": [(0.0, 0.0)]}


def test_descriptions_are_those_of_the_model_description(data: Any) -> None:
    variables = {variable["name"]: variable for variable in data["fmus"]["Plant3DOF"]["variables"]}
    assert variables["y.mass"] | {"description": ""} == {
        "name": "y.mass", "causality": "parameter", "boolean": False, "start": 6.9, "fixed": False,
        "unit": "kg", "description": "", "min": 1e-3, "max": 1e6}
    assert variables["y.position_start"]["fixed"] is True
    controller = {variable["name"]: variable for variable in data["fmus"]["Regulator3DOF"]["variables"]}
    assert controller["antiwindup"]["start"] is True and "min" not in controller["antiwindup"]


def test_plots_and_readouts_are_those_of_the_table_of_panels(data: Any) -> None:
    """As the report titles and counts them; of no axis or motor nothing is left out."""
    stage = data["stages"]["5dof"]
    assert [strip["title"] for strip in stage["strips"]] == [
        "gap y (mm)", "displacement (mm)", "tilt (mrad)", "|error| of axes", "motor currents (A)"]
    assert [strip["axes"] for strip in stage["strips"]] == [["y"], ["x", "z"], ["roll", "pitch"],
                                                          list(PACKAGED_STAGES["5dof"].axis_names), []]
    error = next(strip for strip in stage["strips"] if strip["kind"] == "error")
    assert error["floor"] == PANELS["error"].drawn_floor == pytest.approx(1e-3)   # mm
    assert [strip["down"] for strip in stage["strips"]] == [True, False, False, False, False]
    assert {name: (shown["name"], shown["unit"], shown["digits"]) for name, shown in stage["shown"].items()} == {
        "y": ("gap y", "mm", 4), "x": ("x", "mm", 4), "z": ("z", "mm", 4), "roll": ("roll", "mrad", 4),
        "pitch": ("pitch", "mrad", 4)}


def test_forces_are_drawn_from_the_shape_functions() -> None:
    table = gap_table(MOTOR)
    for k in (0, 17, len(table["values"]) - 1):
        expected = gap_functions(MOTOR, table["first"] + k * table["step"])
        np.testing.assert_allclose(table["values"][k], expected, rtol=1e-5)


def test_a_missing_module_is_refused(tmp_path: Path, runs: list[RunPlan]) -> None:
    with raises(FmuError, tmp_path / "Plant2DOF.wasm"):
        page_data(tmp_path, runs)
    said = error_line(maglev("live", "--fmus", tmp_path, "--out", tmp_path))
    assert "maglev build --kind native --target wasm" in said
    assert not (tmp_path / "live.html").exists()


@pytest.fixture
def mine(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A user's folder with a stage; where modules would be there are files that say that they are those of now."""
    monkeypatch.chdir(tmp_path)
    new_stage("mine.toml")
    folder = tmp_path / "wasm"
    folder.mkdir()
    for name in modules_of(know_stage("mine.toml")):
        (folder / f"{name}.wasm").write_bytes(b"module")
        made = made_of(definition(name), b"module", installed())
        (folder / f"{name}.xml").write_bytes(model_description(definition(name), "{0}", "1", 0) + made)
    yield folder
    known_stages().forget(*known_stages().own)


@pytest.mark.usefixtures("slow")
def test_a_page_of_a_stage_of_ones_own(mine: Path, tmp_path: Path) -> None:
    assert write_live(tmp_path, files="mine-setpoints.toml", fmus=tmp_path).name == "live-mine-setpoints.html"
    page = write_live(tmp_path, files=["mine.toml", "mine-setpoints.toml"], fmus=tmp_path)
    assert page.name == "live-mine.html"   # next to the page of ours
    data = json.loads(element(page.read_text(encoding="utf-8"), "data"))
    assert list(data["fmus"]) == ["PlantMine", "RegulatorMine", "LinearRegulatorMine", "PIDMine",
                                  "AdaptiveRegulatorMine", "MeasurementMine"]
    assert {name: run["command"] for name, run in data["runs"].items()} == {
        "mine": "", "mine-setpoints": "mine-setpoints.toml"}   # no command runs what is in no scenario
    rest, simulated = data["runs"].values()
    assert rest["signals"] == [] and len(simulated["signals"]) == 3
    assert rest["wires"] == simulated["wires"] and rest["step"] == simulated["step"] == 2e-4
    assert data["stages"]["mine"]["mass"]["y"] == 6.9


@pytest.mark.usefixtures("slow")
def test_names_the_missing_parts_of_a_users_page(mine: Path, tmp_path: Path) -> None:
    description = tmp_path / "mine.toml"
    description.write_text(description.read_text(encoding="utf-8").replace("mass = 6.9 ", "mass = 6.8 "),
                           encoding="utf-8")
    said = error_line(maglev("live", "mine.toml", "--fmus", tmp_path))
    require_facts(said, "PlantMine.wasm", "`maglev build --stage mine.toml --kind native --target wasm --fmus .`")
    (mine / "PlantMine.wasm").unlink()
    require_facts(error_line(maglev("live", "mine.toml", "--fmus", tmp_path)), "PlantMine.wasm")
    scenario = tmp_path / "mine-setpoints.toml"
    scenario.write_text(scenario.read_text(encoding="utf-8").replace('signals = "setpoints"', 'signals = "ramp"', 1),
                        encoding="utf-8")
    with raises(ScenarioError, "signals", "'ramp'"):
        plans_of(scenario)
    for name, simulated in (("2dof-identification-rig", "PID2DOF, Plant2DOF, Estimator2DOF"),
                            ("5dof-guided-first-linear", "LinearRegulator3DOF, Plant5DOF")):
        with raises(FmuError, name, simulated):
            page_data(mine, [load_plan(name)])
