"""The experiments that FMUs carry, run with fmpy, each FMU alone, and compared with the results that they carry."""

import functools
import io
import time
from collections.abc import Iterable, Mapping, Sequence
from contextlib import redirect_stdout
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from fmpy.model_description import ModelDescription, ScalarVariable
from fmpy.simulation import simulate_fmu

from maglev.cosim.fmi_versions import Messages, fmi_of
from maglev.cosim.fmu import checked_description, flaw_note, unpack, unpacking_folder
from maglev.cosim.helper_process import called_apart
from maglev.cosim.isolated_run import TIMEOUT
from maglev.files.arrays import Array
from maglev.files.errors import FAILURES, FmuError, in_one_line, nearest, option
from maglev.files.scratch import remove_scratch
from maglev.files.side_by_side import Progress, Watch, Watcher, processes, unwatched, watched
from maglev.files.time_grid import ON_GRID
from maglev.files.worker_process import Forged
from maglev.fmi.parameter import REALS
from maglev.runs import carried_experiments as carried
from maglev.runs.baseline_check import deviation_text
from maglev.runs.baseline_file import Tolerance
from maglev.runs.carried_experiments import CarriedExperiment, File, carried_experiments
from maglev.runs.chain import chained
from maglev.runs.check_outcome import CheckResult, DeviatingSample, WorstDifference, first_deviation, worst, write_junit
from maglev.user.source import FmuFile

SOLVER_TOLERANCE = 1e-8   # relative, of the integration of model exchange, by default


class Times(NamedTuple):
    """Start and end of a run and the communication step, s, and the relative tolerance of a solver."""

    start: float
    stop: float
    step: float
    tolerance: float | None


class FmuRun(NamedTuple):
    """The output of an FMU at the communication points, by variable and with the column time, and its messages."""

    columns: dict[str, npt.NDArray[Any]]
    said: str


def run_fmu(path: Path, times: Times, parameters: Mapping[str, str], inputs: npt.NDArray[Any] | None,
            outputs: list[str], progress: Progress) -> FmuRun:
    """Run an FMU alone, in this process.

    Parameters are start values, as texts. Inputs are in the form of fmpy: continuous ones are interpolated, the others
    held. FmuError if the FMU refuses something, with its message.
    """
    messages = Messages()
    folder = unpacking_folder()
    steps = max(1, round((times.stop - times.start) / times.step))
    description = checked_description(f"{path}:", path)

    def stepped(time: float, _recorder: object) -> bool:
        progress(max(0, min(steps, round((time - times.start) / times.step))), steps)
        return True

    try:
        unpack(path, folder)
        instance = None
        if description.coSimulation is not None:
            instance = fmi_of(description).instantiated(description, folder, b"checked", messages.told)
        with redirect_stdout(io.StringIO()):   # fmpy warns there of inputs that stay as they start
            result = simulate_fmu(str(folder), validate=False, start_time=times.start, stop_time=times.stop,
                                  relative_tolerance=times.tolerance or (None if instance else SOLVER_TOLERANCE),
                                  output_interval=times.step, start_values=dict(parameters), input=inputs,
                                  output=outputs, model_description=description, fmu_instance=instance,
                                  step_finished=stepped)
        if instance is not None:
            instance.freeInstance()
        return FmuRun({name: result[name].copy() for name in result.dtype.names}, messages.summary())
    except Exception as error:   # fmpy raises whatever ctypes and its own checks raise
        raise FmuError(f"{path.name} cannot be run: {messages.take() or in_one_line(error)}") from error
    finally:
        remove_scratch(folder)


