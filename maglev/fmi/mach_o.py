"""Universal binaries of macOS: several libraries, each for one processor, behind a common header."""

import struct
from collections.abc import Sequence

FAT_MAGIC = 0xCAFEBABE      # of the header, which is big-endian
MACH_MAGIC = 0xFEEDFACF     # of a 64-bit library, in its own byte order
ALIGNMENT = 14              # power of two, by which each library is placed: a page of arm64


def universal(libraries: Sequence[bytes]) -> bytes:
    """Universal binary of 64-bit Mach-O libraries, little-endian."""
    header = struct.pack(">II", FAT_MAGIC, len(libraries))
    result = bytearray(1 << ALIGNMENT)   # in which the header has its place
    for library in libraries:
        magic, processor, variant = struct.unpack_from("<III", library)
        if magic != MACH_MAGIC:
            raise ValueError(f"library begins with {magic:#x}, expected a 64-bit Mach-O library, {MACH_MAGIC:#x}")
        result += bytes(-len(result) % (1 << ALIGNMENT))
        header += struct.pack(">IIIII", processor, variant, len(result), len(library), ALIGNMENT)
        result += library
    result[:len(header)] = header
    return bytes(result)
