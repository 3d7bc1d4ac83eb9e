"""Columns of a run as CSV and Parquet: every bit comes back, and what it is and rests on with it."""

import csv
import errno
import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command_line import maglev
from facts import raises
from hypothesis import example, given
from hypothesis import strategies as st
from pyarrow import parquet

import maglev as front_door
from maglev.cosim.master import Recording
from maglev.files.cache import record_conflict
from maglev.files.table import read_table
from maglev.runs.execution import RunResult, write_result
from maglev.runs.results import ResultFiles, write_csv, write_parquet
from maglev.scenario.run_plan import RunPlan

NUMBERS = st.lists(st.floats(allow_nan=False), min_size=1, max_size=50)


def recording(values: list[float]) -> Recording:
    time = 0.1 * np.arange(len(values), dtype=float)
    return Recording(time, {"plant.y": np.array(values), "plant.at_stop": np.arange(len(values), dtype=np.int32) % 2,
                            'odd,"name"': -time, "held": np.repeat(values, 3)[:len(values)]})


@given(NUMBERS, st.integers(1, 4))
@example([-0.0, 0.0, 1e22, 0.1, 0.1, 0.1], 1)
@example([0.1, -0.0, 5e-324, 1.7976931348623157e308, 1e-5, 1 / 3, 1e16, 123456789012345680.0, float("inf")], 1)
def test_numbers_come_back(tmp_path_factory: pytest.TempPathFactory, values: list[float], every: int) -> None:
    path = tmp_path_factory.mktemp("csv") / "run.csv"
    written = recording(values)
    write_csv(path, written, every)
    write_parquet(path.with_suffix(".parquet"), written, {"plant.y": "m"}, {}, every)
    with path.open(newline="", encoding="utf-8") as file:
        header, *rows = csv.reader(file)
    table = parquet.read_table(path.with_suffix(".parquet"))
    expected = sorted({*range(0, len(values), every), len(values) - 1})
    assert header == table.column_names == ["time", "plant.y", "plant.at_stop", 'odd,"name"', "held"]
    for i, column in enumerate((written.time, *written.columns.values())):
        wanted = column[expected].astype(float).tobytes()
        assert np.array([float(row[i]) for row in rows]).tobytes() == wanted
        assert table.column(i).to_numpy().astype(float).tobytes() == wanted


def test_our_own_reader_reads_it(tmp_path: Path) -> None:
    values = np.random.default_rng(1).standard_normal(3000) * 10.0 ** np.arange(-150, 150).repeat(10)
    write_csv(tmp_path / "run.csv", recording(values.tolist()))
    table = read_table(tmp_path / "run.csv")
    assert table.column("plant.y").tobytes() == values.tobytes()
    assert b"\r" not in (tmp_path / "run.csv").read_bytes()


def test_parquet_says_units_and_provenance(fastest_fmus: Path, tmp_path: Path) -> None:
    run = front_door.run("2dof-smooth-nonlinear", fmus=fastest_fmus, set={"plant.v.mass": 8.0})
    run.to_parquet(tmp_path / "run.parquet")
    table = parquet.read_table(tmp_path / "run.parquet")
    units = {field.name: field.metadata[b"unit"].decode() for field in table.schema}
    assert (units["time"], units["plant.v.position"], units["plant.motor.i_a"]) == ("s", "m", "A")
    assert (units["controller.v.reference"], units["plant.at_stop"]) == ("m", "")
    about = json.loads(table.schema.metadata[b"maglev"])
    assert about["name"] == "2dof-smooth-nonlinear"
    assert about["provenance"]["changes"] == ["plant.v.mass = 8.0 kg instead of 4.35 kg"]
    assert [fmu["model"] for fmu in about["provenance"]["fmus"]] == ["Regulator2DOF", "Plant2DOF"]
    assert table.column("plant.v.position").to_numpy().tobytes() == run["plant.v.position"].tobytes()


def test_the_form_that_is_asked_for(fastest_fmus: Path, tmp_path: Path) -> None:
    """The other form of an earlier run does not pass for what this one gave, nor does either after a failure."""
    def left() -> set[str]:
        return {path.name for path in tmp_path.glob("2dof-smooth*")}

    def run(*options: str) -> int:
        return maglev("run", "2dof-smooth-nonlinear", "--fmus", fastest_fmus, "--out", tmp_path, *options).exit_code

    name = "2dof-smooth-nonlinear"
    beside = {f"{name}.json", f"{name}.txt"}
    assert run() == 0
    assert left() == {f"{name}.csv", *beside}
    assert run("--format", "parquet") == 0
    assert left() == {f"{name}.parquet", *beside}
    assert run("--set", "plant.v.mass=-1") == 2
    assert f"{name}.previous.parquet" in left()
    assert f"{name}.parquet" not in left()
    assert run() == 0
    assert left() == {f"{name}.csv", *beside}


