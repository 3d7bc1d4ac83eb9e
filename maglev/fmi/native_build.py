"""Build of native FMUs: the block as C, the FMI layer, and binaries that need no Python."""

import hashlib
import platform
import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from importlib.resources import files
from pathlib import Path
from typing import NamedTuple

from maglev.files.session import SESSION
from maglev.files.whole_file import write_whole
from maglev.fmi.block_code import BLOCK, TABLE, TEMPLATES, BlockCode, block_code, model_table
from maglev.fmi.build import Maker, build_date, common_files, digest, write_archive
from maglev.fmi.compiler import FLAGS, MACOS, PLATFORMS, WEBASSEMBLY, Libraries, Platform
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.model_description import build_description, model_description, model_description_3
from maglev.fmi.templates import filled
from maglev.language.errors import ExportError
from maglev.language.sources import carried_modules

# The layer that is the same in all versions: each file knows those before it, and all know model.h and instance.h.
PARTS = ("messages", "state", "outputs", "variables", "exchange", "events", "life")
CORE = ("model.h", "instance.h", *(f"{part}.{ending}" for part in PARTS for ending in ("h", "c")))


class Shell(NamedTuple):
    """A version of FMI: `layer`, the C files of an FMU next to its block, headers that importers have, platforms."""

    version: str
    layer: tuple[str, ...]
    headers: tuple[str, ...]
    platforms: Mapping[str, Platform]


SHELLS = {
    2: Shell("2.0", (*CORE, "fmi2.c", "fmi2_exchange.c", "fmi2_absent.c"),
             ("fmi2Functions.h", "fmi2FunctionTypes.h", "fmi2TypesPlatform.h"),
             {"linux64": PLATFORMS["x86_64-linux"], "win64": PLATFORMS["x86_64-windows"], "darwin64": MACOS,
              # FMI 2.0 has no name for it and allows others (2.3).
              "aarch64-linux": PLATFORMS["aarch64-linux"]}),
    3: Shell("3.0", (*CORE, "fmi3.c", "fmi3_events.c", "fmi3_exchange.c", "fmi3_absent.c"),
             ("fmi3Functions.h", "fmi3FunctionTypes.h", "fmi3PlatformTypes.h"),
             PLATFORMS),
}

BUILD = "buildDescription.xml"
KEYS = {False: ' guid=""', True: ' instantiationToken=""'}   # place of the GUID, by True for FMI 3.0
IN_BROWSERS = SHELLS[2]._replace(layer=(*SHELLS[2].layer, "webassembly_host.c"))
FILE_SCOPE = re.compile(r"^(?:static [\w *]*?\b|#define |enum \{ )(\w+)(?=\(| =| [\d(]|\[)", re.MULTILINE)
PREFIX = "prefix.h"
# Functions and objects that a header declares for other files; members of structures are indented.
EXTERNAL = re.compile(r"^(?!static\b|typedef\b)(?:extern )?\w[\w ]*[ *](\w+)(?:\([^;]*\))?;$", re.MULTILINE)
BINARIES, SOURCES = "binaries/", "sources/"
DIGESTS = "documentation/binaries.sha256"   # of the libraries in an FMU, as sha256sum writes and reads it


