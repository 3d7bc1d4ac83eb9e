"""Flight of one FMU alone, with fmpy: any version, co-simulation, or model exchange where there is nothing else."""

import io
from collections.abc import Mapping
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

import numpy.typing as npt
from fmpy.model_description import ModelDescription
from fmpy.simulation import simulate_fmu

from maglev.cosim.fmu import unpack, unpacking_folder
from maglev.cosim.versions.fmi import Messages, fmi_of
from maglev.errors import FmuError, in_one_line
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


def simulate(path: Path, description: ModelDescription, times: Times, parameters: Mapping[str, str],
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
