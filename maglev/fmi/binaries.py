"""pythonfmu's binaries as they go into an FMU."""

from importlib.metadata import version
from importlib.resources import files

from maglev.language.errors import ExportError

# Bytes of the Linux binary of pythonfmu 0.7.0 that are to be others: instructions that occur once, the place of the
# bytes in them, and their replacement.
CORRECTIONS = tuple((bytes.fromhex(code), place, bytes.fromhex(instead)) for code, place, instead in (
    # Start of finalizePythonInterpreter. The function runs as a destructor of the library, after the static object that
    # it releases. It therefore writes to freed memory at the end of every process that has used a pythonfmu FMU; now
    # and then the C library notices and aborts the process. The function is not needed, because the static object
    # releases the interpreter itself. The patch makes it return at once, after the landing pad of indirect branches.
    ("f30f1efa 55 660fefc0 53 4883ec08 488b2d73640100 0f290564640100", 4, "c3"),

    # fmi2Instantiate looks for the 7 characters of file:// in the location of the resources and removes them. FMI also
    # allows file:/path, which Java writes, and the function makes no path of it. The patch looks for the first 5
    # characters and removes them: a path may begin with /// as well as with /.
    ("b907000000 31d2 4c89f7 488d353ee40100", 1, "05"),
    ("b807000000 4839c2 480f47d0 4839ce 0f87d3060000", 1, "05"),

    # handle_py_exception is called where something failed. If Python has no exception to tell of, it returns, and its
    # caller continues with a null pointer: resources that cannot be read end the process. Without the jump to the
    # return
    # it throws then as well, and fmi2Instantiate refuses.
    ("4885c0 0f84c2030000 4c89ef e83206feff", 3, "660f1f440000"),
    # It gives up the references to class, slave and log, and fmi2FreeInstance gives them up again. The patch makes the
    # jump over each unconditional: giving them up once is enough.
    ("498b7d68 4885ff 7411 8b07 85c0 780b 83e801 8907 0f8402040000", 7, "eb"),
    ("498b7d70 4885ff 7411 8b07 85c0 780b 83e801 8907 0f84f8030000", 7, "eb"),
    ("498b7d78 4885ff 7411 8b07 85c0 780b 83e801 8907 0f84ee030000", 7, "eb"),

    # fmi2FreeFMUstate reads the state from its place (mov (%rax),%rdi), and leaves there what it has freed. It is to
    # put a null pointer there in exchange (xor %edi,%edi; xchg %rdi,(%rax)); the code after that moves up to a gap.
    ("488b38 4885ff 740d 8b07 85c0 7807 83e801 8907 7403 c3 6690", 0,
     "31ff 488738 4885ff 740d 8b07 85c0 7807 83e801 8907 7401 c3"),
    # fmi2GetFMUstate puts the new state where the importer may have an older one. That is freed first, by the function
    # above, which takes the same argument (mov %rbx,%rdi; call). The check of the stack's end gives room for it.
    ("488b4308 488928 488b442438 64482b042528000000 0f85b7000000 488b3b", 0,
     "4889df e881cfffff 488b4308 488928 660f1f840000000000 0f1f00"),
    # fmi2SerializeFMUstate copies as many bytes as the importer has room for. With the patch it copies as many as there
    # are. If the room is less (mov %r12,%rdi; call PyBytes_Size; mov %rax,%rcx; cmp %rcx,0x18(%rbx); jb), it takes the
    # branch for values that are not bytes (then: mov 0x10(%rbx),%rax; mov (%rax),%rdi; mov %rbp,%rsi; rep movsb).
    ("48837b1800 741f 31c0 0f1f4000 488b5310 0fb64c0500 488b12 880c02 4883c001 48394318 77e7", 0,
     "4c89e7 e87dfbfdff 4889c1 48394b18 0f8218010000 488b4310 488b38 4889ee f3a4 0f1f440000"),
))


def binaries(name: str) -> dict[str, bytes]:
    """Binaries of an FMU by their name in the archive, named after its model identifier.

    ExportError if the installed pythonfmu is not the one that this project knows.
    """
    folder = files("pythonfmu").joinpath("resources", "binaries")
    linux = folder.joinpath("linux64", "libpythonfmu-export.so").read_bytes()
    windows = folder.joinpath("win64", "pythonfmu-export.dll").read_bytes()
    return {f"binaries/linux64/{name}.so": corrected(linux), f"binaries/win64/{name}.dll": windows}


def corrected(library: bytes) -> bytes:
    result = bytearray(library)
    for code, place, instead in CORRECTIONS:
        if library.count(code) != 1:
            raise ExportError(f"pythonfmu {version('pythonfmu')}: its Linux binary is not known, "
                              "expected that of 0.7.0")
        start = library.index(code) + place
        result[start:start + len(instead)] = instead
    return bytes(result)
