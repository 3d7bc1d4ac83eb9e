"""Runs against their committed baselines, and the update of these."""

from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import TypeVar, Unpack

from maglev.api.options import experiments_of
from maglev.api.running import say_notes
from maglev.files.errors import ScenarioError, option
from maglev.files.pictures import require_matplotlib
from maglev.files.side_by_side import Say, Watch, processes, unwatched, warn
from maglev.runs.baseline_check import check_runs, update_all
from maglev.runs.baseline_file import baseline_file
from maglev.runs.chain import Scenarios, needed, select
from maglev.runs.check_outcome import CheckResult, UpdateResult, write_junit
from maglev.scenario.layers import PACKAGED
from maglev.scenario.options import CheckOptions, takes_options
from maglev.scenario.run_plan import RunPlan

Result = TypeVar("Result", CheckResult, UpdateResult)


@takes_options
def check(names: Scenarios | None = None, *, baselines: str | Path | None = None,
          junit: str | Path | None = None, pictures: str | Path | None = None, jobs: int | None = None,
          watch: Watch | None = None, say: Say | None = None, **options: Unpack[CheckOptions]) -> list[CheckResult]:
    """Simulate runs, and compare them with their baselines.

    Parameters
    ----------
    names : str, Path or mapping, or iterable of these, optional
        Scenarios, variants, TOML files or tables; every scenario of the package if not given.
    baselines : path, optional
        Folder with `NAME_ref.csv` and `digests.txt`; for scenarios of the package its own if not given.
    junit : path, optional
        Also write the outcome as JUnit XML.
    pictures : path, optional
        Folder for `NAME.check.png` of each run that deviates: expected and actual signals (extra `report`).
    jobs, watch, say
        See `run_all`.
    **options
        See `run`; the communication step and the order are those of the baselines.

    Returns
    -------
    list of CheckResult
        One for each run, with the status "passed", "deviated" or "error".

    Raises
    ------
    MaglevError
        If a name or an option cannot be used.

    Examples
    --------
    >>> import maglev
    >>> [result.status for result in maglev.check(["2dof-smooth-nonlinear"])]
    ['passed']
    """
    if pictures is not None:
        require_matplotlib()
    work = partial(check_runs, pictures=None if pictures is None else Path(pictures))
    results = run_with_baselines(work, False, names, baselines, jobs, watch, say, options)
    if junit is not None:
        write_junit(Path(junit), results)
    return results


@takes_options
def update(names: Scenarios | None = None, *, baselines: str | Path | None = None, jobs: int | None = None,
           watch: Watch | None = None, say: Say | None = None, **options: Unpack[CheckOptions]) -> list[UpdateResult]:
    """Simulate runs, write their baselines again, and report the changes; see `check` for parameters and errors.

    The baselines are written when all runs are done: after Ctrl-C, all are unchanged.
    """
    return run_with_baselines(update_all, True, names, baselines, jobs, watch, say, options)


def require_packaged(plans: Sequence[RunPlan], write: bool) -> None:
    """Refuse to look among the baselines of the package for that of a user's scenario, and to write it there."""
    for plan in plans:
        if plan.own and (write or not baseline_file(PACKAGED / "baselines", plan.name).exists()):
            raise ScenarioError(f"{plan.source}: needs {option('baselines')}, the folder of its baseline; "
                                "the package has baselines of its own scenarios only")


def run_with_baselines(work: Callable[..., list[Result]], write: bool, names: Scenarios | None,
                       baselines: str | Path | None, jobs: int | None, watch: Watch | None, say: Say | None,
                       options: CheckOptions) -> list[Result]:
    """Check or update the given runs and, after them, the runs that they start from."""
    plans = select(names)
    plans += needed(plans)
    if baselines is None:
        require_packaged(plans, write)
    experiments = experiments_of(plans, options, say or warn, watch or unwatched)
    say_notes(experiments, say or warn)
    with (watch or unwatched)([experiment.plan.name for experiment in experiments]) as watcher:
        results = work(experiments, PACKAGED / "baselines" if baselines is None else Path(baselines), processes(jobs),
                       watcher)
    for result in results:
        for note in result.notes:
            (say or warn)(f"{result.name}: {note}")
    return results
