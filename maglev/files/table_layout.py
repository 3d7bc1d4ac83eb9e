"""Text of a table in whatever encoding, and its layout: separators, decimal marks, header, units, other lines."""

import csv
import re
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from maglev.files.errors import CsvError, nearest_file, shortened
from maglev.files.regular_file import regular
from maglev.files.table_columns import is_number, is_time_stamp, unit_word

SEPARATORS = {",": "commas", ";": "semicolons", "\t": "tabs", "|": "bars", " ": "blanks"}
COMMENTS = ("#", "%", "//", '"#')   # beginnings of comment lines
SAMPLE = 300   # lines that tell the layout
FOOTER = 30    # lines at the end that may be no rows
NAMES = "expected the names of the columns, such as time,v,h,i_d,i_q"

# Marks at the beginning, the longest first.
MARKS = ((b"\xff\xfe\0\0", "utf-32", "UTF-32"), (b"\0\0\xfe\xff", "utf-32", "UTF-32"),
         (b"\xef\xbb\xbf", "utf-8-sig", ""), (b"\xff\xfe", "utf-16", "UTF-16"), (b"\xfe\xff", "utf-16", "UTF-16"))
OTHER_FORMATS = {b"PK\x03\x04": "is an archive or a workbook", b"\xd0\xcf\x11\xe0": "is a workbook",
                 b"\x89HDF": "is HDF5", b"MATLAB 5.0": "is a MAT file", b"\x1f\x8b": "is compressed"}
NO_TEXT = "is not text, expected a CSV file: export the data as CSV in UTF-8"
CONTROLS = re.compile(r"[\0-\x08\x0e-\x1f\x7f-\x84\x86-\x9f]")   # in no text; of Latin-1 as well
ENOUGH = 4096   # bytes that tell an encoding


class Row(NamedTuple):
    """Fields of a row, and the number of its last line in the file; the first line is 1."""

    line: int
    fields: list[str]


class Layout(NamedTuple):
    """A table in a text: its columns, and the lines of its rows."""

    separator: str
    decimal: str
    names: list[str]        # as in the header, one for each field of a row; "" of one without a name
    units: dict[str, str]   # by name, of a row of units below the header
    before: int             # lines before the first row
    body: str               # lines of the rows, and of comments between them
    assumed: tuple[str, ...]   # differences from a plain CSV, in words

    def rows(self) -> Iterator[Row]:
        """The rows below the header."""
        return parsed(self.body.split("\n"), self.separator, self.before)


def parsed(lines: Iterable[str], separator: str, before: int = 0) -> Iterator[Row]:
    """Rows of lines that are no comments and not blank; csv.Error if they are no CSV."""
    blank = ("" if line.startswith(COMMENTS) and separator != line[0] else line for line in lines)
    if separator == " ":
        blank = (" ".join(line.split()) for line in blank)
    reader = csv.reader((f"{line}\n" for line in blank), delimiter=separator, skipinitialspace=True)
    for fields in reader:
        stripped = [" ".join(field.split()) for field in fields]
        if any(stripped):
            yield Row(before + reader.line_num, stripped)


