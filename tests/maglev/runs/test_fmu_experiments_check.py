"""Experiments that FMUs carry: ours repeat, an altered one does not, anybody's are read, broken ones named."""

from collections.abc import Sequence
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from carried_experiments import carrying, experiments, files_of, manifest
from command_line import error_line, maglev
from facts import raises, require_facts
from faulty_fmus import faulty
from fmpy.model_description import BaseUnit, ModelDescription, ScalarVariable, Unit, read_model_description
from left_processes import require_none

from maglev.cosim.master import FmuSetup, Master
from maglev.files.errors import FmuError
from maglev.runs.baseline_file import Tolerance
from maglev.runs.carried_experiments import CarriedExperiment, File, given_starts
from maglev.runs.experiment_check import (
    Expected,
    FmuRun,
    Times,
    check_experiment,
    check_fmus,
    compare_results,
    named_experiments,
    run_where_it_belongs,
    times_of,
)

FALL = "time,v.position\n0,0.02\n0.02,0.0202\n"   # as a file of results looks
RESULT = 'type="text/csv" source="fall.csv" role="result" description="a fall"'
EXPERIMENT = 'type="application/x-ma-hs-experiments" source="all.exp" role="experiment"'
TRANSIENT = '<TransientSimulation stopTime="0.02" stepSize="0.0005"/>'
REFERENCES = '<References source="fall.csv"/>'


def ssv(parameter: str, value: str) -> str:
    """A parameter set with one parameter."""
    return ('<p:ParameterSet xmlns:p="http://ssp-standard.org/SSP1/SystemStructureParameterValues" version="1.0" '
            f'name="n"><p:Parameters><p:Parameter {parameter}>{value}</p:Parameter></p:Parameters></p:ParameterSet>')


def test_every_fmu_repeats_its_embedded_experiments(fastest_fmus: Path) -> None:
    results = check_fmus(sorted(fastest_fmus.glob("*.fmu")), jobs=2)
    assert [f"{result.name}: {result.message}" for result in results if result.status != "passed"] == []
    assert len(results) > 60


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize("kind", ["fmus", "native_fmus", "fmi3_fmus"])
def test_every_kind_repeats_the_same(kind: str, request: pytest.FixtureRequest) -> None:
    folder: Path = request.getfixturevalue(kind)
    results = check_fmus([folder / f"{name}.fmu" for name in ("Plant3DOF", "Regulator3DOF", "Estimator3DOF")], jobs=1)
    assert [result.status for result in results] == ["passed"] * 6
    assert [result.status for result in check_fmus(str(folder / "Plant3DOF.fmu"), jobs=1)] == ["passed"] * 2


def outcome(path: Path, partial: bool = False) -> tuple[str, str]:
    """Status and message of the only experiment of an FMU."""
    (name, (fmu, experiment)), = named_experiments([path]).items()
    result = check_experiment(name, fmu, experiment, partial=partial)
    return result.status, result.message


@pytest.fixture(scope="module")
def fall(fmus: Path) -> list[float]:
    """Gap of the stage without current at 0, 10 and 20 ms, m, under another master than that of a check."""
    with Master([FmuSetup("plant", fmus / "Plant2DOF.fmu")], [], 0.0005) as master:
        return master.run(0.02).columns["plant.v.position"][::20].tolist()


def table(gaps: Sequence[float]) -> str:
    """File of a fall."""
    return "time,v.position\n" + "".join(f"{0.01 * k},{gap!r}\n" for k, gap in enumerate(gaps))


def test_an_altered_result_deviates(fmus: Path, tmp_path: Path) -> None:
    """By more than the tolerance, one in a million; a third of that passes."""
    files = files_of(fmus / "Plant2DOF.fmu")
    name = "Plant2DOF_validation_ref.csv"
    lines = files[name].decode().splitlines()
    column = lines[0].split(",").index("v.position")
    for share, status in ((3e-6, "deviated"), (3e-7, "passed")):
        cells = lines[9].split(",")
        cells[column] = repr(float(cells[column]) * (1.0 + share))
        altered = "\n".join([*lines[:9], ",".join(cells), *lines[10:]])
        path = carrying(fmus / "Plant2DOF.fmu", tmp_path / "altered.fmu", {**files, name: altered.encode()})
        results = {name: check_experiment(name, *each) for name, each in named_experiments([path]).items()}
        assert [result.status for result in results.values()] == ["passed", status]


