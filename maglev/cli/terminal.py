"""Output of the command line: errors, progress and results."""

import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from io import TextIOWrapper
from json import dumps
from pathlib import Path
from typing import TYPE_CHECKING, Any, TextIO

import typer

import maglev
from maglev.files.errors import FAILURES, ended_by, in_one_line, signal_of, visible
from maglev.files.interrupts import termination_like_interrupt

if TYPE_CHECKING:
    from rich.console import Console

    from maglev.files.side_by_side import Watcher
    from maglev.runs.check_outcome import CheckResult, UpdateResult

MOST_NAMED = 10     # files that are named one by one
FEW_STEPS = 100     # the bars' own clock would skip those of a quick build


@contextmanager
def one_line_errors(debug: bool) -> Iterator[None]:
    """Print errors that users can correct as one line, and exit with 2; after Ctrl-C with 130, after SIGTERM with 143.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="replace")   # a terminal that lacks a letter is no reason to end a run
    try:
        with termination_like_interrupt(), warnings.catch_warnings():
            warnings.showwarning = warn_line
            yield
    except KeyboardInterrupt as error:
        if debug:
            raise
        say(str(error) or ended_by(error))
        raise typer.Exit(128 + signal_of(error)) from None
    except (RecursionError, *FAILURES) as error:
        if debug:
            raise
        say("a file is nested too deeply, expected expressions and tables of fewer levels (--debug shows where)"
            if isinstance(error, RecursionError) else error)
        raise typer.Exit(2) from None


def warn_line(message: Warning | str, category: type[Warning], filename: str, lineno: int, file: TextIO | None = None,
              line: str | None = None) -> None:
    """Print a warning of this project in one line; warnings of Python and other packages are unchanged."""
    if category is UserWarning:
        say(str(message))
    else:
        (file or sys.stderr).write(warnings.formatwarning(message, category, filename, lineno, line))


def require_environment() -> None:
    """Refuse an environment variable that is no number, before the import that reads it."""
    from maglev.files.environment import require_numbers

    try:
        require_numbers()
    except ValueError as error:
        say(str(error))
        raise typer.Exit(2) from None


def say(sentence: object) -> None:
    """Print a sentence next to the results, in one line."""
    typer.echo(f"maglev: {in_one_line(sentence)}", err=True)


def report_console() -> "Console":
    """Console as wide as the terminal, or as COLUMNS says; of 80 letters where there is neither."""
    from maglev.files.console import plain_console

    return plain_console()


@contextmanager
def progress_of(names: Sequence[str]) -> Iterator["Watcher"]:
    """Progress bars of the named runs, and of all together, where a person looks on."""
    from rich.console import Console
    from rich.markup import escape
    from rich.progress import Progress, TaskID, TimeRemainingColumn

    with Progress(*Progress.get_default_columns()[:3], TimeRemainingColumn(elapsed_when_finished=True),
                  console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        whole = bar.add_task("all runs", total=len(names), visible=len(names) > 1)
        tasks: dict[str, TaskID] = {}

        def watch(name: str, done: int, steps: int) -> None:
            if name not in tasks:
                tasks[name] = bar.add_task(escape(name))
            bar.update(tasks[name], completed=done, total=steps, refresh=steps <= FEW_STEPS)
            if done == steps:
                bar.remove_task(tasks[name])
                bar.advance(whole)

        yield watch


def run_and_print(names: list[str] | None, json: bool = False, debug: bool = False, fail_on_claims: bool = False,
                  open_page: bool = False, **options: Any) -> None:
    """Run scenarios, open the page about them if requested, and print the results, perhaps as JSON.

    Exits with 2 if a run did not complete, with `debug` after the traceback. With `fail_on_claims` it otherwise exits
    with 1 if a run failed or a claim is missed, and prints each.
    """
    results = maglev.run_all(names or None, watch=progress_of, say=say, **options)
    if open_page:
        import webbrowser

        if not webbrowser.open(results.files[-1].resolve().as_uri()):
            say(f"no browser was found: open {results.files[-1]} in one")
    if json:
        print_json(results.as_data())
    else:
        print_tables(results)
    failed = [run for run in results.runs if run.failure is not None]
    for run in failed:
        if debug:
            typer.echo(visible(run.traceback), err=True)
        say(f"{run.plan.name}: {run.failure}")
    if fail_on_claims:
        for sentence in results.missed:
            say(sentence)
    if failed:
        raise typer.Exit(2)
    if fail_on_claims and results.missed:
        raise typer.Exit(1)


def print_json(data: object) -> None:
    """Print data as JSON that any terminal can show."""
    typer.echo(dumps(data, indent=1, allow_nan=False))


def write_json(path: Path, data: object) -> None:
    """Write data as JSON, infinite numbers as Python has them, and print where."""
    from maglev.files.whole_file import write_whole

    write_whole(path, dumps(data, indent=1, ensure_ascii=False) + "\n")
    typer.echo(f"results: {path}")


def print_tables(results: "maglev.Results") -> None:
    """Print the tables of runs, and which files there are."""
    results.show(report_console())
    few, files = len(results.files) <= MOST_NAMED, results.files
    typer.echo(f"results: {', '.join(map(str, files)) if few else f'{len(files)} files in {files[0].parent}'}")


def print_outcomes(results: "Sequence[CheckResult | UpdateResult]") -> None:
    """Print a line for each run that was checked, or whose baseline was updated."""
    from maglev.runs.check_outcome import describe

    for result in results:
        typer.echo(visible(describe(result)))
