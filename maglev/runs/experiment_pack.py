"""A scenario put into an FMU as an experiment: its inputs there, its outputs, and the tolerances of a repetition."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, BadZipFile, ZipFile

import numpy as np
from fmpy.model_description import ModelDescription

from maglev.cosim.fmu import kind_of
from maglev.cosim.master import Recording
from maglev.cosim.open import describe
from maglev.cosim.port_map import apply
from maglev.files.arrays import Array
from maglev.files.errors import FmuError, ScenarioError, option
from maglev.files.side_by_side import Watcher
from maglev.files.whole_file import whole_file
from maglev.fmi.experiment_files import FOLDER, VALIDATION, ExperimentFiles, experiments_files, tolerances
from maglev.fmi.parameter_set import Value
from maglev.runs.carried_experiments import carried_experiments
from maglev.runs.check_outcome import CheckResult
from maglev.runs.experiment_check import check_all
from maglev.runs.preparation import Experiment, know_stage_of, prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.fmus_for_runs import fmus_for_runs
from maglev.scenario.loading import load_plan
from maglev.user.source import FmuFile

LARGEST = 5_000_000   # bytes of an experiment: it goes with every copy of the FMU

KINDS = ("Real", "Boolean", "Integer", "Int64")   # that a master records


def pack_reference(fmu: str | Path, scenario: str | Path, *, name: str | None = None, out: str | Path | None = None,
                   fmus: str | Path | None = None, watch: Watcher = lambda name, done, steps: None) -> CheckResult:
    """Run a scenario with an FMU, and put its inputs and outputs there into it, as an experiment for it alone.

    The experiment is a validation by the layered standard FMI-LS-REF. The compared signals and their tolerances are
    those of the FMU in the scenario's table `check`, or all outputs if it has none. The FMU is then run alone with
    this experiment. If its results differ, nothing is written.

    Parameters
    ----------
    fmu : path
        The FMU, of FMI 2.0 or 3.0, for co-simulation.
    scenario : str or Path
        Name of a run, or a TOML file with one.
    name : str, optional
        Name of the FMU to replace in the scenario, such as "controller"; not needed where the scenario names its file.
    out : path, optional
        Where to write; the FMU itself if not given.
    fmus : path, optional
        See `run`.
    watch : callable, optional
        Called with the name of the run, and the steps done and in all.

    Returns
    -------
    CheckResult
        Of the repetition.

    Raises
    ------
    MaglevError
        If the run cannot be made, takes too much room, or is not repeated by the FMU alone.
    """
    path, plan = Path(fmu), load_plan(scenario)
    if plan.needs:
        raise ScenarioError(f"{plan.source}: starts from the run {', '.join(sorted(plan.needs))}, expected a run that "
                            "needs no other")
    place = name or next((place for place, fmu in plan.fmus.items() if fmu.file is not None
                          and Path(fmu.file).resolve() == path.resolve()), None)
    if place is None:
        raise ScenarioError(f"{plan.source}: does not name {path}, needs {option('name')}: the FMU that it replaces, "
                            f"one of {', '.join(plan.fmus)}")
    if place not in plan.fmus:
        raise ScenarioError(f"{place}: is not in the scenario {plan.name}, expected one of {', '.join(plan.fmus)}")
    know_stage_of(plan)
    needed = [fmu.model for key, fmu in plan.fmus.items() if key != place and fmu.model is not None]
    put_in = {} if name is None else {place: Replacement(FmuFile(path))}
    experiment = prepare(plan, fmus_for_runs(needed, fmus), put_in, {})
    experiment.require_current()
    recording = experiment.run(lambda done, steps: watch(plan.name, min(done, steps - 1), steps))
    every = max(1, round(plan.check.interval / experiment.step)) if plan.check.signals else experiment.output_every()
    made = recorded_experiment(experiment, recording, place, plan.name,
                               f"As {place} in the scenario {plan.name}: {plan.title}", every)
    compared = {signal.removeprefix(f"{place}."): tolerance for signal, tolerance in plan.check.signals.items()
                if signal.removeprefix(f"{place}.") in made.results and signal.startswith(f"{place}.")}
    if compared:   # as a baseline of the scenario has them of the FMU
        made = replace(made, results={key: made.results[key] for key in ("time", *compared)},
                       tolerances={key: (value.absolute, value.relative) for key, value in compared.items()})
    files = made.files()
    size = sum(map(len, files.values()))
    if size > LARGEST:
        raise ScenarioError(f"{plan.source}: stop_time = {plan.stop_time} s: the experiment takes {1e-6 * size:.1f} "
                            f"MB, expected at most {1e-6 * LARGEST:g} MB: a shorter scenario")
    with whole_file(Path(out) if out is not None else path) as unfinished:
        with_experiment(path, unfinished, plan.name, files)
        own = [carried for carried in carried_experiments(unfinished) if carried.name == plan.name]
        result, = check_all({plan.name: (unfinished, own[0])}, 1, watch)
        if result.status != "passed":
            raise FmuError(f"{path}: alone, with its inputs of {plan.name}, it gives other outputs, so nothing is "
                           f"written: {result.message}")
    return result


def with_experiment(path: Path, destination: Path, name: str, files: Mapping[str, bytes]) -> None:
    """Write an FMU with the files of an experiment in it, next to those that it has already."""
    try:
        with ZipFile(path) as archive, ZipFile(destination, "w", ZIP_DEFLATED) as written:
            before = {entry: archive.read(entry) for entry in archive.namelist() if entry.startswith(FOLDER)}
            new = experiments_files({name: (VALIDATION, files)}, before)
            for entry in archive.infolist():
                if entry.filename not in new:
                    written.writestr(entry, archive.read(entry))
            for file, data in new.items():
                written.writestr(file, data)
    except BadZipFile as error:
        raise FmuError(f"{path}: cannot be read as an FMU: {error}") from error


def recorded_experiment(experiment: Experiment, recording: Recording, fmu: str, name: str, description: str,
                        every: int) -> ExperimentFiles:
    """Return the experiment that repeats an FMU's inputs of a run in sequential order, with its outputs as results.

    The results have a row every `every` communication steps. ScenarioError if no output of the FMU was recorded.
    """
    source = experiment.sources[fmu]
    described = describe(fmu, source)
    scales = apply(experiment.ports[fmu], described) if fmu in experiment.ports else {}
    variables = {v.name: v for v in described.modelVariables}

    def own(variable: str, values: Any) -> Any:
        """Values in the unit of the FMU."""
        return scales[variable].to_own(values) if variable in scales else values

    results = {"time": recording.time[::every].tolist()}
    for variable in variables.values():
        column = recording.columns.get(f"{fmu}.{variable.name}")
        if variable.causality == "output" and column is not None:
            results[variable.name] = [float(value) for value in own(variable.name, column[::every]).tolist()]
    if len(results) == 1:
        raise ScenarioError(f"{fmu} ({source.name}) has no outputs that are numbers, expected some to compare with")
    parameters = [Value(key, kind_of(variables[key]).replace("Int64", "Integer"), own(key, start.value))
                  for key, start in experiment.plan.fmus[fmu].start.items() if variables[key].causality == "parameter"]
    nominals = {key: None if variable.nominal is None else float(variable.nominal)
                for key, variable in variables.items() if kind_of(variable) == "Real"}
    return ExperimentFiles(name, VALIDATION, description, experiment.step, results, tolerances(results, nominals),
                           inputs_of(experiment, recording, fmu, described, own), parameters)


def at_changes(times: Array, columns: Mapping[str, Array], step: float) -> tuple[Array, dict[str, Array]]:
    """Rows of held columns at the start and at changes; these are half a step (s) early, as rounding may miss them."""
    changed = np.any([np.diff(values) != 0.0 for values in columns.values()], axis=0)
    rows = [0, *(np.flatnonzero(changed) + 1).tolist()]
    starts = times[rows]
    starts[1:] -= step / 2.0
    return starts, {name: values[rows] for name, values in columns.items()}


def inputs_of(experiment: Experiment, recording: Recording, fmu: str, described: ModelDescription,
              own: Any) -> dict[str, Sequence[float]]:
    """Return the inputs of an FMU at each communication point, "time" first; inputs without a source keep their start.

    An output of an FMU that is stepped earlier in the same step is taken from the row after. Where all changing inputs
    are held, not interpolated, there are rows at the changes alone, half a step early: no rounding error of a clock
    misses them.
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
            values = np.full(len(recording.time) - 1, experiment.start_value(full, {fmu: described}))
        columns[variable.name] = own(variable.name, values)
    times = recording.time[:-1]
    held = {v.name for v in described.modelVariables if v.variability in ("discrete", "tunable")
            or kind_of(v) != "Real"}
    moving = {name for name, values in columns.items() if (values != values[0]).any()}
    if moving <= held and not described.coSimulation.canHandleVariableCommunicationStepSize:
        times, columns = at_changes(times, columns, experiment.step)
    return {"time": times.tolist(), **{name: values.tolist() for name, values in columns.items()}} if columns else {}
