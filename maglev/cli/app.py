"""The command line `maglev`."""

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Annotated

import typer
from rich.table import Column, Table

from maglev.cli.identify import identify
from maglev.cli.options import (
    Controller,
    Debug,
    Everything,
    Fmus,
    Jobs,
    Model,
    Names,
    Native,
    Ordering,
    Out,
    Plant,
    PortsFile,
    Settings,
    Step,
    chosen_folder,
    given_settings,
    read_step,
    replacements,
)
from maglev.cli.terminal import note, one_line_errors, progress_of, report_console
from maglev.cosim.master import Recording
from maglev.cosim.wiring import Order
from maglev.errors import ScenarioError
from maglev.experiment.execution import RunResult, execute, execute_all, judge_all
from maglev.experiment.processes import processors
from maglev.experiment.replacement import Replacement
from maglev.experiment.selection import compared, needed, prepare_all, select
from maglev.judging.verdicts import Judgements
from maglev.procedures.evaluate import evaluate_all
from maglev.procedures.judging import judge_procedure
from maglev.procedures.outcome import Outcome
from maglev.regression.check import CheckResult, UpdateResult, check_all, describe, exit_code, update_all
from maglev.regression.junit import write_junit
from maglev.report.outcome_text import show_outcome, write_outcomes
from maglev.report.page import require_plotly, write_report
from maglev.report.plot import plot as write_plot
from maglev.report.plot import require_matplotlib
from maglev.report.text import claims_markdown, show, study_table, text_of
from maglev.schema.loading import load_runs, packaged_scenarios
from maglev.schema.scenario import Scenario
from maglev.schema.toml_table import PACKAGED

app = typer.Typer(no_args_is_help=True, add_completion=False, rich_markup_mode="markdown", help="""
Magnetically levitated stages as FMI 2.0 co-simulation: build the FMUs, run the experiments, judge the claims.

    maglev build                          # every FMU, into the folder fmus
    maglev list                           # what there is to build and to run
    maglev run 3dof-setpoints-improved    # one experiment, results into the folder results
    maglev run --all                      # every experiment of the thesis, and a table of verdicts
    maglev report                         # the same, and one HTML page about it
    maglev check                          # does every experiment still give what it gave?
""")

MOST_NAMED = 7   # files, or variants of a scenario, that are listed one by one
MOST_SHOWN = 3   # procedures whose findings are printed; there are files of all


@app.command()
def build(names: Annotated[list[str] | None, typer.Argument(help="FMUs to build; all if none is named.",
                                                            show_default=False)] = None,
          fmus: Fmus = Path("fmus"),
          native: Annotated[bool, typer.Option("--native", help="FMUs that need no Python, into the folder's folder "
                                               "native, and closed loops of them; needs the extra `native`.")] = False,
          target: Annotated[str, typer.Option(help="With --native: `all`, binaries for Linux, Windows and macOS, or "
                                              "`host`, one for this machine.")] = "all",
          debug: Debug = False) -> None:
    """Build FMUs from the blocks: the same sources give the same bytes.

    **Examples:** `maglev build Plant3DOF Regulator3DOF`, `maglev build --native`,
    `maglev build --native ClosedLoop3DOF`
    """
    from maglev import build as catalogue  # only building needs the blocks

    with one_line_errors(debug):
        if target not in ("all", "host") or (target == "host" and not native):
            raise ScenarioError(f"--target {target}: expected all or host, and --native with it")
        built = (catalogue.build_without_python(names or (), fmus, target == "host") if native
                 else catalogue.build(names or [*catalogue.DEFINITIONS, *catalogue.SYSTEMS], fmus))
        for path in built:
            typer.echo(f"{path}  {path.stat().st_size / 1000:.0f} kB")


@app.command("list")
def list_all(fmus: Fmus = Path("fmus"), debug: Debug = False) -> None:
    """List the FMUs and the scenarios."""
    from maglev import build as catalogue

    console = report_console()
    with one_line_errors(debug):
        table = Table("FMU", "built", "what it is")
        for name in catalogue.DEFINITIONS:
            built = "yes" if (fmus / f"{name}.fmu").is_file() else "no"
            table.add_row(name, built, catalogue.definition(name).description)
        for names, ending, what in ((catalogue.SYSTEMS, "ssp", "plant and controller of {}, connected (SSP)"),
                                    (catalogue.CONTAINERS, "fmu", "plant and controller of {} in one native FMU")):
            for name, scenario in names.items():
                built = "yes" if (fmus / f"{name}.{ending}").is_file() else "no"
                table.add_row(name, built, what.format(scenario))
        console.print(table)
        table = Table(Column("run", no_wrap=True), "figures", "what it is")
        for name in packaged_scenarios():
            runs = load_runs(name)
            if len(runs) > MOST_NAMED:
                table.add_row(f"{name}-…", "", f"{len(runs)} variants: {runs[0].title}, …")
                continue
            for run in runs:
                table.add_row(run.name, ", ".join(run.figures), run.title)
        console.print(table)


