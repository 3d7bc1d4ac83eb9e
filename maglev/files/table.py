"""A table of numbers: a file as laboratories and other tools write it, or columns that are given.

NumPy reads numbers with decimal points; other fields are read as texts, one row at a time.
"""

import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.files.arrays import Array
from maglev.files.cache import record_conflict
from maglev.files.errors import CsvError, lacking, nearest, shortened
from maglev.files.table_columns import NO_NUMBER, is_number, numbers_of, split_name
from maglev.files.table_layout import Layout, Row, decoded, file_bytes, layout_of
from maglev.files.units import Unit, known_unit, like

PARQUET = b"PAR1"


@dataclass(frozen=True)
class DataTable:
    """Columns of a file by name, or columns that are given; a refusal names file, row, column and value.

    Rows of a file are counted by its lines, and those of given columns from 0. `assumed` has the assumptions made in
    reading it, in words; `said` has them in one line.
    """

    path: Path   # of the file, or the name of given columns in messages
    names: Sequence[str]
    layout: Layout | None = None
    given: dict[str, NDArray[Any]] = field(default_factory=dict)   # columns as they are, or fields as texts
    units: dict[str, str] = field(default_factory=dict)   # that somebody says, by column
    called: dict[str, str] = field(default_factory=dict)   # names of columns by other names for them
    assumed: list[str] = field(default_factory=list)
    numbers: dict[str, Array] = field(default_factory=dict)   # of columns that were read

    def find(self, *names: str) -> str | None:
        """First column of these names, also if it is written with a unit, or with other capital letters."""
        for name in names:
            if name in self.called:
                return self.called[name]
            if name in self.names:
                return name
        for name in names:
            alike = [own for own in self.names if own not in self.called.values()
                     and split_name(own)[0].casefold() == name.casefold()]
            if len(alike) == 1:
                return alike[0]
        return None

    def unit(self, name: str, exact: str = "") -> str:
        """Unit in the table for a column; "" if there is none. A column with exactly this name has none."""
        if name in self.units:
            return self.units[name]
        below = self.layout.units.get(name, "") if self.layout is not None else ""
        return below or ("" if name == exact else split_name(name)[1])

    def column(self, name: str, unit: str = "", exact: str = "") -> Array:
        """Numbers of a column, all finite, in a unit if one is given and the table states that of the column.

        CsvError if a field is missing or no finite number, or the unit is another one. `exact` as in `unit`.
        """
        numbers = self.plain_numbers(name)
        said = self.unit(name, exact)
        if not said or not unit or said == unit:
            return numbers
        return self.converted(numbers, name, said, unit)

    def converted(self, numbers: Array, name: str, said: str, unit: str) -> Array:
        """Numbers of a column in another unit."""
        own, expected = known_unit(said), known_unit(unit)
        if own is None:
            raise CsvError(self.path, f"column {name}: unknown unit {said!r}; {like(said)}")
        if expected is None or own.dimension != expected.dimension:
            raise CsvError(self.path, f"column {name} is in {said}, expected {unit}")
        self.assume(f"{split_name(name)[0] or name} is in {said}")
        return scaled(numbers, own, expected)

    def plain_numbers(self, name: str) -> Array:
        """Numbers of a column as they are written, all finite."""
        if name not in self.numbers:
            try:
                self.numbers[name] = self.read_numbers(name)
            except (TypeError, ValueError):   # columns that are given may be anything
                raise self.first_bad(name) from None
            if not np.isfinite(self.numbers[name]).all():
                del self.numbers[name]
                raise self.first_bad(name)
        return self.numbers[name]

    def read_numbers(self, name: str) -> Array:
        if self.layout is None:
            return np.asarray(self.given[name], dtype=np.float64)
        if name not in self.given and self.layout.decimal == ".":
            separator = None if self.layout.separator == " " else self.layout.separator
            try:
                return np.asarray(np.loadtxt(StringIO(self.layout.body), delimiter=separator, ndmin=1, comments=None,
                                             usecols=self.names.index(name), quotechar='"'), dtype=np.float64)
            except ValueError:
                pass   # a comment between rows, a minus sign
        return numbers_of(self.texts(name).tolist(), self.layout.decimal)

    def texts(self, name: str) -> NDArray[Any]:
        """Fields of a column as texts, shape (n,)."""
        if self.layout is None:
            return np.array([str(value) for value in self.given[name]], dtype=object)
        if name not in self.given:
            columns = list(zip(*(row.fields for row in self.rows()), strict=True))
            self.given.update({own: np.array(columns[k], dtype=object) for k, own in enumerate(self.names) if own})
        return self.given[name]

    def rows(self) -> Iterator[Row]:
        """Yield the rows of the file below the header; CsvError if it is no CSV."""
        assert self.layout is not None
        try:
            yield from self.layout.rows()
        except csv.Error as error:
            raise CsvError(self.path, f"{error}, expected a CSV file") from None

    def require_full_rows(self) -> None:
        """Refuse a row with more or fewer fields than the header: a part of a file that was cut."""
        row = next((row for row in self.rows() if len(row.fields) != len(self.names)), None)
        if row is not None:
            absent = self.names[len(row.fields)] if len(row.fields) < len(self.names) else ""
            values = f"{len(row.fields)} value{'' if len(row.fields) == 1 else 's'}"
            raise CsvError(self.path, f"row {row.line} has {values}, expected {len(self.names)} as in the header"
                                      f"{f': {absent} is missing' if absent else ''}")

    def line(self, k: int) -> int:
        """Number of the row that messages give the k-th one."""
        if self.layout is None:
            return k
        return next((row.line for number, row in enumerate(self.rows()) if number == k), k)

    def first_bad(self, name: str) -> CsvError:
        """Refusal of the first field of a column that is no finite number."""
        decimal = "." if self.layout is None else self.layout.decimal
        for k, text in enumerate(self.texts(name)):
            if not is_number(text.strip(), decimal) or NO_NUMBER.fullmatch(text.strip()):
                hint = " with a decimal comma" if decimal == "," and is_number(text) else ""
                return CsvError(self.path, f"row {self.line(k)}, column {name} is {shortened(text)}, expected a finite "
                                           f"number{hint}")
        return CsvError(self.path, f"column {name}: expected finite numbers")

    def renamed(self, names: Mapping[str, str], units: Mapping[str, str] | None = None) -> "DataTable":
        """The table with columns under other names, and with units by these; CsvError if one is not there."""
        called, said = {}, {}
        for name, own in names.items():
            called[name] = self.find(own) or self.missing(f"columns: {name}={own!r}: there is no such column", own)
        for name, unit in (units or {}).items():
            column = called.get(name) or self.find(name) or self.missing(f"units: there is no column {name}", name)
            if known_unit(unit) is None:
                raise CsvError(self.path, f"units: {name}={unit!r}: unknown unit; {like(unit)}")
            said[column] = unit
        return replace(self, units=said, called=called)

    def missing(self, problem: str, name: str) -> str:
        raise CsvError(self.path, f"{problem}, {nearest(name, list(filter(None, self.names)))}")

    def refusal(self, name: str, k: int, expectation: str) -> CsvError:
        """Refusal of the k-th number of a column."""
        return CsvError(self.path, f"row {self.line(k)}, column {name} is {self.numbers[name][k]:.9g}, {expectation}")

    def assume(self, words: str) -> None:
        """Note an assumption of the reading."""
        if words not in self.assumed:
            self.assumed.append(words)

    @property
    def said(self) -> str:
        """The assumptions, in one line that begins with the file; "" for a plain table in SI."""
        return f"{self.path}: {'; '.join(self.assumed)}" if self.assumed else ""


