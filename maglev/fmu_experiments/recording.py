"""What one FMU was given and gave in a run, as an experiment for this FMU alone."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from fmpy.model_description import ModelDescription, ScalarVariable

from fmi_export.experiments.files import ExperimentFiles, tolerances
from fmi_export.parameter_set import Value
from maglev.cosim.fmu import kind_of
from maglev.cosim.master import Recording
from maglev.cosim.open import read_description
from maglev.cosim.port_map import apply
from maglev.errors import ScenarioError
from maglev.experiment.preparation import Experiment

KINDS = ("Real", "Boolean", "Integer", "Int64")   # that a master records


def recorded(experiment: Experiment, recording: Recording, fmu: str, name: str, role: str, description: str,
             every: int, digits: int = 17) -> ExperimentFiles:
    """Experiment in which an FMU gets what it got in a run in sequential order; what it gave there are the results.

    Of the results there is one row for `every` so many communication steps, with so many digits. ScenarioError if the
    FMU gave nothing that was recorded.
    """
    path = experiment.files[fmu]
    described = read_description(fmu, path)
    scales = apply(experiment.ports[fmu], described) if fmu in experiment.ports else {}
    variables = {v.name: v for v in described.modelVariables}

    def own(variable: str, values: Any) -> Any:
        """Values in the unit of the FMU."""
        scale = scales.get(variable)
        return values if scale is None else values * scale.up / scale.down

    results = {"time": recording.time[::every]}
    for variable in variables.values():
        column = recording.columns.get(f"{fmu}.{variable.name}")
        if variable.causality == "output" and column is not None:
            results[variable.name] = rounded(own(variable.name, column[::every]), digits)
    if len(results) == 1:
        raise ScenarioError(f"{fmu} ({path.name}) has no outputs that are numbers, expected some to compare with")
    parameters = [Value(key, kind_of(variables[key]).replace("Int64", "Integer"), own(key, start.value))
                  for key, start in experiment.plan.fmus[fmu].start.items() if variables[key].causality == "parameter"]
    nominals = {key: None if variable.nominal is None else float(variable.nominal)
                for key, variable in variables.items() if kind_of(variable) == "Real"}
    return ExperimentFiles(name, role, description, experiment.step,
                           {key: values.tolist() for key, values in results.items()},
                           tolerances({key: values.tolist() for key, values in results.items()}, nominals),
                           inputs_of(experiment, recording, fmu, described, own), parameters)


def rounded(values: Any, digits: int) -> Any:
    """Numbers with so many digits."""
    return np.array([float(f"{value:.{digits}g}") for value in values.tolist()])


def inputs_of(experiment: Experiment, recording: Recording, fmu: str, described: ModelDescription,
              own: Any) -> dict[str, Sequence[float]]:
    """What an FMU was given at each communication point, "time" first; what nothing feeds stays as it starts.

    What an FMU that is stepped before it computes in the same step is the row after. Where all that changes is held,
    not interpolated, there are rows at the changes alone, half a step early: no rounding error of a clock misses them.
    """
    plan, order = experiment.plan, list(experiment.plan.fmus)
    sources = {target: source for source, target in plan.wires.values()}
    columns = {}
    for variable in described.modelVariables:
        if variable.causality != "input" or kind_of(variable) not in KINDS:
            continue
        full = f"{fmu}.{variable.name}"
        source = sources.get(full, full)
        if source in recording.columns:
            ahead = source != full and order.index(source.partition(".")[0]) < order.index(fmu)
            values = recording.columns[source][1:] if ahead else recording.columns[source][:-1]
        else:
            values = np.full(len(recording.time) - 1, start_of(experiment, fmu, variable))
        columns[variable.name] = own(variable.name, values)
    times = recording.time[:-1]
    held = {v.name for v in described.modelVariables if v.variability in ("discrete", "tunable")
            or kind_of(v) != "Real"}
    moving = {name for name, values in columns.items() if (values != values[0]).any()}
    if moving <= held and not described.coSimulation.canHandleVariableCommunicationStepSize:
        changed = np.any([np.diff(values) != 0.0 for values in columns.values()], axis=0)
        rows = [0, *(np.flatnonzero(changed) + 1).tolist()]
        times = times[rows] - np.array([0.0, *[experiment.step / 2.0] * (len(rows) - 1)])
        columns = {name: values[rows] for name, values in columns.items()}
    return {"time": times.tolist(), **{name: values.tolist() for name, values in columns.items()}} if columns else {}


def start_of(experiment: Experiment, fmu: str, variable: ScalarVariable) -> float:
    """Start value of an input, SI: the run's, or the FMU's."""
    start = experiment.plan.fmus[fmu].start.get(variable.name)
    if start is not None:
        return float(start.value)
    text = str(variable.start)
    return float(text == "true") if text in ("true", "false") else float(text)
