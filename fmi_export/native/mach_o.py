"""Universal binaries of macOS: several libraries, each for one processor, behind a common header."""

import struct
from collections.abc import Sequence
from typing import NamedTuple

FAT_MAGIC = 0xCAFEBABE      # of the header, which is big-endian
MACH_MAGIC = 0xFEEDFACF     # of a 64-bit library, in its own byte order
ALIGNMENT = 14              # power of two, by which each library is placed: a page of arm64


class Slice(NamedTuple):
    """Where a library lies in a universal binary."""

    processor: int
    variant: int
    offset: int
    size: int
    alignment: int


def universal(libraries: Sequence[bytes]) -> bytes:
    """Universal binary of 64-bit Mach-O libraries, little-endian."""
    slices = []
    offset = 1 << ALIGNMENT
    for library in libraries:
        magic, processor, variant = struct.unpack_from("<III", library)
        if magic != MACH_MAGIC:
            raise ValueError(f"library begins with {magic:#x}, expected a 64-bit Mach-O library, {MACH_MAGIC:#x}")
        slices.append(Slice(processor, variant, offset, len(library), ALIGNMENT))
        offset = (offset + len(library) + (1 << ALIGNMENT) - 1) >> ALIGNMENT << ALIGNMENT
    result = bytearray(struct.pack(">II", FAT_MAGIC, len(slices)))
    for piece in slices:
        result += struct.pack(">IIIII", *piece)
    for piece, library in zip(slices, libraries, strict=True):
        result += bytes(piece.offset - len(result)) + library
    return bytes(result)
