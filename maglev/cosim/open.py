"""What a path names, opened: an FMU, or a user's class in Python."""

from collections.abc import Mapping
from pathlib import Path

from fmpy.model_description import ModelDescription

from maglev.cosim import fmu
from maglev.cosim.fmu import Fmu
from maglev.cosim.port_map import Scale
from maglev.cosim.written import WrittenController, written_description
from maglev.written.source import is_written


def read_description(name: str, path: Path) -> ModelDescription:
    """Model description of an FMU 2.0 for co-simulation, or of a user's class; errors say what is wrong with others."""
    return written_description(path) if is_written(path) else fmu.read_description(name, path)


def open_fmu(name: str, path: Path, description: ModelDescription, scales: Mapping[str, Scale]) -> Fmu:
    """Load an FMU, or make an object of a user's class."""
    kind = WrittenController if is_written(path) else Fmu
    return kind(name, path, description, scales)
