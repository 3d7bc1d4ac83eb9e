"""Any block of a loop as a Python file: a plant, a sensor, a generator of references, a supervisor."""

from pathlib import Path

import numpy as np
import pytest
from command_line import error_line
from command_line import maglev as command
from facts import warns
from numpy.testing import assert_array_equal
from written_controllers import WIRED, blocks

import maglev
from maglev.scenario.loading import load_plans

pytestmark = pytest.mark.filterwarnings("ignore:plant .* starts with")

CLAMP = '''
class Clamp:
    """A supervisor between controller and plant."""
    inputs = {"a": "A", "b": "A", "c": "A"}
    outputs = {"i_a": "A", "i_b": "A", "i_c": "A"}
    def __init__(self):
        self.sample_time = 0.5e-3
        self.a = self.b = self.c = self.i_a = self.i_b = self.i_c = 0.0
    def step(self, t):
        self.i_a, self.i_b, self.i_c = (max(-20.0, min(20.0, each)) for each in (self.a, self.b, self.c))
'''
SUPERVISED = '''
extends = "trial.toml"
name = "supervised"
stop_time = "0.05 s"
[fmus.clamp]
file = "clamp.py"
before = "plant"
inputs = { a = "controller.motor.i_a_cmd", b = "controller.motor.i_b_cmd", c = "controller.motor.i_c_cmd" }
[fmus.plant.inputs]
"motor.i_a_cmd" = "clamp.i_a"
"motor.i_b_cmd" = "clamp.i_b"
"motor.i_c_cmd" = "clamp.i_c"
'''


def test_each_block_of_the_loop_can_be_a_file(fastest_fmus: Path, tmp_path: Path) -> None:
    """Ideal ones give the bits of the loop without them, from the first sample on; and none has two sources."""
    blocks(tmp_path)
    usual = maglev.run(tmp_path / "trial.toml", fmus=fastest_fmus)
    runs = {name: maglev.run(tmp_path / f"{name}.toml", fmus=fastest_fmus) for name in WIRED}
    for name, run in runs.items():
        assert run.metrics.rms_errors == usual.metrics.rms_errors, name
        for column in ("plant.v.position", "plant.h.position", "controller.motor.i_a_cmd"):
            assert_array_equal(run[column], usual[column], err_msg=f"{name} {column}")
    assert runs["sensor"]["sensor.v.measured"][0] == 0.02   # its file begins with 0: it was given the plant's
    assert_array_equal(runs["generator"]["generator.v.reference"], usual["controller.v.reference"])
    assert runs["generator"].metrics.steps[0].overshoot == usual.metrics.steps[0].overshoot


def test_a_supervisor_is_stepped_where_it_stands(fastest_fmus: Path, tmp_path: Path) -> None:
    """In the loop, with `before`; after the plant the currents would come a step late, and that is said."""
    blocks(tmp_path)
    (tmp_path / "clamp.py").write_text(CLAMP)
    path = tmp_path / "supervised.toml"
    path.write_text(SUPERVISED)
    plan, = load_plans(path)
    assert list(plan.fmus) == ["controller", "clamp", "plant"]
    usual = maglev.run(tmp_path / "trial.toml", fmus=fastest_fmus)
    run = maglev.run(path, fmus=fastest_fmus)
    assert_array_equal(run["plant.v.position"], usual["plant.v.position"][:len(run.time)])
    path.write_text(SUPERVISED.replace('before = "plant"\n', ""))
    with warns("clamp", "plant", "0.0005 s", 'before = "plant"'):
        late = maglev.run(path, fmus=fastest_fmus)
    assert np.any(late["plant.v.position"] != run["plant.v.position"])


def test_a_study_takes_every_file(fastest_fmus: Path, tmp_path: Path) -> None:
    """Those of the scenario and those that are put in; a row is what the files run."""
    path, plant = blocks(tmp_path) / "sensor.toml", tmp_path / "plant.py"
    study = maglev.study(path, vary={"sensor.resolution": [0.0, 1e-4]}, plant=plant, fmus=fastest_fmus,
                         out=tmp_path / "out", jobs=1, say=lambda _: None)
    frame = study.to_pandas()
    assert frame["failure"].isna().all()
    run = maglev.run(path, plant=plant, fmus=fastest_fmus, set={"sensor.resolution": 1e-4})
    assert run.metrics.rms_errors["v"] == frame["rms error of v"][1] != frame["rms error of v"][0]
    assert f"--plant {plant}" in study.command(1)


@pytest.mark.parametrize(("old", "new", "words"), [
    ('= "sensor.v.measured"', '= "sensor.v.mesured"', "missing port: output v.mesured (nearest is 'v.measured')"),
    ('"v.encoder" = "plant.v.encoder"', '"v.encodr" = "plant.v.encoder"',
     "missing port: input v.encodr (nearest is 'v.encoder')"),
    ('= "plant.v.encoder"', '= "plant.at_stop"', "connects Boolean to Real, expected the same type"),
    ('= "plant.v.encoder"', '= "plant.motor.i_a"', "connects A to m, expected the same unit"),
    ('file = "sensor.py"', 'file = "sensr.py"', "there is no file"),
    ('[fmus.controller.inputs]', 'before = "sensor"\n[fmus.controller.inputs]',
     "fmus.sensor.before = 'sensor': expected another FMU of this scenario, there are '"),
    ('[fmus.controller.inputs]', 'before = "plant"\n[fmus.plant]\nbefore = "sensor"\n'
     '[fmus.controller.inputs]', "expected no FMUs that are to be stepped before each other"),
    ('[fmus.controller.inputs]', '[[signals]]\nto = "controller.v.measured"\n'
     'kind = "constant"\nvalue = 0\n[fmus.controller.inputs]', "is fed by fmus.controller.inputs.")])
def test_what_does_not_fit_is_refused(fastest_fmus: Path, tmp_path: Path, old: str, new: str, words: str) -> None:
    path = blocks(tmp_path) / "sensor.toml"
    text = path.read_text()
    assert text.count(old) == 1
    path.write_text(text.replace(old, new))
    line = error_line(command("run", path, "--fmus", fastest_fmus, "--out", tmp_path / "out"))
    assert words in line, line


def test_an_empty_source_takes_a_connection_away(tmp_path: Path) -> None:
    path = blocks(tmp_path) / "cut.toml"
    path.write_text('extends = "trial.toml"\nname = "cut"\n[fmus.controller.inputs]\n"v.measured" = ""\n')
    plan, = load_plans(path)
    assert "controller.v.measured" not in [target for _, target in plan.wires.values()]
    assert len(plan.wires) == 4


