"""Check of runs against their committed baselines, and the update of these."""

import time
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Literal

from maglev.cosim.master import Progress, Recording, RunFailed
from maglev.errors import FAILURES, BaselineError, CsvError, in_one_line
from maglev.experiment.chain import Ends, ends_of, in_order, started
from maglev.experiment.preparation import Experiment, prepare
from maglev.experiment.processes import Task, Watcher
from maglev.experiment.replacement import Replacement
from maglev.regression.baseline import Baseline, baseline_files, from_recording, read_baseline, write_baseline
from maglev.regression.deviation import Deviation, WorstDifference, changes, first_deviation, worst
from maglev.regression.fit import BEYOND, require_fit, require_whole
from maglev.schema.run_plan import RunPlan


@dataclass(frozen=True)
class CheckResult:
    """Outcome of one run.

    Attributes
    ----------
    name : str
        Name of the plan.
    status : str
        "deviated" is a difference beyond its tolerance, "error" a run that could not be compared.
    message : str
        One line, without the name.
    deviation : Deviation, optional
        The first, if there is one.
    worst : dict of str to WorstDifference
        Largest difference of each signal; empty after an error.
    elapsed : float
        Wall time, s.
    units : dict of str to str
        Of each signal, empty text where the FMU gives none.
    ends : mapping of str to float
        Every output at the end, for the runs that start from there; empty if the run was not run to its end.
    """

    name: str
    status: Literal["passed", "deviated", "error"]
    message: str
    deviation: Deviation | None
    worst: dict[str, WorstDifference]
    elapsed: float
    units: dict[str, str] = field(default_factory=dict)
    ends: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class UpdateResult:
    """Outcome of the update of one baseline.

    Attributes
    ----------
    name : str
        Name of the plan.
    status : str
        "new": there was no baseline; "replaced": the old one could not be read or compared; "error": nothing was
        written.
    message : str
        One line, without the name.
    moved : dict of str to WorstDifference
        Largest change of each signal that the old baseline had too.
    elapsed : float
        Wall time, s.
    ends : mapping of str to float
        Every output at the end; empty after an error.
    """

    name: str
    status: Literal["new", "unchanged", "updated", "replaced", "error"]
    message: str
    moved: dict[str, WorstDifference]
    elapsed: float
    ends: Mapping[str, float] = field(default_factory=dict)


def check_run(plan: RunPlan, fmus: Path, replaced: Mapping[str, Replacement], settings: Sequence[str],
              baselines: Path, ends: Ends, progress: Progress | None = None) -> CheckResult:
    """Run a plan to the end of its baseline and a little further, and compare.

    Parameters
    ----------
    plan : RunPlan
    fmus : Path
        Folder with the FMUs of this project.
    replaced : mapping of str to Replacement
        FMUs that take the place of the plan's, by name in the run.
    settings : sequence of str
        Start values that go before the plan's, `fmu.variable=value`.
    baselines : Path
        Folder with the baselines.
    ends : mapping of str to mapping of str to float
        Of the runs that the plan starts from.
    progress : callable, optional
        Called now and then with the steps done and the steps in all.

    What can be wrong is a result, too: the status "error".
    """
    begin = time.perf_counter()
    try:
        # First, because a run is long and a missing baseline is found at once.
        baseline = read_baseline(baselines, plan.name)
        require_fit(plan, baseline, baselines)
        end = min(plan.stop_time, baseline.stop_time + BEYOND * plan.check.interval)
        shortened = plan.model_copy(update={"stop_time": end})
        experiment = prepared(shortened, fmus, replaced, settings, ends)
        lacking = [name for name in shortened.check.signals if name not in experiment.plan.check.signals]
        baseline = without(baseline, lacking)
        units = units_of(experiment, baseline.columns)
        recording = flown(experiment, baseline.stop_time, progress)
        deviation = first_deviation(baseline, recording)
        differences = worst(baseline, recording)
        if deviation is None:
            require_whole(plan, baseline, recording, baselines)
    except FAILURES as error:
        return CheckResult(plan.name, "error", in_one_line(error), None, {}, time.perf_counter() - begin)
    elapsed = time.perf_counter() - begin
    # A run that was cut short has not come to the results that others start from.
    reached = ends_of(recording) if shortened.stop_time == plan.stop_time else {}
    if deviation is not None:
        return CheckResult(plan.name, "deviated", deviation_text(deviation, units[deviation.signal]), deviation,
                           differences, elapsed, units, reached)
    same = all(difference == 0.0 for difference, _ in differences.values())
    message = (f"passed, {len(differences)} signals at {len(baseline.time)} samples to t = {baseline.stop_time:.9g} s "
               + ("equal the baseline" if same else "are within their tolerances")
               + (f"; not compared, for the FMU has no such signals: {', '.join(lacking)}" if lacking else ""))
    return CheckResult(plan.name, "passed", message, None, differences, elapsed, units, reached)


