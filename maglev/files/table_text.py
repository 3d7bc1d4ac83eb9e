"""Text of a file of a table, in whatever encoding it is."""

import re
from pathlib import Path

from maglev.files.errors import CsvError, nearest_file
from maglev.files.regular_file import regular

# Marks at the beginning, the longest first.
MARKS = ((b"\xff\xfe\0\0", "utf-32", "UTF-32"), (b"\0\0\xfe\xff", "utf-32", "UTF-32"),
         (b"\xef\xbb\xbf", "utf-8-sig", ""), (b"\xff\xfe", "utf-16", "UTF-16"), (b"\xfe\xff", "utf-16", "UTF-16"))
OTHER_FORMATS = {b"PK\x03\x04": "is an archive or a workbook", b"\xd0\xcf\x11\xe0": "is a workbook",
                 b"\x89HDF": "is HDF5", b"MATLAB 5.0": "is a MAT file", b"\x1f\x8b": "is compressed"}
NO_TEXT = "is not text, expected a CSV file: export the data as CSV in UTF-8"
CONTROLS = re.compile(r"[\0-\x08\x0e-\x1f\x7f-\x84\x86-\x9f]")   # in no text; of Latin-1 as well
ENOUGH = 4096   # bytes that tell an encoding


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