def layout_of(text: str, path: Path) -> Layout:
    """Find out how a text is laid out; CsvError, which names the line, if it is no table with a header."""
    lines = text.split("\n")
    head = lines[:SAMPLE]
    if not any(line.strip() for line in lines):
        raise CsvError(path, "is empty, expected a CSV file with a header and rows")
    try:
        separator, decimal, rows = best_separator(head)
        width = width_of(rows)
        if width < 2:
            raise CsvError(path, "has one column, expected a CSV file with a header and columns separated by commas")
        numeric = numeric_columns(rows, width, decimal)
        header, units, begin, in_comment = header_of(rows, width, numeric, decimal, head, separator, path)
        end = begin + end_of(lines[begin:], width, numeric, decimal, separator)
    except csv.Error as error:
        raise CsvError(path, f"{error}, expected a CSV file") from None
    names = [*header, *[""] * (width - len(header))]
    for name in names:
        if name and names.count(name) > 1:
            line = next((row.line for row in rows if row.fields == header), 1)
            raise CsvError(path, f"row {line} has the column {name!r} {names.count(name)} times, expected it once")
    comments = sum(line.startswith(COMMENTS) for line in lines[:begin])
    above = comments + sum(row.line <= begin for row in rows) - 1 - bool(units)
    below = sum(bool(line.strip()) for line in lines[end:])
    left_out = " and ".join(f"{count} line{'' if count == 1 else 's'} {where}" for count, where in
                            ((above, "above the header"), (below, "below the rows")) if count > 0)
    assumed = [*([f"columns are separated by {SEPARATORS[separator]}"] if separator != "," else []),
               *(["numbers have decimal commas"] if decimal == "," else []),
               *(["the header is in a comment"] if in_comment else []),
               *([f"{left_out} {'is' if above + below == 1 else 'are'} left out"] if left_out else [])]
    by_name = {name: unit for name, unit in zip(names, units, strict=False) if unit}
    return Layout(separator, decimal, names, by_name, begin, "\n".join(lines[begin:end]), tuple(assumed))


def best_separator(lines: Sequence[str]) -> tuple[str, str, list[Row]]:
    """Return the separator and the decimal mark that make the largest share of fields numbers, and the rows.

    A field can have several numbers, the elements of an array. Where shares are equal, a row of as many names decides.
    """
    best: tuple[tuple[float, bool], str, str, list[Row]] = ((-1.0, False), ",", ".", [])
    for separator in SEPARATORS:
        rows = list(parsed(lines, separator))
        width = width_of(rows)
        sample = [field for row in rows[1:] if len(row.fields) == width for field in row.fields if field]
        named = any(len(row.fields) == width and not any(is_number(field, ".") for field in row.fields) for row in rows)
        for decimal in ".,":
            share = sum(is_time_stamp(field) or all(is_number(part, decimal) for part in field.split(" "))
                        for field in sample) / max(len(sample), 1)
            if width > 1 and (share, named) > best[0]:
                best = (share, named), separator, decimal, rows
    return (*best[1:3], best[3] or list(parsed(lines, ",")))


def width_of(rows: Sequence[Row]) -> int:
    """Number of fields that most rows with more than one have; 1 without any."""
    counts = Counter(len(row.fields) for row in rows if len(row.fields) > 1)
    return max(counts, key=lambda count: (counts[count], count), default=1)


def numeric_columns(rows: Sequence[Row], width: int, decimal: str) -> list[int]:
    """Columns that are numbers or time stamps in at least half of the rows below the first."""
    below = [row.fields for row in rows[1:] if len(row.fields) == width]
    return [k for k in range(width) if below and 2 * sum(
        is_number(fields[k], decimal) or is_time_stamp(fields[k]) for fields in below) >= len(below)]


