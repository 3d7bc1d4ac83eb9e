"""What the command line prints: errors, progress and tables."""

import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import typer
from rich.console import Console
from rich.progress import Progress, TaskID, TimeRemainingColumn

from maglev.errors import FAILURES, in_one_line
from maglev.experiment.preparation import Experiment
from maglev.experiment.processes import Watcher
from maglev.report.text import REPORT_WIDTH


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


def note(experiments: Sequence[Experiment]) -> None:
    """Say, once, what FMUs that were put in do not take, lack or leave open."""
    sentences = [f"the FMU that was put in has no {', '.join(experiment.left_out)}: the scenario's start values are "
                 "left out" for experiment in experiments if experiment.left_out]
    sentences += [sentence for experiment in experiments for sentence in experiment.notes]
    for sentence in dict.fromkeys(sentences):
        typer.echo(f"maglev: {sentence}", err=True)
