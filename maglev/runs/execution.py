"""Execution of one run or of many at once, and their results."""

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from traceback import format_exception
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from maglev.cosim.master import Recording, RunFailed, RunInterrupted
from maglev.files.cache import FILES, digest_at
from maglev.files.errors import FAILURES, Interrupted, MeasurementError, ScenarioError, in_one_line
from maglev.files.side_by_side import Progress, Watcher
from maglev.files.whole_file import whole_file, write_whole
from maglev.runs.chain import Ended, Ends, chained, ends_of, started
from maglev.runs.endings import ABORTED, COMPLETED, ending
from maglev.runs.measures import measures_data, measures_of
from maglev.runs.measuring import run_metrics
from maglev.runs.metrics import Metrics, metrics_data, phase_resistances
from maglev.runs.preparation import Experiment
from maglev.runs.provenance import Provenance
from maglev.runs.results import ResultFiles, write_csv, write_parquet
from maglev.runs.verdicts import Judgements, judge_run, of_modified_runs, require_sides
from maglev.scenario.options import Format
from maglev.scenario.run_plan import RunPlan

T = TypeVar("T", bound=Ended)


@dataclass(frozen=True)
class RunResult:
    plan: RunPlan
    # every output interval of the plan; of a run that did not complete nothing, or the rows until then
    recording: Recording = field(default_factory=lambda: Recording(np.zeros(0), {}))
    metrics: Metrics | None = None   # what was measured; None if nothing was, or the run did not complete
    failure: str | None = None   # why the run did not complete
    traceback: str = ""   # of that, for who looks for a bug; empty if the run completed
    # every output at the end; empty if the run did not complete
    ends: Mapping[str, float] = field(default_factory=dict)
    # every Real parameter that the run started with; empty if it did not complete
    parameters: Mapping[str, float] = field(default_factory=dict)
    provenance: Provenance | None = None   # what it rests on; None if it was refused before anything was looked at

    def __repr__(self) -> str:
        return f"<RunResult {self.plan.name}: {self.failure or f'{len(self.time)} rows'}>"

    @property
    def outcome(self) -> str:
        """Return "did not complete" for an aborted run, "failed" if the stage touched a stop or tripped.

        Return "ended off target" for other runs that end beyond `metrics.fail_error`, else "completed".
        """
        if self.failure is not None or self.metrics is None:
            return ABORTED
        return "failed" if self.metrics.failed else "ended off target" if self.metrics.ended_off else COMPLETED

    @property
    def ending(self) -> str:
        """Return how the run ended: the outcome with its cause, time and axis."""
        if self.failure is not None or self.metrics is None:
            return ABORTED + (f": {self.failure}" if self.failure else "")
        return ending(self.plan, self.metrics)

    @property
    def time(self) -> NDArray[np.float64]:
        """Times of the rows, s, shape (n,)."""
        return self.recording.time

    @property
    def columns(self) -> Mapping[str, NDArray[Any]]:
        """Return the columns by name, `fmu.variable`, SI, shape (n,); Booleans as 0 and 1."""
        return self.recording.columns

    @property
    def modified(self) -> bool:
        """Return True if the run differs from its plan."""
        return self.provenance is not None and self.provenance.modified


def simulate(experiment: Experiment, progress: Progress | None = None) -> RunResult:
    """Run an experiment and measure it without writing files; errors as in `execute`."""
    recording = experiment.run(progress)
    return replace(completed_run(experiment, recording), metrics=whole_metrics(experiment.plan, recording))


