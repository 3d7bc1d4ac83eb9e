"""The command line `maglev`."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.progress import Progress, TimeRemainingColumn
from rich.table import Table

from scenarios.component import ComponentError
from scenarios.errors import ScenarioError
from scenarios.experiment import Experiment, prepare
from scenarios.master import Recording, RunFailed
from scenarios.plot import plot as write_plot
from scenarios.plot import require_matplotlib
from scenarios.quantity import number_or_text, parse_quantity
from scenarios.results import write_csv
from scenarios.scenario import load_scenario, packaged_scenarios
from scenarios.tables import claim_table, metric_tables, outcome

app = typer.Typer(no_args_is_help=True, add_completion=False, rich_markup_mode="markdown", help="""
Magnetically levitated stages as FMI 2.0 co-simulation: build the FMUs, run the experiments, judge the claims.

    maglev build                          # every FMU, into the folder fmus
    maglev list                           # what there is to build and to run
    maglev run 3dof-setpoints-improved    # one experiment, results into the folder results
""")

REPORT_WIDTH = 120   # characters

Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
Fmus = Annotated[Path, typer.Option("--fmus", help="Folder with the built FMUs.")]


@contextmanager
def one_line_errors(debug: bool) -> Iterator[None]:
    """Print what users can put right as one line, and exit with 2."""
    try:
        yield
    except (ScenarioError, ComponentError, RunFailed, ValueError, OSError) as error:
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
        table = Table("scenario", "figures", "what it is")
        for name in packaged_scenarios():
            scenario = load_scenario(name)
            table.add_row(name, ", ".join(scenario.figures), scenario.title)
        console.print(table)


@app.command()
def run(scenario: Annotated[str, typer.Argument(help="Name of a scenario (see `maglev list`), or a TOML file.")],
        settings: Annotated[list[str] | None, typer.Option(
            "--set", metavar="FMU.variable=value", help="Start value that goes before the scenario's; may carry a "
            "unit and may be repeated.")] = None,
        plant: Annotated[Path | None, typer.Option(help="Another plant FMU with the same ports.")] = None,
        controller: Annotated[Path | None, typer.Option(help="Another controller FMU with the same ports.")] = None,
        step: Annotated[str | None, typer.Option(help="Communication step, in s or with a unit.")] = None,
        out: Annotated[Path, typer.Option(help="Folder for the results.")] = Path("results"),
        plot: Annotated[bool, typer.Option("--plot", help="Also write a picture (needs matplotlib).")] = False,
        fmus: Fmus = Path("fmus"), debug: Debug = False) -> None:
    """Run a scenario: co-simulate its FMUs, measure, judge its claims, and write CSV and text.

    **Examples:**

    `maglev run 3dof-setpoints --set plant.y.mass=7.2kg --plot`

    `maglev run 2dof-setpoints --controller my_controller.fmu --set controller.gain=3`

    The results are `NAME.csv` (time first, then `fmu.variable`) and `NAME.txt`. A run that an FMU ends early leaves
    what it has recorded in `NAME.partial.csv`.
    """
    console = report_console()
    with one_line_errors(debug):
        replaced = {name: path for name, path in (("plant", plant), ("controller", controller)) if path is not None}
        experiment = prepare(load_scenario(scenario), fmus, replaced, settings or [],
                             None if step is None else read_step(step))
        name = experiment.scenario.name
        # What would fail after the run fails before it.
        out.mkdir(parents=True, exist_ok=True)
        if plot:
            require_matplotlib()
        try:
            recording = run_with_progress(experiment)
        except RunFailed as error:
            partial = out / f"{name}.partial.csv"
            write_csv(partial, error.recording, experiment.output_every())
            raise RunFailed(f"{error}; what was recorded until then is in {partial}", error.recording) from error
        write_csv(out / f"{name}.csv", recording, experiment.output_every())
        show(console, experiment, recording)
        written = [f"{name}.csv", f"{name}.txt"]
        if plot:
            write_plot(out / f"{name}.png", experiment.scenario, recording, experiment.output_every())
            written.append(f"{name}.png")
        (out / f"{name}.txt").write_text(console.export_text(), encoding="utf-8")
        console.print(f"results: {', '.join(str(out / file) for file in written)}", soft_wrap=True)


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


def run_with_progress(experiment: Experiment) -> Recording:
    """Run an experiment, with a progress bar where a person looks on."""
    with Progress(*Progress.get_default_columns()[:3], TimeRemainingColumn(elapsed_when_finished=True),
                  console=Console(stderr=True), transient=True, disable=not sys.stderr.isatty()) as bar:
        task = bar.add_task(experiment.scenario.name, total=None)
        return experiment.run(lambda done, steps: bar.update(task, completed=done, total=steps))


def show(console: Console, experiment: Experiment, recording: Recording) -> None:
    """Print what was measured, and the claims with their verdicts."""
    scenario = experiment.scenario
    metrics, results = experiment.judge(recording)
    console.print(f"[bold]{scenario.name}[/]: {scenario.title}")
    for table in metric_tables(scenario, metrics):
        console.print(table)
    if results:
        console.print(claim_table(results))
    console.print(outcome(metrics))


if __name__ == "__main__":
    app()
