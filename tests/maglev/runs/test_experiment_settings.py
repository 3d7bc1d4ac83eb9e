"""Whose start values they are: conditions of an experiment are for every FMU, settings of a design for its model."""

import hashlib
import json
import shutil
import zipfile
from pathlib import Path

import pytest
from command_line import error_line
from command_line import maglev as command
from facts import raises, warns
from fmpy import read_model_description

import maglev
from maglev.api.options import experiments_of
from maglev.files.errors import ScenarioError
from maglev.fmi.parameter_set import Value, parameter_set, xml_file
from maglev.runs.preparation import Experiment, prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.loading import load_plan
from maglev.scenario.options import RunOptions
from maglev.scenario.settings import start_values
from maglev.user.source import source_of

RUN = "3dof-setpoints-improved"

# Parameters of the names of the regulator's gains, with another meaning.
MINE = '''
class Mine:
    """A controller whose y.k1 is no gain of the regulator; it gives no currents."""

    inputs = {f"{axis}.{port}": "m" for axis in "yxz" for port in ("measured", "reference")}
    outputs = {f"{motor}.i_{phase}_cmd": "A" for motor in ("alpha", "beta") for phase in "abc"}
    parameters = {"y.k1": "", "y.k2": "", "current_limit": "A"}

    def __init__(self):
        self.sample_time = 0.2e-3
        for name in (*self.inputs, *self.outputs):
            setattr(self, name.replace(".", "_"), 25e-3 if name.startswith("y.") else 0.0)
        for name in self.outputs:
            setattr(self, name.replace(".", "_"), 0.0)
        self.y_k1 = self.y_k2 = self.current_limit = 8.0

    def step(self, t):
        pass
'''


@pytest.fixture
def mine(tmp_path: Path) -> Path:
    """A file with that controller."""
    path = tmp_path / "mine.py"
    path.write_text(MINE)
    return path


def prepared(fmus: Path, path: Path, *settings: str, run: str = RUN, name: str = "controller",
             keep: bool = False) -> Experiment:
    return prepare(load_plan(run), fmus, {name: Replacement(source_of(path), keep_settings=keep)},
                   start_values(settings))


def starts(experiment: Experiment, name: str = "controller") -> dict[str, object]:
    return {variable: start.value for variable, start in experiment.plan.fmus[name].start.items()}


def disguised(path: Path, folder: Path) -> Path:
    """An FMU of ours as somebody else's: the same, and a file more."""
    copy = Path(shutil.copy(path, folder))
    with zipfile.ZipFile(copy, "a") as archive:
        archive.writestr("resources/theirs.txt", "theirs")
    return copy


def test_settings_of_the_plans_model_are_not_for_another_one(fmus: Path, mine: Path) -> None:
    experiment = prepared(fmus, mine)
    assert starts(experiment) == {}
    assert experiment.left_out["controller.y.k1"] == "it is a setting of Regulator3DOF"
    assert experiment.left_out["controller.x.k1"] == "it has no such variable"
    assert starts(experiment, "plant")["y.position_start"] == 25e-3
    parameters = experiment.parameters()
    assert [parameters[f"controller.{name}"] for name in ("y.k1", "y.k2", "current_limit")] == [8.0, 8.0, 8.0]


def test_who_asks_for_them_gets_them(fmus: Path, mine: Path) -> None:
    experiment = prepared(fmus, mine, keep=True)
    assert starts(experiment) == {"y.k1": -1274.0, "y.k2": -104.0, "current_limit": 4.0}
    assert "controller.y.k1" not in experiment.left_out
    one = prepared(fmus, mine, "controller.y.k1=3")
    assert starts(one) == {"y.k1": 3}
    assert "controller.y.k1" not in one.left_out


def test_a_signal_on_a_gain_is_a_setting_too(fmus: Path, mine: Path, tmp_path: Path) -> None:
    path = tmp_path / "driven.toml"
    path.write_text(f'extends = "{RUN}.toml"\nname = "driven"\nclaims = []\nstop_time = "10 ms"\n[[signals]]\n'
                    'to = "controller.y.k1"\nkind = "constant"\nvalue = -1000\n')

    def driven(controller: Path, *settings: str, keep: bool = False) -> list[str]:
        replaced = {"controller": Replacement(source_of(controller), keep_settings=keep)}
        experiment = prepare(load_plan(path), fmus, replaced, start_values(settings))
        return [name for name in experiment.drives(experiment.check()) if name == "controller.y.k1"]

    assert driven(mine) == driven(mine, "controller.y.k1=3") == []
    assert driven(mine, keep=True) == driven(fmus / "LinearRegulator3DOF.fmu") == ["controller.y.k1"]


