"""Many runs at once: one process for each, and what each of them gives."""

import multiprocessing
import os
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from multiprocessing.connection import Connection, wait
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from scenarios.component import ComponentError
from scenarios.errors import ScenarioError
from scenarios.experiment import Experiment
from scenarios.master import Progress, Recording, RunFailed
from scenarios.metrics import Metrics, evaluate
from scenarios.results import write_csv
from scenarios.scenario import Scenario
from scenarios.verdicts import ClaimResult, judge

FAILURES = (ScenarioError, ComponentError, RunFailed, ValueError, OSError)   # what users can put right


@dataclass(frozen=True)
class RunResult:
    """One run of a study.

    Attributes
    ----------
    scenario : Scenario
    time : ndarray, shape (n,)
        Times of the rows, s: every output interval of the scenario; none if the run did not complete.
    columns : mapping of str to ndarray, shape (n,)
        By name, `fmu.variable`, SI; Booleans as 0 and 1.
    metrics : Metrics or None
        What was measured; None if the run did not complete.
    failure : str or None
        Why the run did not complete.
    """

    scenario: Scenario
    time: NDArray[np.float64]
    columns: Mapping[str, NDArray[Any]] = field(default_factory=dict)
    metrics: Metrics | None = None
    failure: str | None = None


class Report(NamedTuple):
    """What a process says of its run: steps done and in all, and at the end the result."""

    done: int
    steps: int
    result: RunResult | None = None


Watcher = Callable[[str, int, int], None]   # name of a run, steps done, steps in all


def execute(experiment: Experiment, out: Path, progress: Progress | None = None) -> RunResult:
    """Run an experiment, write its CSV, and measure it.

    Raises
    ------
    RunFailed
        If an FMU ends the run; what was recorded until then is in `NAME.partial.csv`.
    ComponentError, ScenarioError, ValueError, OSError
        If it cannot run, be measured or be written.
    """
    scenario = experiment.scenario
    every = experiment.output_every()
    try:
        recording = experiment.run(progress)
    except RunFailed as error:
        partial = out / f"{scenario.name}.partial.csv"
        write_csv(partial, error.recording, every)
        raise RunFailed(f"{error}; what was recorded until then is in {partial}", error.recording) from error
    write_csv(out / f"{scenario.name}.csv", recording, every)
    metrics = evaluate(scenario, recording.time, recording.columns)
    thin = thinned(recording, every)
    return RunResult(scenario, thin.time, thin.columns, metrics)


def thinned(recording: Recording, every: int) -> Recording:
    """Copy every n-th communication point of a recording."""
    return Recording(recording.time[::every].copy(),
                     {name: values[::every].copy() for name, values in recording.columns.items()})


def execute_all(experiments: Sequence[Experiment], out: Path, jobs: int, watch: Watcher) -> list[RunResult]:
    """Run experiments, each in a process of its own, at most `jobs` at a time.

    A run that fails, or whose process dies, has a result that says why; the others go on.
    """
    context = multiprocessing.get_context("spawn")
    waiting = deque(experiments)
    running: dict[Connection, tuple[Experiment, Any]] = {}
    results: dict[str, RunResult] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                experiment = waiting.popleft()
                ours, theirs = context.Pipe(duplex=False)
                process = context.Process(target=work, args=(experiment, out, theirs), daemon=True)
                process.start()
                theirs.close()
                running[ours] = (experiment, process)
            for ready in wait(list(running)):
                pipe = cast(Connection, ready)
                experiment, process = running[pipe]
                name = experiment.scenario.name
                try:
                    report: Report = pipe.recv()
                except EOFError:
                    process.join()
                    results[name] = failed(experiment, "the process of the run died with exit code "
                                                       f"{process.exitcode}, expected 0")
                    report = Report(1, 1, results[name])
                watch(name, report.done, report.steps)
                if report.result is not None:
                    results[name] = report.result
                    del running[pipe]
                    pipe.close()
                    process.join()
    finally:
        for _, process in running.values():
            process.terminate()
    return [results[experiment.scenario.name] for experiment in experiments]


def work(experiment: Experiment, out: Path, reports: Connection) -> None:
    """Run an experiment in this process, and send reports."""
    def progress(done: int, steps: int) -> None:
        if done < steps:   # the last report has the result
            reports.send(Report(done, steps))

    try:
        result = execute(experiment, out, progress)
    except FAILURES as error:
        result = failed(experiment, " ".join(str(error).split()))
    reports.send(Report(1, 1, result))


def failed(experiment: Experiment, message: str) -> RunResult:
    """Result of a run that did not complete."""
    return RunResult(experiment.scenario, np.zeros(0), failure=message)


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def judge_all(results: Sequence[RunResult]) -> dict[str, list[ClaimResult]]:
    """Judge the claims of every run, by name, comparative ones against the other runs."""
    metrics = {result.scenario.name: result.metrics for result in results}
    return {result.scenario.name: [judge(claim, result.metrics, metrics) for claim in result.scenario.claims]
            for result in results}
