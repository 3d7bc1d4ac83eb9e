"""Check of runs against their committed baselines, of the baselines themselves, and their update."""

import time
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np

from maglev.cosim.master import Recording, RunFailed
from maglev.files.arrays import Array
from maglev.files.errors import FAILURES, BaselineError, CsvError, in_one_line
from maglev.files.interrupts import held_interrupts
from maglev.files.pictures import new_figure, write_figure
from maglev.files.side_by_side import Progress, Watcher
from maglev.files.time_grid import ON_GRID
from maglev.files.units import unit_of
from maglev.runs.baseline_file import (
    DIGESTS,
    Baseline,
    Tolerance,
    baseline_file,
    digest_of,
    from_recording,
    read_baseline,
    rows_before_contact,
    tolerances_of,
    write_baseline,
)
from maglev.runs.chain import Ends, ends_of, started
from maglev.runs.check_outcome import (
    CheckResult,
    DeviatingSample,
    UpdateResult,
    WorstDifference,
    changes,
    closest,
    first_deviation,
    samples_of,
    worst,
)
from maglev.runs.execution import run_each
from maglev.runs.preparation import Experiment
from maglev.scenario.quantities import common_unit
from maglev.scenario.run_plan import RunPlan

BEYOND = 2   # check intervals that a run continues after the end of its baseline, to see why it ends there
RENEW = "; `maglev check --update` writes a new baseline"


def check_run(baselines: Path, experiment: Experiment, ends: Ends, progress: Progress | None = None,
              pictures: Path | None = None) -> CheckResult:
    """Run an experiment to the end of its baseline in the folder `baselines`, and a little further, and compare.

    `ends` are those of the runs that it starts from. A picture of a deviating run goes into the folder `pictures`. An
    error that the user can correct is a result, too: the status "error".
    """
    plan = experiment.plan
    begin = time.perf_counter()
    try:
        experiment.require_current()
        # First, because a run is long and a missing baseline is found at once.
        baseline = read_baseline(baselines, plan)
        # A baseline of an FMU that was put in lacks what this FMU lacks.
        require_fit(plan, baseline, baselines)
        exact = baseline.digest is not None and experiment.exact()
        # With a digest to its end, otherwise only far enough to find why the baseline ends.
        end = plan.stop_time if exact else min(plan.stop_time, baseline.stop_time + BEYOND * plan.check.interval)
        experiment = replace(experiment, plan=started(plan, ends).model_copy(update={"stop_time": end}))
        baseline = replace(baseline, columns={name: values for name, values in baseline.columns.items()
                                              if name not in experiment.not_compared})
        units = experiment.units(baseline.columns)
        recording = recorded_to(experiment, baseline.stop_time, progress)
        digest, tolerances = digest_of(recording.time, recording.columns), tolerances_of(plan)
        same = exact and digest == baseline.digest
        samples = samples_of(baseline, recording)
        deviation = first_deviation(baseline.time, baseline.columns, samples, tolerances)
        differences = worst(baseline.time, baseline.columns, samples)
        if deviation is None:
            # Flags that an FMU which was put in lacks are not looked at.
            require_whole(plan, baseline, recording, baselines, same)
        if exact and not same and deviation is None:
            none = dict.fromkeys(baseline.columns, Tolerance(0.0, 0.0))
            deviation = first_deviation(baseline.time, baseline.columns, samples, none)
        nearest = closest(baseline, samples, tolerances)
        if pictures is not None:
            picture = pictures / f"{plan.name}.check.png"
            if deviation is not None:
                write_deviation_picture(picture, baseline, recording, samples, deviation)
            else:
                picture.unlink(missing_ok=True)   # of an earlier check
    except FAILURES as error:
        return CheckResult(plan.name, "error", in_one_line(error), None, {}, time.perf_counter() - begin)
    # A run that was cut short has not come to the results that others start from.
    reached = ends_of(recording) if end == plan.stop_time else {}
    result = partial(CheckResult, plan.name, deviation=deviation, worst=differences, units=units, ends=reached,
                     elapsed=time.perf_counter() - begin, notes=recording.notes)
    if deviation is not None:
        return result("deviated", deviation_text(deviation, units[deviation.signal]))
    if exact and baseline.digest is not None:
        extent, expected = digest.extent, baseline.digest.extent
        return result("passed", f"passed, {extent} equal the baseline bit for bit") if same else result(
            "deviated", f"deviates: {extent} do not have the bits of the baseline, though those of its table do"
                        f"{'' if extent == expected else f'; expected {expected}'}")
    message = f"passed, {len(differences)} signals at {len(baseline.time)} samples to t = {baseline.stop_time:.9g} s "
    if nearest is None:
        message += "equal the baseline"
    else:
        signal, *sizes = nearest
        unit = common_unit(sizes[1:], units[signal])   # in which what is allowed reads well
        off = " of ".join(f"{size / unit_of(unit).factor:.3g}" if unit else f"{size:.3g}" for size in sizes)
        message += f"are within their tolerances, the closest is {signal}, off by {off} {unit}".rstrip()
    if baseline.digest is None and experiment.exact():
        message += f"; not bit for bit, for {plan.name} is not in {DIGESTS}"
    if experiment.not_compared:
        message += f"; not compared, for the FMU has no such signals: {', '.join(experiment.not_compared)}"
    return result("passed", message)


