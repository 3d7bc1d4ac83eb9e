"""Runs: one of them as data, or many with files, verdicts and a page."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Unpack, get_args

from maglev.api.options import experiments_of
from maglev.api.run import Run
from maglev.files.errors import ScenarioError, UnknownName, nearest, one_of, option
from maglev.files.pictures import require_matplotlib, write_figure
from maglev.files.side_by_side import Progress, Say, Watch, processes, unwatched, warn
from maglev.files.units import own_number
from maglev.files.whole_file import write_whole
from maglev.pages.picture import figure_of
from maglev.pages.report_page import write_report
from maglev.pages.run_text import (
    Printable,
    Verdicts,
    claims_markdown,
    run_text,
    short_outcome,
    show_results,
    write_outcomes,
)
from maglev.pages.what_if import run_frictionless
from maglev.runs.chain import Scenarios, compared_with, needed, select
from maglev.runs.execution import RunResult, completed_run, execute_all, judge_all, require_judgeable, run_as_json
from maglev.runs.preparation import Experiment
from maglev.runs.procedure_outcome import Outcome
from maglev.runs.procedures import evaluate_all, judge_outcomes
from maglev.runs.replacement import start_value_notes
from maglev.runs.results import alone, require_parquet
from maglev.runs.verdicts import ClaimResult, Judgements
from maglev.scenario.layers import Scenario
from maglev.scenario.loading import load_plan
from maglev.scenario.options import Format, RunOptions, takes_options
from maglev.scenario.run_plan import RunPlan

if TYPE_CHECKING:
    from rich.console import Console

MOST_SHOWN = 5   # runs in the text of results

ClaimsOf = Literal["thesis"]


@dataclass(frozen=True, eq=False, repr=False)
class Results(Printable, Mapping[str, Run]):
    """Results of many runs, a mapping of the completed ones by name.

    Attributes
    ----------
    asked : tuple of str
        Names of the requested runs; those that they start from or compare with come after them.
    runs : tuple of RunResult
        Also those that did not complete, with their reasons.
    outcomes : tuple of Outcome
        Outcomes of the procedures that the runs belong to.
    verdicts : mapping of str to sequence of ClaimResult
        By name of the run or procedure.
    files : tuple of Path
        The written files.
    units : mapping of str to mapping of str to str
        Of the columns, by name of the run.
    """

    asked: tuple[str, ...]
    runs: tuple[RunResult, ...]
    outcomes: tuple[Outcome, ...]
    verdicts: Judgements
    files: tuple[Path, ...]
    units: Mapping[str, Mapping[str, str]]

    def __getitem__(self, name: str) -> Run:
        """Return a run by its name; UnknownName if there is none, or it did not complete."""
        result = next((run for run in self.runs if run.plan.name == name), None)
        if result is None or result.failure is not None:
            raise UnknownName(f"{name} did not complete: {result.failure}" if result else
                              f"there is no run {name!r}, {nearest(name, self)}")
        return Run(result, self.units[name])

    def __iter__(self) -> Iterator[str]:
        return (run.plan.name for run in self.runs if run.failure is None)

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __repr__(self) -> str:
        runs = "; ".join(f"{run.plan.name}: {short_outcome(run)}" for run in self.runs[:MOST_SHOWN])
        more = f"; and {len(self.runs) - MOST_SHOWN} more" if len(self.runs) > MOST_SHOWN else ""
        return f"<Results: {runs}{more}>"

    def show(self, console: "Console") -> None:
        """Print the tables on a console of rich."""
        show_results(console, self.asked, self.runs, self.verdicts, self.outcomes)

    @property
    def missed(self) -> tuple[str, ...]:
        """Return a sentence for each missed claim, and for each run that failed or did not complete; see
        `--fail-on-claims`.

        A user's own claims count also if they could not be judged. A failure that a claim asks for does not count.
        """
        return (*(said for run in self.runs if run.plan.name in self.asked
                  for said in missed_by(run, self.verdicts[run.plan.name])),
                *(said for outcome in self.outcomes
                  for said in missed_claims(outcome.settings.name, self.verdicts[outcome.settings.name])))

    def as_data(self) -> dict[str, Any]:
        """Return everything except the columns in JSON form: by run, provenance, metrics, measures and verdicts."""
        runs = {result.plan.name: {**run_as_json(result), "claims": claims_data(self.verdicts[result.plan.name])}
                for result in self.runs}
        procedures = {outcome.settings.name: {"title": outcome.settings.title,
                                              "claims": claims_data(self.verdicts[outcome.settings.name])}
                      for outcome in self.outcomes}
        return {"runs": runs, "procedures": procedures, "missed": list(self.missed),
                "files": [str(path) for path in self.files]}


def missed_by(run: RunResult, claims: Sequence[ClaimResult]) -> list[str]:
    """Return the misses of a run, a sentence for each; see `Results.missed`."""
    name = run.plan.name
    if run.metrics is None:
        return [f"{name}: did not complete"]
    asked_for = any(judged.claim.quantity in ("failed", "stop_contact", "tripped") and judged.claim.target is True
                    for judged in claims)
    flawed = [] if asked_for or run.outcome == "completed" else [f"{name}: {short_outcome(run)}"]
    return [*flawed, *missed_claims(name, claims)]


def missed_claims(name: str, claims: Sequence[ClaimResult]) -> list[str]:
    """Return the missed claims about a run or a procedure, a sentence for each; see `Results.missed`."""
    return [f"{name}: {judged.verdict}: {judged.claim.text}" + (f" ({judged.claim.criterion}: {judged.measured_text})"
                                                                if judged.measured is not None else "")
            for judged in claims if judged.verdict in ("not met", "no difference", "not reproduced")
            or (judged.claim.own and judged.verdict in ("not run", "not testable"))]


def claims_data(claims: Sequence[ClaimResult]) -> list[dict[str, Any]]:
    """Return claims with their verdicts in JSON form."""
    return [{"claim": judged.claim.text, "kind": judged.claim.kind, "source": judged.claim.cited,
             "criterion": judged.claim.criterion, "measured": judged.measured_text, "verdict": judged.verdict,
             "note": judged.note} for judged in claims]


@takes_options
def run(name: Scenario, *, every: int | None = None, progress: Progress | None = None,
        **options: Unpack[RunOptions]) -> Run:
    """Simulate one run and return its columns and metrics; no files are written.

    It runs in this process; a third-party FMU in one of its own, which may crash.

    Parameters
    ----------
    name : str, Path or mapping
        A run of `scenarios()`, such as "3dof-setpoints", or your own TOML file without variants. Or its content as a
        table, whose relative paths begin in the working folder.
    set : mapping of str to value, optional
        Start values that go before the plan's, by `fmu.variable`; SI, or text with a unit: {"plant.y.mass": "7.2 kg"}.
    parameters : path, or mapping of str to path, optional
        Parameter sets (SSV) with start values: one whose names begin with an FMU's, "plant.y.mass", or one for each
        FMU, {"plant": "plant.ssv"}. They go before the plan's and those of `model`; `set` goes before them.
    model : path, optional
        Constants of plant and controller, a file that `identify` has written; or "plant": the model of the controller
        follows the masses of the plant. `set` goes before it.
    plant, controller : path, class or object, optional
        Replacement for the plan's FMU: the name of an FMU of this project, or the path of an FMU or of a Python file.
        In the file is a class, "lqi.py" or "lqi.py:LQI". It can also be the class itself, or an object of it, with a
        copy of which the run begins (docs/controllers.md). Classes and objects run in this process.
    ports : path, optional
        TOML file with their names for the ports, and the units.
    step : float or str, optional
        Communication step, s or with a unit.
    order : "sequential" or "jacobi"
        One FMU after the other, or all at once with the outputs of the step before.
    fmus : path, optional
        Folder with FMUs, taken as they are; if not given, missing ones are built and kept in the user's cache.
    kind : "python" or "native", optional
        Of the same results; native where there is a compiler if not given. Native ones of `fmus` are in its `native`.
    fmi : int
        3 for those of FMI 3.0, native as well, of the folder's folder `fmi3`.
    timeout : float or str
        Longest time that a call of a third-party FMU may take, s or with a unit.
    keep_settings : bool
        Also give a replacement the settings (gains, limits) of the replaced model, if it has parameters of their
        names; otherwise only FMUs of this project share them (docs/controllers.md).
    every : int, optional
        Keep every n-th communication step, instead of the plan's output interval. The metrics use all steps.
    progress : callable, optional
        Called from time to time with the steps done and the steps in all.

    Raises
    ------
    MaglevError
        If an argument cannot be used; `RunFailed` if an FMU ends the run, with the recording until then.
    KeyboardInterrupt
        `RunInterrupted` after Ctrl-C, with the recording until then.

    Examples
    --------
    >>> import maglev
    >>> run = maglev.run("2dof-smooth-nonlinear", set={"plant.h.friction.coulomb": 0.0})
    >>> run["plant.v.position"].shape == run.time.shape
    True
    >>> run.metrics.failed
    False
    """
    plan = load_plan(name)
    if plan.needs:
        raise ScenarioError(f"{plan.name} needs the results of {', '.join(sorted(plan.needs))}: use run_all, which "
                            "runs these first")
    experiment, = keeping(experiments_of([plan], options), every)
    say_notes([experiment], warn)
    recording = experiment.run(progress)
    for note in recording.notes:
        warn(note)
    return Run(completed_run(experiment, recording), experiment.units(recording.columns), recording)


@takes_options
def run_all(names: Scenarios | None = None, *, out: str | Path = "results", plot: bool = False,
            page: bool | Literal["run"] = False, what_if: bool = True, claims: ClaimsOf | None = None,
            format: Format = "csv", every: int | None = None, jobs: int | None = None, watch: Watch | None = None,
            say: Say | None = None, **options: Unpack[RunOptions]) -> Results:
    """Run scenarios side by side, judge the claims about them, and write the results.

    Parameters
    ----------
    names : str, Path or mapping, or iterable of these, optional
        Scenarios, variants, TOML files or tables; every experiment of the package if not given.
    out : path
        Folder for NAME.csv, NAME.json (provenance and metrics), NAME.txt and, of runs with claims, claims.md.
    plot : bool
        Also write pictures, NAME.png.
    page : bool or "run"
        Also write one HTML page about all, report.html; with "run", if it is one run, NAME.html.
    what_if : bool
        For report.html repeat, without friction, the runs of missed claims whose reasons blame friction; the files are
        in the folder `without-friction`.
    claims : "thesis", optional
        Show the thesis's claims also for runs with your own controller, stage, scenario or values. They have no
        verdict there.
    format : "csv" or "parquet"
        Of the columns: NAME.parquet, with units and provenance in it, replaces NAME.csv.
    every : int, optional
        As of `run`.
    jobs : int, optional
        Runs at a time, in as many processes; as many as processors if not given.
    watch : callable, optional
        Called with the names of the runs; returns a context manager, whose value is called with their progress.
    say : callable, optional
        Called with one sentence for each port that a replaced FMU lacks, and each message of an FMU; a warning if not
        given.
    **options
        As of `run`.

    Returns
    -------
    Results
        Runs that did not complete are in it, with their reasons.

    Raises
    ------
    MaglevError
        If a name, an option or a scenario cannot be used.
    """
    # Errors that would come after the runs come before them.
    if format not in get_args(Format):   # the ending of the files, too
        raise ScenarioError(f"{option('format', format)}: expected {one_of(format, get_args(Format))}")
    if plot:
        require_matplotlib()
    if format == "parquet":
        require_parquet()
    asked = sorted((plan for plan in select(names) if names is not None or not plan.check_only),
                   key=lambda plan: not plan.own)   # a user's own runs before the thesis's
    jobs, watch, say = processes(jobs), watch or unwatched, say or warn
    experiments = keeping(experiments_to_run(asked, options, claims == "thesis", say, watch), every)
    require_judgeable(experiments)
    say_notes(experiments, say)
    folder, by_name = Path(out), {experiment.plan.name: experiment for experiment in experiments}
    folder.mkdir(parents=True, exist_ok=True)
    with alone(folder, [*by_name]):
        runs = run_experiments(experiments, folder, format, jobs, watch)
        for note in dict.fromkeys(f"{result.plan.name}: {note}" for result in runs for note in result.recording.notes):
            say(note)
        outcomes = evaluate_all(runs, {plan.name for plan in asked})
        judged = {**judge_all(runs), **judge_outcomes(outcomes, [run.plan.name for run in runs if run.modified])}
        verdicts = {name: Verdicts(claims) for name, claims in judged.items()}
        files = [*write_runs(runs, verdicts, folder, format, plot), *write_outcomes(outcomes, verdicts, folder)]
        if any(verdicts.values()):
            files.append(folder / "claims.md")
            write_whole(files[-1], claims_markdown(runs, verdicts, outcomes))
        if page:
            again = run_frictionless(experiments, verdicts if what_if and page != "run" else {}, lambda runs:
                                     run_experiments(runs, folder / "without-friction", format, jobs, watch))
            files.append(folder / (f"{asked[0].name}.html" if page == "run" and len(asked) == 1 else "report.html"))
            write_report(files[-1], runs, {**verdicts, **again.verdicts}, outcomes, again)
    return Results(tuple(plan.name for plan in asked), tuple(runs), tuple(outcomes), verdicts, tuple(files),
                   {run.plan.name: by_name[run.plan.name].units(run.columns) for run in runs if not run.failure})


def keeping(experiments: Sequence[Experiment], every: int | None) -> list[Experiment]:
    """Return the planned runs, with every n-th communication step kept if a number is given; ScenarioError without
    runs.
    """
    if every is None:
        return [*experiments]
    number = own_number(every)
    for experiment in experiments:
        steps = len(experiment.times) - 1
        if type(number) is not int or not 1 <= number <= steps:
            raise ScenarioError(f"{option('every', every)}: expected a whole number from 1 to {steps}, the "
                                f"communication steps of {experiment.plan.name}")
    return [replace(experiment, plan=experiment.plan.model_copy(update={"output_interval": every * experiment.step}))
            for experiment in experiments]


def experiments_to_run(asked: Sequence[RunPlan], options: RunOptions, thesis: bool, say: Say, watch: Watch
                       ) -> list[Experiment]:
    """Runs that were asked for, those that their claims compare with, and those that these start from, made ready.

    If both sides of a comparison have another FMU, a claim of the thesis is not judged. A user's own claims compare
    with runs as planned. Unless `thesis` is asked for, runs that are not the thesis's have none of its claims.
    """
    def with_its_claims(plan: RunPlan, changed: bool) -> RunPlan:
        return without_thesis(plan) if (plan.own or changed) and not thesis else plan

    def made_ready(plans: Sequence[RunPlan], chosen: RunOptions) -> list[Experiment]:
        return [replace(experiment, plan=with_its_claims(experiment.plan, experiment.modified))
                for experiment in experiments_of(plans, chosen, say, watch)]

    if not (options.get("plant") or options.get("controller")):
        changed = any(options.get(name) for name in ("set", "parameters", "model"))
        plans = [*asked, *compared_with([with_its_claims(plan, changed) for plan in asked])]
        return made_ready([*plans, *needed(plans)], options)
    plans = [*asked, *needed(asked)]
    names = {plan.name for plan in plans}
    others = [plan for plan in compared_with(list(map(without_thesis, asked)))
              if not names & {other.name for other in needed([plan])}]
    as_planned: RunOptions = {**options, "set": None, "parameters": None, "model": None, "plant": None,
                              "controller": None, "ports": None, "keep_settings": False}
    return [*made_ready(plans, options), *made_ready([*others, *needed(others)], as_planned)]


def without_thesis(plan: RunPlan) -> RunPlan:
    """A run with the user's own claims alone, also those of its procedure."""
    own = plan.model_copy(update={"claims": [claim for claim in plan.claims if claim.own]})
    if plan.procedure is None:
        return own
    mine = [claim for claim in plan.procedure.claims if claim.own]
    return own.model_copy(update={"procedure": plan.procedure.model_copy(update={"claims": mine})})


