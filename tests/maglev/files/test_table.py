"""Shapes of tables as laboratories write them: what is read and said, and what is refused in which words."""

import datetime
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pytest
from facts import raises

from maglev.files.errors import CsvError, MaglevError
from maglev.files.table import DataTable, given_table, read_table
from maglev.files.table_columns import numbers_of, split_name
from maglev.files.table_times import Times, even, nanoseconds, require_time, times_of

ROWS = [[0.0, 0.02, 1.5], [0.001, 0.021, -1.0], [0.002, 0.022, 2e-3]]
PLAIN = "time,v,i_q\n0,0.02,1.5\n0.001,0.021,-1\n0.002,0.022,2e-3\n"
COMMAS = PLAIN.replace(",", ";").replace(".", ",")
ISO = "2024-05-01T12:00:00.{}"


def file(folder: Path, content: str | bytes) -> Path:
    path = folder / "mine.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    return path


def seconds(table: DataTable) -> Times:
    return times_of(table, require_time(table), guess=True)


def column(table: DataTable, name: str, unit: str) -> list[float]:
    found = table.find(name)
    assert found is not None
    return table.column(found, unit).tolist()


def stamped(separator: str, form: Callable[[int], str]) -> str:
    """Rows every millisecond with times of a form, from milliseconds."""
    return "\n".join([separator.join(("time", "v", "i_q")),
                      *(separator.join((form(k), *map(repr, row[1:]))) for k, row in enumerate(ROWS))]) + "\n"