def test_the_metrics_are_measured_on_every_step_when_they_are_asked_for(fastest_fmus: Path) -> None:
    run = front_door.run("2dof-smooth-nonlinear", fmus=fastest_fmus)
    assert run.recording is not None
    every = run.recording
    peak = np.max([np.abs(every.columns[name]).max() for name in run.plan.motors["motor"].currents])
    assert run.metrics.motors[0].peak_current == peak
    assert run.metrics is run.metrics
    assert run.recording is None


@pytest.mark.usefixtures("slow")
def test_writing_imports_no_pandas(tmp_path: Path) -> None:
    """It takes a second."""
    code = ("import sys, numpy; from pathlib import Path; from maglev.cosim.master import Recording; "
            "from maglev.runs.results import write_csv, write_parquet; "
            f"write_csv(Path({str(tmp_path / 'run.csv')!r}), Recording(numpy.zeros(3), {{'a': numpy.ones(3)}})); "
            "print(*sorted({'pandas', 'pyarrow'} & set(sys.modules))); "
            f"write_parquet(Path({str(tmp_path / 'p')!r}), Recording(numpy.zeros(3), {{}}), {{}}, {{}}); "
            "print(*sorted({'pandas', 'pyarrow'} & set(sys.modules)))")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["", "pyarrow"]


def test_parquet_without_pyarrow_is_refused_before_the_run(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    monkeypatch.setattr("maglev.api.running.run_experiments", lambda *_: pytest.fail("it ran"))
    with raises(front_door.MaglevError, "Parquet", "pyarrow", "'maglev-fmus[data]'"):
        front_door.run_all("2dof-smooth-nonlinear", out=tmp_path, format="parquet")


@pytest.mark.usefixtures("slow")
def test_what_is_installed_without_an_extra_has_no_pyarrow() -> None:
    """Runs, batches and tunings are planned without it; a study says what it needs."""
    code = ("import sys; sys.modules['pyarrow'] = None\nimport maglev, maglev.many.study_plan\n"
            "import maglev.many.tuning_plan, maglev.many.tuning_search, maglev.api.batch, maglev.api.comparing\n"
            "try:\n    maglev.study('payload-friction')\nexcept maglev.MaglevError as error:\n    print(error)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("a study needs pyarrow; install it with the Python that runs maglev: python -m pip "
                                  "install "
                                  "'maglev-fmus[study]'")


@pytest.fixture
def earlier(tmp_path: Path) -> dict[str, bytes]:
    """Files of an earlier run, by name."""
    contents = {f"hold.{ending}": ending.encode() for ending in ("csv", "json", "txt", "png")}
    for name, content in contents.items():
        (tmp_path / name).write_bytes(content)
    return contents


def left(folder: Path) -> dict[str, bytes]:
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def short_result() -> RunResult:
    plan = RunPlan.model_validate({"name": "hold", "title": "Hold", "step": 1.0, "stop_time": 1.0,
                                   "fmus": {"plant": {"model": "Plant3DOF"}}})
    return RunResult(plan, Recording(np.array([0.0, 1.0]), {"plant.y.position": np.array([0.02, 0.02])}))


@pytest.mark.parametrize("place", ["execution.write_csv", "execution.json_text"])
def test_a_run_that_cannot_be_written_leaves_every_file_of_an_earlier_one(
        tmp_path: Path, earlier: dict[str, bytes], monkeypatch: pytest.MonkeyPatch, place: str) -> None:
    def full_disk(*_: Any, **__: Any) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(f"maglev.runs.{place}", full_disk)
    files, result = ResultFiles(tmp_path, "hold"), short_result()
    with pytest.raises(OSError) as refusal:
        write_result(files, "csv", result, {}, result.recording)
    assert refusal.value.errno == errno.ENOSPC and Path(refusal.value.filename).stem == "hold"
    assert left(tmp_path) == earlier
    files.set_aside()
    previous = {name.replace("hold.", "hold.previous."): content for name, content in earlier.items()}
    assert left(tmp_path) == previous
    (tmp_path / "hold.txt").write_text("did not complete")
    files.set_aside()   # nor does a second failure take anything away
    assert left(tmp_path) == {**previous, "hold.txt": b"did not complete"}


@pytest.mark.usefixtures("earlier")
def test_a_run_that_was_written_takes_the_place_of_an_earlier_one(tmp_path: Path) -> None:
    files, result = ResultFiles(tmp_path, "hold"), short_result()
    files.set_aside()
    write_result(files, "csv", result, {}, result.recording)
    assert left(tmp_path).keys() == {"hold.csv", "hold.json"}
    assert record_conflict(files.file("csv")) == ""
