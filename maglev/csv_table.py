"""A CSV file with a header and numbers below it, whose columns are read on demand; or columns that are given."""

import csv
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from maglev.arrays import Array
from maglev.errors import CsvError, nearest, nearest_file, shortened
from maglev_files.belonging import stranger

NO_TEXT = ("no text in UTF-8, expected a CSV file with a header and columns separated by commas: export the data as "
           "CSV in UTF-8")


@dataclass(frozen=True)
class CsvTable:
    """Names and numbers of a CSV file; a refusal names file, row, column and value. The header is row 1.

    Of columns that are given, there are all, and the first row is 0.
    """

    path: Path
    names: Sequence[str]
    columns: dict[str, Array] = field(default_factory=dict)
    first: int = 2

    def column(self, name: str) -> Array:
        """Numbers of a column, all finite; CsvError if a field is missing or no finite number."""
        try:
            values = self.columns[name] if name in self.columns else np.loadtxt(
                self.path, delimiter=",", skiprows=1, usecols=list(self.names).index(name), ndmin=1, comments=None,
                quotechar='"', encoding="utf-8-sig")
            numbers = np.asarray(values, dtype=np.float64)
        except (TypeError, ValueError):   # columns that are given may be anything
            raise self.first_bad(name) from None
        if not np.isfinite(numbers).all():
            raise self.first_bad(name)
        self.columns[name] = numbers
        return numbers

    def rows(self, strict: bool = False) -> Iterator[tuple[int, list[str]]]:
        """Numbers and fields of the rows below the header that are not empty; CsvError of what is no CSV."""
        with self.path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file, strict=strict)
            try:
                yield from ((reader.line_num, row) for row in islice(reader, 1, None) if row)
            except csv.Error as error:
                raise CsvError(self.path, f"row {reader.line_num}: {error}, expected a CSV file") from None
            except UnicodeDecodeError:
                raise CsvError(self.path, f"below row {reader.line_num} is {NO_TEXT}") from None

    def first_bad(self, name: str) -> CsvError:
        """Refusal of the first field of a column that is no finite number."""
        index = list(self.names).index(name)
        fields = enumerate(map(str, self.columns[name]), self.first) if name in self.columns else (
            (number, row[index] if index < len(row) else "") for number, row in self.rows())
        for number, text in fields:
            if not is_finite(text):
                return CsvError(self.path, f"row {number}, column {name} is {shortened(text)}, expected a "
                                           "finite number")
        return CsvError(self.path, f"column {name}: expected finite numbers")

    def renamed(self, names: Mapping[str, str]) -> "CsvTable":
        """The table with columns under other names, by these; CsvError if one is not there."""
        for name, own in names.items():
            if own not in self.names:
                raise CsvError(self.path, f"columns: {name}={own!r}: there is no such column, nearest is "
                                          f"{nearest(own, self.names)}")
            self.column(own)   # here a refusal has the name that the data have for it
        # What is replaced has no name.
        new = {**dict.fromkeys(names, ""), **{own: name for name, own in names.items()}}
        return replace(self, names=[new.get(name, name) for name in self.names],
                       columns={new.get(name, name): values for name, values in self.columns.items()})

    def refusal(self, name: str, k: int, expectation: str) -> CsvError:
        """Refusal of the k-th number of a column."""
        return CsvError(self.path, f"row {k + self.first}, column {name} is {self.columns[name][k]:.9g}, {expectation}")

    def require_full_rows(self) -> None:
        """Refuse a row with more or fewer fields than the header: a part of a file that was cut."""
        for number, row in self.rows(strict=True):
            if len(row) != len(self.names):
                raise CsvError(self.path, f"row {number} has {len(row)} values, expected {len(self.names)} as the "
                                          "header has")


def read_csv(path: Path) -> CsvTable:
    """Open a CSV file: a header with unique names, then rows of numbers.

    CsvError if it is missing, no CSV text, or has no header or no rows; also if it is not the file that the record of
    a run beside it is of.
    """
    try:
        with path.open("rb") as file:
            start = file.read(4096)
        if b"\0" in start:
            raise UnicodeDecodeError("utf-8", start, 0, 1, "binary")
        with path.open(newline="", encoding="utf-8-sig") as text:
            reader = csv.reader(text, skipinitialspace=True)
            header = [name.strip() for name in next(reader, [])]
            rows = any(row for row in reader)
    except UnicodeDecodeError:
        raise CsvError(path, NO_TEXT) from None
    except csv.Error as error:
        raise CsvError(path, f"{error}, expected a CSV file") from None
    except OSError as error:
        raise CsvError(path, f"cannot be read: {error.strerror}{nearest_file(path)}") from None
    if len(header) < 2:
        separator = next((mark for mark in (";", "\t") if header and mark in header[0]), None)
        wrong = "is empty" if not header else "has one column" if separator is None else (
            f"has columns separated by {separator!r}")
        raise CsvError(path, f"{wrong}, expected a CSV file with a header and columns separated by commas")
    if all(is_finite(name) for name in header):
        raise CsvError(path, "row 1 is numbers, expected the names of the columns, such as time,v,h,i_d,i_q")
    for name in header:
        if header.count(name) > 1:
            raise CsvError(path, f"row 1 has the column {name!r} {header.count(name)} times, expected it once")
    if not rows:
        raise CsvError(path, "has a header only, expected rows of numbers")
    if why := stranger(path):
        raise CsvError(path, why)
    return CsvTable(path, header)


def given_table(name: str, given: Any) -> CsvTable:
    """Columns of a mapping, such as a `Run`, or of a DataFrame, of whatever library.

    CsvError if one is no row, or they are not of one length; whether they are numbers is asked of those that are used.
    """
    path = Path(name)
    try:
        names = [str(name) for name in getattr(given, "columns", given)]
        columns = {name: np.asarray(given[name]) for name in names}
    except (TypeError, ValueError, KeyError, IndexError) as error:
        raise CsvError(path, f"{type(given).__name__}: {error}, expected a path, or columns of numbers by name, such "
                             "as a Run, a table of arrays or a DataFrame") from None
    index = getattr(given, "index", None)
    time = getattr(given, "time", index if getattr(index, "name", "") == "time" else None)
    if "time" not in columns and time is not None:
        columns["time"] = np.asarray(time)
    for column, values in columns.items():
        if values.ndim != 1 or len(values) != len(columns[names[0]]):
            raise CsvError(path, f"column {column} has the shape {values.shape}, expected as many rows as {names[0]}, "
                                 f"{len(np.atleast_1d(columns[names[0]]))}")
    return CsvTable(path, list(columns), columns, 0)


def is_finite(text: str) -> bool:
    try:
        return math.isfinite(float(text))
    except ValueError:
        return False