READ: dict[str, tuple[str | bytes, str]] = {
    "plain": (PLAIN, ""),
    "byte order mark": (b"\xef\xbb\xbf" + PLAIN.encode(), ""),
    "Windows": (PLAIN.replace("\n", "\r\n"), ""),
    "old Macintosh": (PLAIN.replace("\n", "\r"), ""),
    "blanks after commas": (PLAIN.replace(",", ", "), ""),
    "no line end": (PLAIN.rstrip(), ""),
    "quotes": (PLAIN.replace("time", '"time"').replace("1.5", '"1.5"'), ""),
    "line break in a header": (PLAIN.replace("time", '"time\n[s]"'), ""),
    "first line is blank": ("\n\n" + PLAIN, ""),
    "blank lines between": (PLAIN.replace("1.5\n", "1.5\n\n"), ""),
    "trailing blanks": (PLAIN + "\n\n  \n", ""),
    "capital letters": (PLAIN.replace("time", "TIME").replace("v", "V").replace("i_q", "I_q"), ""),
    "t": (PLAIN.replace("time", "t"), ""),
    "Timestamp": (PLAIN.replace("time", "Timestamp"), ""),
    "minus sign": (PLAIN.replace("-1", "\N{MINUS SIGN}1"), ""),
    "D exponent": (PLAIN.replace("2e-3", "2D-3"), ""),
    "d exponent": (PLAIN.replace("2e-3", "0.2d-02"), ""),
    "plus": (PLAIN.replace("1.5", "+1.5"), ""),
    "a column of words": ('time,state,v,i_q\n0,"on, 7",0.02,1.5\n0.001,"on, 8",0.021,-1\n0.002,off,0.022,2e-3\n', ""),
    "semicolons": (PLAIN.replace(",", ";"), "columns are separated by semicolons"),
    "tabs": (PLAIN.replace(",", "\t"), "columns are separated by tabs"),
    "bars": (PLAIN.replace(",", "|"), "columns are separated by bars"),
    "blanks": (PLAIN.replace(",", "   "), "columns are separated by blanks"),
    "decimal commas": (COMMAS, "columns are separated by semicolons; numbers have decimal commas"),
    "decimal commas, tabs": (COMMAS.replace(";", "\t"), "separated by tabs; numbers have decimal commas"),
    "decimal commas, quotes": ('time,v,i_q\n"0","0,02","1,5"\n"0,001","0,021","-1"\n"0,002","0,022","0,002"\n',
                               "numbers have decimal commas"),
    "Latin-1": ("time,v,Größe,i_q\n0,0.02,1,1.5\n0.001,0.021,1,-1\n0.002,0.022,1,2e-3\n".encode("latin-1"),
                "is in Latin-1"),
    "UTF-16": (PLAIN.encode("utf-16"), "is in UTF-16"),
    "UTF-16 without a mark": (PLAIN.encode("utf-16-le"), "is in UTF-16"),
    "UTF-16, the other way": (PLAIN.encode("utf-16-be"), "is in UTF-16"),
    "comments above": ("# stage 3\n# 2024-05-01\n" + PLAIN, "2 lines above the header are left out"),
    "percent signs": ("% stage 3\n" + PLAIN, "1 line above the header is left out"),
    "lines above": ("Logger 5.1\nOperator: N. N.\n\n" + PLAIN, "2 lines above the header are left out"),
    "settings above": (COMMAS.join(["Messung;Mai\nSchritte;1000\n\n", ""]), "2 lines above the header are left out"),
    "a header in a comment": ("# " + PLAIN, "the header is in a comment"),
    "comments between": ("time,v,i_q\n# begin\n0,0.02,1.5\n0.001,0.021,-1\n# note\n0.002,0.022,2e-3\n", ""),
    "a footer": (PLAIN + "end of the recording\n", "1 line below the rows is left out"),
    "a footer of fields": (PLAIN + "\nMean,0.021,0.5\nMax,0.022,1.5\n", "2 lines below the rows are left out"),
    "a column after the last mark": (PLAIN.replace("\n", ",\n"), ""),
    "units in brackets": ("time [ms],v [mm],i_q [mA]\n0,20,1500\n1,21,-1000\n2,22,2\n",
                          "time is in ms; v is in mm; i_q is in mA"),
    "units in parentheses": ("Time (ms),v(mm),i_q (A)\n0,20,1.5\n1,21,-1\n2,22,0.002\n", "Time is in ms; v is in mm"),
    "units after a slash": ("time / ms,v / mm,i_q / A\n0,20,1.5\n1,21,-1\n2,22,0.002\n", "time is in ms; v is in mm"),
    "units after a line": ("time_ms,v_mm,i_q\n0,20,1.5\n1,21,-1\n2,22,0.002\n", "time is in ms; v is in mm"),
    "units written out": ("time (milliseconds),v (Millimetres),i_q (Amperes)\n0,20,1.5\n1,21,-1\n2,22,0.002\n",
                          "time is in ms; v is in mm"),
    "a row of units": ("time,v,i_q\nms,mm,A\n0,20,1.5\n1,21,-1\n2,22,0.002\n", "time is in ms; v is in mm"),
    "a row of units in brackets": ("time;v;i_q\n[µs];[µm];[-]\n0;20000;1,5\n1000;21000;-1\n2000;22000;0,002\n",
                                   "time is in µs; v is in µm"),
    "ms": ("time,v,i_q\n0,0.02,1.5\n1,0.021,-1\n2,0.022,2e-3\n", "assumed time in ms, because it has a row every 1"),
    "µs": ("time,v,i_q\n5000,0.02,1.5\n6000,0.021,-1\n7000,0.022,2e-3\n", "assumed time in µs"),
    "ns": ("time,v,i_q\n0,0.02,1.5\n1000000,0.021,-1\n2000000,0.022,2e-3\n", "assumed time in ns"),
    "epoch": (stamped(",", lambda k: f"1700000000.00{k}"), "time starts at 1700000000, the first row"),
    "epoch in ms": (stamped(",", lambda k: f"170000000000{k}"), " in ms, because it has a row every 1"),
    "epoch in ns": (stamped(",", lambda k: f"170000000000{k}000000"), " in ns"),
    "ISO 8601": (stamped(",", lambda k: ISO.format(f"00{k}")), "time has time stamps, from 2024-05-01T12:00:00.000 on"),
    "ISO 8601, UTC": (stamped(",", lambda k: ISO.format(f"00{k}Z")), "time has time stamps"),
    "ISO 8601, a zone": (stamped(";", lambda k: ISO.format(f"00{k}+02:00").replace("T", " ")), "time has time stamps"),
    "time of day": (stamped(",", lambda k: f"09:15:00.00{k}"), "time has time stamps, from 09:15:00.000 on")}


@pytest.mark.parametrize("name", READ)
def test_what_is_read(name: str, tmp_path: Path) -> None:
    content, said = READ[name]
    table = read_table(file(tmp_path, content))
    times = seconds(table).seconds
    assert times - (times[0] if name == "µs" else 0.0) == pytest.approx([0.0, 0.001, 0.002], abs=3e-7)
    assert column(table, "v", "m") == pytest.approx([row[1] for row in ROWS], rel=1e-15)
    assert column(table, "i_q", "A") == pytest.approx([row[2] for row in ROWS], rel=1e-15)
    assert "\n" not in table.said
    assert said in table.said if said else table.said in ("", f"{table.path}: 2 lines above the header are left out")


