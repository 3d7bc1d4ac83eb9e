"""Build of pythonfmu FMUs: the same sources give the same bytes, whenever and wherever."""

import hashlib
import re
import zipfile
from collections.abc import Mapping
from datetime import UTC, datetime
from importlib.metadata import distribution
from pathlib import Path
from typing import NamedTuple

from maglev.files.environment import DATE, number_in
from maglev.files.whole_file import whole_file
from maglev.fmi.binaries import binaries
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.documentation import documentation, external_dependencies, icon_of
from maglev.fmi.icon import png_icon, svg_file
from maglev.fmi.model_description import model_description, terminals_and_icons
from maglev.language.errors import ExportError
from maglev.language.sources import carried_modules, imported_modules, renamed

CARRIED = ("maglev.fmi", "pythonfmu")   # packages whose modules every FMU carries

EARLIEST_IN_ZIP = 315532800    # 1980-01-01, the first date that a zip archive can hold

SLAVE = '''"""The slave of {name}, in a module that is imported once."""

from {code}.maglev.fmi.slave import one_more_reference
from {code}.{slave_module} import {slave}
from {code}.definition import DEFINITION


class {name}({slave}):
    """{description}"""

    def __init__(self, **kwargs):
        super().__init__(DEFINITION, guid="{guid}", **kwargs)


def begin(names):
    """Called by the entry module for every instance, with its names, for which the binary gives up a reference."""
    one_more_reference(names)
'''

ENTRY = '''"""Entry module of {name}: pythonfmu's binary finds it by slavemodule.txt and executes it for every instance.

It defines nothing, because a definition would stay for each instance as long as the process lives.
"""

from {code}.slave import {name}, begin  # noqa: F401

begin(globals())
'''


class Maker(NamedTuple):
    """The maker of FMUs: version and licence text of the project, and the packages whose modules they can carry.

    `pages` are further folders of packages, with pages of their documentation.
    """

    version: str
    licence: str
    packages: tuple[str, ...]
    pages: tuple[Path, ...] = ()


def build_fmu(definition: FmuDefinition, written: str, maker: Maker, destination: Path,
              extra: Mapping[str, bytes] | None = None) -> Path:
    """Write `destination/NAME.fmu` and return its path; the folder is made if it is not there.

    `written` is the definition as Python, which the FMU runs to have it as DEFINITION. The FMU carries those modules of
    the maker's packages that it imports, and `extra`, further files by their names in it, which do not run.

    pythonfmu's slave class and binaries are used, but not its builder. The builder names modules as they are, so that a
    second FMU in the process runs the first one's code, and stamps clock and random GUID into the file.
    """
    packages = (*maker.packages, *CARRIED)
    texts: dict[str, str] = {}
    for module in (definition.slave[0], *imported_modules("", written)):
        texts |= carried_modules(module, packages)
    contents = what_runs(definition, written, maker, texts, build_date()) | common_files(definition, maker)
    contents["documentation/licenses/pythonfmu.txt"] = licence_of("pythonfmu").encode("utf-8")
    contents["documentation/externalDependencies.txt"] = external_dependencies(definition).encode("utf-8")
    return write_archive(destination / f"{definition.name}.fmu", contents | dict(extra or {}))


def write_archive(path: Path, contents: Mapping[str, bytes]) -> Path:
    """Write an FMU of files by their name in it; it appears under its name when it is complete."""
    stamp = datetime.fromtimestamp(max(build_date(), EARLIEST_IN_ZIP), UTC).timetuple()[:6]
    with whole_file(path) as unfinished, zipfile.ZipFile(unfinished, "w", zipfile.ZIP_DEFLATED) as archive:
        for name in sorted(contents):
            entry = zipfile.ZipInfo(name, stamp)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.create_system = 3   # Unix, also where the build runs on Windows
            entry.external_attr = (0o755 if name.startswith("binaries/") else 0o644) << 16
            archive.writestr(entry, contents[name])
    return path


def build_date() -> int:
    """Date that goes into the FMU, seconds since 1970."""
    try:
        return number_in(DATE)
    except ValueError as error:
        raise ExportError(str(error)) from None


def what_runs(definition: FmuDefinition, written: str, maker: Maker, texts: Mapping[str, str],
              date: int) -> dict[str, bytes]:
    """The files of the FMU that run, and its model description: with modules, by name, and a date in seconds."""
    slave_module, slave = definition.slave
    parts = (part for item in sorted(texts.items()) for part in item)
    fingerprint = digest([definition.name, maker.version, SLAVE, ENTRY, written, *parts])
    entry = f"{definition.name.lower()}_{fingerprint[:12]}"
    code = f"{entry}_code"
    packages = (*maker.packages, *CARRIED)
    contents = {f"resources/{code}/{name.replace('.', '/')}.py": renamed(text, packages, code).encode("utf-8")
                for name, text in texts.items()}
    without_guid = model_description(definition, "", maker.version, date).decode("utf-8")
    guid = f"{{{digest([fingerprint, without_guid])[:32]}}}"
    contents["modelDescription.xml"] = without_guid.replace('guid=""', f'guid="{guid}"', 1).encode("utf-8")
    contents[f"resources/{code}/definition.py"] = renamed(written, packages, code).encode("utf-8")
    contents[f"resources/{code}/slave.py"] = SLAVE.format(
        name=definition.name, code=code, slave_module=slave_module, slave=slave, guid=guid,
        description=re.sub(r'[\\"]', "", definition.description)).encode("utf-8")
    contents[f"resources/{entry}.py"] = ENTRY.format(name=definition.name, code=code).encode("utf-8")
    contents["resources/slavemodule.txt"] = entry.encode("ascii")
    contents |= binaries(definition.name)
    return contents


def common_files(definition: FmuDefinition, maker: Maker, fmi: str = "2.0") -> dict[str, bytes]:
    """Return the files next to the model description of every FMU: icon, documentation, licence; terminals.

    The latter only in FMI 3.0: FMI 2.0.4 allows them, with the schema of FMI 3.0, and FMI Library refuses just that.
    """
    shapes = icon_of(definition)
    icon = png_icon(shapes)
    pictures = {"model.png": icon} if fmi == "2.0" else {
        "terminalsAndIcons/icon.png": icon, "terminalsAndIcons/icon.svg": svg_file(shapes),
        "terminalsAndIcons/terminalsAndIcons.xml": terminals_and_icons(definition)}
    page = documentation(definition, maker.version, maker.pages)
    return pictures | {"documentation/index.html": page.encode("utf-8"),
                       "documentation/licenses/license.txt": maker.licence.encode("utf-8")}


def digest(parts: list[str]) -> str:
    """SHA-256 of texts, each with its length, in hexadecimal."""
    sha = hashlib.sha256()
    for part in parts:
        data = part.encode("utf-8")
        sha.update(len(data).to_bytes(8, "big") + data)
    return sha.hexdigest()


def licence_of(package: str) -> str:
    """Licence text of an installed package whose code is in the FMU."""
    metadata = distribution(package)
    for path in metadata.files or []:
        if path.name == "LICENSE":
            return path.read_text(encoding="utf-8")
    raise FileNotFoundError(f"{package} {metadata.version} is installed without its LICENSE, expected one to ship")