def header_of(rows: Sequence[Row], width: int, numeric: Sequence[int], decimal: str, head: Sequence[str],
              separator: str, path: Path) -> tuple[list[str], list[str], int, bool]:
    """Names, units of a row of them, the number of lines before the first row, and whether a comment has the names."""
    def numbers(row: Row) -> int:
        return sum(is_number(field, decimal) or is_time_stamp(field) for field in row.fields)

    first = next((k for k, row in enumerate(rows) if len(row.fields) == width and numeric
                  and all(not row.fields[i] or is_number(row.fields[i], decimal) or is_time_stamp(row.fields[i])
                          for i in numeric) and numbers(row)), len(rows) if numeric else 1)
    names = [k for k, row in enumerate(rows[:first]) if not numbers(row) and width - 1 <= len(row.fields) <= width]
    if not names and numeric:   # a name can look like a number, where that of the first column does not
        names = [k for k, row in enumerate(rows[:first]) if len(row.fields) == width
                 and not is_number(row.fields[numeric[0]], decimal) and not is_time_stamp(row.fields[numeric[0]])][-1:]
    units: list[str] = []
    if len(names) > 1 and all(bare_unit(field) is not None for field in rows[names[-1]].fields):
        units = [bare_unit(field) or "" for field in rows[names.pop()].fields]
    if names and len(rows) == names[-1] + 1 + bool(units):
        raise CsvError(path, "has a header only, expected rows of numbers")
    if names:
        last = names[-1] + bool(units)
        if len(rows[names[-1]].fields) < width and any(row.fields[-1] for row in rows[first:]):
            names.clear()   # a column without a name
        else:
            return rows[names[-1]].fields, units, rows[last].line, False
    for k in range(rows[first].line - 2 if first < len(rows) else len(head) - 1, -1, -1):   # as NumPy writes it
        comment = next((mark for mark in COMMENTS if head[k].startswith(mark)), None)
        if comment is not None:
            row = next(parsed([head[k].removeprefix(comment).strip()], separator), Row(0, []))
            if len(row.fields) == width and not numbers(row):
                return row.fields, [], k + 1, True
    other = next((row for row in rows[:first] if not numbers(row) and len(row.fields) > 1), None)
    if other is not None and first < len(rows):
        raise CsvError(path, f"row {rows[first].line} has {width} values, expected {len(other.fields)} as in the "
                             "header; decimal commas need semicolons or tabs between columns")
    first_row = "numbers" if numbers(rows[0]) else shortened(rows[0].fields)
    raise CsvError(path, f"row {rows[0].line} is {first_row}, {NAMES}")


def bare_unit(field: str) -> str | None:
    """Unit that a field of a row of units is, with or without brackets."""
    return unit_word(field.strip("[](){} "))


def end_of(lines: Sequence[str], width: int, numeric: Sequence[int], decimal: str, separator: str) -> int:
    """Return the number of lines to the last row; final lines without a number where each row has one are no rows."""
    start = max(0, len(lines) - FOOTER)
    rows = list(parsed(lines[start:], separator, start))
    if not numeric:
        return len(lines)
    for row in reversed(rows):
        field = row.fields[numeric[0]] if numeric[0] < len(row.fields) else ""
        if is_number(field, decimal) or is_time_stamp(field) or (not field and len(row.fields) == width):
            return row.line
    return len(lines)


def file_bytes(path: Path) -> bytes:
    """Content of a regular file; CsvError if it cannot be read, or is a pipe or a device, which may never end."""
    try:
        if path.is_dir():
            raise CsvError(path, "is a folder, expected a file")
        return regular(path).read_bytes()
    except OSError as error:
        raise CsvError(path, f"cannot be read: {error.strerror}{nearest_file(path)}") from None


def decoded(data: bytes, path: Path) -> tuple[str, str]:
    """Return the text with plain line ends, and its encoding if that is not UTF-8; CsvError if it is no text."""
    for begin, what in OTHER_FORMATS.items():
        if data.startswith(begin):
            raise CsvError(path, f"{what}, expected a CSV file: export the data as CSV")
    codec, name = next(((codec, name) for mark, codec, name in MARKS if data.startswith(mark)), ("utf-8", ""))
    start = data[:ENOUGH]
    if codec == "utf-8" and b"\0" in start:   # UTF-16 without a mark: every other byte of digits is 0
        low, high = start[::2].count(0), start[1::2].count(0)
        codec, name = ("utf-16-le" if high > low else "utf-16-be"), "UTF-16"
        if max(low, high) < len(start) // 4 or min(low, high):
            raise CsvError(path, NO_TEXT)
    try:
        text = data.decode(codec)
    except UnicodeDecodeError:
        if codec != "utf-8":
            raise CsvError(path, NO_TEXT) from None
        text, name = data.decode("latin-1"), "Latin-1"
    if CONTROLS.search(text):
        raise CsvError(path, NO_TEXT)
    return text.replace("\r\n", "\n").replace("\r", "\n"), name
