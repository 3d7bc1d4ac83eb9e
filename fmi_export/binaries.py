"""pythonfmu's binaries as they go into an FMU."""

from importlib.metadata import version
from importlib.resources import files
from typing import NamedTuple

from fmi_export.errors import ExportError


class Correction(NamedTuple):
    """One byte of the Linux binary of pythonfmu 0.7.0 that is to be another one."""

    code: bytes     # instructions that occur once
    place: int      # of the byte in them
    value: int


CORRECTIONS = (
    # Start of finalizePythonInterpreter. The function runs as a destructor of the library, after the static object that
    # it releases is gone, and so writes to freed memory at the end of every process that has used a pythonfmu FMU; now
    # and then the C library notices and aborts the process. Nothing else needs it: the static object releases the
    # interpreter itself. So it is made to return at once, after the landing pad of indirect branches.
    Correction(bytes.fromhex("f30f1efa 55 660fefc0 53 4883ec08 488b2d73640100 0f290564640100"), 4, 0xc3),
    # fmi2Instantiate looks for the 7 characters of file:// in the location of the resources and removes them. Of
    # file:/path, which FMI allows as well, and which is what Java makes, it so makes no path, and ends the process. The
    # first 5 characters are enough to look for and to remove: of /// a path begins as well as of /.
    Correction(bytes.fromhex("b907000000 31d2 4c89f7 488d353ee40100"), 1, len("file:")),
    Correction(bytes.fromhex("b807000000 4839c2 480f47d0 4839ce 0f87d3060000"), 1, len("file:")),
)


def binaries(name: str) -> dict[str, bytes]:
    """Binaries of an FMU by their name in the archive, named after its model identifier.

    Raises
    ------
    ExportError
        If the installed pythonfmu is not the one that this project knows.
    """
    folder = files("pythonfmu").joinpath("resources", "binaries")
    linux = folder.joinpath("linux64", "libpythonfmu-export.so").read_bytes()
    windows = folder.joinpath("win64", "pythonfmu-export.dll").read_bytes()
    return {f"binaries/linux64/{name}.so": corrected(linux), f"binaries/win64/{name}.dll": windows}


def corrected(library: bytes) -> bytes:
    """Linux binary with every correction."""
    result = bytearray(library)
    for correction in CORRECTIONS:
        if library.count(correction.code) != 1:
            raise ExportError(f"pythonfmu {version('pythonfmu')}: its Linux binary is not known, "
                              "expected that of 0.7.0")
        result[library.index(correction.code) + correction.place] = correction.value
    return bytes(result)