def test_a_bare_result_is_of_the_default_experiment(fmus: Path, tmp_path: Path, fall: list[float]) -> None:
    """As Reference-FMUs have it; without tolerances it is held to a thousandth of the largest value."""
    for last, expected in ((0.9995, "passed, 1 variable at 3 times to t = 0.02 s are within tolerance, 0.001 of"),
                           (1.0015, "deviates first at t = 0.02 s: v.position expected"),
                           (1.0, "passed, 1 variable at 3 times to t = 0.02 s equal the results in it")):
        path = carrying(fmus / "Plant2DOF.fmu", tmp_path / "any.fmu", {
            "fmi-ls-manifest.xml": manifest(RESULT), "fall.csv": table([*fall[:2], fall[2] * last]).encode()})
        assert outcome(path, partial=True)[1].startswith(expected)


def test_booleans_as_fmpy_writes_them(fmus: Path, tmp_path: Path, fall: list[float]) -> None:
    path = carrying(fmus / "Plant2DOF.fmu", tmp_path / "fall.fmu", {})
    head, *rows = table(fall).splitlines()
    (tmp_path / "fall_ref.opt").write_text("StopTime,0.02\n")
    for flag, status in (("False", "passed"), ("True", "deviated")):
        (tmp_path / "fall_ref.csv").write_text("\n".join([f"{head},at_stop", *(f"{row},{flag}" for row in rows)]))
        assert outcome(path)[0] == status


def test_reads_experiments_next_to_an_fmu(fmus: Path, tmp_path: Path, fall: list[float]) -> None:
    """Of the FMI cross-check: under a force that is in a file the stage falls otherwise, beyond the tolerance."""
    path = carrying(fmus / "Plant2DOF.fmu", tmp_path / "fall.fmu", {})
    (tmp_path / "fall_ref.csv").write_text(table(fall))
    stop = float(read_model_description(str(path)).defaultExperiment.stopTime)
    assert outcome(path) == ("error", f"{tmp_path / 'fall_ref.csv'}: no results from t = 0.02 s to {stop:.9g} s, "
                                      "expected them for the whole experiment; partial compares the existing ones")
    (tmp_path / "fall_ref.opt").write_text("StopTime,0.0299\n")   # a row more would be at 0.03
    assert outcome(path) == ("passed", "passed, 1 variable at 3 times to t = 0.02 s equal the results in it")
    (tmp_path / "fall_in.csv").write_text("time,v.force\n0,-11.5\n1,-11.5\n")
    status, message = outcome(path)
    assert (status, message.startswith("deviates first at t = 0.01 s")) == ("deviated", True)
    (tmp_path / "fall_ref.opt").write_text("\ufeffStopTime,0.02\nStepSize,0.0005\nAbsTol,v.position,2e-3\n",
                                           encoding="utf-8")
    assert outcome(path)[0] == "passed"


def test_rows_just_beside_events_do_not_make_the_step() -> None:
    """As tools with a variable step write them; where nothing else gives one, it is that of most rows."""
    description = ModelDescription()
    description.coSimulation = description.defaultExperiment = None
    rows = np.array([0.0, 3.2e-30, 0.2, 0.4, 0.4, 0.4 + 1e-12, 0.6, 0.8, 1.0])
    assert times_of(CarriedExperiment(""), description, {}, rows).step == pytest.approx(0.2)


def test_files_beside_an_fmu_that_go_on_after_its_default_experiment(fmus: Path, tmp_path: Path) -> None:
    """It is run as long as they go on; what has no tolerance of its own next to others that have is said."""
    path = carrying(fmus / "Commutation2DOF.fmu", tmp_path / "long.fmu", {})
    stop = read_model_description(str(path)).defaultExperiment.stopTime
    end = 2.0 * float(stop)
    (tmp_path / "long_ref.csv").write_text(f"time,motor.i_a_cmd,motor.i_b_cmd\n0,0,1e-9\n{end},0,1e-9\n")
    (tmp_path / "long_ref.opt").write_text("AbsTol,motor.i_b_cmd,1e-8\n")
    status, message = outcome(path)
    assert message == (f"passed, 2 variables at 2 times to t = {end:.9g} s are within tolerance, 0.001 of the largest "
                       "value where none is given")
    assert status == "passed"