REFUSED: dict[str, tuple[bytes, *tuple[str, ...]]] = {   # a file, and the facts of its refusal
    "nothing": (b"", "empty"), "blank lines": (b"\n \n", "empty"),
    "a workbook": (b"PK\x03\x04\0\0binary", "workbook"),
    "binary": (bytes(range(256)), "text"), "half of UTF-16": (b"\xff\xfe1,2,\n", "text"),
    "one column": (b"time\n0\n1\n", "one column"),
    "no header": (b"0.0,0.02,0.0\n1,2,3\n", "row 1", "numbers"),
    "a header only": (b"time,v,h\n", "header only"),
    "two of a name": (b"time,v,v\n0,1,2\n", "row 1", "'v'", "2 times"),
    "commas for both": (b"time,v\n0,0,0,02\n0,1,0,03\n", "row 2", "4 values", "2", "decimal"),
    "too many fields": (b"time,v\n0,1\n1,2,3\n2,3\n", "row 3", "3 values", "2"),
    "too few, semicolons": (b"time;v\n0;1\n1\n2;3\n", "row 3", "1 value", "2", "v"),
    "an empty field": (b"time,v\n0,\n1,2\n", "row 2", "v", "''"),
    "no number": (b"time,v\n0,1\n1,NaN\n2,3\n", "row 3", "v", "'NaN'"),
    "a unit in a field": (b"time,v\n0,1\n1,5 mm\n2,3\n", "row 3", "v", "'5 mm'"),
    "below a comment": (b"# a\n\ntime,v\n0,1\n\n1,x\n2,3\n", "row 6", "v", "'x'"),
    "a point, too": (b"time;v\n0;0,5\n1;0.7\n2;0,9\n", "row 3", "v", "'0.7'", "decimal comma"),
    "thousands": (b"time;v\n0;0,5\n1;1.000,7\n2;0,9\n", "row 3", "v", "'1.000,7'"),
    "another unit": (b"time,v [kg]\n0,1\n1,2\n", "v [kg]", "m"),
    "an unknown unit": (b"time,v [counts]\n0,1\n1,2\n", "v [counts]", "'counts'"),
    "no time stamp": (b"time,v\n2024-05-01T12:00:00,1\n2024-05-01T12:61:00,2\n", "row 3", "time",
                      "'2024-05-01T12:61:00'", "2024-05-01T12:00:00.0005"),
    "a day of another form": (b"time,v\n01.05.2024 12:00,1\n01.05.2024 12:01,2\n", "row 2", "time",
                              "'01.05.2024 12:00'")}


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_refused(name: str, tmp_path: Path) -> None:
    content, *facts = REFUSED[name]
    path = file(tmp_path, content)
    with raises(CsvError, path, *facts):
        table = read_table(path)
        seconds(table)
        column(table, "v", "m")


def test_what_is_no_file(tmp_path: Path) -> None:
    with raises(CsvError, tmp_path, "folder"):
        read_table(tmp_path)
    if hasattr(os, "mkfifo"):
        os.mkfifo(tmp_path / "pipe.csv")
        with raises(CsvError, tmp_path / "pipe.csv", "named pipe"):
            read_table(tmp_path / "pipe.csv")


def test_a_column_of_arrays_beside_the_time_alone(tmp_path: Path) -> None:
    """As FMI has it, elements behind each other; a file with blanks between columns and decimal commas looks alike."""
    table = read_table(file(tmp_path, "time,y\n0,1 2 3\n1,2.5 5 7.5\n2,6.25 12.5 18.75\n"))
    assert table.names == ["time", "y"]
    assert list(table.texts("y")) == ["1 2 3", "2.5 5 7.5", "6.25 12.5 18.75"]
    blanks = read_table(file(tmp_path, "time v i_q\n0,5 1,5 2,5\n1,5 2,5 3,5\n2,5 3,5 4,5\n"))
    assert blanks.names == ["time", "v", "i_q"]
    assert column(blanks, "i_q", "A") == [2.5, 3.5, 4.5]


