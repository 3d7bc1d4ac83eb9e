"""Inputs of an FMU that name their sources: the same as connections, in words of their own where they do not fit."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from facts import raises

from maglev.files.errors import ScenarioError
from maglev.runs.plan_check import check_names
from maglev.runs.preparation import prepare
from maglev.scenario.layers import PACKAGED
from maglev.scenario.loading import load_plan, load_plans
from maglev.scenario.run_plan import RunPlan

LOOP = """
step = "1 ms"
stop_time = "1 s"
name = "loop"
title = "Loop"
[fmus.controller]
model = "Controller"
inputs = { "y.measured" = "plant.y.encoder" }
[fmus.plant]
model = "Plant"
"""
EXTRA = """
[fmus.plant.inputs]
"m.i_a_cmd" = "controller.m.i_a_cmd"
[fmus.watcher]
model = "Watcher"
[fmus.watcher.inputs]
"y.measured" = "plant.y.encoder"
"""
EXPERIMENT = """
extends = ["loop.toml", "extra.toml"]
[variants.exact]
extends = "exact.toml"
[variants.coarse.fmus.watcher.inputs]
force = "controller.force"
"""
EXACT = """
[fmus.watcher.inputs]
"y.measured" = "plant.y.position"
"""


@pytest.fixture
def loop(tmp_path: Path) -> Path:
    """A loop without connections, an observer next to it, and two variants of both."""
    texts = {"loop": LOOP, "extra": EXTRA, "experiment": EXPERIMENT, "exact": EXACT}
    for name, text in texts.items():
        (tmp_path / f"{name}.toml").write_text(text)
    return tmp_path / "loop.toml"


def variables(**kinds: str) -> dict[str, SimpleNamespace]:
    return {name: SimpleNamespace(name=name, causality=kind, variability="fixed",
                                  type="Boolean" if name == "at_stop" else "Real",
                                  unit="A" if ".i_" in name else "m" if name.startswith("y.") else None)
            for kind, names in kinds.items() for name in names.split()}


DESCRIPTIONS = {
    "controller": variables(input="y.measured y.reference", output="m.i_a_cmd force", parameter="gain"),
    "plant": variables(input="m.i_a_cmd", output="y.encoder y.position at_stop"),
    "watcher": variables(input="y.measured force", output="y.estimate")}


def test_inputs_are_connections(loop: Path) -> None:
    plan = load_plan(loop)
    assert plan.connections == []
    assert plan.wires == {'fmus.controller.inputs."y.measured"': ("plant.y.encoder", "controller.y.measured")}
    loop.write_text(LOOP.replace("[fmus.controller]", 'connections = [["controller.m.i_a_cmd", "plant.m.i_a_cmd"]]\n'
                                                      "[fmus.controller]", 1))
    assert list(load_plan(loop).wires.items()) == [
        ("connections[0]", ("controller.m.i_a_cmd", "plant.m.i_a_cmd")),
        ('fmus.controller.inputs."y.measured"', ("plant.y.encoder", "controller.y.measured"))]


def test_inputs_of_several_files_and_variants_are_merged(loop: Path) -> None:
    exact, coarse = load_plans(loop.with_name("experiment.toml"))
    loop_wires = [("plant.y.encoder", "controller.y.measured"), ("controller.m.i_a_cmd", "plant.m.i_a_cmd")]
    assert list(exact.wires.values()) == [*loop_wires, ("plant.y.position", "watcher.y.measured")]
    assert list(coarse.wires.values()) == [*loop_wires, ("plant.y.encoder", "watcher.y.measured"),
                                           ("controller.force", "watcher.force")]
    for run in (exact, coarse):
        check_names(run, DESCRIPTIONS, {})


SIGNAL = '[[signals]]\nto = "controller.y.measured"\nkind = "constant"\nvalue = 0\n'
WIRE = '"y.measured" = "plant.y.encoder"'
KEY = 'fmus.controller.inputs."y.measured"'


@pytest.mark.parametrize(("old", "new", "facts"), [
    (WIRE, '"y.measured" = "plnt.y.encoder"', [KEY, "'plnt.y.encoder'", "'plant'"]),
    (WIRE, '"y.measured" = "plant.y.encodr"', [KEY, "'plant.y.encodr'", "'y.encoder'"]),
    (WIRE, '"y.measured" = "plant.m.i_a_cmd"', [KEY, "'plant.m.i_a_cmd'", "input", "output"]),
    (WIRE, '"y.measurd" = "plant.y.encoder"',
     ['fmus.controller.inputs."y.measurd"', "controller", "'y.measurd'", "'y.measured'"]),
    (WIRE, 'gain = "plant.y.encoder"', ["fmus.controller.inputs.gain", "'gain'", "fixed", "tunable"]),
    (WIRE, '"y.measured" = "plant.at_stop"', [KEY, "'plant.at_stop'", "Boolean", "Real"]),
    (WIRE, '"y.measured" = "controller.m.i_a_cmd"', [KEY, "'controller.m.i_a_cmd'", "A", "m"]),
    ('title = "Loop"', 'title = "Loop"\nconnections = [["plant.y.position", "controller.y.measured"]]',
     [KEY, "'controller.y.measured'", "connections[0][1]"]),
    ('[fmus.plant]\nmodel = "Plant"\n', f'[fmus.plant]\nmodel = "Plant"\n{SIGNAL}',
     ["signals[0].to", "'controller.y.measured'", KEY])])
def test_inputs_that_do_not_fit_are_refused_by_their_key(loop: Path, old: str, new: str, facts: list[str]) -> None:
    assert LOOP.count(old) == 1
    loop.write_text(LOOP.replace(old, new))
    with raises(ScenarioError, loop, *facts):
        check_names(load_plan(loop), DESCRIPTIONS, {})


@pytest.mark.parametrize("source", ["3", '["plant.y.encoder"]'])
def test_a_source_is_one_name(loop: Path, source: str) -> None:
    loop.write_text(LOOP.replace(WIRE, f'"y.measured" = {source}'))
    with raises(ScenarioError, loop, KEY, source.replace('"', "'"), "string"):
        load_plan(loop)


def simulated(plan: RunPlan, fmus: Path) -> dict[str, np.ndarray]:
    return dict(prepare(plan, fmus, {}, {}).run().columns)


def test_a_run_is_the_same_bit_for_bit_as_with_connections(fmus: Path, tmp_path: Path) -> None:
    path = tmp_path / "drive.toml"
    path.write_text(f'extends = "{PACKAGED / "loops" / "2dof-drive.toml"}"\nname = "drive"\ntitle = "Drive"\n'
                    'stop_time = "20 ms"\n[fmus.controller.start]\n"motor.i_q_reference" = 3\n')
    own = load_plan(path)
    connected = own.model_copy(update={
        "connections": list(own.wires.values())[::-1],
        "fmus": {name: fmu.model_copy(update={"inputs": {}}) for name, fmu in own.fmus.items()}})
    first, second = simulated(own, fmus), simulated(connected, fmus)
    assert set(first) == set(second)
    assert np.ptp(first["plant.h.position"]) > 1e-4
    for name, values in first.items():
        assert np.array_equal(values, second[name]), name
