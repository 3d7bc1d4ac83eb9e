"""pythonfmu's binaries as they go into an FMU."""

from importlib.metadata import version
from importlib.resources import files

from fmi_export.errors import ExportError

# Start of finalizePythonInterpreter in the Linux binary of pythonfmu 0.7.0. The function runs as a destructor of the
# library, after the static object that it releases is gone, and so writes to freed memory at the end of every process
# that has used a pythonfmu FMU; now and then the C library notices and aborts the process. Nothing else needs it: the
# static object releases the interpreter itself. So it is made to return at once.
FINALIZER = bytes.fromhex("f30f1efa 55 660fefc0 53 4883ec08 488b2d73640100 0f290564640100")
FIRST_INSTRUCTION = 4   # after the landing pad of indirect branches
RETURN = b"\xc3"


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
    return {f"binaries/linux64/{name}.so": without_finalizer(linux), f"binaries/win64/{name}.dll": windows}


def without_finalizer(library: bytes) -> bytes:
    """Linux binary whose finalizer returns at once."""
    if library.count(FINALIZER) != 1:
        raise ExportError(f"pythonfmu {version('pythonfmu')}: its Linux binary is not known, expected that of 0.7.0")
    at = library.index(FINALIZER) + FIRST_INSTRUCTION
    return library[:at] + RETURN + library[at + 1:]