@pytest.mark.parametrize("value", ['value="0.021"', 'value="21" unit="mm"', 'value="2.1" unit="cm"'])
def test_times_in_the_experiment_itself(fmus: Path, tmp_path: Path, value: str) -> None:
    """An older form of the draft; a start value in it decides where the fall begins."""
    element = ('<Experiment name="e" stopTime="0.001" stepSize="0.0005"><Parameters source="a.ssv"/>'
               f"{REFERENCES}</Experiment>")
    path = carrying(fmus / "Plant2DOF.fmu", tmp_path / "any.fmu", {
        "fmi-ls-manifest.xml": manifest(EXPERIMENT, RESULT), "all.exp": experiments(element),
        "a.ssv": ssv('name="v.position_start"', f"<p:Real {value}/>").encode(),
        "fall.csv": b"time,v.position\n0,0.021\n"})
    assert outcome(path, partial=True) == ("passed", "passed, 1 variable at 1 time to t = 0 s equal the results in it; "
                                                     "not compared: t = 0 s to 0.001 s")


@pytest.mark.parametrize("stated", ["experiment", "options", "default"])
def test_results_that_are_cut_are_not_the_whole_experiment(fmus: Path, tmp_path: Path, stated: str) -> None:
    """To a quarter, without the beginning, or without their last row: a part that is equal is no repetition."""
    files = files_of(fmus / "Plant2DOF.fmu")
    header, *rows = files["smoke_test_ref.csv"].decode().splitlines()
    start, stop, size = 0.0, float(rows[-1].partition(",")[0]), 0.0005
    if stated == "default":
        default = read_model_description(str(fmus / "Plant2DOF.fmu")).defaultExperiment
        stop, size = float(default.stopTime), float(default.stepSize)
        with Master([FmuSetup("plant", fmus / "Plant2DOF.fmu")], [], size) as master:
            run = master.run(stop)
        header, rows = "time,v.position", [f"{t!r},{v!r}" for t, v in zip(run.time.tolist(), run.columns[
            "plant.v.position"].tolist(), strict=True)]
    times = f'stepSize="{size}"' + (f' startTime="{start}" stopTime="{stop}"' if stated == "experiment" else "")
    options = f"StopTime,{stop}\n" if stated == "options" else f"StepSize,{size}\n"
    n = len(rows)
    for kept, lacking in ((rows, None), (rows[:n // 4 + 1], f"t = {rows[n // 4].partition(',')[0]} s to {stop:.9g} s"),
                          (rows[:-1], f" s to {stop:.9g} s"), (rows[n // 2:], "t = 0 s to ")):
        path = carrying(fmus / "Plant2DOF.fmu", tmp_path / "any.fmu", {
            "fmi-ls-manifest.xml": manifest(EXPERIMENT), "fall.opt": options.encode(),
            "fall.csv": "\n".join([header, *kept]).encode(),
            "all.exp": experiments(f'<Experiment name="e"><TransientSimulation {times}/>{REFERENCES}</Experiment>')})
        if lacking is None:
            assert outcome(path)[0] == "passed", outcome(path)
        else:
            status, message = outcome(path)
            assert status == "error" and "no results from t = " in message and lacking in message, message
            status, message = outcome(path, partial=True)
            assert status == "passed" and "not compared: t = " in message and lacking in message, message


def test_a_column_that_the_fmu_lacks(fmus: Path, tmp_path: Path, fall: list[float]) -> None:
    """Such as one of an older version: what else is equal says nothing of it."""
    path = carrying(fmus / "Plant2DOF.fmu", tmp_path / "fall.fmu", {})
    rows = table(fall).splitlines()
    (tmp_path / "fall_ref.opt").write_text("StopTime,0.02\n")
    (tmp_path / "fall_ref.csv").write_text("\n".join([f"{rows[0]},v.positon", *(f"{row},0" for row in rows[1:])]))
    assert outcome(path) == ("error", f"{tmp_path / 'fall_ref.csv'}: column v.positon: the FMU has no such variable, "
                                      "nearest is 'v.position'; partial compares the others")
    checked = maglev("check", path)
    assert checked.exit_code == 2 and "partial compares the others" in " ".join(checked.output.split())
    result = maglev("check", path, "--partial")
    assert result.exit_code == 0
    assert "equal the results in it; not compared: v.positon" in " ".join(result.stdout.split())


@pytest.mark.parametrize(("own", "value", "start"), [
    ("mm", 'value="20"', 20.0), ("mm", 'value="0.02" unit="m"', 20.0), ("mm", 'value="20" unit="mm"', 20.0),
    ("furlong", 'value="3" unit="furlong"', 3.0), ("furlong", 'value="402.336" unit="m"', 2.0),
    ("degC", 'value="20" unit="degC"', 20.0), ("degC", 'value="300" unit="K"', 26.85), (None, 'value="3"', 3.0)])
def test_parameters_are_in_the_units_of_the_fmu(own: str | None, value: str, start: float) -> None:
    """As `--parameters` reads them: an FMU may count in units of its own, also with an offset."""
    description = ModelDescription()
    description.modelVariables = [ScalarVariable("x", 1, type="Real", unit=own)]
    description.unitDefinitions = [Unit("furlong", BaseUnit(m=1, factor=201.168)),
                                   Unit("degC", BaseUnit(K=1, offset=273.15))]
    file = File("a.ssv", ssv('name="x"', f"<p:Real {value}/>").encode())
    assert float(given_starts(file, description)["x"]) == pytest.approx(start, rel=1e-12)
    for wrong in ('value="1" unit="kg"', 'value="1" unit="cubit"'):
        with raises(FmuError, "a.ssv", "x", "1", own or "1"):
            given_starts(File("a.ssv", ssv('name="x"', f"<p:Real {wrong}/>").encode()), description)


BROKEN = {
    "file": (TRANSIENT + '<References source="fal.csv"/>', {}, ["'fal.csv'", "'fall.csv'"]),
    "outside": (TRANSIENT + '<References source="../../../fall.csv"/>', {}, ["'../../../fall.csv'"]),
    "kind": (f"<Linearization/>{REFERENCES}", {}, ["Linearization", "TransientSimulation"]),
    "type": (TRANSIENT + '<References type="application/hdf5" source="fall.csv"/>', {},
             ["References", "application/hdf5", "text/csv"]),
    "nothing": (TRANSIENT, {}, ["experiment e", "References"]),
    "step": (f'<TransientSimulation stepSize="-1"/>{REFERENCES}', {}, ["stepSize", "'-1'"]),
    "nan": (TRANSIENT + REFERENCES, {"fall.csv": "time,v.position\n0,nan\n"},
            ["fall.csv", "row 2", "v.position", "'nan'"]),
    "ragged": (TRANSIENT + REFERENCES, {"fall.csv": "time,v.position\n0,1,2\n"}, ["row 2", "3 values", "2"]),
    "column": (TRANSIENT + REFERENCES, {"fall.csv": "time,v.positon\n0,1\n"}, ["v.positon", "'v.position'"]),
    "back": (TRANSIENT + REFERENCES, {"fall.csv": "time,v.position\n1,1\n0,1\n"}, ["row 3", "time", "0"]),
    "input": (f'{TRANSIENT}<Stimuli source="in.csv"/>{REFERENCES}', {"in.csv": "time,v.forc\n0,1\n"},
              ["in.csv", "v.forc", "'v.force'"]),
    "parameter": (f'{TRANSIENT}<Parameters source="a.ssv"/>{REFERENCES}', {
        "a.ssv": ssv('name="C9"', '<p:Real value="1"/>')}, ["a.ssv", "'C9'"]),
    "text": (f'{TRANSIENT}<Parameters source="a.ssv"/>{REFERENCES}', {
        "a.ssv": ssv('name="C1"', '<p:Real value="nan"/>')}, ["a.ssv", "C1", "nan"]),
    "unit": (f'{TRANSIENT}<Parameters source="a.ssv"/>{REFERENCES}', {
        "a.ssv": ssv('name="v.position_start"', '<p:Real value="21" unit="mA"/>')},
        ["a.ssv", "v.position_start", "21 mA", "m"]),
    "tolerance": (TRANSIENT + REFERENCES, {"fall.opt": "AbsTol,v.x,1\n"}, ["v.x", "tolerance"]),
    "word": (TRANSIENT + REFERENCES, {"fall.opt": "StepSize,0.0005\nStopTime\n"}, ["line 2", "'StopTime'"]),
    "key": (TRANSIENT + REFERENCES, {"fall.opt": "Abstol,v.position,1\n"}, ["'Abstol,v.position,1'"]),
    "option": (TRANSIENT + REFERENCES, {"fall.opt": "AbsTol,v.position,-1\n"}, ["AbsTol", "v.position", "-1.0"]),
    "longer": ('<TransientSimulation stopTime="0.01" stepSize="0.0005"/>' + REFERENCES, {},
               ["0 s", "0.01 s", "0.02 s"])}


@pytest.mark.parametrize("name", BROKEN)
def test_names_the_broken_file(name: str, fmus: Path, tmp_path: Path) -> None:
    inside, files, facts = BROKEN[name]
    given = {"fall.csv": FALL, **files}
    path = carrying(fmus / "Plant2DOF.fmu", tmp_path / "any.fmu", {
        "fmi-ls-manifest.xml": manifest(EXPERIMENT), **{file: text.encode() for file, text in given.items()},
        "all.exp": experiments(f'<Experiment name="e">{inside}</Experiment>')})
    status, message = outcome(path)
    assert status == "error"
    require_facts(message, *facts)


@pytest.mark.parametrize(("data", "facts"), [(b"<a", ["line 1"]), (b"<a/>", ["a", "fmiReferences"]),
                                             (manifest(), ["experiments"])])
def test_a_broken_manifest(data: bytes, facts: list[str], fmus: Path, tmp_path: Path) -> None:
    path = carrying(fmus / "Commutation2DOF.fmu", tmp_path / "any.fmu", {"fmi-ls-manifest.xml": data})
    status, message = outcome(path)
    assert status == "error"
    require_facts(message, "fmi-ls-manifest.xml", *facts)


def test_a_result_belongs_to_its_experiment_alone(fmus: Path, tmp_path: Path) -> None:
    """Also where that cannot be run: without its inputs it would deviate. A broken experiments file leaves others."""
    broken = f'<Experiment name="e">{TRANSIENT}<Stimuli source="in.csv"/>{REFERENCES}</Experiment>'
    lost = f'<Experiment name="lost">{TRANSIENT}<References source="lost.csv"/></Experiment>'
    path = carrying(fmus / "Plant2DOF.fmu", tmp_path / "any.fmu", {
        "fmi-ls-manifest.xml": manifest(EXPERIMENT.replace("all.exp", "no.exp"), EXPERIMENT, RESULT,
                                        RESULT.replace("fall.csv", "lost.csv")),
        "no.exp": b"<a", "all.exp": experiments(broken, lost), "fall.csv": FALL.encode()})
    problems = {experiment.name: experiment.problem for _, experiment in named_experiments([path]).values()}
    assert list(problems) == ["no.exp", "e", "lost"]
    assert "expected XML" in problems["no.exp"]
    assert "the file 'in.csv'" in problems["e"] and "the file 'lost.csv'" in problems["lost"]


@pytest.mark.usefixtures("slow")
def test_an_fmu_that_hangs(tmp_path: Path) -> None:
    """It never comes back from a step: a line, and the exit code of what could not be checked."""
    path = faulty("hang", tmp_path)
    path.with_name(f"{path.stem}_ref.csv").write_text("time,current_u\n0,0\n0.5,0\n")
    result = maglev("check", path, "--timeout", "0.5 s")
    assert (result.exit_code, "has been silent for 0.5 s" in result.stdout) == (2, True), result.output


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(("fault", "message"), [
    ("pickle into pipes", "has written into the pipe of its process"),
    ("close pipes and leave a child", "has closed the pipe of its process")])
def test_an_fmu_that_deceives_its_process_is_not_believed_and_leaves_nothing(
        fault: str, message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither what it writes is executed, nor does a child of it go on; with the pipe closed the check ends."""
    monkeypatch.setattr("maglev.files.worker_process.PATIENCE", 1.0)
    monkeypatch.setenv("MARKER", str(tmp_path / "marker"))
    path = faulty(fault, tmp_path)
    path.with_name(f"{path.stem}_ref.csv").write_text("time,current_u\n0,0\n0.5,0\n")
    (name, (fmu, experiment)), = named_experiments([path]).items()
    result = check_experiment(name, fmu, experiment)
    assert (result.status, result.message) == ("error", f"pd_controller.fmu {message}")
    assert not (tmp_path / "marker").exists()
    require_none(tmp_path / "marker")


@pytest.mark.parametrize("columns", [
    {"time": [0.0, 1.0]}, {"time": [0.0, 1.0], "y": [1.0]}, {"time": [], "y": []},
    {"time": [1.0, 0.0], "y": [1.0, 2.0]}, {"time": [0.0, np.nan], "y": [1.0, 2.0]},
    {"time": [[0.0], [1.0]], "y": [1.0, 2.0]},
    {"time": [0.0, 1.0], "y": [1j, 2.0]}, {"time": [0.0, 1.0], "y": [1.0, 2.0], "z": [1.0, 2.0]}, {"y": [1.0]}],
    ids=range(9))
def test_refuses_results_that_no_run_gives(columns: dict[str, list[float]], tmp_path: Path,
                                           monkeypatch: pytest.MonkeyPatch) -> None:
    given = FmuRun({name: np.array(values) for name, values in columns.items()}, "")
    monkeypatch.setattr("maglev.runs.experiment_check.called_apart", lambda *_: given)
    (tmp_path / "theirs.fmu").write_bytes(b"theirs")
    with raises(FmuError, "theirs.fmu"):
        run_where_it_belongs(tmp_path / "theirs.fmu", Times(0.0, 1.0, 1.0, None), {}, None, ["y"],
                             lambda done, steps: None, 1.0)


def test_comparison_at_events_between_points_and_in_arrays() -> None:
    """Two values at one time: either will do. Between points a continuous variable is a line, another one holds."""
    simulated = np.array([(0.0, 0.0, 0, (1.0, 2.0)), (1.0, 2.0, 1, (1.0, 3.0)), (1.0, 5.0, 2, (1.0, 4.0)),
                      (2.0, 7.0, 3, (1.0, 5.0))],
                     [("time", float), ("line", float), ("count", int), ("both", float, 2)])
    variables = {name: ScalarVariable(name, 0, variability="discrete" if name == "count" else "continuous")
                 for name in (simulated.dtype.names or ())[1:]}

    def found(time: float, name: str, *values: float) -> object:
        expected = Expected(np.array([time]), {name: np.array([values])}, {name: Tolerance(1e-9, 0.0)}, [])
        deviation, _ = compare_results(expected, {name: simulated[name] for name in simulated.dtype.names or ()},
                                       variables)
        return deviation and (deviation.signal, deviation.got)

    assert found(1.0, "line", 2.0) is None
    assert found(1.0, "line", 5.0) is None
    assert found(1.0, "line", 3.0) == ("line", 2.0)
    assert found(1.5, "line", 6.0) is None
    assert found(1.5, "count", 2.0) is None
    assert found(1.5, "count", 3.0) == ("count", 2.0)
    assert found(0.0, "both", 1.0, 2.0) is None
    assert found(0.0, "both", 1.0, 2.5) == ("both[2]", 2.0)
    with raises(FmuError, "both", 2, 1):
        found(0.0, "both", 1.0)
    with raises(FmuError, "0 s", "2 s", "3 s"):
        found(3.0, "line", 7.0)


def test_the_command(fmus: Path, tmp_path: Path) -> None:
    good = fmus / "Commutation2DOF.fmu"
    junit = tmp_path / "check.xml"
    bad = carrying(fmus / "Plant2DOF.fmu", tmp_path / "bad.fmu",
                   {"fmi-ls-manifest.xml": manifest(RESULT), "fall.csv": FALL.replace("0.0202", "0.03").encode()})
    result = maglev("check", good, bad, "--partial", "--junit", junit)
    assert result.exit_code == 1
    assert f"{good}, smoke_test: passed, 6 variables at 6 times" in result.stdout
    assert "bad.fmu, a fall: deviates first" in result.stdout
    assert [len(ElementTree.parse(junit).findall(f".//{tag}")) for tag in ("testcase", "failure")] == [3, 1]
    (tmp_path / "other.fmu").write_bytes(b"PK\x05\x06" + bytes(18))   # an empty archive
    result = maglev("check", tmp_path / "other.fmu")
    assert (result.exit_code, "has no modelDescription.xml, expected an FMU" in result.stdout) == (2, True)
    result = maglev("check", tmp_path / "none.fmu")
    assert (result.exit_code, "there is no such file" in result.stdout) == (2, True)
    assert "--plant: needs a scenario" in error_line(maglev("check", good, "--plant", good))
    assert "--partial: needs an FMU" in error_line(maglev("check", "3dof-setpoints", "--partial"))
    assert "--update takes scenarios" in error_line(maglev("check", good, "--update"))
