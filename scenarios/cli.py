"""The command line `maglev`."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, TaskID, TimeRemainingColumn
from rich.table import Table

from scenarios.errors import ScenarioError
from scenarios.experiment import Experiment
from scenarios.master import Recording
from scenarios.plot import plot as write_plot
from scenarios.plot import require_matplotlib
from scenarios.quantity import number_or_text, parse_quantity
from scenarios.scenario import load_runs, packaged_scenarios
from scenarios.selection import compared, prepare_all, select
from scenarios.study import FAILURES, RunResult, execute, execute_all, judge_all, processors
from scenarios.tables import claim_table, claims_markdown, metric_tables, outcome, study_table
from scenarios.verdicts import ClaimResult

app = typer.Typer(no_args_is_help=True, add_completion=False, rich_markup_mode="markdown", help="""
Magnetically levitated stages as FMI 2.0 co-simulation: build the FMUs, run the experiments, judge the claims.

    maglev build                          # every FMU, into the folder fmus
    maglev list                           # what there is to build and to run
    maglev run 3dof-setpoints-improved    # one experiment, results into the folder results
    maglev run --all                      # every experiment of the thesis, and a table of verdicts
""")

REPORT_WIDTH = 120   # characters

Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
Fmus = Annotated[Path, typer.Option("--fmus", help="Folder with the built FMUs.")]
Names = Annotated[list[str] | None, typer.Argument(
    metavar="SCENARIO", help="Scenarios or variants (see `maglev list`), or TOML files.")]
All = Annotated[bool, typer.Option("--all", help="Every scenario of the package.")]
Settings = Annotated[list[str] | None, typer.Option(
    "--set", metavar="FMU.variable=value", help="Start value that goes before the scenario's; may carry a unit and may "
    "be repeated.")]
Plant = Annotated[Path | None, typer.Option(help="Another plant FMU with the same ports.")]
Controller = Annotated[Path | None, typer.Option(help="Another controller FMU with the same ports.")]
Step = Annotated[str | None, typer.Option(help="Communication step, in s or with a unit.")]
Jobs = Annotated[int | None, typer.Option(
    min=1, help="Runs at a time, each in a process of its own; as many as processors if not given.",
    show_default=False)]


@contextmanager
def one_line_errors(debug: bool) -> Iterator[None]:
    """Print what users can put right as one line, and exit with 2."""
    try:
        yield
    except FAILURES as error:
        if debug:
            raise
        typer.echo(f"maglev: {' '.join(str(error).split())}", err=True)
        raise typer.Exit(2) from None


@app.command()
def build(names: Annotated[list[str] | None, typer.Argument(help="FMUs to build; all if none is named.")] = None,
          fmus: Fmus = Path("fmus"), debug: Debug = False) -> None:
    """Build FMUs from the blocks: the same sources give the same bytes.

    **Example:** `maglev build Plant3DOF Regulator3DOF`
    """
    from scenarios import catalogue  # only building needs the blocks

    with one_line_errors(debug):
        for path in catalogue.build(names or catalogue.DEFINITIONS, fmus):
            typer.echo(f"{path}  {path.stat().st_size / 1000:.0f} kB")


@app.command("list")
def list_all(fmus: Fmus = Path("fmus"), debug: Debug = False) -> None:
    """List the FMUs and the scenarios."""
    from scenarios import catalogue

    console = Console()
    with one_line_errors(debug):
        table = Table("FMU", "built", "what it is")
        for name in catalogue.DEFINITIONS:
            built = "yes" if (fmus / f"{name}.fmu").is_file() else "no"
            table.add_row(name, built, catalogue.definition(name).description)
        console.print(table)
        table = Table("run", "figures", "what it is")
        for name in packaged_scenarios():
            for scenario in load_runs(name):
                table.add_row(scenario.name, ", ".join(scenario.figures), scenario.title)
        console.print(table)


@app.command()
def run(names: Names = None, everything: All = False, settings: Settings = None, plant: Plant = None,
        controller: Controller = None, step: Step = None,
        out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("results"),
        plot: Annotated[bool, typer.Option("--plot", help="Also write pictures (needs matplotlib).")] = False,
        fmus: Fmus = Path("fmus"), jobs: Jobs = None, debug: Debug = False) -> None:
    """Run scenarios: co-simulate their FMUs, measure, judge the claims, and write CSV and text.

    **Examples:**

    `maglev run 3dof-setpoints --set plant.y.mass=7.2kg --plot`

    `maglev run 2dof-setpoints --controller my_controller.fmu --set controller.gain=3`

    `maglev run 2dof-step-4` runs both variants, `maglev run 2dof-step-4-linear` one of them

    The results are `NAME.csv` (time first, then `fmu.variable`) and `NAME.txt`. A run that an FMU ends early leaves
    what it has recorded in `NAME.partial.csv`. Runs that claims compare with are run as well.
    """
    with one_line_errors(debug):
        runs = select(names or [], everything)
        replaced = replacements(plant, controller)
        # With another FMU on both sides of a comparison, the claim would be about something else.
        others = [] if replaced else compared(runs)
        at = None if step is None else read_step(step)
        experiments = prepare_all([*runs, *others], fmus, replaced, settings or [], at)
        note_left_out(experiments)
        # What would fail after the run fails before it.
        out.mkdir(parents=True, exist_ok=True)
        if plot:
            require_matplotlib()
        results = run_experiments(experiments, out, jobs or processors())
        verdicts = judge_all(results)
        written = [file for result in results for file in write_results(result, verdicts, out, plot)]
        if len(results) > 1:
            console = report_console()
            console.print(study_table(results, verdicts))
            claims = out / "claims.md"
            claims.write_text(claims_markdown(results, verdicts), encoding="utf-8")
            written = [f"every NAME.csv and NAME.txt, and claims.md, in {out}"]
        typer.echo(f"results: {', '.join(written)}")
        if any(result.failure is not None for result in results):
            raise typer.Exit(2)


def replacements(plant: Path | None, controller: Path | None) -> dict[str, Path]:
    """FMU files that take the place of a scenario's, by participant."""
    return {name: path for name, path in (("plant", plant), ("controller", controller)) if path is not None}