def test_fmus_of_this_project_share_their_meaning(fmus: Path, tmp_path: Path) -> None:
    assert starts(prepared(fmus, fmus / "LinearRegulator3DOF.fmu"))["y.k1"] == -1274.0
    assert starts(prepared(fmus, fmus / "PID3DOF.fmu")) == {"current_limit": 4.0, "antiwindup": True}


def test_an_fmu_that_only_says_it_is_ours_has_its_own(fmus: Path, tmp_path: Path) -> None:
    theirs = disguised(fmus / "Regulator3DOF.fmu", tmp_path)
    experiment = prepared(fmus, theirs)
    assert starts(experiment) == {}
    assert "controller.y.k1" in experiment.left_out


def test_conditions_are_for_everybody(fmus: Path, tmp_path: Path) -> None:
    plant = disguised(fmus / "Plant3DOF.fmu", tmp_path)
    experiment = prepared(fmus, plant, run="3dof-payload-10-percent", name="plant")
    planned = load_plan("3dof-payload-10-percent").fmus["plant"].start
    assert starts(experiment, "plant") == {name: start.value for name, start in planned.items()}
    controller = disguised(fmus / "PID2DOF.fmu", tmp_path)
    assert "h.reference" in starts(prepared(fmus, controller, run="2dof-cogging"))
    assert "v.prefilter" not in starts(prepared(fmus, controller, run="2dof-cogging"))


def scenario(folder: Path, *lines: str) -> Path:
    """A scenario that runs mine.py as a file of its own."""
    path = folder / "scenario.toml"
    path.write_text("\n".join(['extends = "3dof-setpoints-improved.toml"', 'name = "scenario"', "claims = []",
                               'stop_time = "10 ms"', "[fmus.controller]", *lines]))
    return path


def test_a_file_in_a_scenario_inherits_conditions_alone(fmus: Path, mine: Path, tmp_path: Path) -> None:
    path = scenario(tmp_path, 'file = "mine.fmu"', '[fmus.controller.start]', '"y.k2" = 5')
    maglev.build([mine], fmus=tmp_path)
    shutil.move(tmp_path / "Mine.fmu", tmp_path / "mine.fmu")
    experiment = prepare(load_plan(path), fmus, {}, {})
    assert starts(experiment) == {"y.k2": 5}
    assert experiment.left_out["controller.y.k1"].startswith("it is a setting of")
    back = tmp_path / "back.toml"
    back.write_text('extends = "scenario.toml"\nname = "back"\n[fmus.controller]\nmodel = "Regulator3DOF"\n')
    assert "y.k2" not in starts(prepare(load_plan(back), fmus, {}, {}))


def test_what_was_set_is_said_and_written_down(fmus: Path, mine: Path, tmp_path: Path) -> None:
    path = scenario(tmp_path, 'model = "Regulator3DOF"')
    done = command("run", path, "--controller", mine, "--fmus", fmus, "--out", tmp_path, "--set",
                   "controller.current_limit=3 A")
    assert ("controller (mine.py) keeps its own controller.y.k1, controller.y.k2: the plan's values are settings of "
            "Regulator3DOF; keep_settings gives them") in done.stderr
    assert "controller (mine.py) starts with current_limit = 3 A" in done.stderr
    fmu = json.loads((tmp_path / "scenario.json").read_text())["provenance"]["fmus"]
    assert fmu[0]["start"] == {"current_limit": 3.0}
    assert fmu[0]["left_out"]["y.k1"] == "it is a setting of Regulator3DOF"
    assert fmu[1]["start"] == {"y.position_start": 25e-3, "x.position_start": 0.0, "z.position_start": 0.0}
    kept = command("run", path, "--controller", mine, "--fmus", fmus, "--out", tmp_path, "--keep-settings")
    assert "starts with y.k1 = -1274, y.k2 = -104" in kept.stderr


@pytest.mark.parametrize("words", [("run", RUN), ("report", RUN), ("check", RUN), ("study", "payload-friction"),
                                   ("study", RUN, "--vary", "plant.y.mass=6:7:2"), ("tune", "horizontal-3dof")])