def test_only_parquet_needs_pandas(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("maglev.files.errors.find_spec", lambda name: None)
    monkeypatch.setitem(sys.modules, "pandas", None)
    for content, _ in READ.values():
        assert column(read_table(file(tmp_path, content)), "i_q", "A")[0] == 1.5
    with raises(CsvError, tmp_path / "mine.csv", "Parquet", "pandas", "'maglev-fmus[data]'"):
        read_table(file(tmp_path, b"PAR1"))


def test_time_stamps_count_nanoseconds() -> None:
    begin = nanoseconds("2024-05-01T12:00:00Z")
    assert nanoseconds("2024-05-01 14:00:00.000500123+02:00") - begin == 500_123
    assert nanoseconds("2024-05-02") - begin == 12 * 3600 * 10**9
    assert nanoseconds("25:00:01,5") == 90_001_500_000_000


@pytest.mark.parametrize(("header", "name", "unit"), [
    ("v", "v", ""), ("v [mm]", "v", "mm"), ("x[1]", "x[1]", ""), ("der(x)", "der(x)", ""), ("v [1]", "v [1]", ""),
    ("a (-)", "a", ""), ("i_d", "i_d", ""), ("plant.alpha.i_d", "plant.alpha.i_d", ""), ("t_s", "t", "s"),
    ("i_s", "i_s", ""), ("v, mm", "v", "mm"), ("gap (counts)", "gap", "counts")])
def test_names_and_units(header: str, name: str, unit: str) -> None:
    assert split_name(header) == (name, unit)


def test_numbers_keep_every_bit() -> None:
    values = np.random.default_rng(1).standard_normal(1000) * 10.0 ** np.arange(-150, 150).repeat(4)[:1000]
    texts = [repr(value) for value in values.tolist()]
    assert numbers_of(texts).tolist() == values.tolist()
    assert numbers_of([text.replace(".", ",") for text in texts], ",").tolist() == values.tolist()


def uneven(times: Sequence[float] | np.ndarray) -> DataTable:
    return given_table("data", {"time": np.array(times), "v": 2.0 * np.array(times)})


def test_uneven_times_are_resampled() -> None:
    """A few per cent of the sample time on straight lines; of a per cent they stay as they are."""
    times = 1e-3 * np.arange(100.0)
    for jitter, words in ((0.004, ""), (0.03, "times are uneven by up to")):
        table = uneven(times + 1e-3 * jitter * (np.arange(100) % 2))
        found = even(table, seconds(table))
        assert np.ptp(np.diff(found.time)) <= (1e-5 if not words else 1e-15)
        assert found.resample(table.column("v")) == pytest.approx(2.0 * found.time, rel=1e-12)
        assert words in table.said


def test_gaps_are_named_filled_or_left_out() -> None:
    times = 1e-3 * np.array([*range(40), *range(52, 120), *range(121, 140)])
    table = uneven(times)
    with raises(CsvError, "row 40", "time", 0.052, "0.04 ± 5%", "0.001 s", 2, "0.013 s", "0.039 s", "fill", "longest"):
        even(table, seconds(table))
    filled = even(table, seconds(table), "fill")
    assert filled.time == pytest.approx(1e-3 * np.arange(140))
    assert filled.resample(table.column("v")) == pytest.approx(2e-3 * np.arange(140))
    assert "the longest step is 0.013 s after 0.039 s: filled with straight lines" in table.said
    longest = even(table := uneven(times), seconds(table), "longest")
    assert longest.time == pytest.approx(1e-3 * np.arange(52, 120))
    assert "68 of 127 rows are used, the longest part without a gap, from 0.052 s to 0.119 s" in table.said
    with raises(MaglevError, "gaps", "some", "refuse", "fill", "longest"):
        even(table, seconds(table), "some")   # type: ignore[arg-type]


def test_moments_of_other_libraries_are_seconds() -> None:
    pandas, polars = pytest.importorskip("pandas"), pytest.importorskip("polars")
    begin = datetime.datetime(2024, 5, 1, 12)   # noqa: DTZ001
    moments = [begin + datetime.timedelta(milliseconds=k) for k in range(3)]
    v = [row[1] for row in ROWS]
    stamps = pandas.DatetimeIndex(moments)
    for given in (pandas.DataFrame({"v": v}, index=stamps), pandas.DataFrame({"v": v}, index=stamps.tz_localize("CET")),
                  pandas.DataFrame({"v": v}, index=stamps - stamps[0]), pandas.DataFrame({"time": stamps, "v": v}),
                  polars.DataFrame({"time": moments, "v": v}), {"time": moments, "v": v},
                  pandas.DataFrame({"time": stamps.tz_localize("CET"), "v": v})):
        table = given_table("data", given)
        assert seconds(table).seconds == pytest.approx([0.0, 0.001, 0.002], abs=1e-12)


def test_a_parquet_file_of_anybody_is_read(tmp_path: Path) -> None:
    pandas = pytest.importorskip("pandas")
    pytest.importorskip("pyarrow")
    pandas.DataFrame({"time": [0.0, 0.001], "v [mm]": [20.0, 21.0]}).to_parquet(tmp_path / "a.parquet")
    assert column(read_table(tmp_path / "a.parquet"), "v", "m") == [0.02, 0.021]
