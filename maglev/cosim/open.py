"""Open an FMU or a Python class of the user."""

from collections.abc import Mapping

from fmpy.model_description import ModelDescription

from maglev.cosim.fmu import Fmu, read_description
from maglev.cosim.helper_process import read_apart
from maglev.cosim.port_map import Scale
from maglev.cosim.user_class import WrittenController, description_text, written_description
from maglev.user.source import FmuFile, PythonClass, Source


def describe(name: str, source: Source, timeout: float = 0.0) -> ModelDescription:
    """Return the model description of an FMU, or of a user's class; errors say what is wrong with other sources.

    A Python file is imported in another process, see `read_apart`; a class is of this one.
    """
    if isinstance(source, FmuFile):
        return read_description(name, source.path)
    return written_description(description_text(source) if isinstance(source, PythonClass) else
                               read_apart(source, timeout))


def open_fmu(name: str, source: Source, description: ModelDescription, scales: Mapping[str, Scale]) -> Fmu:
    kind = Fmu if isinstance(source, FmuFile) else WrittenController
    return kind(name, source, description, scales)