def build_native_fmu(definition: FmuDefinition, maker: Maker, destination: Path, host_only: bool = False, fmi: int = 2,
                     extra: Mapping[str, bytes] | None = None, further: Mapping[str, str] | None = None) -> Path:
    """Write `destination/NAME.fmu` with binaries for Linux, Windows and macOS, and return its path.

    The parameters are those of `maglev.fmi.build.build_fmu`. With `host_only` there is only a binary for this machine.
    FMI 2.0 has no name for Linux on ARM: its binary is in linux64, where tools on such a machine look for it. `further`
    are texts of modules, by name, that the block is made of as well. ExportError if the block is not of the language of
    blocks, if ziglang is not installed, or refuses the sources.
    """
    shell = SHELLS[fmi]
    chosen = host_platform(fmi) if host_only else shell.platforms
    texts = carried_modules(definition.block.__module__, maker.packages) | dict(further or {})
    code = own_code(definition, maker.packages).text
    made = native_sources(definition, texts, code, maker.version, chosen, shell, build_date())
    contents = {f"{SOURCES}{name}": text.encode("utf-8") for name, text in made.files.items()}
    libraries = {f"{BINARIES}{folder}/{definition.name}{platform.ending}":
                 SESSION.get(Libraries).made({**made.files, **made.headers}, definition.name, platform)
                 for folder, platform in chosen.items()}
    contents |= {**libraries, DIGESTS: library_digests(libraries)}
    contents |= common_files(definition, maker, shell.version)
    contents["documentation/licenses/fmi.txt"] = fmi_licence(made.headers[shell.headers[0]]).encode("utf-8")
    contents["modelDescription.xml"] = made.description
    return write_archive(destination / f"{definition.name}.fmu", contents | dict(extra or {}))


def build_webassembly(definition: FmuDefinition, maker: Maker, destination: Path,
                      further: Mapping[str, str] | None = None) -> tuple[Path, Path]:
    """Write `destination/NAME.wasm`, the FMU's functions in a module without imports, and its description `NAME.xml`.

    It is for co-simulation alone. The last line of the description names the sources of both, see `made_of`. Arguments
    and errors as in `build_native_fmu`; returns both paths.
    """
    definition = replace(definition, continuous=None)
    chosen = {"wasm32": WEBASSEMBLY}
    texts = carried_modules(definition.block.__module__, maker.packages) | dict(further or {})
    code = own_code(definition, maker.packages).text
    made = native_sources(definition, texts, code, maker.version, chosen, IN_BROWSERS, build_date())
    module, description = (destination / f"{definition.name}.{ending}" for ending in ("wasm", "xml"))
    content = SESSION.get(Libraries).made({**made.files, **made.headers}, definition.name, chosen["wasm32"])
    write_whole(module, content)
    write_whole(description, made.description + made_of(definition, content, maker))
    return module, description


def made_of(definition: FmuDefinition, module: bytes, maker: Maker) -> bytes:
    """Line with the digests of a WebAssembly module and of its present sources.

    Neither translator nor compiler runs; see `is_native_build` for the remaining trust.
    """
    definition = replace(definition, continuous=None)
    files = carried_modules(definition.block.__module__, maker.packages) | layer_files(IN_BROWSERS.layer)
    parts = [model_description(definition, "", maker.version, 0).decode("utf-8"), repr(definition.arguments),
             repr((FLAGS, WEBASSEMBLY)),
             hashlib.sha256(module).hexdigest(), *(part for item in sorted(files.items()) for part in item)]
    return f"<!-- made of {digest(parts)} -->\n".encode("ascii")


class NativeSources(NamedTuple):
    """An FMU as C: files by name, the FMI headers that they need, and modelDescription.xml with the same GUID."""

    files: dict[str, str]
    headers: dict[str, str]
    description: bytes


def own_code(definition: FmuDefinition, packages: tuple[str, ...]) -> BlockCode:
    """The block of a definition as C that fits into the layer; the code of the packages is not a user's."""
    return block_code(definition, packages, frozenset(layer_names()))