def recorded_to(experiment: Experiment, end: float, progress: Progress | None) -> Recording:
    """Recording of a run; also of one that an FMU ends, if that is after the end of the baseline (s)."""
    try:
        return experiment.run(progress)
    except RunFailed as error:
        if not len(error.recording.time) or error.recording.time[-1] < end:
            raise
        return error.recording


def check_runs(experiments: Sequence[Experiment], baselines: Path, jobs: int, watch: Watcher,
               pictures: Path | None = None) -> list[CheckResult]:
    """Check runs in other processes, at most `jobs` at a time; see `check_run` for the other parameters."""
    return run_each(experiments, partial(check_run, baselines, pictures=pictures),
                    lambda experiment, message: CheckResult(experiment.plan.name, "error", message, None, {}, 0.0),
                    jobs, watch)


def deviation_text(deviation: DeviatingSample, unit: str) -> str:
    """A deviation in words, with every digit: expected and got can differ in the last one."""
    expected, got, allowed = (f"{text} {unit}".rstrip() for text in
                              (repr(deviation.expected), repr(deviation.got), f"{deviation.allowed:.6g}"))
    return (f"deviates first at t = {deviation.time:.9g} s: {deviation.signal} expected {expected}, got {got}, "
            + (f"allowed {allowed}" if deviation.allowed else "expected the same bits"))


def require_fit(plan: RunPlan, baseline: Baseline, folder: Path) -> None:
    """Refuse a baseline that no longer fits the plan, because a part would then go unchecked."""
    file, near = baseline_file(folder, plan.name), ON_GRID * plan.step
    off_grid = np.abs(baseline.time - plan.check.interval * np.arange(len(baseline.time))) > near
    if off_grid.any():
        k = int(np.argmax(off_grid))
        raise BaselineError(f"{file}: sample {k + 1} is at t = {baseline.time[k]:.9g} s, expected "
                            f"{k * plan.check.interval:.9g} s by check.interval of the scenario{RENEW}")
    if baseline.stop_time > plan.stop_time + near:
        raise BaselineError(f"{file}: ends at t = {baseline.stop_time:.9g} s, expected at most the stop time of the "
                            f"scenario, {plan.stop_time} s{RENEW}")
    for name in plan.check.signals:
        if name not in baseline.columns:
            raise BaselineError(f"{file}: there is no column {name}, expected every signal of check.signals in "
                                f"{plan.source}{RENEW}")
    for name in baseline.columns:
        if name not in plan.check.signals:
            raise BaselineError(f"{file}: there is a column {name}, expected signals of check.signals in "
                                f"{plan.source}{RENEW}")


def require_whole(plan: RunPlan, baseline: Baseline, recording: Recording, folder: Path, same: bool) -> None:
    """Refuse a baseline that ends before its run does, and before a stop is touched or the controller trips.

    Where a run with other bits touches a stop, its baseline may end before; not so if the run is the `same`.
    """
    rows = rows_before_contact(plan, recording)
    untouched = rows == len(recording.time)
    end = plan.stop_time if untouched else float(recording.time[rows - 1])
    if (untouched or same) and end - baseline.stop_time > plan.check.interval - 0.5 * plan.step:
        raise BaselineError(f"{baseline_file(folder, plan.name)}: ends at t = {baseline.stop_time:.9g} s, expected "
                            f"samples to {end:.9g} s, for no stop is touched and nothing trips before{RENEW}")


MOST = 6   # signals, that of the deviation among them


