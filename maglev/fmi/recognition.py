"""Check that an FMU is a build of the installed sources: by its contents, not by its own statements."""

import re
from collections.abc import Mapping
from dataclasses import replace
from datetime import datetime
from pathlib import PurePosixPath

from maglev.fmi.block_code import BLOCK
from maglev.fmi.build import CARRIED, Maker, what_runs
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.native_build import BINARIES, DIGESTS, SHELLS, SOURCES, library_digests, native_sources
from maglev.language.sources import carried_modules, is_of, module_path

# Files that people or other tools only read; files that run are compared byte for byte.
FOR_READERS = ("documentation/", "model.png", "terminalsAndIcons/", "extra/")

DATE = re.compile(rb'generationDateAndTime="(\d{4}-\d\d-\d\dT\d\d:\d\d:\d\dZ)"')
MODULE = re.compile(r"resources/\w+/(\w+(?:/\w+)*)\.py")


def is_python_build(contents: Mapping[str, bytes], definition: FmuDefinition, written: str, maker: Maker) -> bool:
    """Return True if files by name are those of `build_fmu`: modules, binaries and model description, all bytes.

    Nothing remains to be trusted; only the date may be another one. For the parameters see `build_fmu`. KeyError,
    ValueError or ModuleNotFoundError if a file that such an FMU has is missing, or cannot be read.
    """
    texts = {}
    for match in filter(None, map(MODULE.fullmatch, contents)):
        name = match[1].replace("/", ".")
        if is_of(name, (*maker.packages, *CARRIED)):   # the module of the slave is in none
            texts[name] = module_path(name).read_text(encoding="utf-8")
    return running(contents) == what_runs(definition, written, maker, texts, date_of(contents))


def is_native_build(contents: Mapping[str, bytes], definition: FmuDefinition, maker: Maker) -> bool:
    """Return True if files by name are those of `build_native_fmu`.

    Model description, FMI layer and table are compared byte for byte. The GUID must be that of the sources in the FMU
    and of the Python modules here. Each library must have the digest that the FMU states. Neither translator nor
    compiler runs, so it is still trusted that these libraries were compiled from these sources. A replaced library with
    matching GUID and digests is not noticed. For parameters and errors see `is_python_build`.
    """
    runs = running(contents)
    sources = {name.removeprefix(SOURCES): data.decode("utf-8") for name, data in runs.items()
               if name.startswith(SOURCES)}
    libraries = {name: data for name, data in runs.items() if name.startswith(BINARIES)}
    shell = SHELLS[3 if b' fmiVersion="3.0"' in contents["modelDescription.xml"] else 2]
    texts = carried_modules(definition.block.__module__, maker.packages)
    platforms = [PurePosixPath(name).parent.name for name in libraries]
    definition = replace(definition, clocked=b"<Clock " in contents["modelDescription.xml"])
    made = native_sources(definition, texts, sources[BLOCK], maker.version, platforms, shell, date_of(contents))
    return contents.get(DIGESTS) == library_digests(libraries) and runs == {
        **{f"{SOURCES}{name}": text.encode("utf-8") for name, text in made.files.items()}, **libraries,
        "modelDescription.xml": made.description}


def running(contents: Mapping[str, bytes]) -> dict[str, bytes]:
    """The files that run, and the model description."""
    return {name: data for name, data in contents.items() if not name.startswith(FOR_READERS)}


def date_of(contents: Mapping[str, bytes]) -> int:
    """Date of generation, seconds since 1970; 0 if there is none."""
    match = DATE.search(contents["modelDescription.xml"])
    return 0 if match is None else int(datetime.fromisoformat(match[1].decode("ascii")).timestamp())