def note_left_out(experiments: list[Experiment]) -> None:
    """Say which start values a replaced FMU does not take: they are its own business, but nothing is silent."""
    for left_out in dict.fromkeys(experiment.left_out for experiment in experiments):
        if left_out:
            typer.echo(f"maglev: the FMU that was put in has no {', '.join(left_out)}: the scenario's start values are "
                       "left out", err=True)


def report_console() -> Console:
    """Console that records for the text report, wide enough for the tables where no terminal sets the width."""
    console = Console(record=True)
    if not console.is_terminal:
        console.width = REPORT_WIDTH
    return console


def read_step(text: str) -> float:
    """Communication step (s) of the option --step."""
    try:
        return parse_quantity(number_or_text(text), "s")
    except ValueError as error:
        raise ScenarioError(f"--step {text}: {error}") from error


def run_experiments(experiments: list[Experiment], out: Path, jobs: int) -> list[RunResult]:
    """Run one experiment here, or several in processes, with progress bars where a person looks on."""
    with Progress(*Progress.get_default_columns()[:3], TimeRemainingColumn(elapsed_when_finished=True),
                  console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        if len(experiments) == 1:
            task = bar.add_task(experiments[0].scenario.name, total=None)
            return [execute(experiments[0], out, lambda done, steps: bar.update(task, completed=done, total=steps))]
        whole = bar.add_task("all runs", total=len(experiments))
        tasks: dict[str, TaskID] = {}

        def watch(name: str, done: int, steps: int) -> None:
            if name not in tasks:
                tasks[name] = bar.add_task(name)
            bar.update(tasks[name], completed=done, total=steps)
            if done == steps:
                bar.remove_task(tasks[name])
                bar.advance(whole)

        return execute_all(experiments, out, jobs, watch)


def write_results(result: RunResult, verdicts: dict[str, list[ClaimResult]], out: Path, plot: bool) -> list[str]:
    """Write the text of a run, and its picture; print the text if it is the only one."""
    scenario = result.scenario
    console = report_console()
    console.quiet = len(verdicts) > 1
    show(console, result, verdicts[scenario.name])
    (out / f"{scenario.name}.txt").write_text(console.export_text(), encoding="utf-8")
    files = [f"{scenario.name}.csv", f"{scenario.name}.txt"]
    if plot and result.metrics is not None:
        write_plot(out / f"{scenario.name}.png", scenario, Recording(result.time, result.columns))
        files.append(f"{scenario.name}.png")
    return [str(out / file) for file in files]


def show(console: Console, result: RunResult, verdicts: list[ClaimResult]) -> None:
    """Print what was measured on a run, and the claims with their verdicts."""
    scenario = result.scenario
    console.print(f"[bold]{scenario.name}[/]: {scenario.title}")
    if result.metrics is None:
        console.print(f"did not complete: {result.failure}")
        return
    for table in metric_tables(scenario, result.metrics):
        console.print(table)
    console.print(claim_table(verdicts) if verdicts else "no claims")
    console.print(outcome(result.metrics))


if __name__ == "__main__":
    app()
