"""Icon of an FMU: coloured rectangles as a PNG, written here so that a build needs no graphics library."""

import struct
import zlib
from collections.abc import Iterable

SIZE = 200   # pixels


def png_icon(rectangles: Iterable[tuple[int, int, int, int, str]]) -> bytes:
    """PNG of rectangles (x, y, width, height, "#rrggbb") on white, SIZE × SIZE pixels, later ones on top."""
    rows = [bytearray(b"\xff\xff\xff" * SIZE) for _ in range(SIZE)]
    for x, y, width, height, colour in rectangles:
        for row in rows[y:y + height]:
            row[3 * x:3 * (x + width)] = bytes.fromhex(colour[1:]) * width
    header = struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)   # 8 bits, RGB
    pixels = zlib.compress(b"".join(b"\x00" + bytes(row) for row in rows), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def chunk(kind: bytes, content: bytes) -> bytes:
    """One PNG chunk."""
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
