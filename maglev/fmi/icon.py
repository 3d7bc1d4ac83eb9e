"""Icon of an FMU from filled polygons: as PNG, drawn here so that a build needs no graphics library, and as SVG."""

import math
import struct
import zlib
from collections.abc import Iterable, Sequence
from functools import lru_cache
from itertools import pairwise

import numpy as np

UNITS = 100    # width and height of the plane that icons are drawn in; y grows downwards
SIZE = 128     # pixels of the PNG
SAMPLES = 4    # to a pixel, along each side

Point = tuple[float, float]
Shape = tuple[str, tuple[Point, ...]]   # colour "#rrggbb" and corners; later ones lie on top


def rectangle(x: float, y: float, width: float, height: float, colour: str) -> Shape:
    """Rectangle by its upper left corner."""
    return colour, ((x, y), (x + width, y), (x + width, y + height), (x, y + height))


def disc(x: float, y: float, radius: float, colour: str) -> Shape:
    turns = [2.0 * math.pi * k / 24 for k in range(24)]
    return colour, tuple((round(x + radius * math.cos(turn), 3), round(y + radius * math.sin(turn), 3))
                         for turn in turns)


def stroke(points: Sequence[Point], width: float, colour: str) -> list[Shape]:
    """Line through points, with round ends and corners."""
    shapes = [disc(x, y, width / 2, colour) for x, y in points]
    for (x0, y0), (x1, y1) in pairwise(points):
        scale = width / 2 / math.hypot(x1 - x0, y1 - y0)
        across, up = round(scale * (y0 - y1), 3), round(scale * (x1 - x0), 3)
        shapes.append((colour, ((x0 + across, y0 + up), (x1 + across, y1 + up), (x1 - across, y1 - up),
                                (x0 - across, y0 - up))))
    return shapes


@lru_cache(maxsize=64)
def png_icon(shapes: tuple[Shape, ...]) -> bytes:
    """PNG of shapes on white, SIZE × SIZE pixels, with smooth edges."""
    fine = np.full((SIZE * SAMPLES, SIZE * SAMPLES, 3), 255, dtype=np.uint8)
    for colour, corners in shapes:
        fill(fine, np.array(corners) * (SIZE * SAMPLES / UNITS), bytes.fromhex(colour[1:]))
    whole = fine.reshape(SIZE, SAMPLES, SIZE, SAMPLES, 3).astype(np.uint32).sum(axis=(1, 3)) // SAMPLES**2
    header = struct.pack(">IIBBBBB", SIZE, SIZE, 8, 2, 0, 0, 0)   # 8 bits, RGB
    pixels = zlib.compress(b"".join(b"\x00" + row.tobytes() for row in whole.astype(np.uint8)), 9)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", pixels) + chunk(b"IEND", b"")


def fill(picture: np.ndarray, corners: np.ndarray, colour: Iterable[int]) -> None:
    """Fill a polygon; its corners in samples, shape (n, 2)."""
    low = np.maximum(np.floor(corners.min(axis=0)).astype(int), 0)
    high = np.minimum(np.ceil(corners.max(axis=0)).astype(int), len(picture))
    x, y = np.arange(low[0], high[0]) + 0.5, (np.arange(low[1], high[1]) + 0.5)[:, None]
    inside = np.zeros((high[1] - low[1], high[0] - low[0]), dtype=bool)
    for (x0, y0), (x1, y1) in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        if y0 != y1:   # a ray to the right crosses the edges on its way out an odd number of times
            inside ^= ((y0 > y) != (y1 > y)) & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
    picture[low[1]:high[1], low[0]:high[0]][inside] = tuple(colour)


def chunk(kind: bytes, content: bytes) -> bytes:
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))


def svg_icon(shapes: Iterable[Shape], attributes: str = 'class="icon" aria-hidden="true"') -> str:
    """Return the icon as SVG for a page, next to the name, where screen readers skip it by default."""
    paths = "".join(f'<path fill="{colour}" d="M{"L".join(f"{x:.3g} {y:.3g}" for x, y in corners)}Z"/>'
                    for colour, corners in shapes)
    return (f'<svg {attributes} viewBox="0 0 {UNITS} {UNITS}">'
            f'<rect width="{UNITS}" height="{UNITS}" fill="#ffffff"/>{paths}</svg>')


def svg_file(shapes: Iterable[Shape]) -> bytes:
    drawn = svg_icon(shapes, f'xmlns="http://www.w3.org/2000/svg" width="{SIZE}" height="{SIZE}"')
    return f"{drawn}\n".encode()