@app.command()
def run(names: Names = None, everything: Everything = False, settings: Settings = None, model: Model = None,
        plant: Plant = None, controller: Controller = None, ports: PortsFile = None, step: Step = None,
        order: Ordering = "sequential", out: Out = Path("results"),
        plot: Annotated[bool, typer.Option("--plot", help="Also write pictures (needs matplotlib).")] = False,
        fmus: Fmus = Path("fmus"), native: Native = False, jobs: Jobs = None, debug: Debug = False) -> None:
    """Run scenarios: co-simulate their FMUs, measure, judge the claims, and write CSV and text.

    **Examples:**

    `maglev run 3dof-setpoints --set plant.y.mass=7.2kg --plot`

    `maglev run 2dof-setpoints --controller my_controller.fmu --map ports.toml --set controller.gain=3`

    `maglev run 2dof-step-4` runs both variants, `maglev run 2dof-step-4-linear` one of them

    The results are `NAME.csv` (time first, then `fmu.variable`), `NAME.txt` and, of all runs, `claims.md`. A run that
    an FMU ends early leaves what it has recorded in `NAME.partial.csv`. Runs that claims compare with are run as well.
    What a procedure of several runs finds is in `PROCEDURE.txt`, its curves in `PROCEDURE.curves.csv`.
    """
    with one_line_errors(debug):
        # What would fail after the runs fails before them.
        if plot:
            require_matplotlib()
        runs = select(names or [], everything)
        starts = given_settings(settings, model, [*runs, *needed(runs)])
        results = run_all(runs, starts, replacements(plant, controller, ports), read_step(step),
                          chosen_folder(fmus, native), out, jobs, order)
        outcomes = evaluate_all(results, {run.name for run in runs})
        verdicts = judge_everything(results, outcomes)
        files = write_results(results, verdicts, out, plot) + write_outcomes(outcomes, verdicts, out)
        finish(results, outcomes, verdicts, len(runs), [*files, write_claims(results, outcomes, verdicts, out)])


@app.command()
def report(names: Names = None, settings: Settings = None, model: Model = None, plant: Plant = None,
           controller: Controller = None, ports: PortsFile = None, step: Step = None, out: Out = Path("results"),
           fmus: Fmus = Path("fmus"), native: Native = False, jobs: Jobs = None, debug: Debug = False) -> None:
    """Run scenarios, every one of the package if none is named, and write one HTML page about them.

    The page `report.html` needs no network: figures as in the thesis, to zoom into, the claims with their verdicts, and
    a moving picture of the stage. Needs plotly (`pip install 'maglev-fmus[report]'`).

    **Examples:** `maglev report`, `maglev report 3dof-setpoints --controller my_controller.fmu`
    """
    with one_line_errors(debug):
        require_plotly()
        runs = select(names or [], not names)
        starts = given_settings(settings, model, [*runs, *needed(runs)])
        results = run_all(runs, starts, replacements(plant, controller, ports), read_step(step),
                          chosen_folder(fmus, native), out, jobs)
        outcomes = evaluate_all(results, {run.name for run in runs})
        verdicts = judge_everything(results, outcomes)
        files = write_results(results, verdicts, out, False) + write_outcomes(outcomes, verdicts, out)
        page = out / "report.html"
        write_report(page, results, verdicts, outcomes)
        finish(results, outcomes, verdicts, len(runs), [*files, write_claims(results, outcomes, verdicts, out), page])


