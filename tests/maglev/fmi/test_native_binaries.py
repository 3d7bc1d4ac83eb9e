"""Binaries for every system: what they export and need; those of Windows and of Linux on ARM, run here, emulated.

The one of this machine in every run of the tests, in which C is compiled for the other systems as well. Theirs are
linked in the thorough tests: zig first makes the C libraries of those systems, Windows's in a minute and a half.
"""

import os
import platform
import re
import shutil
import struct
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from fmpy.model_description import ModelDescription
from native_binaries import ARM64_MACOS, X86_64_MACOS, X86_64_WINDOWS, mac_libraries, windows_library
from native_builds import (
    FMI_HEADERS,
    HERE,
    STRICT,
    built_once,
    compiled,
    require_command,
    require_native_tools,
    unpacked_sources,
)

from maglev.fmi.compiler import FLAGS
from maglev.fmi.native_build import SHELLS
from maglev.scenario.catalogue import Kind, build

NAME = "Regulator2DOF"
STEP = 5e-4    # s, its sample time

# Every function of FMI 2.0: an FMU that is for co-simulation alone refuses those of model exchange.
FUNCTIONS = {f"fmi2{name}" for name in (
    "GetTypesPlatform", "GetVersion", "SetDebugLogging", "Instantiate", "FreeInstance", "SetupExperiment",
    "EnterInitializationMode", "ExitInitializationMode", "Terminate", "Reset", "GetReal", "GetInteger", "GetBoolean",
    "GetString", "SetReal", "SetInteger", "SetBoolean", "SetString", "GetFMUstate", "SetFMUstate", "FreeFMUstate",
    "SerializedFMUstateSize", "SerializeFMUstate", "DeSerializeFMUstate", "GetDirectionalDerivative",
    "SetRealInputDerivatives", "GetRealOutputDerivatives", "DoStep", "CancelStep", "GetStatus", "GetRealStatus",
    "GetIntegerStatus", "GetBooleanStatus", "GetStringStatus", "EnterEventMode", "NewDiscreteStates",
    "EnterContinuousTimeMode", "CompletedIntegratorStep", "SetTime", "SetContinuousStates", "GetDerivatives",
    "GetEventIndicators", "GetContinuousStates", "GetNominalsOfContinuousStates")}

TARGETS = sorted({target for shell in SHELLS.values() for each in shell.platforms.values() for target in each.targets})
PROCESSORS = {"x86_64": 62, "aarch64": 183}   # their numbers in ELF

OF_THE_LINKER = {"___dso_handle", "__mh_dylib_header"}    # zig's linker exports these in every library of macOS