def run_experiments(experiments: Sequence[Experiment], out: Path, form: Format, jobs: int,
                    watch: Watch) -> list[RunResult]:
    """Make a single run here, several in processes; each leaves its columns."""
    with watch([experiment.plan.name for experiment in experiments]) as watcher:
        if len(experiments) == 1:
            experiments[0].check()   # of many runs, one that cannot be run leaves the others alone
        return execute_all(experiments, out, form, jobs, watcher, here=len(experiments) == 1)


def write_runs(runs: Sequence[RunResult], verdicts: Judgements, out: Path, form: Format, plot: bool) -> list[Path]:
    """Write the text of each run, and its picture; columns and JSON are there already. Returns all files."""
    files = []
    for result in runs:
        name = result.plan.name
        write_whole(out / f"{name}.txt", run_text(result, verdicts[name]))
        recorded = [out / f"{name}.{form}", out / f"{name}.json"] if result.metrics is not None else []
        files += [*recorded, out / f"{name}.txt"]
        if plot and result.metrics is not None:
            write_figure(out / f"{name}.png", figure_of(result))
            files.append(out / f"{name}.png")
    return files


def say_notes(experiments: Iterable[Experiment], say: Say) -> None:
    """Report, once, the ports and settings that replaced FMUs do not take, lack or leave open."""
    sentences: list[str] = []
    for experiment in experiments:
        if experiment.put_in and not experiment.fits():
            continue   # the run itself raises this error: its start values are not news
        sentences += start_value_notes(experiment.plan, experiment.sources, experiment.left_out, experiment.put_in)
        sentences += experiment.notes
    for sentence in dict.fromkeys(sentences):
        say(sentence)