def flown(experiment: Experiment, end: float, progress: Progress | None) -> Recording:
    """Recording of a run; also of one that an FMU ends, if that is after the end of the baseline (s)."""
    try:
        return experiment.run(progress)
    except RunFailed as error:
        if not len(error.recording.time) or error.recording.time[-1] < end:
            raise
        return error.recording


def update_run(plan: RunPlan, fmus: Path, replaced: Mapping[str, Replacement], settings: Sequence[str],
               baselines: Path, ends: Ends, progress: Progress | None = None) -> UpdateResult:
    """Run a whole scenario, write its baseline with the plan's tolerances, and say what moved against the old one.

    Parameters as of `check_run`. After an error the old baseline stands.
    """
    begin = time.perf_counter()
    try:
        old, unreadable = old_baseline(baselines, plan.name)
        experiment = prepared(plan, fmus, replaced, settings, ends)
        units = units_of(experiment, plan.check.signals)
        recording = experiment.run(progress)
        new, reached = from_recording(plan, experiment.step, recording), ends_of(recording)
        write_baseline(baselines, new)
    except FAILURES as error:
        return UpdateResult(plan.name, "error", in_one_line(error), {}, time.perf_counter() - begin)
    elapsed = time.perf_counter() - begin
    extent = f"{len(new.columns)} signals at {len(new.time)} samples to t = {new.stop_time:.9g} s"
    if unreadable is not None:
        return UpdateResult(plan.name, "replaced", f"replaced, {extent}; the old one: {unreadable}", {}, elapsed,
                            reached)
    if old is None:
        return UpdateResult(plan.name, "new", f"new, {extent}", {}, elapsed, reached)
    try:
        moved = changes(old, new)
    except BaselineError as error:
        return UpdateResult(plan.name, "replaced", f"replaced, {extent}; nothing to compare: {error}", {}, elapsed,
                            reached)
    notes = change_notes(old, new, moved, units)
    if not notes:
        return UpdateResult(plan.name, "unchanged", f"unchanged, {extent}", moved, elapsed, reached)
    return UpdateResult(plan.name, "updated", f"updated, {extent}; {'; '.join(notes)}", moved, elapsed, reached)


def prepared(plan: RunPlan, fmus: Path, replaced: Mapping[str, Replacement], settings: Sequence[str],
             ends: Ends) -> Experiment:
    """Experiment of a run that starts from the ends of others; settings go before these."""
    experiment = prepare(plan, fmus, replaced, settings)
    return replace(experiment, plan=started(experiment.plan, ends))


def check_all(runs: Sequence[RunPlan], fmus: Path, replaced: Mapping[str, Replacement], settings: Sequence[str],
              baselines: Path, jobs: int, watch: Watcher) -> list[CheckResult]:
    """Check runs, each in a process of its own, at most `jobs` at a time; other parameters as of `check_run`."""
    by_name = {run.name: run for run in runs}

    def task(name: str, ends: Ends) -> Task[CheckResult]:
        return partial(check_run, by_name[name], fmus, replaced, settings, baselines, ends)

    return list(in_order({run.name: run.needs for run in runs}, task,
                         jobs, lambda name, message: CheckResult(name, "error", message, None, {}, 0.0),
                         watch).values())


