"""Which FMU of a run left its range first: who refuses such a value is not who gave it."""

from collections.abc import Iterable, Mapping

import numpy as np
from fmpy.model_description import ModelDescription

from maglev.cosim.master import RunFailed


def after_departure(failure: RunFailed, descriptions: Mapping[str, ModelDescription],
                    connections: Iterable[tuple[str, str]]) -> RunFailed:
    """The failure, after which output was beyond the range of an input that it is connected to, if one was, and when.

    It is the first one. Inputs of FMUs that have no description here are left out.
    """
    recording, departures = failure.recording, []
    inputs = {f"{name}.{variable.name}": variable for name, description in descriptions.items()
              for variable in description.modelVariables}
    for source, target in connections:
        variable, values = inputs.get(target), recording.columns.get(source)
        if variable is None or values is None or variable.min is None or variable.max is None:
            continue
        low, high = float(variable.min), float(variable.max)
        beyond = np.flatnonzero(~((values >= low) & (values <= high)))
        if len(beyond):
            unit = f" {variable.unit}" if variable.unit else ""
            departures.append((int(beyond[0]), f"{source} = {values[beyond[0]]:.9g}{unit} is beyond "
                                               f"{low:g}…{high:g}{unit}, the range of {target}; "))
    if not departures:
        return failure
    k, said = min(departures)
    when = f"at t = {recording.time[k]:.9g} s: "
    return RunFailed(f"{when}{said}{str(failure).removeprefix(when)}", recording)