def write_deviation_picture(path: Path, baseline: Baseline, recording: Recording, samples: Mapping[str, Array],
                            deviation: DeviatingSample) -> None:
    """Write a picture, a row for each signal: both curves, and their difference. MaglevError without matplotlib."""
    names = [deviation.signal, *(name for name in baseline.columns if name != deviation.signal)][:MOST]
    figure = new_figure(11.0, 1.0 + 1.6 * len(names))
    figure.suptitle(f"{baseline.name}: off from t = {deviation.time:.6g} s")
    rows = figure.subplots(len(names), 2, sharex=True, squeeze=False)
    for (curves, differences), name in zip(rows, names, strict=True):
        curves.plot(recording.time, recording.columns[name], linewidth=1.2, label="now")
        curves.plot(baseline.time, baseline.columns[name], "k.", markersize=3.0, label="baseline")
        differences.plot(baseline.time, samples[name] - baseline.columns[name], "k.-", markersize=3.0, linewidth=0.8)
        for axes in (curves, differences):
            axes.axvline(deviation.time, color="tab:red", linewidth=0.8)
        curves.set_ylabel(name, fontsize="small")
    rows[0, 0].legend(loc="upper right", fontsize="small")
    rows[0, 1].set_title("now − baseline", fontsize="small")
    for axes in rows[-1]:
        axes.set_xlabel("t, s")
    write_figure(path, figure)


def renewed(baselines: Path, experiment: Experiment, ends: Ends, progress: Progress | None = None) -> UpdateResult:
    """Run a whole experiment and make its baseline, not yet written; says what moved against the old one."""
    plan = experiment.plan
    begin = time.perf_counter()
    try:
        experiment.require_current()
        old, unreadable = old_baseline(baselines, plan)
        experiment = replace(experiment, plan=started(plan, ends))
        units = experiment.units(plan.check.signals)
        recording = experiment.run(progress)
        new = from_recording(plan, experiment.step, recording, experiment.exact())
        reached = ends_of(recording)
    except FAILURES as error:
        return UpdateResult(plan.name, "error", in_one_line(error), {}, time.perf_counter() - begin)
    result = partial(UpdateResult, plan.name, elapsed=time.perf_counter() - begin, ends=reached, notes=recording.notes,
                     baseline=new)
    extent = f"{len(new.columns)} signals at {len(new.time)} samples to t = {new.stop_time:.9g} s"
    if old is None:
        return result("new", f"new, {extent}", {}) if unreadable is None else result(
            "replaced", f"replaced, {extent}; the old one: {unreadable}", {})
    try:
        moved = changes(old, new)
    except BaselineError as error:
        return result("replaced", f"replaced, {extent}; nothing to compare: {error}", {})
    notes = change_notes(old, new, moved, units)
    return result("updated", "; ".join([f"updated, {extent}", *notes]), moved) if notes else result(
        "unchanged", f"unchanged, {extent}", moved)


def write_updated(result: UpdateResult, baselines: Path) -> UpdateResult:
    """Write the new baseline of a result; after an error, which is a result, too, the old one stands."""
    try:
        if result.baseline is not None:
            write_baseline(baselines, result.baseline)
    except FAILURES as error:
        return UpdateResult(result.name, "error", in_one_line(error), {}, result.elapsed)
    return result


def update_all(experiments: Sequence[Experiment], baselines: Path, jobs: int, watch: Watcher) -> list[UpdateResult]:
    """Update the baselines of runs; see `check_runs` for the parameters.

    They are written together when all runs are done: after an interruption before that, all old ones are still there.
    """
    results = run_each(experiments, partial(renewed, baselines),
                       lambda experiment, message: UpdateResult(experiment.plan.name, "error", message, {}, 0.0), jobs,
                       watch)
    with held_interrupts():
        return [write_updated(result, baselines) for result in results]


def old_baseline(folder: Path, plan: RunPlan) -> tuple[Baseline | None, str | None]:
    """The baseline that an update replaces and why it cannot be read; both None if there is none."""
    if not baseline_file(folder, plan.name).exists():
        return None, None
    try:
        return read_baseline(folder, plan), None
    except (BaselineError, CsvError) as error:
        return None, in_one_line(error)


def change_notes(old: Baseline, new: Baseline, moved: dict[str, WorstDifference], units: dict[str, str]) -> list[str]:
    """Return the differences between two baselines, one phrase each; empty if nothing differs."""
    notes = [f"{name} moved by at most {difference!r} {units[name]}".rstrip() + f" (t = {at:.9g} s)"
             for name, (difference, at) in moved.items() if difference > 0.0]
    notes += [f"{name} added" for name in new.columns if name not in old.columns]
    notes += [f"{name} removed" for name in old.columns if name not in new.columns]
    if old.digest != new.digest and not notes:
        notes.append("its digest is another one" if old.digest and new.digest else
                     "it has a digest now" if new.digest else "it has no digest any more")
    if old.stop_time != new.stop_time:
        notes.append(f"it ended at t = {old.stop_time:.9g} s")
    if len(old.time) != len(new.time):
        notes.append(f"it had {len(old.time)} samples")
    return notes
