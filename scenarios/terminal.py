"""What the command line prints: errors, progress and tables."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import StringIO

import typer
from rich.console import Console
from rich.markup import escape
from rich.progress import Progress, TaskID, TimeRemainingColumn

from scenarios.errors import in_one_line
from scenarios.experiment import FAILURES, Experiment
from scenarios.processes import Watcher
from scenarios.study import RunResult
from scenarios.tables import claim_table, metric_tables, outcome
from scenarios.verdicts import ClaimResult

REPORT_WIDTH = 120   # characters


@contextmanager
def one_line_errors(debug: bool) -> Iterator[None]:
    """Print what users can put right as one line, and exit with 2."""
    try:
        yield
    except FAILURES as error:
        if debug:
            raise
        typer.echo(f"maglev: {in_one_line(error)}", err=True)
        raise typer.Exit(2) from None


def report_console() -> Console:
    """Console wide enough for the tables where no terminal sets the width."""
    console = Console()
    if not console.is_terminal:
        console.width = REPORT_WIDTH
    return console


@contextmanager
def progress_of(names: Sequence[str]) -> Iterator[Watcher]:
    """Progress bars of the named runs, and of all together, where a person looks on."""
    with Progress(*Progress.get_default_columns()[:3], TimeRemainingColumn(elapsed_when_finished=True),
                  console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        whole = bar.add_task("all runs", total=len(names), visible=len(names) > 1)
        tasks: dict[str, TaskID] = {}

        def watch(name: str, done: int, steps: int) -> None:
            if name not in tasks:
                tasks[name] = bar.add_task(name)
            bar.update(tasks[name], completed=done, total=steps)
            if done == steps:
                bar.remove_task(tasks[name])
                bar.advance(whole)

        yield watch


def show(console: Console, result: RunResult, verdicts: Sequence[ClaimResult]) -> None:
    """Print what was measured on a run, and the claims with their verdicts."""
    scenario = result.scenario
    console.print(f"[bold]{escape(scenario.name)}[/]: {escape(scenario.title)}")
    if result.metrics is None:
        console.print(f"did not complete: {result.failure}", markup=False)
        return
    for table in metric_tables(scenario, result.metrics):
        console.print(table)
    console.print(claim_table(verdicts) if verdicts else "no claims")
    console.print(outcome(result.metrics))


def text_of(result: RunResult, verdicts: Sequence[ClaimResult]) -> str:
    """What `show` prints, as text."""
    text = StringIO()
    show(Console(file=text, width=REPORT_WIDTH), result, verdicts)
    return text.getvalue()


def note(experiments: Sequence[Experiment]) -> None:
    """Say, once, what FMUs that were put in do not take, lack or leave open."""
    sentences = [f"the FMU that was put in has no {', '.join(experiment.left_out)}: the scenario's start values are "
                 "left out" for experiment in experiments if experiment.left_out]
    sentences += [sentence for experiment in experiments for sentence in experiment.notes]
    for sentence in dict.fromkeys(sentences):
        typer.echo(f"maglev: {sentence}", err=True)