def run_where_it_belongs(path: Path, times: Times, parameters: Mapping[str, str], inputs: npt.NDArray[Any] | None,
                         outputs: list[str], progress: Progress, timeout: float) -> FmuRun:
    """Run an FMU of this project in this process, any other FMU in another process, because it is not trusted."""
    task = functools.partial(run_fmu, path, times, parameters, inputs, outputs)
    if not FmuFile(path).foreign:
        return task(progress)
    run: FmuRun = called_apart(functools.partial(watched, task), path.name, timeout, FmuRun, progress)
    instants = run.columns.get("time", np.zeros(0))
    if (run.columns.keys() != {"time", *outputs} or instants.ndim != 1 or not len(instants)
            or not np.isfinite(instants).all() or (np.diff(instants) < 0.0).any()
            or any(column.dtype.kind not in "biuf" or column.shape[:1] != instants.shape or not column.size
                   for column in run.columns.values())):
        raise FmuError(f"{path.name} {Forged()}")
    return run


class Expected(NamedTuple):
    """Results that are expected: times (s), values by variable with a row for each time, tolerances, left out ones."""

    time: Array
    values: dict[str, Array]
    tolerances: dict[str, Tolerance]
    left_out: list[str]
    said: str = ""   # what reading their file took for granted


def named_experiments(paths: Sequence[Path]) -> dict[str, tuple[Path, CarriedExperiment]]:
    """Every experiment of FMUs, by the name that its outcome has."""
    by_name: dict[str, tuple[Path, CarriedExperiment]] = {}
    for path in paths:
        try:
            experiments = carried_experiments(path)
        except FmuError as error:
            experiments = [CarriedExperiment("", problem=in_one_line(error).removeprefix(f"{path}: "))]
        for experiment in experiments:
            name = f"{path}, {experiment.name}" if experiment.name else str(path)
            same = sum(other == name or other.startswith(f"{name} (") for other in by_name)
            by_name[f"{name} ({same + 1})" if same else name] = (path, experiment)
    return by_name


def check_fmus(paths: str | Path | Iterable[str | Path], *, jobs: int | None = None, junit: str | Path | None = None,
               timeout: float = TIMEOUT, partial: bool = False, watch: Watch | None = None) -> list[CheckResult]:
    """Run the experiments that any FMUs carry, and compare with the results that they carry.

    These are experiments by the layered standard FMI-LS-REF (1.0.0-beta.1), or files NAME_ref.csv, NAME_in.csv and
    NAME_ref.opt next to NAME.fmu. Without a given tolerance, a Real may differ by a thousandth of its largest value,
    and the other types not at all.

    Parameters
    ----------
    paths : str or Path, or iterable of these
        FMUs of FMI 2.0 or 3.0.
    jobs : int, optional
        Number at a time, in as many processes; as many as processors if not given.
    junit : path, optional
        Also write the outcome as JUnit XML.
    timeout : float
        Longest time that a step may take, s; to load and start an FMU takes a minute at least.
    partial : bool
        Accept incomplete results with a note: some columns are no variables of the FMU, or the beginning or the end of
        the experiment is left out. Otherwise these are errors.
    watch : callable, optional
        See `maglev.run_all`.

    Returns
    -------
    list of CheckResult
        One for each experiment, with the status "passed", "deviated" or "error".
    """
    experiments = named_experiments([Path(path) for path in ([paths] if isinstance(paths, str | Path) else paths)])
    with (watch or unwatched)(list(experiments)) as watcher:
        results = check_all(experiments, processes(jobs), watcher, timeout, partial)
    if junit is not None:
        write_junit(Path(junit), results)
    return results


def check_all(experiments: Mapping[str, tuple[Path, CarriedExperiment]], jobs: int, watch: Watcher,
              timeout: float = TIMEOUT, partial: bool = False) -> list[CheckResult]:
    """Check experiments of FMUs, by the names of their outcomes, in other processes, at most `jobs` at a time."""
    return list(chained({name: set() for name in experiments},
                        lambda name, _: functools.partial(check_experiment, name, *experiments[name], timeout=timeout,
                                                          partial=partial),
                        jobs, lambda name, message: CheckResult(name, "error", message, None, {}, 0.0), watch).values())


