"""The C of a controller for a microcontroller: of this project, of a stage of the user's, or of a Python file."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path

from fmi_export.definition import FmuDefinition
from fmi_export.errors import ExportError
from fmi_export.native.build import translated_blocks
from fmi_export.sources import carried_modules
from fmi_export.target.freestanding import freestanding
from maglev.errors import BuildError
from maglev.own_fmus import definition
from maglev.packages import PACKAGES
from maglev.user_controllers.build import Buildable, buildable, finished, named_lines
from maglev.user_controllers.source import is_written

MAKER = "Maglev FMUs"


@dataclass(frozen=True)
class Generated:
    """A controller as freestanding C: what it is, and its files by name."""

    definition: FmuDefinition
    files: dict[str, str]


def generated(controller: str | Path) -> Generated:
    """C of a controller, by the name of an FMU or the path of a Python file, perhaps with the name of a class in it.

    MaglevError if there is none, or it is not what C can have, with file and line.
    """
    with described(Path(controller)) as (described_as, packages, own):
        if not described_as.sampled:
            raise BuildError(f"{controller}: has no sample_time, expected a controller, or another block that samples")
        modules = carried_modules(described_as.block.__module__, packages)
        try:
            if own is None:
                translation = translated_blocks([described_as], packages)
            else:
                with named_lines(own.files):
                    translation = finished(translated_blocks([described_as], packages), own.packages)
            files = freestanding(described_as, modules, translation, f"{MAKER} {version('maglev-fmus')}")
        except ExportError as error:
            raise BuildError(f"{controller}: {error}") from None
    return Generated(described_as, files)


@contextmanager
def described(controller: Path) -> Iterator[tuple[FmuDefinition, tuple[str, ...], Buildable | None]]:
    """Definition of a controller, the packages that its modules are of, and what there is around a user's class."""
    if is_written(controller):
        with buildable(controller, PACKAGES, native=True) as own:
            yield own.definition, (*PACKAGES, *own.packages), own
    else:
        yield definition(str(controller)), PACKAGES, None
