"""Environment variables that hold numbers."""

import os
from collections.abc import Mapping
from typing import NamedTuple

DATE = "SOURCE_DATE_EPOCH"
MOST_UNPACKED = "MAGLEV_MOST_UNPACKED"


class Number(NamedTuple):
    """A whole number from 0 on: its default without the variable, its least value, and the thing that it counts."""

    default: int
    limit: int
    what: str


NUMBERS: Mapping[str, Number] = {
    # 2026-01-01 without it; a zip archive cannot hold 2108-01-01.
    DATE: Number(1767225600, 4354819200, "seconds since 1970 as a whole number, before 2108"),
    MOST_UNPACKED: Number(1_000_000_000, 1 << 63, "bytes as a whole number, such as 1000000000")}


def number_in(variable: str) -> int:
    """Number in one of these variables; its default if it is not set, or empty. ValueError if it is no number."""
    default, limit, what = NUMBERS[variable]
    text = os.environ.get(variable) or str(default)
    if not (text.isascii() and text.isdigit() and len(text) <= len(str(limit)) and int(text) < limit):
        raise ValueError(f"{variable} = {text!r}, expected {what}")
    return int(text)


def require_numbers() -> None:
    """Raise ValueError if a variable is no number; remove empty ones, because numpy would read them as numbers."""
    for variable in NUMBERS:
        number_in(variable)
        if not os.environ.get(variable, "0"):
            del os.environ[variable]
