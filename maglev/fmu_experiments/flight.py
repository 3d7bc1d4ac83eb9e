"""Flight of one FMU alone, with fmpy: any version, co-simulation, or model exchange where there is nothing else."""

import io
from collections.abc import Mapping
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

import fmpy
import numpy.typing as npt
from fmpy.model_description import ModelDescription
from fmpy.simulation import simulate_fmu

from maglev.cosim.fmu import IDENTIFIER, unpack, unpacking_folder
from maglev.cosim.versions.fmi import fmi_of
from maglev.cosim.versions.messages import Messages
from maglev.errors import FmuError, in_one_line, shortened
from maglev.processes.side_by_side import Progress
from maglev_files.scratch import remove_scratch

TOLERANCE = 1e-8   # relative, of the integration of model exchange, where nothing else is said
KEY = b"checked"   # name of the instance


class Times(NamedTuple):
    """Start and end of a run and the communication step, s, and the relative tolerance of a solver."""

    start: float
    stop: float
    step: float
    tolerance: float | None


def description_of(path: Path) -> ModelDescription:
    """Model description of an FMU of FMI 2.0 or 3.0."""
    try:
        description = fmpy.read_model_description(str(path))
    except Exception as error:   # fmpy raises whatever zipfile, lxml and its own checks raise
        raise FmuError(f"{path}: cannot be read as an FMU: {in_one_line(error)}") from error
    if description.fmiVersion != "2.0" and not description.fmiVersion.startswith("3.0"):
        raise FmuError(f"{path}: is an FMI {description.fmiVersion} FMU, expected FMI 2.0 or 3.0")
    kind = description.coSimulation or description.modelExchange
    if kind is None:
        raise FmuError(f"{path}: is for scheduled execution only, expected co-simulation or model exchange")
    if IDENTIFIER.fullmatch(kind.modelIdentifier) is None:   # a path would load a library from outside the archive
        raise FmuError(f"{path}: has modelIdentifier = {shortened(kind.modelIdentifier)}, expected letters, digits and "
                       "underscores")
    return description


def fly(path: Path, description: ModelDescription, times: Times, parameters: Mapping[str, str],
        inputs: npt.NDArray[Any] | None, outputs: list[str], progress: Progress) -> tuple[npt.NDArray[Any], str]:
    """What an FMU gives at the communication points, with the column time, and what it has said.

    Parameters are start values, as texts; inputs are as fmpy takes them: what is continuous is interpolated, the rest
    held. FmuError if the FMU refuses something, with what it says.
    """
    messages = Messages()
    folder = unpacking_folder()
    steps = max(1, round((times.stop - times.start) / times.step))

    def told(status: int, message: bytes) -> None:
        if status != 0:
            messages.add((message or b"").decode("utf-8", "replace"))

    def stepped(time: float, _recorder: object) -> bool:
        progress(min(steps, round((time - times.start) / times.step)), steps)
        return True

    try:
        unpack(path, folder)
        instance = None
        if description.coSimulation is not None:
            instance = fmi_of(description).instantiated(description, folder, KEY, told)
        with redirect_stdout(io.StringIO()):   # fmpy warns there of inputs that stay as they start
            result = simulate_fmu(str(folder), validate=False, start_time=times.start, stop_time=times.stop,
                                  relative_tolerance=times.tolerance or (None if instance else TOLERANCE),
                                  output_interval=times.step, start_values=dict(parameters), input=inputs,
                                  output=outputs, model_description=description, fmu_instance=instance,
                                  step_finished=stepped)
        if instance is not None:
            instance.freeInstance()
        return result, messages.summary()
    except Exception as error:   # fmpy raises whatever ctypes and its own checks raise
        raise FmuError(f"{path.name} cannot be run: {messages.take() or in_one_line(error)}") from error
    finally:
        remove_scratch(folder)