def scaled(numbers: Array, own: Unit, expected: Unit) -> Array:
    """Numbers in another unit; by a power of ten as on paper, to the last bit."""
    by = own.factor / expected.factor
    inverse = round(1.0 / by) if by < 1.0 else 0
    return numbers / inverse if inverse and abs(inverse * by - 1.0) < 1e-12 else numbers * by


def read_table(path: Path) -> DataTable:
    """Read a table from a file; CsvError, one line with the file, if it cannot be read.

    CsvError also if the record of a run next to it is of another file.
    """
    data = file_bytes(path)
    if why := record_conflict(path):
        raise CsvError(path, why)
    return table_of(data, path)


def table_of(data: bytes, path: Path) -> DataTable:
    """Table in the bytes of a file."""
    if data.startswith(PARQUET):
        return parquet_table(data, path)
    text, encoding = decoded(data, path)
    layout = layout_of(text, path)
    table = DataTable(path, layout.names, layout, assumed=[*([f"is in {encoding}"] if encoding else []),
                                                           *layout.assumed])
    counts = {line.count(layout.separator) + 1 for line in layout.body.split("\n")}
    if layout.separator == " " or '"' in layout.body or counts != {len(layout.names)}:
        table.require_full_rows()
    return table


def parquet_table(data: bytes, path: Path) -> DataTable:
    """Table of a Parquet file; CsvError, with the install command, if pandas (extra `data`) is missing."""
    if missing := lacking("pandas", "data", "what is Parquet"):
        raise CsvError(path, f"is Parquet, expected a CSV file; {missing}")
    return given_table(str(path), import_module("pandas").read_parquet(BytesIO(data)))


def given_table(name: str, given: Any) -> DataTable:
    """Columns of a mapping, such as a `Run`, or of a DataFrame, of whatever library.

    An index that is called time, or has time stamps, is the column time. CsvError if a column is no row, or they are
    not of one length; whether they are numbers is asked of those that are used.
    """
    path = Path(name)
    try:
        names = [str(name) for name in getattr(given, "columns", given)]
        columns = {name: np.asarray(given[name]) for name in names}
    except (TypeError, ValueError, KeyError, IndexError) as error:
        raise CsvError(path, f"{type(given).__name__}: {error}, expected a path, or columns of numbers by name, such "
                             "as a Run, a table of arrays or a DataFrame") from None
    index = getattr(given, "index", None)
    stamped = getattr(getattr(index, "dtype", None), "kind", "") in "mM"
    if getattr(index, "name", None) != "time" and not stamped:
        index = None
    time = getattr(given, "time", index)
    if "time" not in columns and time is not None:
        columns["time"] = np.asarray(time.to_numpy("datetime64[ns]") if getattr(time, "tz", None) else time)
    for column, values in columns.items():
        if values.ndim != 1 or len(values) != len(columns[names[0]]):
            raise CsvError(path, f"column {column} has the shape {values.shape}, expected as many rows as {names[0]}, "
                                 f"{len(np.atleast_1d(columns[names[0]]))}")
    return DataTable(path, list(columns), given=columns)
