"""Text of a user's file for the languages that an FMU consists of: a function for each.

HTML is left to `html.escape`, the marks of XML to `xml.etree`, those of CSV to `csv.writer`, a shell to `shlex.join`.
TOML and the terminal, which FMUs have nothing of, are in `maglev.files.errors`: `quoted` and `visible`.
"""

import re
from html import escape

# Everything but the characters of XML 1.0, section 2.2: no parser accepts the rest, escaped or not.
NO_XML = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def c_string(text: str) -> str:
    """C string literal, in UTF-8 and without anything that its source's encoding could change.

    The escapes are octal: unlike hexadecimal ones they have an end.
    """
    return '"' + "".join(chr(byte) if 32 <= byte <= 126 and byte not in b'"\\?' else f"\\{byte:03o}"
                         for byte in text.encode("utf-8")) + '"'


def c_comment(text: str) -> str:
    """Text in one line, which a backslash could join to the next, that neither ends a C comment nor begins one."""
    return re.sub(r"\s", " ", text).replace("*/", "* /").replace("/*", "/ *")


def page_text(text: str) -> str:
    """HTML in which no equation begins: for a page whose TeX is yet to be typeset."""
    return escape(text).replace("\\", "&#92;")


def csv_text(text: str) -> str:
    """Return the text of a CSV cell that no spreadsheet takes for a formula; a number does not change."""
    try:
        float(text)
    except ValueError:
        return f"'{text}" if text.lstrip()[:1] in ("=", "+", "-", "@") else text
    return text


def xml_text(text: str) -> str:
    """Text without the characters that no XML can hold."""
    return NO_XML.sub("", text)
