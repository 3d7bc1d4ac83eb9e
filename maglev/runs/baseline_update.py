"""Update of the committed baselines of runs."""

import time
from collections.abc import Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from maglev.files.errors import FAILURES, BaselineError, CsvError, in_one_line
from maglev.files.interrupts import held_interrupts
from maglev.files.side_by_side import Progress, Watcher
from maglev.runs.baseline_file import Baseline, baseline_file, from_recording, read_baseline, write_baseline
from maglev.runs.chain import Ends, ends_of, started
from maglev.runs.check_outcome import UpdateResult
from maglev.runs.deviation import WorstDifference, changes
from maglev.runs.execution import run_each
from maglev.runs.preparation import Experiment
from maglev.scenario.run_plan import RunPlan


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