def check_experiment(name: str, path: Path, experiment: CarriedExperiment,
                     progress: Progress = lambda done, steps: None, *, timeout: float = TIMEOUT,
                     partial: bool = False) -> CheckResult:
    """Run an experiment of an FMU and compare; an error that users can correct is a result: the status "error"."""
    begin = time.perf_counter()
    try:
        if experiment.problem or experiment.results is None:
            raise FmuError(experiment.problem or "there are no results, expected some to compare with")
        description = checked_description(f"{path}:", path)
        variables = {v.name: v for v in description.modelVariables}
        run, tolerances = carried.run_options(experiment.options)
        expected = expected_results(experiment.results, variables, tolerances, partial)
        asked = times_of(experiment, description, run, expected.time)
        lacking = missing_times(expected.time, asked)
        if lacking and not partial:
            raise FmuError(f"{experiment.results.place}: no results from {lacking[0]}, expected them for the whole "
                           f"experiment; {option('partial', True)} compares the existing ones")
        result, said = run_where_it_belongs(
            path, asked, carried.given_starts(experiment.parameters, description) if experiment.parameters else {},
            carried.input_array(experiment.inputs, variables) if experiment.inputs else None, list(expected.values),
            progress, timeout)
        deviation, differences = compare_results(expected, result, variables)
    except FAILURES as error:
        return CheckResult(name, "error", in_one_line(error), None, {}, time.perf_counter() - begin)
    units = {signal: (variables.get(signal) or variables[signal.rpartition("[")[0]]).unit or ""
             for signal in differences}
    outcome = functools.partial(CheckResult, name, deviation=deviation, worst=differences, units=units,
                                elapsed=time.perf_counter() - begin, notes=tuple(filter(None, (
                                    expected.said, f"the FMU says: {said}" if said else "", flaw_note(path)))))
    if deviation is not None:
        return outcome("deviated", deviation_text(deviation, units[deviation.signal]))
    counted = (f"{len(expected.values)} variable{'' if len(expected.values) == 1 else 's'} at "
               f"{len(expected.time)} time{'' if len(expected.time) == 1 else 's'}")
    same = all(difference == 0.0 for difference, _ in differences.values())
    message = (f"passed, {counted} to t = {expected.time[-1]:.9g} s "
               + ("equal the results in it" if same else "are within tolerance")
               + (f", {carried.TOLERANCE:g} of the largest value" + (" where none is given" if tolerances else "")
                  if not same and not tolerances.keys() >= expected.values.keys() else "")
               + (f"; not compared: {', '.join(left_out)}" if (left_out := [*expected.left_out, *lacking]) else ""))
    return outcome("passed", message)


def expected_results(file: File, variables: Mapping[str, ScalarVariable],
                     given: Mapping[str, Tolerance], partial: bool) -> Expected:
    """Results of a file that are numbers of a variable of the FMU; tolerances and `partial` as of `check_fmus`."""
    table = carried.read_columns(file, variables)
    columns = table.names
    left_out = [name for name in columns if name not in variables or variables[name].type in carried.TEXTS]
    values = {name: table.values(variables[name]) for name in columns if name not in left_out}
    if not values:
        name = left_out[0]
        raise FmuError(f"{file.place}: no column is a numeric variable of the FMU: {name}: "
                       f"{nearest(name, variables)}")
    for name in given:   # who gives a tolerance means to have it compared
        for known, where in ((columns, f"{file.place}: there is no column"), (variables, "the FMU has no variable")):
            if name not in known:
                raise FmuError(f"{where} {name}, which has a tolerance; {nearest(name, known)}")
    absent = next((name for name in left_out if name not in variables), None)
    if absent is not None and not partial:
        raise FmuError(f"{file.place}: column {absent}: the FMU has no such variable, "
                       f"{nearest(absent, variables)}; {option('partial', True)} compares the others")
    tolerances = {name: given.get(name, Tolerance(
        carried.TOLERANCE * float(np.max(np.abs(column))) if variables[name].type in REALS else 0.0, 0.0))
        for name, column in values.items()}
    return Expected(table.time, values, tolerances, left_out, table.table.said)


