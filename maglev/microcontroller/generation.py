"""The C of a controller for a microcontroller: of this project, of a stage of the user's, or of a Python file."""

from contextlib import nullcontext
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
from maglev.user_controllers.build import buildable, finished, named_lines
from maglev.user_controllers.source import is_written

MAKER = "Maglev FMUs"


def generated(controller: str | Path) -> tuple[FmuDefinition, dict[str, str]]:
    """A controller, and its freestanding C: files by name.

    It is the name of an FMU, or the path of a Python file, perhaps with the name of a class in it. MaglevError if there
    is none, or it is not what C can have, with file and line.
    """
    path = Path(controller)
    with buildable(path, PACKAGES, native=True) if is_written(path) else nullcontext() as own:
        described = definition(str(controller)) if own is None else own.definition
        packages = PACKAGES if own is None else (*PACKAGES, *own.packages)
        if not described.sampled:
            raise BuildError(f"{controller}: has no sample_time, expected a controller, or another block that samples")
        modules = carried_modules(described.block.__module__, packages)
        try:
            with nullcontext() if own is None else named_lines(own.files):
                translation = translated_blocks([described], packages)
                translation = translation if own is None else finished(translation, own.packages)
            return described, freestanding(described, modules, translation, f"{MAKER} {version('maglev-fmus')}")
        except ExportError as error:
            raise BuildError(f"{controller}: {error}") from None
