"""Tables at any width: no number and no unit is cut, and no word broken."""

import re
from io import StringIO
from itertools import chain

import pytest
from rich.text import Text

from maglev.files.console import ResultTable, plain_console

HEADS = ("quantity", "of", "Regulator3DOF", "PID3DOF", "LinearRegulator3DOF", "ScheduledRegulator3DOF", "the next is")
ROWS = [["settling time to 0.1 mm, worst of 5", "alpha", "1.73 s*", "0.599 s", "2.37 s", "not settled", "98 % larger"],
        ["steady-state error", "z", "35 µm", "0.305 mm", "1.25e-06 A", "–", "over 1000 times"]]


def lines_of(table: ResultTable, width: int) -> list[str]:
    text = StringIO()
    plain_console(file=text, width=width).print(table)
    return [line.rstrip() for line in text.getvalue().splitlines()]


@pytest.mark.parametrize("width", [30, 40, 60, 80, 100, 140])
def test_no_number_unit_or_word_is_cut(width):
    lines = lines_of(ResultTable("A title", HEADS, ROWS, left=2), width)
    assert max(map(len, lines)) <= width
    cells = set(chain.from_iterable(re.split(r" {2,}", line.strip()) for line in lines))
    assert set(chain.from_iterable(row[2:] for row in ROWS)) <= cells
    assert not any("…" in line for line in lines)
    assert all(re.search(r"0\.1 mm\b", line) for line in lines if "0.1" in line), "a number leads its unit"
    words = set(" ".join(lines).split())
    assert {"settling", "worst", "steady-state", "alpha"} <= words


def test_first_columns_stand_in_every_part():
    lines = lines_of(ResultTable("A title", HEADS, ROWS, left=2), 60)
    assert sum("quantity" in line for line in lines) == sum(line.startswith("steady-state") for line in lines) > 1
    assert sum("A title" in line for line in lines) == 1


def test_all_is_in_one_part_where_it_fits():
    lines = lines_of(ResultTable("", HEADS, ROWS, left=2), 140)
    assert sum("quantity" in line for line in lines) == 1
    assert sum(line.startswith(("settling", "steady")) for line in lines) == len(lines[-2:]), "none wraps"


def test_spare_column_goes_before_the_table_is_split():
    table = ResultTable("", HEADS, ROWS, left=2, spare=1)
    assert any("next" in line for line in lines_of(table, 140))
    lines = lines_of(table, 80)
    assert not any("next" in line for line in lines)
    assert sum("quantity" in line for line in lines) == 1


def test_keys_too_wide_to_be_repeated_leave_the_first():
    heads = ("sample", *(f"plant.axis{k}.friction.coulomb" for k in range(4)), "rms error of y")
    lines = lines_of(ResultTable("", heads, [["0", *("0.001234 N" for _ in range(4)), "0.3 mm"]], left=0, keys=5), 60)
    assert sum(line.split()[:1] == ["0"] for line in lines) > 1
    assert sum("0.001234 N" in line for line in lines) == 2, "each is there once, three in the first part"


def test_an_empty_line_stays_between_rows():
    rows: list[list[str | Text] | None] = [["a", Text("1 m", "bold")], None, ["b", "2 m"]]
    assert lines_of(ResultTable("", ("name", "value"), rows), 40)[2:] == ["a       1 m", "", "b       2 m"]


def test_a_word_wider_than_the_terminal_is_broken_and_not_lost():
    text = "".join(lines_of(ResultTable("", ("name", "value"), [["x" * 70, "1 m"]]), 40))
    assert text.count("x") == 70
