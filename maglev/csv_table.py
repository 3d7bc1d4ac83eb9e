"""A CSV file with a header, columns read on demand."""

import csv
from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from maglev.errors import IdentificationError, nearest_file

Array = NDArray[np.float64]


@dataclass(frozen=True)
class CsvTable:
    """Names and numbers of a CSV file; a refusal names file, column, row and value."""

    path: Path
    names: Sequence[str]
    columns: dict[str, Array] = field(default_factory=dict)

    def column(self, name: str) -> Array:
        """Numbers of a column, all finite.

        Raises
        ------
        IdentificationError
            If a field is missing or no finite number.
        """
        if name not in self.columns:
            index = list(self.names).index(name)
            try:
                values = np.loadtxt(self.path, delimiter=",", skiprows=1, usecols=index, ndmin=1, comments=None,
                                    encoding="utf-8-sig")
            except ValueError:
                values = None
            if values is None or not np.all(np.isfinite(values)):
                raise self.first_bad(index)
            self.columns[name] = values
        return self.columns[name]

    def first_bad(self, index: int) -> IdentificationError:
        """Refusal of the first field of a column that is no finite number."""
        with self.path.open(newline="", encoding="utf-8-sig") as file:
            reader = csv.reader(file)
            for row in islice(reader, 1, None):
                text = row[index] if index < len(row) else ""
                try:
                    good = bool(np.isfinite(float(text)))
                except ValueError:
                    good = not row
                if not good:
                    return IdentificationError(f"{self.path}: row {reader.line_num}, column {self.names[index]} is "
                                               f"{text!r}, expected a finite number")
        return IdentificationError(f"{self.path}: column {self.names[index]}: expected finite numbers")

    def refusal(self, name: str, k: int, expectation: str) -> IdentificationError:
        """Refusal of the k-th number of a column; the header is row 1 of the file."""
        return IdentificationError(f"{self.path}: row {k + 2}, column {name} is {self.columns[name][k]:.9g}, "
                                   f"{expectation}")


def read_csv(path: Path) -> CsvTable:
    """Open a CSV file: a header with unique names, then rows of numbers.

    Raises
    ------
    IdentificationError
        If it is missing, no CSV text, or has no header or no rows.
    """
    try:
        with path.open("rb") as file:
            start = file.read(4096)
        if b"\0" in start:
            raise UnicodeDecodeError("utf-8", start, 0, 1, "binary")
        with path.open(newline="", encoding="utf-8-sig") as text:
            reader = csv.reader(text)
            header = [name.strip() for name in next(reader, [])]
            rows = any(row for row in reader)
    except UnicodeDecodeError:
        raise IdentificationError(f"{path}: no text, expected a CSV file with a header and columns separated by "
                                  "commas: export the data as CSV") from None
    except csv.Error as error:
        raise IdentificationError(f"{path}: {error}, expected a CSV file") from None
    except OSError as error:
        raise IdentificationError(f"{path}: cannot be read: {error.strerror}{nearest_file(path)}") from None
    if len(header) < 2:
        separator = next((mark for mark in (";", "\t") if header and mark in header[0]), None)
        found = "is empty" if not header else "has one column" if separator is None else (
            f"has columns separated by {separator!r}")
        raise IdentificationError(f"{path}: {found}, expected a CSV file with a header and columns separated by commas")
    if all(is_number(name) for name in header):
        raise IdentificationError(f"{path}: row 1 is numbers, expected the names of the columns, such as "
                                  "time,v,h,i_d,i_q")
    for name in header:
        if header.count(name) > 1:
            raise IdentificationError(f"{path}: row 1 has the column {name!r} {header.count(name)} times, expected it "
                                      "once")
    if not rows:
        raise IdentificationError(f"{path}: has a header only, expected rows of numbers")
    return CsvTable(path, header)


def is_number(text: str) -> bool:
    """Whether a text is a number."""
    try:
        float(text)
    except ValueError:
        return False
    return True