def test_without_another_fmu_there_is_nobody_to_keep_them(fmus: Path, tmp_path: Path, words: tuple[str, ...]) -> None:
    done = command(*words, "--keep-settings", "--fmus", fmus, *(() if words[0] == "check" else ("--out", tmp_path)))
    assert "keep_settings: needs controller or plant" in error_line(done)


def test_they_are_kept_for_those_who_are_put_in(fmus: Path, mine: Path, tmp_path: Path) -> None:
    """The plan's own controller, next to it in a comparison, has them anyway."""
    path = scenario(tmp_path, 'model = "Regulator3DOF"')
    with warns("mine.py", "y.k1 = -1274"):
        found = maglev.compare(path, ["Regulator3DOF", mine], fmus=fmus, keep_settings=True)
    assert [run.parameters["controller.y.k1"] for run in found.runs.values()] == [-1274.0, -1274.0]
    with warns("mine.py", "controller.y.k1", "Regulator3DOF", "keep_settings"):
        found = maglev.compare(path, ["Regulator3DOF", mine], fmus=fmus)
    assert [run.parameters["controller.y.k1"] for run in found.runs.values()] == [-1274.0, 8.0]


def parameter_file(fmu: Path, folder: Path, **changed: tuple[float, str]) -> Path:
    """Parameter set with every start value of an FMU, except for some, `y_mass=(7200.0, "g")`."""
    values = {variable.name: Value(variable.name, variable.type, variable.start == "true" if variable.type == "Boolean"
                                   else float(variable.start), variable.unit or "")
              for variable in read_model_description(fmu).modelVariables
              if variable.causality in ("input", "parameter")}
    for name, (value, unit) in changed.items():
        values[name.replace("_", ".")] = Value(name.replace("_", "."), "Real", value, unit)
    path = folder / "plant.ssv"
    path.write_bytes(xml_file(parameter_set("plant", values.values())))
    return path


def made_ready(options: RunOptions) -> Experiment:
    experiment, = experiments_of([load_plan(RUN)], options)
    experiment.check()
    return experiment


def test_a_parameter_set_of_the_whole_fmu(fmus: Path, tmp_path: Path) -> None:
    """What it sets is what `--set` sets; inputs that the controller feeds are left out, which is said."""
    path = parameter_file(fmus / "Plant3DOF.fmu", tmp_path, y_mass=(7200.0, "g"), x_mass=(8.0, "kg"))
    experiment = made_ready({"fmus": fmus, "parameters": {"plant": path}, "set": {"plant.x.mass": 9.0}})
    found = experiment.provenance()
    assert "plant.y.mass = 7200.0 g instead of 6.9 kg" in found.changes
    assert not any("C1" in change or "i_a_cmd" in change for change in found.changes)
    assert found.parameter_sets == {str(path): hashlib.sha256(path.read_bytes()).hexdigest()}
    assert experiment.notes[-1].endswith("plant.alpha.i_a_cmd, plant.alpha.i_b_cmd, plant.alpha.i_c_cmd and 3 others "
                                         "of parameter sets are left out: the run feeds them")
    values = made_ready({"fmus": fmus, "set": {"plant.y.mass": "7.2 kg", "plant.x.mass": 9.0}}).parameters()
    same = experiment.parameters()
    for axis, mass in (("y", 7.2), ("x", 9.0)):
        assert same[f"plant.{axis}.mass"] == values[f"plant.{axis}.mass"] == mass


@pytest.mark.parametrize(("name", "value", "unit", "facts"), [
    ("y.mass", 7.0, "m", ["y.mass = 7.0 m", "kg"]), ("y.mas", 7.0, "kg", ["y.mas = 7.0 kg", "plant", "'y.mass'"]),
    ("y.mass", 7.0, "stone", ["y.mass = 7.0 stone", "'stone'", "plant", "'kg'"])])
def test_parameter_sets_that_do_not_fit(fmus: Path, tmp_path: Path, name: str, value: float, unit: str,
                                        facts: list[str]) -> None:
    path = tmp_path / "plant.ssv"
    path.write_bytes(xml_file(parameter_set("plant", [Value(name, "Real", value, unit)])))
    with raises(ScenarioError, path, *facts) as refusal:
        made_ready({"fmus": fmus, "parameters": f"plant={path}"})
    assert str(refusal.value) in error_line(command("run", "3dof-pid-small-nonlinear", "--fmus", fmus, "--parameters",
                                                    f"plant={path}", "--out", tmp_path / "out"))
    assert not [*(tmp_path / "out").glob("*.csv")]