@app.command()
def check(names: Names = None, settings: Settings = None, model: Model = None, plant: Plant = None,
          controller: Controller = None, ports: PortsFile = None,
          update: Annotated[bool, typer.Option("--update", help="Write new baselines, and say what moved.")] = False,
          baselines: Annotated[Path, typer.Option(help="Folder with the baselines.", show_default="the package's")]
          = PACKAGED / "baselines",
          junit: Annotated[Path | None, typer.Option(help="Also write the outcome as JUnit XML.", show_default=False)]
          = None,
          fmus: Fmus = Path("fmus"), native: Native = False, jobs: Jobs = None, debug: Debug = False) -> None:
    """Run scenarios, every one of the package if none is named, and compare with their baselines.

    A baseline is `NAME_ref.csv` with a few signals at a few times, and `NAME_ref.opt` with the tolerance of each. The
    exit code is 0 if all runs are within the tolerances, 1 if one is not, 2 if one could not be compared.

    **Examples:** `maglev check --junit check.xml`, `maglev check 3dof-smooth-nonlinear --plant my_plant.fmu`
    """
    with one_line_errors(debug):
        if update and junit is not None:
            raise ScenarioError(f"--junit {junit}: expected no --update with it, which checks nothing")
        replaced = replacements(plant, controller, ports)
        folder = chosen_folder(fmus, native)
        runs = select(names or [], not names)
        runs += needed(runs)
        starts = given_settings(settings, model, runs)
        note(prepare_all(runs, folder, replaced, starts))
        arguments = (runs, folder, replaced, starts, baselines, jobs or processors())
        with progress_of([run.name for run in runs]) as watch:
            if update:
                results: Sequence[CheckResult | UpdateResult] = update_all(*arguments, watch)
            else:
                results = checked = check_all(*arguments, watch)
                if junit is not None:
                    write_junit(junit, checked)
        for result in results:
            typer.echo(describe(result))
        raise typer.Exit(exit_code(results))


def run_all(runs: list[Scenario], settings: list[str], replaced: Mapping[str, Replacement], step: float | None,
            fmus: Path, out: Path, jobs: Jobs, order: Order = "sequential") -> list[RunResult]:
    """Run what is asked for and, after it, what its claims compare with; a single run here, several in processes."""
    # With another FMU on both sides of a comparison, the claim would be about something else.
    others = [] if replaced else compared(runs)
    everything = [*runs, *others, *needed([*runs, *others])]
    experiments = prepare_all(everything, fmus, replaced, settings, step, order)
    note(experiments)
    out.mkdir(parents=True, exist_ok=True)
    with progress_of([experiment.scenario.name for experiment in experiments]) as watch:
        if len(experiments) == 1:
            return [execute(experiments[0], out, partial(watch, experiments[0].scenario.name))]
        return execute_all(experiments, out, jobs or processors(), watch)


def judge_everything(results: list[RunResult], outcomes: list[Outcome]) -> Judgements:
    """Judge the claims of every run and of every procedure, by name."""
    return {**judge_all(results), **{outcome.settings.name: judge_procedure(outcome) for outcome in outcomes}}


def write_results(results: list[RunResult], verdicts: Judgements, out: Path, plot: bool) -> list[Path]:
    """Write the text of each run, and its picture; the CSV is there already."""
    files = []
    for result in results:
        name = result.scenario.name
        (out / f"{name}.txt").write_text(text_of(result, verdicts[name]), encoding="utf-8")
        files += [out / f"{name}.csv", out / f"{name}.txt"] if result.metrics is not None else [out / f"{name}.txt"]
        if plot and result.metrics is not None:
            write_plot(out / f"{name}.png", result.scenario, Recording(result.time, result.columns))
            files.append(out / f"{name}.png")
    return files


def write_claims(results: list[RunResult], outcomes: list[Outcome], verdicts: Judgements, out: Path) -> Path:
    """Write the table of the claims."""
    path = out / "claims.md"
    path.write_text(claims_markdown(results, verdicts, outcomes), encoding="utf-8")
    return path


def finish(results: list[RunResult], outcomes: list[Outcome], verdicts: Judgements, asked: int,
           files: list[Path]) -> None:
    """Print the text of the only run asked for, or a table of all, and what procedures found.

    Exits with 2 if a run did not complete.
    """
    if asked == 1:
        show(report_console(), results[0], verdicts[results[0].scenario.name])
    else:
        report_console().print(study_table(results, verdicts, outcomes))
    for outcome in outcomes if len(outcomes) <= MOST_SHOWN else ():
        show_outcome(report_console(), outcome, verdicts[outcome.settings.name])
    few = len(files) <= MOST_NAMED
    typer.echo(f"results: {', '.join(map(str, files)) if few else f'{len(files)} files in {files[0].parent}'}")
    for result in results:
        if result.failure is not None:
            typer.echo(f"maglev: {result.scenario.name}: {result.failure}", err=True)
    if any(result.failure is not None for result in results):
        raise typer.Exit(2)


app.command()(identify)

if __name__ == "__main__":
    app()
