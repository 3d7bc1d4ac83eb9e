"""Open the FMU or the user's Python class that a path names."""

from collections.abc import Mapping
from pathlib import Path

from fmpy.model_description import ModelDescription

from maglev.cosim import fmu
from maglev.cosim.fmu import Fmu
from maglev.cosim.helper_process import read_apart
from maglev.cosim.port_map import Scale
from maglev.cosim.user_class import WrittenController, description_text, written_description
from maglev.user.source import is_class, is_written


def read_description(name: str, path: Path, timeout: float = 0.0) -> ModelDescription:
    """Model description of an FMU 2.0 for co-simulation, or of a user's class; errors say what is wrong with others.

    A Python file is imported in another process, see `read_apart`; a class is of this one.
    """
    if not is_written(path):
        return fmu.read_description(name, path)
    return written_description(description_text(path) if is_class(path) else read_apart(path, timeout))


def open_fmu(name: str, path: Path, description: ModelDescription, scales: Mapping[str, Scale]) -> Fmu:
    kind = WrittenController if is_written(path) else Fmu
    return kind(name, path, description, scales)