def execute(experiment: Experiment, out: Path, form: Format = "csv", progress: Progress | None = None) -> RunResult:
    """Run an experiment, write its columns, and measure it.

    RunFailed if an FMU ends the run, RunInterrupted after Ctrl-C or SIGTERM: the columns until then are in
    `NAME.partial.csv`. MaglevError or OSError if it cannot run, be measured or be written.
    """
    every, files = experiment.output_every(), ResultFiles(out, experiment.plan.name)
    results = []

    def complete(recording: Recording) -> None:
        """Write the results of the run, even if its FMUs crash after it."""
        try:
            metrics = whole_metrics(experiment.plan, recording)
        except MeasurementError as error:
            raise MeasurementError(f"{error}; {keep_recording(files, recording, every)}") from error
        result = replace(completed_run(experiment, recording), metrics=metrics)
        write_result(files, form, result, experiment.units(recording.columns), recording, every)
        results.append(result)

    try:
        recording = experiment.run(progress, complete)
    except RunFailed as error:
        raise RunFailed(f"{error}; {keep_recording(files, error.recording, every)}", error.recording) from error
    except RunInterrupted as error:
        message = f"{error}; {keep_recording(files, error.recording, every)}"
        files.set_aside()   # the files of an earlier run must not pass for those of this one
        raise RunInterrupted(message, error.recording, error.number) from error
    except Interrupted as error:
        if not results:
            raise
        raise Interrupted(f"{error}; its results are in {files.file(form)}", error.number) from error
    return replace(results[0], recording=replace(results[0].recording, notes=recording.notes))


def write_result(files: ResultFiles, form: Format, result: RunResult, units: Mapping[str, str], recording: Recording,
                 every: int = 1) -> None:
    """Write the columns of a run, and its JSON file with their digest; see `write_columns` for the parameters.

    Files of an earlier run stay until both are complete, and are then removed.
    """
    with whole_file(files.file(form)) as columns, whole_file(files.file("json")) as record:
        write_columns(columns, form, result, units, recording, every)
        write_whole(record, json_text({**run_as_json(result), FILES: {columns.name: digest_at(columns)}}))
    files.forget_others(form)


def write_columns(path: Path, form: Format, result: RunResult, units: Mapping[str, str], recording: Recording,
                  every: int = 1) -> None:
    """Write every n-th communication point of the recording of a run; `units` of the columns go to Parquet."""
    if form == "csv":
        write_csv(path, recording, every)
    else:
        about = {key: value for key, value in run_as_json(result).items() if key in ("name", "title", "provenance")}
        write_parquet(path, recording, units, about, every)


def keep_recording(files: ResultFiles, recording: Recording, every: int) -> str:
    """Write what was recorded of a run that ended early; says where it is, or why it is not."""
    try:
        write_csv(files.file("partial.csv"), recording, every)
    except OSError as error:
        return f"what was recorded until then cannot be written: {in_one_line(error)}"
    return f"what was recorded until then is in {files.file('partial.csv')}"


def whole_metrics(plan: RunPlan, recording: Recording) -> Metrics:
    """Return the metrics of a run that was recorded to its end."""
    return run_metrics(plan, recording.time, recording.columns, phase_resistances(plan)({}))


def expected(experiment: Experiment) -> Metrics:
    """Return the metrics of an ideal run that follows its references exactly, as far as they are known beforehand."""
    plan, time, drives = experiment.plan, experiment.times, experiment.drives(experiment.check())
    rest = np.zeros(len(time))
    columns = {name: rest for motor in plan.motors.values() for name in (*motor.currents, *motor.commands)}
    columns |= {flag: rest for flag in (plan.stop_flag, plan.trip_flag) if flag is not None}
    for axis in plan.axes.values():
        columns[axis.position] = columns[axis.reference] = drives.get(axis.reference, rest)
    return run_metrics(plan, time, columns, phase_resistances(plan)({}))


def require_judgeable(experiments: Sequence[Experiment]) -> None:
    """Refuse a claim of a user's scenario that has no metric, and references that are out of reach.

    ScenarioError names the file. Runs with references from another FMU are not checked, because these are unknown
    before.
    """
    by_name = {experiment.plan.name: experiment for experiment in experiments}
    for experiment in experiments:
        plan = experiment.plan
        if not (plan.own or experiment.changes) or not experiment.fits():   # of another, its run says why
            continue
        drives = experiment.drives(experiment.check())   # refuses what the stage cannot reach
        if not (plan.own and plan.claims):
            continue
        if all(axis.reference in drives for axis in plan.axes.values()):
            others = {name: expected(by_name[name]) for claim in plan.claims for name in claim.other_runs
                      if name in by_name}
            try:
                require_sides(plan.claims, expected(experiment), others)
            except MeasurementError as error:
                raise ScenarioError(f"{plan.source}: {error}") from None


