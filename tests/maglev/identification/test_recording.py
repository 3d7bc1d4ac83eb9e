"""Reading recordings: what columns may be called, and every file that is refused."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from facts import raises
from motor import MOTOR

from maglev.files.errors import CsvError, IdentificationError, MaglevError, StageError
from maglev.files.table import given_table
from maglev.identification.identify import identify
from maglev.identification.recording import read_recording
from pmlsm.dq_transform import phase_currents

N, DT = 4001, 0.5e-3
Table = dict[str, np.ndarray]


def good() -> Table:
    t = DT * np.arange(N)
    return {"time": t, "v": 0.02 + 2e-3 * np.sin(6.0 * t), "h": 0.01 * np.sin(9.0 * t),
            "i_d": np.cos(5.0 * t), "i_q": 0.5 * np.sin(9.0 * t)}


def write(path: Path, table: Table) -> Path:
    np.savetxt(path, np.column_stack(list(table.values())), delimiter=",", header=",".join(table), comments="",
               fmt="%.15g")
    return path


def test_plain_columns(tmp_path: Path) -> None:
    found = read_recording(write(tmp_path / "a.csv", good()))
    assert found.stage.name == "2dof"
    assert found.dt == pytest.approx(DT)
    assert found.positions[:, 1] == pytest.approx(good()["h"], abs=1e-14)
    assert found.i_q[:, 0] == pytest.approx(good()["i_q"], abs=1e-14)


def test_three_phases_are_transformed_at_the_measured_displacement(tmp_path: Path) -> None:
    table = good()
    phases = np.array([phase_currents(d, q, MOTOR.electrical_angle(h))
                       for d, q, h in zip(table["i_d"], table["i_q"], table["h"], strict=True)])
    renamed = {"time": table["time"], "v": table["v"], "h": table["h"],
               **{f"i_{phase}": phases[:, k] + 0.3 for k, phase in enumerate("abc")}}   # a common part makes no force
    found = read_recording(write(tmp_path / "a.csv", renamed))
    assert found.i_d[:, 0] == pytest.approx(table["i_d"], abs=1e-12)
    assert found.i_q[:, 0] == pytest.approx(table["i_q"], abs=1e-12)


def test_results_of_this_project_with_a_shorter_last_step(tmp_path: Path) -> None:
    table = good()
    table["time"][-1] -= 0.5 * DT
    names = {"v": "plant.v.encoder", "h": "plant.h.encoder", "i_d": "plant.motor.i_d", "i_q": "plant.motor.i_q"}
    renamed = {names.get(name, name): values for name, values in table.items()}
    found = read_recording(write(tmp_path / "a.csv", {**renamed, "plant.v.position": 0.0 * table["v"]}))
    assert len(found.time) == N - 1
    assert found.positions[:, 0] == pytest.approx(table["v"][:-1])


def test_3dof_columns(tmp_path: Path) -> None:
    table = good()
    three = {"time": table["time"], "y": table["v"], "x": table["h"], "z": -table["h"], "alpha.i_d": table["i_d"],
             "alpha.i_q": table["i_q"], "beta.i_d": table["i_d"], "beta.i_q": 2.0 * table["i_q"]}
    found = read_recording(write(tmp_path / "a.csv", three))
    assert found.stage.name == "3dof"
    assert found.i_q[:, 1] == pytest.approx(2.0 * table["i_q"])
    with raises(IdentificationError, tmp_path / "a.csv", "v", "plant.v.encoder", "'time', 'y', 'x' and 5 others"):
        read_recording(tmp_path / "a.csv", "2dof")
    with raises(StageError, "stage", "'4dof'", "2dof, 3dof, 5dof"):
        read_recording(tmp_path / "a.csv", "4dof")


def test_run_of_a_stage_of_the_user_s_asks_for_its_description(tmp_path: Path) -> None:
    """Its columns are those of a packaged stage, whose field, motors and friction would be taken for its own."""
    path, fmu = write(tmp_path / "a.csv", good()), {"name": "plant", "model": "PlantMine", "kind": "native"}
    for model, kind in (("PlantMine", "native"), ("Plant2DOF", "native"), ("PlantMine", "foreign")):
        record = {"provenance": {"fmus": [{**fmu, "model": model, "kind": kind}]}}
        path.with_suffix(".json").write_text(json.dumps(record))
        if (model, kind) == ("PlantMine", "native"):
            with raises(IdentificationError, path, "PlantMine", "stage", "mine.toml"):
                read_recording(path)
            assert read_recording(path, "2dof").stage.name == "2dof"
        else:
            assert read_recording(path).stage.name == "2dof"


def put(column: str, row: int, value: float) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        table[column][row] = value
    return change


def scale(column: str, by: float) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        table[column] = by * table[column]
    return change


def cut(rows: int) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        for name in table:
            table[name] = table[name][:rows]
    return change


def rename(old: str, new: str) -> Callable[[Table], None]:
    def change(table: Table) -> None:
        table[new] = table.pop(old)
    return change


@pytest.mark.parametrize(("change", "kind", "facts"), [
    (cut(1000), IdentificationError, ["0.4995 s", "1000 rows", "1.0 s"]),
    (put("time", 100, 0.0495), CsvError, ["row 102", "time", "0.0495"]),
    (put("time", 100, 0.04), CsvError, ["row 102", "time", "0.04", "0.0495"]),
    (put("time", 100, 0.0501), CsvError, ["row 102", "time", "0.0501", "0.05 ± 5%", "0.0005 s"]),
    (put("i_q", 7, float("nan")), CsvError, ["row 9", "i_q", "'nan'"]),
    (put("h", 7, float("inf")), CsvError, ["row 9", "h", "'inf'"]),
    (scale("time", 12.0), IdentificationError, ["time", "0.006 s", "0.005 s"]),
    (scale("time", 1e2), IdentificationError, ["0.2 s", "4001 rows", "ms", "0.05"]),
    (scale("v", 1e3), CsvError, ["row 2", "v", "20", "0.020", "v = mm"]),
    (scale("v", 1e6), CsvError, ["row 2", "v", "20000", "0.020", "v = µm"]),
    (scale("h", 1e3), CsvError, ["h", "-0.5", "0.5 m", "h = mm"]),
    (scale("i_d", 1e3), CsvError, ["row 2", "i_d", "1000", "±100.0 A", "i_d = mA"]),
    (put("v", 50, 0.05), CsvError, ["row 52", "v", "0.05", "0.008", "0.04 m"]),
    (rename("i_q", "iq"), IdentificationError, ["i_q", "'iq'"]),
    (rename("h", "hh"), IdentificationError, ["h", "plant.h"]),
    (rename("time", "tme"), CsvError, ["time", "'tme'"])])
def test_bad_columns(tmp_path: Path, change: Callable[[Table], None], kind: type[MaglevError],
                     facts: list[str]) -> None:
    table = good()
    change(table)
    path = write(tmp_path / "mine.csv", table)
    with raises(kind, path, *facts):
        read_recording(path)


@pytest.mark.parametrize(("content", "facts"), [
    (b"time,a,b\n0,1,2\n", ["v, h", "y, x, z", "y, x, z, roll, pitch"]),
    (b"time,v,h,y,x,z\n0,1,2,3,4,5\n", ["2dof and 3dof", "stage = 2dof", "stage = 3dof"])])
def test_bad_files(tmp_path: Path, content: bytes, facts: list[str]) -> None:
    path = tmp_path / "mine.csv"
    path.write_bytes(content)
    with raises(IdentificationError, path, *facts):
        read_recording(path)


def test_a_recording_of_a_laboratory(tmp_path: Path) -> None:
    """Millimetres, decimal commas, times in ms that jitter, and a line that says what was assumed."""
    table = good()
    table["time"] += 1e-5 * (np.arange(N) % 2)
    rows = np.column_stack([1e3 * table["time"], 1e3 * table["v"], table["h"], table["i_d"], 1e3 * table["i_q"]])
    text = "\n".join(";".join(f"{value:.9f}" for value in row) for row in rows.tolist()).replace(".", ",")
    path = tmp_path / "mine.csv"
    path.write_text(f"Zeit [ms];V [mm];h;i_d;i_q (mA)\n{text}\n", encoding="utf-8")
    found = read_recording(path)
    assert found.dt == pytest.approx(DT, rel=1e-5)
    assert found.positions == pytest.approx(np.column_stack([good()["v"], good()["h"]]), abs=1e-6)
    assert found.i_q[:, 0] == pytest.approx(good()["i_q"], abs=1e-4)
    assert found.said == (f"{path}: columns are separated by semicolons; numbers have decimal commas; Zeit is in ms; "
                          "times are uneven by up to 2.0% of 0.0005 s, columns are resampled; V is in mm; i_q is in mA")


def test_columns_that_nothing_uses_may_be_anything() -> None:
    spare = {"note": ["20 mm"] * N, "temperature": np.full(N, np.nan), "none": [None] * N}
    table = given_table("data", {**good(), **spare})
    assert read_recording(table).positions[:, 1] == pytest.approx(good()["h"])
    for name, shown in ("note", "'20 mm'"), ("temperature", "'nan'"), ("none", "'None'"):
        with raises(CsvError, "data", "row 0", name, shown):
            read_recording(table.renamed({"v": name}))


def test_nothing_moves(tmp_path: Path) -> None:
    table = {name: values if name == "time" else np.full(N, values[0] + 0.001) for name, values in good().items()}
    with raises(IdentificationError, "v 0 mm", "h 0 mm"):
        identify(read_recording(write(tmp_path / "a.csv", table)))


def test_one_axis_moves(tmp_path: Path) -> None:
    table = good()
    table["v"] = np.full(N, 0.02)
    table["i_d"] = np.zeros(N)
    found = identify(read_recording(write(tmp_path / "a.csv", table)))
    assert "C2, C3, C4: cannot be identified from this recording of axis v" in found.warnings[0]
    assert np.isinf(found.standard_error["C3"])
    assert np.isfinite(found.standard_error["C1"])