def missing_times(given: Array, asked: Times) -> list[str]:
    """Return which parts of a run the results omit, in words: where one more row would have fitted."""
    most = float(np.diff(given).max(initial=0.0)) * (1.0 - ON_GRID)
    return [f"t = {begin:.9g} s to {end:.9g} s" for begin, end in ((asked.start, given[0]), (given[-1], asked.stop))
            if end - begin > ON_GRID * asked.step and end - begin >= most]


def times_of(experiment: CarriedExperiment, description: ModelDescription, run: Mapping[str, float],
             expected: Array) -> Times:
    """Times of a run: those of the experiment, of the options, of the FMU's default experiment, of the results."""
    default = description.defaultExperiment
    internal = getattr(description.coSimulation, "fixedInternalStepSize", None)

    def first(*candidates: Any) -> float | None:
        return next((float(value) for value in candidates if value is not None), None)

    def of_default(key: str) -> Any:
        return getattr(default, key, None)

    apart = np.diff(expected)
    start = first(experiment.start_time, run.get("StartTime"), of_default("startTime"), 0.0)
    # A default experiment need not be that of the results: they can continue after it.
    stop = first(experiment.stop_time, run.get("StopTime"), max(float(of_default("stopTime") or 0.0), expected[-1]))
    step = first(experiment.step, run.get("StepSize") or None, of_default("stepSize"), internal,
                 *((np.median(apart[apart > 0.0]),) if (apart > 0.0).any() else ()))   # an event can be just next to
    assert start is not None and stop is not None
    if step is None or not 0.0 < step <= stop - start + ON_GRID * step:
        raise FmuError(f"communication step = {step} s from {start} s to {stop} s, expected a positive step in a "
                       "positive time")
    return Times(start, stop, step, first(experiment.tolerance, run.get("RelTol") or None, of_default("tolerance")))


def compare_results(expected: Expected, result: Mapping[str, npt.NDArray[Any]],
                    variables: Mapping[str, ScalarVariable]
                    ) -> tuple[DeviatingSample | None, dict[str, WorstDifference]]:
    """The first deviation, and the largest difference of every variable, or element of an array.

    Where a result has two values at one time, as at an event, either will do. At times between communication points a
    continuous variable is interpolated, another one holds.
    """
    times = result["time"]
    near = 1e-6 * max(float(times[-1] - times[0]) / max(1, len(times) - 1), 1e-12)
    if expected.time[-1] > times[-1] + near or expected.time[0] < times[0] - near:
        raise FmuError(f"the run went from t = {times[0]:.9g} s to {times[-1]:.9g} s, expected "
                       f"{expected.time[0]:.9g} s to {expected.time[-1]:.9g} s, as the results do")
    first = np.searchsorted(times, expected.time - near)
    last = np.searchsorted(times, expected.time + near, "right") - 1
    between = last < first
    wanted: dict[str, Array] = {}
    nearer: dict[str, Array] = {}
    tolerances: dict[str, Tolerance] = {}
    for name, column in expected.values.items():
        got = np.asarray(result[name], np.float64).reshape(len(times), -1)
        if got.shape[1] != column.shape[1]:
            raise FmuError(f"{name} has {got.shape[1]} elements, expected {column.shape[1]} as the results have")
        for k in range(column.shape[1]):
            signal = name if column.shape[1] == 1 else f"{name}[{k + 1}]"
            early, late = got[np.where(between, last, first), k], got[last, k]
            if variables[name].variability == "continuous":
                interpolated = np.interp(expected.time, times, got[:, k])
                early, late = np.where(between, interpolated, early), np.where(between, interpolated, late)
            wanted[signal], tolerances[signal] = column[:, k], expected.tolerances[name]
            nearer[signal] = np.where(np.abs(early - column[:, k]) < np.abs(late - column[:, k]), early, late)
    return first_deviation(expected.time, wanted, nearer, tolerances), worst(expected.time, wanted, nearer)