@pytest.fixture(scope="session")
def everywhere(slow: None, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Unpacked FMU with a binary for every system."""
    require_native_tools()

    def make(folder: Path) -> None:
        path, = build([NAME], folder, Kind(native=True))
        with zipfile.ZipFile(path) as archive:
            archive.extractall(folder)

    return built_once(tmp_path_factory, "native_everywhere", make)


@pytest.fixture(scope="session")
def description(native_fmus: Path) -> ModelDescription:
    return fmpy.read_model_description(str(native_fmus / f"{NAME}.fmu"))


def unpacked_library(native_fmus: Path, folder: Path, name: str = NAME) -> Path:
    """The library of this machine, which is Linux, out of the FMU that is built for it alone."""
    if platform.system() != "Linux":
        pytest.skip("this machine is not Linux")
    with zipfile.ZipFile(native_fmus / f"{name}.fmu") as archive:
        return Path(archive.extract(f"binaries/linux64/{name}.so", folder))


@pytest.mark.few(2)
@pytest.mark.parametrize("target", TARGETS)
def test_the_c_is_c_of_every_system(fmi3_fmus: Path, native_fmus: Path, tmp_path: Path, target: str) -> None:
    """With the headers of its C library alone: FMI 3.0 on ARM, FMI 2.0 elsewhere."""
    fmu = (fmi3_fmus if target.startswith("aarch64") else native_fmus) / "Regulator3DOF.fmu"
    sources = unpacked_sources(fmu, tmp_path)
    (sources / "unit.c").write_text("".join(f'#include "{path.name}"\n' for path in sorted(sources.glob("*.c"))))
    done = subprocess.run([sys.executable, "-m", "ziglang", "cc", "-target", target, *STRICT,
                           *(flag for flag in FLAGS if flag != "-s"), *FMI_HEADERS, "-c", "unit.c"], cwd=sources,
                          capture_output=True, text=True)
    assert done.returncode == 0 and not done.stderr, done.stderr[-3000:]
    assert len(list(sources.glob("unit.o*"))) == 1


@pytest.mark.thorough
def test_platforms(everywhere: Path) -> None:
    assert {str(path.relative_to(everywhere)) for path in everywhere.glob("binaries/*/*")} == {
        f"binaries/linux64/{NAME}.so", f"binaries/aarch64-linux/{NAME}.so", f"binaries/win64/{NAME}.dll",
        f"binaries/darwin64/{NAME}.dylib"}
    assert set(fmpy.supported_platforms(str(everywhere / f"{NAME}.fmu"))) >= {"c-code", "darwin64", "linux64", "win64"}


def test_the_binary_of_this_machine(native_fmus: Path, tmp_path: Path) -> None:
    path = unpacked_library(native_fmus, tmp_path)
    check_linux_binary(path, PROCESSORS[platform.machine()])
    check_nothing_of_the_building_machine(path)


@pytest.mark.thorough
@pytest.mark.parametrize(("folder", "processor"), [("linux64", "x86_64"), ("aarch64-linux", "aarch64")])
def test_linux_binary(everywhere: Path, folder: str, processor: str) -> None:
    check_linux_binary(everywhere / f"binaries/{folder}/{NAME}.so", PROCESSORS[processor])


def check_linux_binary(path: Path, processor: int) -> None:
    """It is for that processor, exports FMI alone, and needs the C library of the oldest kind, no mathematical one."""
    header = path.read_bytes()[:20]
    assert header[:5] == b"\x7fELF\x02" and struct.unpack_from("<H", header, 18)[0] == processor
    tool = require_command("readelf")
    symbols = subprocess.run([tool, "-W", "--dyn-syms", path], check=True, capture_output=True, text=True).stdout
    defined = {line.split()[7].partition("@")[0] for line in symbols.splitlines()
               if re.search(r" (GLOBAL|WEAK) +DEFAULT +\d+ ", line)}
    assert defined - {"_init", "_fini"} == FUNCTIONS
    dynamic = subprocess.run([tool, "-d", path], check=True, capture_output=True, text=True).stdout
    needed = {"libc.so.6", "libdl.so.2", "libpthread.so.0", "libutil.so.1", "librt.so.1"}
    assert set(re.findall(r"NEEDED.*\[(.*)\]", dynamic)) <= needed
    assert not re.search("R(UN)?PATH", dynamic)
    versions = {tuple(map(int, found.split("."))) for found in re.findall(r"GLIBC_([\d.]+)", symbols)}
    assert max(versions) <= (2, 17)


# What an FMU takes of a C library, all of it: memory, texts, numbers in texts.
TAKEN = {"calloc", "free", "memcpy", "memset", "memmove", "memcmp", "bcmp", "strlen", "strchr", "strcmp", "strncmp",
         "strcpy", "strcat", "snprintf", "vsnprintf", "atoi", "strtol", "strtod"}
OF_THE_START = {"_ITM_deregisterTMCloneTable", "_ITM_registerTMCloneTable", "__cxa_finalize", "__gmon_start__"}
MATHEMATICAL = re.compile("(?:a?(?:sin|cos|tan)h?|atan2|sincos|exp(?:2|10|m1)?|log(?:2|10|1p|b)?|pow|fmod|remainder|"
                          "cbrt|hypot|erfc?|[lt]gamma|fma|sqrt|floor|ceil|trunc|rint|round)[fl]?")


def symbols_of(path: Path, *flags: str) -> dict[str, str]:
    """Kind by name of the symbols of a binary or an object, as nm has them."""
    listing = subprocess.run([require_command("nm"), "--format=posix", *flags, path], check=True, capture_output=True,
                             text=True).stdout
    return {name.partition("@")[0]: kind for name, kind, *_ in map(str.split, listing.splitlines())}


def test_no_binary_asks_for_a_mathematical_function(native_fmus: Path, tmp_path: Path) -> None:
    """Of no library: what is not on the list is not asked for."""
    names = sorted(path.stem for path in native_fmus.glob("*.fmu"))
    assert {name[:5] for name in names} >= {"Plant", "Regul", "Close", "Estim", "Measu"}
    for name in names:
        symbols = symbols_of(unpacked_library(native_fmus, tmp_path / name, name), "--dynamic")
        asked = {symbol for symbol, kind in symbols.items() if kind in "Uw"} - OF_THE_START
        assert "strlen" in asked and asked <= TAKEN, (name, asked - TAKEN)


@pytest.mark.few(2)
@pytest.mark.parametrize("name", [
    *(f"{kind}{stage}DOF" for kind in ("Plant", "ClosedLoop", "Estimator", "Measurement") for stage in (2, 3, 5)),
    "ScheduledRegulator3DOF", "PID5DOF"])
def test_nothing_mathematical_comes_with_an_fmu(native_fmus: Path, tmp_path: Path, name: str) -> None:
    """Nor does a compiler's own library answer: an object of its sources, which has all names, asks for no more."""
    asked, defined = symbols_of_sources(native_fmus / f"{name}.fmu", tmp_path, "-fno-math-errno")
    assert "strlen" in asked and asked <= TAKEN, asked - TAKEN
    assert "fmi2DoStep" in defined
    assert {symbol for symbol in defined if MATHEMATICAL.fullmatch(symbol)} == set()


def test_a_compiler_that_sets_errno_asks_for_a_square_root(native_fmus: Path, tmp_path: Path) -> None:
    """For that alone the build description has the library `m`."""
    asked, _ = symbols_of_sources(native_fmus / "Plant3DOF.fmu", tmp_path)
    assert asked - TAKEN == {"sqrt"}


def symbols_of_sources(fmu: Path, folder: Path, *flags: str) -> tuple[set[str], set[str]]:
    """What gcc's object of an FMU's sources asks for, and what it has."""
    sources = unpacked_sources(fmu, folder)
    (sources / "unit.c").write_text("".join(f'#include "{path.name}"\n' for path in sorted(sources.glob("*.c"))))
    subprocess.run([require_command("gcc"), "-std=c99", "-O1", *flags, *FMI_HEADERS, "-c", "unit.c", "-o", "unit.o"],
                   cwd=sources, check=True)
    symbols = symbols_of(sources / "unit.o")
    asked = {symbol for symbol, kind in symbols.items() if kind == "U"}
    return asked, symbols.keys() - asked


@pytest.mark.thorough
def test_windows_binary(everywhere: Path) -> None:
    binary = windows_library((everywhere / f"binaries/win64/{NAME}.dll").read_bytes())
    assert binary.processor == X86_64_WINDOWS
    assert binary.exports == FUNCTIONS
    assert {name.lower() for name in binary.libraries} == {"kernel32.dll", *(
        f"api-ms-win-crt-{part}-l1-1-0.dll" for part in ("convert", "heap", "private", "runtime", "stdio", "string"))}


@pytest.mark.thorough
def test_mac_binary(everywhere: Path) -> None:
    """Universal: both processors, placed at whole pages, each signed, which arm64 requires of every library."""
    data = (everywhere / f"binaries/darwin64/{NAME}.dylib").read_bytes()
    libraries = mac_libraries(data)
    assert [piece.processor for piece, _ in libraries] == [X86_64_MACOS, ARM64_MACOS]
    end = 8 + 20 * len(libraries)
    for piece, binary in libraries:
        assert binary.processor == piece.processor
        assert binary.exports - OF_THE_LINKER == {f"_{name}" for name in FUNCTIONS}
        assert binary.libraries == {"/usr/lib/libSystem.B.dylib"}
        assert binary.oldest_system == "11.0"
        assert binary.signed or binary.processor == X86_64_MACOS
        assert piece.offset >= end and piece.offset % (1 << piece.alignment) == 0
        end = piece.offset + piece.size
    assert end == len(data)


@pytest.mark.thorough
@pytest.mark.parametrize("folder", ["linux64", "aarch64-linux", "win64", "darwin64"])
def test_nothing_of_the_building_machine_is_in_it(everywhere: Path, folder: str) -> None:
    path, = everywhere.glob(f"binaries/{folder}/*")
    check_nothing_of_the_building_machine(path)


def check_nothing_of_the_building_machine(path: Path) -> None:
    data = path.read_bytes()
    for text in (b"maglev_scratch_", str(Path.home()).encode() + b"/", b"site-packages"):
        assert text not in data, text


def bits(values: list[float]) -> str:
    """Doubles as hexadecimal digits."""
    return " ".join(struct.pack(">d", value).hex() for value in values)


def program(description: ModelDescription, steps: int) -> str:
    """What `replay` reads: a start off the setpoint, references that move, noise on the positions."""
    inputs = [v for v in description.modelVariables if v.causality == "input"]
    outputs = [v for v in description.modelVariables if v.causality == "output" and v.type == "Real"]
    random = np.random.default_rng(1)
    lines = [f"{steps} {bits([STEP])} {len(inputs)} {len(outputs)}",
             " ".join(str(v.valueReference) for v in inputs + outputs)]
    for k in range(steps):
        lines.append(bits([float(v.start) + 1e-3 * np.sin(0.05 * k + i) + 1e-5 * random.standard_normal()
                           for i, v in enumerate(inputs)]))
    return "\n".join(lines) + "\n"


def replay_built(folder: Path, *compiler: str) -> Path:
    """The program `replay`, made by a compiler."""
    output = folder / "replay.exe"
    subprocess.run([*compiler, *STRICT, *FMI_HEADERS, str(HERE / "replay.c"), "-o", str(output)], check=True)
    return output


def replayed(command: list[str | Path], guid: str, text: str, environment: dict[str, str] | None = None) -> np.ndarray:
    """Outputs of a run of `replay`, shape (steps, outputs)."""
    done = subprocess.run([*command, guid], input=text, capture_output=True, text=True, timeout=120,
                          env={**os.environ, **(environment or {})})
    assert done.returncode == 0, done.stderr
    rows = [[int(each, 16) for each in line.split()] for line in done.stdout.split("\n") if line.strip()]
    return np.array(rows, dtype=np.uint64).view(np.float64)


def test_sources_compiled_by_another_compiler_give_the_same_bits(
        native_fmus: Path, description: ModelDescription, tmp_path: Path) -> None:
    """gcc at another level of optimisation, from what is in the FMU."""
    tool = replay_built(tmp_path, require_command("gcc"))
    sources = unpacked_sources(native_fmus / f"{NAME}.fmu", tmp_path)
    ours = compiled(sources, tmp_path / "fmu.so", "-shared", "-fPIC", "-O1", "-DFMI2_OVERRIDE_FUNCTION_PREFIX")
    shipped, text = unpacked_library(native_fmus, tmp_path), program(description, 500)
    results = [replayed([tool, library], description.guid, text) for library in (shipped, ours)]
    assert results[0].tobytes() == results[1].tobytes()
    assert np.isfinite(results[0]).all() and np.ptp(results[0], axis=0).max() > 0.1


@pytest.mark.thorough
def test_windows_binary_under_wine(everywhere: Path, tmp_path: Path) -> None:
    """Run with Wine 8.0."""
    require_command("wine")
    prefix = {"WINEPREFIX": str(tmp_path / "prefix"), "WINEDEBUG": "-all", "WINEDLLOVERRIDES": "mscoree,mshtml=",
              "DISPLAY": "", "HOME": str(tmp_path)}
    tool = replay_built(tmp_path, sys.executable, "-m", "ziglang", "cc", "-target", "x86_64-windows-gnu")
    library = everywhere / f"binaries/win64/{NAME}.dll"
    has_the_bits_of_this_machine(everywhere, tmp_path, ["wine", tool, library], prefix)


@pytest.mark.thorough
def test_linux_arm_binary_under_qemu(everywhere: Path, tmp_path: Path) -> None:
    """Run with QEMU 7.2 and the C library 2.36."""
    emulator = shutil.which("qemu-aarch64") or require_command("qemu-aarch64-static")
    system = Path("/usr/aarch64-linux-gnu")
    if not system.is_dir():
        pytest.skip("libc6-arm64-cross is not installed")
    tool = replay_built(tmp_path, sys.executable, "-m", "ziglang", "cc", "-target", "aarch64-linux-gnu.2.17")
    has_the_bits_of_this_machine(everywhere, tmp_path, [emulator, "-L", system, tool,
                                                        everywhere / f"binaries/aarch64-linux/{NAME}.so"])


def has_the_bits_of_this_machine(everywhere: Path, folder: Path, emulated: list[str | Path],
                                 environment: dict[str, str] | None = None) -> None:
    """Outputs of the library of another system, run here, and of this one's."""
    description = fmpy.read_model_description(str(everywhere / f"{NAME}.fmu"))
    text = program(description, 500)
    here = folder / "here"
    here.mkdir()
    ours = replayed([replay_built(here, require_command("gcc")), everywhere / f"binaries/linux64/{NAME}.so"],
                    description.guid, text)
    theirs = replayed(emulated, description.guid, text, environment)
    assert theirs.tobytes() == ours.tobytes()
    assert np.isfinite(ours).all() and np.ptp(ours, axis=0).max() > 0.1