def completed_run(experiment: Experiment, recording: Recording) -> RunResult:
    """Result of a run that was recorded to its end: every output interval of it; nothing is measured yet."""
    descriptions = experiment.check()
    return RunResult(experiment.plan, thinned(recording, experiment.output_every()), ends=ends_of(recording),
                     parameters=experiment.parameters(descriptions), provenance=experiment.provenance(descriptions))


def run_as_json(result: RunResult) -> dict[str, Any]:
    """Return metrics and provenance of a run in JSON form; None for a time that never came or a value that is not
    finite.
    """
    return {"name": result.plan.name, "title": result.plan.title, "outcome": result.outcome, "ending": result.ending,
            "failure": result.failure,
            "provenance": None if result.provenance is None else result.provenance.as_data(),
            "metrics": None if result.metrics is None else metrics_data(result.metrics),
            "measures": [] if result.metrics is None else measures_data(measures_of(result.plan, result.metrics))}


def json_text(data: Mapping[str, Any]) -> str:
    """JSON with a line for each entry."""
    return json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False) + "\n"


def thinned(recording: Recording, every: int) -> Recording:
    """Copy every n-th communication point of a recording."""
    return Recording(recording.time[::every].copy(),
                     {name: values[::every].copy() for name, values in recording.columns.items()}, recording.notes)


def run_each(experiments: Sequence[Experiment], job: Callable[[Experiment, Ends, Progress], T],
             died: Callable[[Experiment, str], T], jobs: int, watch: Watcher, here: bool = False) -> list[T]:
    """Do a job with each experiment and the ends of the runs that it starts from, in the order of `chained`.

    They run in other processes, at most `jobs` at a time; `here`, or with a given class, they run in this one.
    """
    by_name = {experiment.plan.name: experiment for experiment in experiments}
    return list(chained({name: experiment.plan.needs for name, experiment in by_name.items()},
                        lambda name, ends: partial(job, by_name[name], ends), jobs,
                        lambda name, message: died(by_name[name], message), watch,
                        here=here or any(experiment.here for experiment in experiments)).values())


def execute_all(experiments: Sequence[Experiment], out: Path, form: Format, jobs: int, watch: Watcher,
                here: bool = False) -> list[RunResult]:
    """Run experiments with `run_each`; one that fails, or whose process dies, has a result with the reason."""
    return run_each(experiments, partial(execute_or_fail, out, form), failed_run, jobs, watch, here)


def execute_or_fail(out: Path, form: Format, experiment: Experiment, ends: Ends, progress: Progress) -> RunResult:
    """Run an experiment that starts from the ends of other runs; an error that users can correct becomes a result."""
    try:
        return execute(replace(experiment, plan=started(experiment.plan, ends)), out, form, progress)
    except FAILURES as error:
        # The files of an earlier run must not pass for those of this one.
        ResultFiles(out, experiment.plan.name).set_aside()
        return failed_run(experiment, in_one_line(error), "".join(format_exception(error)))


def failed_run(experiment: Experiment, message: str, traceback: str = "") -> RunResult:
    return RunResult(experiment.plan, failure=message, traceback=traceback)


def judge_all(results: Sequence[RunResult]) -> Judgements:
    """Judge the claims of every run, by name, comparative ones against the other runs.

    The thesis's claims are about its runs. A modified run, or one that a user's file makes of it, has no verdict on the
    thesis, nor has a comparison with one. A user's own claims are always judged. Another reading of an experiment does
    not count.
    """
    metrics = {result.plan.name: result.metrics for result in results}
    modified = {result.plan.name for result in results if result.modified or result.plan.own}
    judged = {}
    for result in results:
        name = result.plan.name
        claims = [replace(claim, counts=not result.plan.another_reading)
                  for claim in judge_run(result.plan.claims, result.metrics, metrics)]
        others = [{name, *claim.other_runs} & modified for claim in result.plan.claims]
        judged[name] = [verdict for claim, other in zip(claims, others, strict=True)
                        for verdict in (of_modified_runs([claim]) if other else [claim])]
    return judged