def update_all(runs: Sequence[RunPlan], fmus: Path, replaced: Mapping[str, Replacement], settings: Sequence[str],
               baselines: Path, jobs: int, watch: Watcher) -> list[UpdateResult]:
    """Update the baselines of runs; parameters as of `check_all`."""
    by_name = {run.name: run for run in runs}

    def task(name: str, ends: Ends) -> Task[UpdateResult]:
        return partial(update_run, by_name[name], fmus, replaced, settings, baselines, ends)

    return list(in_order({run.name: run.needs for run in runs}, task,
                         jobs, lambda name, message: UpdateResult(name, "error", message, {}, 0.0), watch).values())


def describe(result: CheckResult | UpdateResult) -> str:
    """One line about a result, the name of the plan first."""
    return f"{result.name}: {'error: ' if result.status == 'error' else ''}{result.message}"


def exit_code(results: Sequence[CheckResult | UpdateResult]) -> int:
    """0 if all passed, 1 if some deviated, 2 if anything could not be checked, or nothing was."""
    statuses = {result.status for result in results}
    if "error" in statuses or not statuses:
        return 2
    return 1 if "deviated" in statuses else 0


def without(baseline: Baseline, signals: Sequence[str]) -> Baseline:
    """Baseline without signals."""
    return replace(baseline, columns={name: values for name, values in baseline.columns.items() if name not in signals})


def old_baseline(folder: Path, name: str) -> tuple[Baseline | None, str | None]:
    """The baseline that an update replaces and why it cannot be read; both None if there is none."""
    if not any(file.exists() for file in baseline_files(folder, name)):
        return None, None
    try:
        return read_baseline(folder, name), None
    except (BaselineError, CsvError) as error:
        return None, in_one_line(error)


def change_notes(old: Baseline, new: Baseline, moved: dict[str, WorstDifference], units: dict[str, str]) -> list[str]:
    """What differs between two baselines, one phrase each; empty if nothing does."""
    notes = [f"{name} moved by at most {difference!r} {units[name]}".rstrip() + f" (t = {at:.9g} s)"
             for name, (difference, at) in moved.items() if difference > 0.0]
    notes += [f"{name} added" for name in new.columns if name not in old.columns]
    notes += [f"{name} removed" for name in old.columns if name not in new.columns]
    if old.stop_time != new.stop_time:
        notes.append(f"it ended at t = {old.stop_time:.9g} s")
    if len(old.time) != len(new.time):
        notes.append(f"it had {len(old.time)} samples")
    for name, tolerance in new.tolerances.items():
        was = old.tolerances.get(name, tolerance)
        if was != tolerance:
            notes.append(f"tolerance of {name} was {was.absolute!r} + {was.relative!r} relative, is "
                         f"{tolerance.absolute!r} + {tolerance.relative!r} relative")
    return notes


def deviation_text(deviation: Deviation, unit: str) -> str:
    """A deviation in words, with every digit: expected and got can differ in the last one."""
    expected, got, allowed = (f"{text} {unit}".rstrip() for text in
                              (repr(deviation.expected), repr(deviation.got), f"{deviation.allowed:.6g}"))
    return (f"deviates first at t = {deviation.time:.9g} s: {deviation.signal} expected {expected}, got {got}, "
            f"allowed {allowed}")


def units_of(experiment: Experiment, signals: Iterable[str]) -> dict[str, str]:
    """Units of signals `fmu.variable`, as the FMUs declare them."""
    units = {f"{fmu}.{variable.name}": variable.unit or "" for fmu, description in experiment.check().items()
             for variable in description.modelVariables}
    return {signal: units.get(signal, "") for signal in signals}
