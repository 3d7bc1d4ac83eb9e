"""The digest of a run: of which bytes, and that its file says the same."""

import hashlib
import math
import struct
from pathlib import Path

import numpy as np
import pytest

from maglev.baselines.baseline import Digest, digest_file, digest_of, read_digest, write_digest
from maglev.errors import BaselineError


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
    write_digest(tmp_path, "mine", digest)
    assert read_digest(tmp_path, "mine") == digest
    assert digest_file(tmp_path, "mine").read_bytes() == f"{digest.sha256}  12 signals at 130001 samples\n".encode()
    digest_file(tmp_path, "mine").write_text(f"{digest.sha256}  12 signals at 130001 samples\n", encoding="utf-8-sig")
    assert read_digest(tmp_path, "mine") == digest, "as editors on Windows write it"
    assert read_digest(tmp_path, "other") is None
    write_digest(tmp_path, "mine", None)
    assert read_digest(tmp_path, "mine") is None
    write_digest(tmp_path, "mine", None)


@pytest.mark.parametrize("text", ["", "0123  1 signals at 2 samples\n", "not a digest", "\xe4" * 64])
def test_another_file_is_refused(tmp_path: Path, text: str) -> None:
    digest_file(tmp_path, "mine").write_text(text, encoding="utf-8")
    with pytest.raises(BaselineError, match=r"mine_ref.sha256: not a digest, expected .* `maglev check --update`"):
        read_digest(tmp_path, "mine")