def native_sources(definition: FmuDefinition, texts: Mapping[str, str], code: str, version: str,
                   platforms: Iterable[str], shell: Shell, date: int) -> NativeSources:
    """Sources of an FMU with the files of a layer over the block, and a GUID of all that goes into it.

    For the block these are the text of its Python modules, by dotted name, and its C. An installation thus recognises
    its own FMUs without a translation.
    """
    timed = shell.version == "3.0"
    blocks = {BLOCK: code}
    above = layer_files(shell.layer)
    # Not in the FMU: FMI leaves its headers to the importer. fmpy brings them along.
    headers = {name: files("fmpy").joinpath("c-code", name).read_text(encoding="utf-8") for name in shell.headers}
    own_headers = [text for name, text in above.items() if name.endswith(".h")]
    prefix = prefix_header(definition.name, own_headers, shell.headers[0])
    without_guid = {**blocks, **above, PREFIX: prefix, TABLE: model_table(definition, "", timed)}
    units = sorted(name for name in without_guid if name.endswith(".c"))
    if timed:
        without_guid[BUILD] = build_description(definition.name, units)
        described_as = model_description_3(definition, "", version, date).decode("utf-8")
    else:
        described_as = model_description(definition, "", version, date, units).decode("utf-8")
    # The arguments of the block count as well: not every number in them is the start value of a variable.
    parts = [described_as, repr(definition.arguments), *(part for files in ({**without_guid, **headers}, texts)
                             for item in sorted(files.items()) for part in item), *sorted(platforms)]
    guid = f"{{{digest(parts)[:32]}}}"
    return NativeSources({**without_guid, TABLE: model_table(definition, guid, timed)}, headers,
                         described_as.replace(KEYS[timed], KEYS[timed][:-1] + f'{guid}"', 1).encode("utf-8"))


def prefix_header(name: str, headers: Iterable[str], functions: str) -> str:
    """C header that adds the FMU's name as a prefix to the names that its headers declare for its other files.

    `functions` is FMI's header of its functions, "fmi2Functions.h" or "fmi3Functions.h".
    """
    names = sorted({name for header in headers for name in EXTERNAL.findall(header)})
    return filled(TEMPLATES / "prefix.h", {
        "NAME": name, "HEADER": functions, "FMI": functions[:4].upper(),
        "NAMES": "\n".join(f"#define {external} {name}_{external}" for external in names)})


def layer_files(names: Iterable[str]) -> dict[str, str]:
    return {name: files("maglev.fmi").joinpath("c", name).read_text(encoding="utf-8") for name in names}


def library_digests(libraries: Mapping[str, bytes]) -> bytes:
    """SHA-256 of files by name, a line for each."""
    return "".join(f"{hashlib.sha256(data).hexdigest()}  {name}\n"
                   for name, data in sorted(libraries.items())).encode("ascii")


def host_platform(fmi: int = 2) -> dict[str, Platform]:
    """Return the platform of this machine, named after the folder of its binary in a version of FMI."""
    system = platform.system()
    processor = "aarch64" if platform.machine().lower() in ("aarch64", "arm64") else "x86_64"
    folder = {"Linux": "linux64", "Windows": "win64", "Darwin": "darwin64"}.get(system)
    if folder is None:
        raise ExportError(f"system = {system!r}, expected Linux, Windows or Darwin")
    own = f"{processor}-{system.lower()}"   # as FMI 3.0 names it
    if fmi == 3:
        return {own: PLATFORMS[own]}
    return {folder: PLATFORMS[own] if system == "Linux" else SHELLS[2].platforms[folder]}


def layer_names() -> set[str]:
    """Names of the FMI layer, which is one translation unit with a block: one that has them as well would not compile.

    All that are in its headers, and those that its C files have outside functions.
    """
    table = (TEMPLATES / TABLE).read_text(encoding="utf-8")
    headers, code = ("".join(re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
                             for shell in SHELLS.values()
                             for name, text in {**layer_files(shell.layer), TABLE: table}.items()
                             if name.endswith(ending))
                     for ending in (".h", ".c"))
    return set(re.findall(r"\b[A-Za-z_]\w*", headers)) | set(FILE_SCOPE.findall(code))


def fmi_licence(header: str) -> str:
    """Copyright and licence of the FMI headers, from the comment in one of them."""
    match = re.search(r"^ *Copyright.*?(?=\*/)", header, re.MULTILINE | re.DOTALL)
    if match is None:
        raise ExportError("FMI headers of fmpy: there is no licence in them, expected one to ship")
    return "\n".join(line.strip() for line in match[0].splitlines()).strip() + "\n"
