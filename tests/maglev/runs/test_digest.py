"""The digest of a run: of which bytes, and that their file says the same."""

import hashlib
import math
import struct
from pathlib import Path

import numpy as np
import pytest
from facts import raises

from maglev.files.errors import BaselineError
from maglev.runs.baseline_file import DIGESTS, Digest, digest_of, read_digests, write_digests


def test_it_is_of_names_and_little_endian_doubles_in_order_of_names() -> None:
    time = np.array([0.0, 0.5])
    columns = {"b.flag": np.array([True, False]), "a.\N{GREEK SMALL LETTER MU}": np.array([-0.0, 1e-300])}
    found = digest_of(time, columns)
    stream = (b"time\0" + struct.pack("<2d", 0.0, 0.5)
              + b"a.\xce\xbc\0" + struct.pack("<2d", -0.0, 1e-300) + b"b.flag\0" + struct.pack("<2d", 1.0, 0.0))
    assert found == Digest(hashlib.sha256(stream).hexdigest(), 2, 2)


def test_the_sign_of_what_is_no_number_does_not_count() -> None:
    one, other = (digest_of(np.array([0.0]), {"a": np.array([value])}) for value in (math.nan, -math.nan))
    assert one == other


def test_there_and_back(tmp_path: Path) -> None:
    digest = Digest("0123456789abcdef" * 4, 12, 130_001)
    assert read_digests(tmp_path) == {}
    write_digests(tmp_path, {"mine": digest, "her-own": digest})
    assert read_digests(tmp_path) == {"her-own": digest, "mine": digest}
    lines = "".join(f"{digest.sha256}  {name}: 12 signals at 130001 samples\n" for name in ("her-own", "mine"))
    assert (tmp_path / DIGESTS).read_bytes() == lines.encode()
    (tmp_path / DIGESTS).write_text(lines, encoding="utf-8-sig")
    assert read_digests(tmp_path)["mine"] == digest, "as editors on Windows write it"
    write_digests(tmp_path, {"mine": None, "nobody's": None})
    assert read_digests(tmp_path) == {"her-own": digest}


GOOD = f"{'0' * 64}  mine: 1 signals at 2 samples\n"


@pytest.mark.parametrize(("text", "line"), [
    ("0123  mine: 1 signals at 2 samples\n", 1), ("not a digest", 1), ("\xe4" * 64, 1), (f"{GOOD}{GOOD}", 2),
    (f"{GOOD}<<<<<<< HEAD\n", 2)])
def test_another_file_is_refused(tmp_path: Path, text: str, line: int) -> None:
    (tmp_path / DIGESTS).write_text(text, encoding="utf-8")
    for refused in (lambda: read_digests(tmp_path), lambda: write_digests(tmp_path, {"other": None})):
        with raises(BaselineError, tmp_path / DIGESTS, f"line {line}", "SHA-256"):
            refused()
    assert (tmp_path / DIGESTS).read_text(encoding="utf-8") == text
