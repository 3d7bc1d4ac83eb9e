"""Names, units and numbers of columns as people write them."""

import re
from collections.abc import Sequence

import numpy as np

from maglev.files.arrays import Array
from maglev.files.units import known_unit, with_hyphen, written_out

NUMBER = re.compile(r"[+\-\N{MINUS SIGN}]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+\-\N{MINUS SIGN}]?\d+)?")
NO_NUMBER = re.compile(r"[+-]?(?:nan|inf|infinity|n/a|#n/a|null)", re.IGNORECASE)   # instead of one
FORTRAN = re.compile(r"(?<=[\d.])[dD](?=[+-]?\d)")
DAY = re.compile(r"\d{4}-\d\d-\d\d(?:[T ]\d\d:\d\d.*)?")
TIME_OF_DAY = re.compile(r"\d\d?:\d\d:\d\d(?:[.,]\d+)?")

BRACKETS = re.compile(r"(.*?\S)(\s*)[\[(<{]\s*([^\[(<{]*?)\s*[\])>}]")
AFTER_MARK = re.compile(r"(.*\S)(?:\s+/\s*|\s*/\s+|\s*,\s+)(\S+)")
SUFFIX = re.compile(r"(.+)_(ms|us|µs|ns|mm|um|µm|nm|cm|mA|mrad|urad|µrad|deg)|((?i:t|time|timestamp))_(s|sec)")


def is_number(text: str, decimal: str = ".") -> bool:
    """Return True if a field is a number, or stands for one that is missing."""
    plain = text if decimal == "." else text.replace(",", ".") if "." not in text else ""
    return NUMBER.fullmatch(plain) is not None or NO_NUMBER.fullmatch(text) is not None


def is_time_stamp(text: str) -> bool:
    return DAY.fullmatch(text) is not None or TIME_OF_DAY.fullmatch(text) is not None


def numbers_of(texts: Sequence[str], decimal: str = ".") -> Array:
    """Numbers of fields, with a decimal comma, a minus sign or Fortran's exponent; ValueError if one is no number."""
    joined = "\n".join(texts)
    if decimal == ",":
        if "." in joined:
            raise ValueError(joined)
        joined = joined.replace(",", ".")
    joined = with_hyphen(joined)
    try:
        numbers = np.array(joined.split("\n"), dtype=np.float64)
    except ValueError:
        numbers = np.array(FORTRAN.sub("e", joined).split("\n"), dtype=np.float64)
    if len(numbers) != len(texts):   # a line break in a field
        raise ValueError(joined)
    return numbers


def unit_word(text: str) -> str | None:
    """Unit that a word means; "" for a word for no unit, such as "-"; None if the word is no unit."""
    if text in ("", "-", "–", "1"):
        return ""
    return text if known_unit(text) is not None else written_out(text)


def split_name(header: str) -> tuple[str, str]:
    """Name and unit of a column, as in "v [mm]", "time (s)", "v / mm", "time_ms"; without a unit it is "".

    A unit that is not known stays as it is, if there is a space before its brackets.
    """
    if match := BRACKETS.fullmatch(header):
        name, space, word = match.groups()
        unit = unit_word(word)
        if unit is not None and not word.isdigit():
            return name, unit
        return (name, word) if space and not word.isdigit() else (header, "")
    if match := AFTER_MARK.fullmatch(header):
        unit = unit_word(match[2])
        return (match[1], unit) if unit else (header, "")
    if match := SUFFIX.fullmatch(header):
        return (match[1], match[2]) if match[1] else (match[3], "s")
    return header, ""
