"""The sentences that users see most, whole. Other tests look at the class of an error and the facts in its message."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from native_builds import require_native_tools
from written_controllers import controller, trial

import maglev

SCENARIO = 'extends = "2dof-setpoints.toml"\nname = "mine"\ntitle = "Mine"\n'
RECORDING = "\n".join(["time,v,h,i_d,i_q", "0,0.02,0,0,0", *(f"{k / 2000},NaN,0,0,0" for k in range(1, 4001))])

Call = Callable[[], Any]


@pytest.fixture(autouse=True)
def _in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def written(name: str, text: str) -> str:
    Path(name).write_text(text, encoding="utf-8")
    return name


def scenario(text: str) -> str:
    return written("mine.toml", SCENARIO + text)


def stage(old: str, new: str) -> str:
    maglev.new_stage("mine.toml", "3dof")
    text = Path("mine.toml").read_text(encoding="utf-8")
    assert old in text
    return written("mine.toml", text.replace(old, new, 1))


def law(*changes: tuple[str, str]) -> str:
    return controller(Path(), *changes).name


def message_of(call: Call) -> str:
    with pytest.raises(maglev.MaglevError) as refusal:
        call()
    return str(refusal.value)


@pytest.mark.parametrize(("call", "sentence"), [
    (lambda: maglev.run("3dof-setpoint"), "there is no scenario '3dof-setpoint'; nearest is '3dof-setpoints'"),
    (lambda: maglev.run(scenario('stop_tme = "2 s"')),
     "mine.toml: stop_tme = '2 s': unknown key, nearest is 'stop_time' (end of the run, a multiple of `step`)"),
    (lambda: maglev.run(scenario('stop_time = "2 m"')),
     "mine.toml: stop_time = '2 m': '2 m' is in m, expected a quantity in s"),
    (lambda: maglev.run(scenario("stop_time = nan")),
     "mine.toml: stop_time = nan: nan is not a quantity, expected a finite number"),
    (lambda: maglev.run(scenario('step = "0.5 msec"')),
     "mine.toml: step = '0.5 msec': '0.5 msec': unknown unit 'msec'; nearest is 'ms'"),
    (lambda: maglev.run(scenario("stop_time = ")), "mine.toml: TOML syntax: Invalid value (at end of document)"),
    (lambda: maglev.run(5), "scenario = 5: expected a name, a path or a table"),   # type: ignore[arg-type]
    (lambda: maglev.run("2dof-setpoints", fmus="nowhere"),
     "controller: there is no file nowhere/Regulator2DOF.fmu, expected an FMU; `maglev build` builds those of this "
     "project, with stage = mine.toml those of your own stage"),
    (lambda: maglev.run("2dof-setpoints", step=-1), "step = -1: expected a time above 0 s"),
    (lambda: maglev.run("2dof-setpoints", order="jacob"),   # type: ignore[arg-type]
     "order = jacob: expected one of sequential, jacobi; nearest is 'jacobi'"),
    (lambda: maglev.run("2dof-setpoints", kin="native"), "kin: unknown option, nearest is 'kind'"),   # type: ignore[call-arg]
    (lambda: maglev.run("2dof-setpoints", set="plant.v.mass"),
     "set = plant.v.mass: expected FMU.variable=value, such as plant.y.mass=7.2"),
    (lambda: maglev.run("2dof-setpoints", controller="PIDDOF"),
     "controller PIDDOF: is no FMU of this project and no file, nearest is 'PID2DOF'"),
    (lambda: maglev.run("2dof-setpoints", controller=law() and "dp.py"),
     "there is no file dp.py, nearest is 'pd.py'; `maglev new controller lqi.py` and `maglev new plant mover.py` "
     "write one to begin with"),
    (lambda: maglev.run("2dof-setpoints", controller=law(("LARGEST = 6.0\n", "LARGEST = (6.0\n"))),
     "pd.py, line 6: SyntaxError: '(' was never closed"),
    (lambda: maglev.run("2dof-setpoints", controller=written("pd.py", "class PD:\n    pass\n")),
     "pd.py: there is no class with ports in it, expected one with inputs, outputs and step; `maglev new controller "
     "lqi.py` and `maglev new plant mover.py` write one to begin with"),
    (lambda: maglev.run("2dof-setpoints", controller=law(('"rad/s"', '"rpm"'))),
     "pd.py, line 39: class PD: parameters has 'bandwidth' in 'rpm', expected one that is made of SI units without "
     'prefixes, such as "m/s2" or "V.s/rad", or ""; symbols are kg, m, s, A, K, mol, cd, rad, N, J, W, Pa, C, V, '
     "Ohm, S, H, F, Wb, T, Hz"),
    (lambda: maglev.build("Plant2DOV"),
     "there is no FMU Plant2DOV, nearest is 'Plant2DOF', expected one from `maglev list`, or one of your own stage, "
     "with stage = mine.toml"),
    (lambda: maglev.stage(stage("mass = 6.9 ", "mass = -1 ")),
     "mine.toml: axes.y.mass = -1 kg, expected a number from 0.001 to 1e+06 kg"),
    (lambda: maglev.stage(stage("mass = 6.9 ", "maas = 6.9 ")),
     "mine.toml: axes.y.maas: no such key; nearest is 'mass'"),
    (lambda: maglev.stage(scenario("")), "mine.toml: is a scenario, expected the description of a stage"),
    (lambda: maglev.linearise("Plant3DOF", {"y": "35 mm"}),
     "Plant3DOF at y = 35 mm: beyond the end stops, expected y within 18.5…32 mm"),
    (lambda: maglev.linearise("Plant3DOF", {"y": "25 mm"}, parameters={"y.mas": 7.0}),
     "Plant3DOF has no parameter 'y.mas'; nearest is 'y.mass'"),
    (lambda: maglev.identify(written("mine.csv", RECORDING)),
     "mine.csv: row 3, column v is 'NaN', expected a finite number"),
    (lambda: maglev.identify(written("mine.csv", RECORDING) and "mien.csv"),
     "mien.csv: cannot be read: No such file or directory, nearest is 'mine.csv'"),
    (lambda: maglev.study("2dof-setpoints", vary={"plant.v.mass": 4.0}),   # type: ignore[dict-item]
     "vary: vary[0].values = 4.0: expected a valid list"),
    (lambda: maglev.check(scenario("")),
     "mine.toml: needs baselines, the folder of its baseline; the package has baselines of its own scenarios only")])
def test_a_mistake(call: Call, sentence: str) -> None:
    assert message_of(call) == sentence


@pytest.mark.usefixtures("slow")
def test_code_that_is_not_of_the_language() -> None:
    require_native_tools()
    path = law(("w = self.bandwidth", "w = max([self.bandwidth])"))
    assert message_of(lambda: maglev.build(path, kind="native")) == (
        "pd.py, line 61: a new list: expected one that __init__ sets, and assignments to its elements; native "
        "FMUs need this")


def short(fmus: Path, **options: Any) -> maglev.Run:
    return maglev.run(trial(Path()), fmus=fmus, **options)


@pytest.mark.parametrize(("call", "sentence"), [
    (lambda fmus: short(fmus, set={"plant.v.mas": 7}),
     "set: plant.v.mas = 7: missing port: plant has no parameter or input 'v.mas'; nearest is 'v.mass'"),
    (lambda fmus: short(fmus, set={"plant.v.mass": -1}),
     "plant (Plant2DOF.fmu) refused fmi2SetReal of v.position_start, h.position_start, v.mass (error): v.mass = -1.0 "
     "kg, expected a number from 0.001 to 1000000.0 kg"),
    (lambda fmus: short(fmus, set={"plant.v.mass": "7 mm"}),
     "set: plant.v.mass = 7 mm: mm given, expected a quantity in kg"),
    (lambda fmus: short(fmus, set={"plant.v.mass": float("nan")}),
     "set: plant.v.mass = nan: nan is not a quantity, expected a finite number"),
    (lambda fmus: short(fmus, set={"reference.v.start": "29 mm"}),
     "trial.toml: reference of v = 29 mm at t = 0 s: out of reach, expected between the stops at 8 mm and 28 mm, for "
     "a stage that begins with a gap of 20 mm"),
    (lambda fmus: short(fmus, controller=law(('"motor.i_c_cmd": "A"', '"motor.i_c": "A"'), (
        "motor_i_c_cmd = 0.0", "motor_i_c = 0.0"), ("motor_i_c_cmd = cos", "motor_i_c = cos"))),
     "controller (pd.py): missing port: output motor.i_c_cmd (nearest is 'motor.i_c'); expected these names in the "
     "table of pd.py, line 37, or a port map (ports, --map) with the FMU's own (docs/importing.md)"),
    (lambda fmus: short(fmus, controller=law(("w = self.bandwidth", "w = 1.0 / (0.1 - t)"))),
     "at t = 0.1 s: controller (pd.py): step failed at t = 0.1 s: pd.py, line 61: ZeroDivisionError: float division "
     "by zero")])
@pytest.mark.filterwarnings("ignore::UserWarning")
def test_a_mistake_that_a_run_finds(fastest_fmus: Path, call: Callable[[Path], Any], sentence: str) -> None:
    assert message_of(lambda: call(fastest_fmus)) == sentence


def test_a_baseline_that_differs(fastest_fmus: Path) -> None:
    written("mine.toml", SCENARIO + 'stop_time = "1 s"\n')
    maglev.update("mine.toml", baselines=".", fmus=fastest_fmus)
    result, = maglev.check("mine.toml", baselines=".", fmus=fastest_fmus, set={"plant.C1": 14.2142})
    assert result.message == ("deviates first at t = 0.1 s: plant.v.position expected 0.020058835051787568 m, got "
                              "0.020058837391252533 m, expected the same bits")
