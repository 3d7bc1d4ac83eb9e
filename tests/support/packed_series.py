"""Signals of the page unpacked as its script does it, to compare them with what was packed."""

import base64
import gzip
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.files.arrays import Array


def unpack(packed: Mapping[str, Any]) -> dict[str, tuple[Array, Array]]:
    """Times (s) and values (SI) by signal, each of shape (k,), of what `pack` made; the page does the same."""
    data = gzip.decompress(base64.b64decode(packed["data"]))
    unpacked = {}
    start = 0
    for name, signal in packed["signals"].items():
        size = 4 * signal["rows"]
        times = decode(data[start:start + size]) * packed["time"]
        unpacked[name] = (times, decode(data[start + size:start + 2 * size]) * signal["quantum"])
        start += 2 * size
    return unpacked


def decode(data: bytes) -> NDArray[np.int64]:
    """Read what `encode` wrote; the page does the same."""
    planes = np.frombuffer(data, dtype=np.uint8).reshape(4, -1)
    bits = np.ascontiguousarray(planes.T).view("<u4")[:, 0].astype(np.int64)
    return np.cumsum(np.where(bits % 2 == 0, bits // 2, -(bits // 2) - 1), dtype=np.int64)
