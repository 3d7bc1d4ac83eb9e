"""FMUs with other experiments in them."""

import zipfile
from collections.abc import Mapping
from pathlib import Path

from maglev.fmi.experiment_files import FOLDER

HEAD = ('<fmiReferences xmlns:fmi-ls="http://fmi-standard.org/fmi-ls-manifest" '
        'fmi-ls:fmi-ls-name="org.fmi-standard.fmi-ls-ref" fmi-ls:fmi-ls-version="1.0.0-alpha.1">')


def manifest(*related: str) -> bytes:
    """A manifest with elements of these attributes."""
    return f"{HEAD}{''.join(f'<Related {each}/>' for each in related)}</fmiReferences>".encode()


def experiments(*elements: str) -> bytes:
    """An experiments file."""
    return f'<Experiments name="all">{"".join(elements)}</Experiments>'.encode()


def carrying(fmu: Path, destination: Path, files: Mapping[str, bytes]) -> Path:
    """A copy of an FMU with these experiments instead of its own; returns its path."""
    with zipfile.ZipFile(fmu) as archive, zipfile.ZipFile(destination, "w") as changed:
        for entry in archive.namelist():
            if not entry.startswith(FOLDER):
                changed.writestr(entry, archive.read(entry))
        for name, data in files.items():
            changed.writestr(f"{FOLDER}{name}", data)
    return destination


def files_of(fmu: Path) -> dict[str, bytes]:
    """Experiments of an FMU by name of the file."""
    with zipfile.ZipFile(fmu) as archive:
        return {name.removeprefix(FOLDER): archive.read(name) for name in archive.namelist() if name.startswith(FOLDER)}
