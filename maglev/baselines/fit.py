"""Whether a baseline is that of a plan: what was cut, edited or outgrown would otherwise go unchecked."""

from pathlib import Path

from maglev.baselines.baseline import ON_GRID, Baseline, baseline_files, rows_before_contact
from maglev.cosim.master import Recording
from maglev.errors import BaselineError
from maglev.schema.run_plan import RunPlan

BEYOND = 2   # check intervals that a run goes on after the end of its baseline, to see why it ends there


def require_fit(plan: RunPlan, baseline: Baseline, folder: Path) -> None:
    """Refuse a baseline that the plan has outgrown: what it lacks would otherwise go unchecked."""
    samples, options = baseline_files(folder, plan.name)
    if abs(plan.step - baseline.step) > ON_GRID * baseline.step:
        raise BaselineError(f"{options}: StepSize = {baseline.step}: expected the communication step of the scenario, "
                            f"{plan.step} s; `maglev check --update` writes a new baseline")
    if baseline.stop_time > plan.stop_time + ON_GRID * baseline.step:
        raise BaselineError(f"{options}: StopTime = {baseline.stop_time}: expected at most the stop time of the "
                            f"scenario, {plan.stop_time} s; `maglev check --update` writes a new baseline")
    if abs(plan.check.interval - baseline.interval) > ON_GRID * baseline.step:
        raise BaselineError(f"{options}: OutputInterval = {baseline.interval}: expected check.interval of the "
                            f"scenario, {plan.check.interval} s; `maglev check --update` writes a new baseline")
    for name, expected in plan.check.signals.items():
        if name in baseline.columns and baseline.tolerances[name] != (expected.absolute, expected.relative):
            raise BaselineError(f"{options}: the tolerance of {name} is {baseline.tolerances[name].absolute} + "
                                f"{baseline.tolerances[name].relative} relative, expected that of the scenario, "
                                f"{expected.absolute} + {expected.relative} relative; `maglev check --update` writes a "
                                "new baseline")
        if name not in baseline.columns:
            raise BaselineError(f"{samples}: there is no column {name}, expected every signal of check.signals in "
                                f"{plan.path}; `maglev check --update` writes a new baseline")


def require_whole(plan: RunPlan, baseline: Baseline, recording: Recording, folder: Path) -> None:
    """Refuse a baseline that ends before its run does, and before a stop is touched or the controller trips."""
    untouched = rows_before_contact(plan, recording) == len(recording.time)
    if untouched and plan.stop_time - baseline.stop_time > plan.check.interval - 0.5 * plan.step:
        raise BaselineError(f"{baseline_files(folder, plan.name)[0]}: ends at t = {baseline.stop_time:.9g} s, expected "
                            f"samples to {plan.stop_time} s, for no stop is touched and nothing trips; `maglev check "
                            "--update` writes a new baseline")
