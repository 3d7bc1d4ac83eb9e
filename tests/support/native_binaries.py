"""What stands in the binaries of Windows and macOS: processor, exported functions, imported libraries."""

import struct
from typing import NamedTuple

from maglev.fmi.compiler import FAT_MAGIC

PE32_PLUS = 0x20B
X86_64_WINDOWS = 0x8664
X86_64_MACOS, ARM64_MACOS = 0x01000007, 0x0100000C
FILE_IS_LIBRARY = 6                     # MH_DYLIB

LOAD_LIBRARY, SIGNATURE, LINKING, BUILD_VERSION, EXPORTS = 0xC, 0x1D, 0x22, 0x32, 0x33   # commands to the loader
REQUIRED = 0x80000000                   # in a command: a loader that does not know it gives up


class Slice(NamedTuple):
    """Where a library lies in a universal binary."""

    processor: int
    variant: int
    offset: int
    size: int
    alignment: int   # power of two


class Binary(NamedTuple):
    """What a loader sees of a library."""

    processor: int
    exports: set[str]
    libraries: set[str]      # that it needs
    signed: bool = False
    oldest_system: str = ""


def text_at(data: bytes, offset: int) -> str:
    """Text up to its zero byte."""
    return data[offset:data.index(b"\0", offset)].decode("ascii")


def windows_library(data: bytes) -> Binary:
    """A 64-bit PE library (Microsoft, PE Format)."""
    assert data[:2] == b"MZ"
    header, = struct.unpack_from("<I", data, 0x3C)
    assert data[header:header + 4] == b"PE\0\0"
    machine, sections, _, _, _, optional_size, characteristics = struct.unpack_from("<HHIIIHH", data, header + 4)
    assert characteristics & 0x2000, "not a DLL"
    optional = header + 24
    magic, = struct.unpack_from("<H", data, optional)
    assert magic == PE32_PLUS
    export_table, _, import_table, _ = struct.unpack_from("<IIII", data, optional + 112)
    table = [struct.unpack_from("<IIII", data, optional + optional_size + 40 * k + 8) for k in range(sections)]

    def place(address: int) -> int:
        """Offset in the file of an address in memory."""
        for size, start, raw_size, raw in table:
            if start <= address < start + max(size, raw_size):
                return address - int(start) + int(raw)
        raise AssertionError(f"address {address:#x} is in no section")

    count, _, names = struct.unpack_from("<III", data, place(export_table) + 24)
    exports = {text_at(data, place(struct.unpack_from("<I", data, place(names) + 4 * k)[0])) for k in range(count)}
    libraries = set()
    entry = place(import_table)
    while (name := struct.unpack_from("<I", data, entry + 12)[0]) != 0:
        libraries.add(text_at(data, place(name)))
        entry += 20
    return Binary(machine, exports, libraries)


def names_in_trie(trie: bytes, at: int = 0, prefix: str = "") -> set[str]:
    """Names of the exported symbols in a tree of their letters."""
    if not trie:
        return set()
    size, at = variable_length(trie, at)
    names = {prefix} if size else set()
    at += size
    children = trie[at]
    at += 1
    for _ in range(children):
        letters = text_at(trie, at)
        child, at = variable_length(trie, at + len(letters) + 1)
        names |= names_in_trie(trie, child, prefix + letters)
    return names


def variable_length(data: bytes, at: int) -> tuple[int, int]:
    """A number of seven bits per byte, the lowest first, and where it ends."""
    value = shift = 0
    while True:
        value |= (data[at] & 0x7F) << shift
        shift += 7
        at += 1
        if not data[at - 1] & 0x80:
            return value, at


def mac_library(data: bytes) -> Binary:
    """A 64-bit Mach-O library (Apple, mach-o/loader.h)."""
    magic, processor, _, kind, commands, _, _ = struct.unpack_from("<7I", data)
    assert magic == 0xFEEDFACF and kind == FILE_IS_LIBRARY
    exports: set[str] = set()
    libraries = set()
    signed, oldest = False, ""
    at = 32
    for _ in range(commands):
        command, size = struct.unpack_from("<II", data, at)
        command &= ~REQUIRED
        if command == LOAD_LIBRARY:
            libraries.add(text_at(data, at + struct.unpack_from("<I", data, at + 8)[0]))
        elif command in (LINKING, EXPORTS):
            start, length = struct.unpack_from("<II", data, at + (40 if command == LINKING else 8))
            exports |= names_in_trie(data[start:start + length])
        elif command == SIGNATURE:
            signed = True
        elif command == BUILD_VERSION:
            version, = struct.unpack_from("<I", data, at + 12)
            oldest = f"{version >> 16}.{version >> 8 & 0xFF}"
        at += size
    return Binary(processor, exports, libraries, signed, oldest)


def mac_libraries(data: bytes) -> list[tuple[Slice, Binary]]:
    """The libraries of a universal binary."""
    return [(piece, mac_library(data[piece.offset:piece.offset + piece.size])) for piece in slices_of(data)]


def slices_of(binary: bytes) -> list[Slice]:
    """Libraries in a universal binary."""
    magic, count = struct.unpack_from(">II", binary)
    if magic != FAT_MAGIC:
        raise ValueError(f"binary begins with {magic:#x}, expected a universal one, {FAT_MAGIC:#x}")
    return [Slice(*struct.unpack_from(">IIIII", binary, 8 + 20 * k)) for k in range(count)]
