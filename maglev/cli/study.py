"""The commands that run a scenario several times: `maglev study`, `maglev tune` and `maglev compare`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import maglev
from maglev.cli.options import MORE, Debug, Jobs, Out, pairs, run_names, with_run_options
from maglev.cli.terminal import one_line_errors, print_json, progress_of, report_console, say
from maglev.files.errors import ScenarioError, lacking
from maglev.scenario.options import CompareOptions, SampleOptions

Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", show_default=False, rich_help_panel=MORE,
                                               help="Use the workers of this Dask scheduler.")]
Resume = Annotated[bool, typer.Option("--resume", help="Continue what was interrupted.")]
SampleTimeout = Annotated[str | None, typer.Option(metavar="TIME", show_default=False, rich_help_panel=MORE,
                                                   help="Longest wall time of a sample.")]


@with_run_options(SampleOptions.__annotations__)
def study(what: Annotated[str, typer.Argument(
              metavar="STUDY", help="A packaged study, a TOML file, or with --vary a run.", autocompletion=run_names)],
          vary: Annotated[list[str] | None, typer.Option(
              "--vary", metavar="FMU.VARIABLE=VALUES", help="FROM:TO:NUMBER, or A,B,C. Repeatable.")] = None,
          samples: Annotated[int | None, typer.Option(
              min=1, metavar="N", help="N samples of ranges, LOW:HIGH or ±20%.")] = None,
          seed: Annotated[int, typer.Option(min=0, metavar="N", help="Seed of --samples.")] = 0,
          keep: Annotated[list[str] | None, typer.Option(
              "--keep", metavar="FMU.VARIABLE", help="With --vary: keep this signal. Repeatable.",
              rich_help_panel=MORE)] = None,
          name: Annotated[str | None, typer.Option(
              metavar="NAME", help="With --vary: name of the results.", show_default=False,
              rich_help_panel=MORE)] = None,
          out: Out = Path("results"), jobs: Jobs = None, scheduler: Scheduler = None,
          resume: Resume = False, sample_timeout: SampleTimeout = None, debug: Debug = False, **options: Any) -> None:
    """Run a parameter study.

    A TOML file lists the parameters, the design and the kept columns. Without a file, `--vary` lists values, and every
    combination is run; with `--samples` a Latin hypercube of ranges is run.

    Run a study of the package:

        maglev study payload-friction

    Vary a gain over 20 values, two parameters on a grid, or one at random:

        maglev study 3dof-setpoints --vary controller.y.k1=-2000:-800:20
        maglev study 2dof-setpoints --vary plant.v.mass=4:5:5 \\
            --vary reference.v.amplitude=0.5,1,1.5
        maglev study 3dof-setpoints --samples 200 \\
            --vary plant.x.friction.coulomb=±20%

    Write a study file, and run it:

        maglev new study robust.toml
        maglev study robust.toml

    The results are `NAME.parquet`, with a row for each sample, and the page `NAME.html`. After Ctrl-C, `--resume`
    continues.
    """
    with one_line_errors(debug):
        write_and_print(maglev.study(what, vary=None if vary is None else read_vary(vary), samples=samples, seed=seed,
                                     keep=keep or (), name=name, out=out, jobs=jobs, scheduler=scheduler,
                                     resume=resume, sample_timeout=sample_timeout, watch=progress_of, say=say,
                                     **options))


def read_vary(words: list[str]) -> dict[str, str]:
    read: dict[str, str] = {}
    for target, values in pairs("--vary", words, "FMU.variable=FROM:TO:NUMBER, such as plant.y.mass=6:8:5"):
        if target in read:
            raise ScenarioError(f"--vary {target}={values}: {target} is given twice, expected once")
        read[target] = values
    return read


def write_and_print(study: "maglev.Study") -> None:
    """Write the page, and print what the study found; exits with 2 if no sample came to its end."""
    from maglev.pages.study_terminal import show_study

    table = study.to_arrow()
    show_study(report_console(), table, study.about)
    typer.echo(f"results: {study.path}, {study.write_page(study.path.with_suffix('.html'))}")
    if table["failure"].null_count == 0:
        say(f"{study.name}: no sample of {table.num_rows} completed; the first failed: {table['failure'][0]}")
        raise typer.Exit(2)


@with_run_options(SampleOptions.__annotations__)
def tune(file: Annotated[str, typer.Argument(metavar="TUNING", help="A packaged tuning, or a TOML file.")],
         out: Out = Path("results"), jobs: Jobs = None, scheduler: Scheduler = None,
         resume: Resume = False, debug: Debug = False, **options: Any) -> None:
    """Tune the gains of a controller by metrics on many plants.

    Tune with a packaged file, or with your own:

        maglev tune horizontal-3dof
        maglev new tuning quicker.toml
        maglev tune quicker.toml

    The result is `NAME.toml`, which a scenario can extend, with the metrics before and after, also on plants kept out
    of the search. After Ctrl-C, `--resume` continues.
    """
    with one_line_errors(debug):
        tuned = maglev.tune(file, out=out, jobs=jobs, scheduler=scheduler, resume=resume, watch=progress_of,
                            say=say, **options)
        tuned.show(report_console())
        typer.echo(f"results: {tuned.path}")


@with_run_options(CompareOptions.__annotations__)
def compare_controllers(
        name: Annotated[str, typer.Argument(metavar="SCENARIO", help="A run from `maglev list`, or a TOML file.",
                                            autocompletion=run_names)],
        controllers: Annotated[list[str], typer.Option(
            "--controller", metavar="[LABEL=]FMU", help="An FMU or a Python file. Repeatable.")],
        out: Out = Path("results"),
        json: Annotated[bool, typer.Option("--json", help="Print the comparison as JSON.")] = False,
        debug: Debug = False, **options: Any) -> None:
    """Run a scenario with several controllers and compare the runs.

    Compare two controllers of this project:

        maglev compare 3dof-setpoints --controller Regulator3DOF \\
            --controller PID3DOF

    Compare with your own controller, under a label:

        maglev new controller lqi.py --stage 2dof
        maglev compare 2dof-setpoints --controller Regulator2DOF \\
            --controller mine=lqi.py

    Each run writes `NAME@LABEL.csv` and `.json`; the comparison is `NAME.compare.json`, `.txt`, `.html`, and `.png`
    with matplotlib.
    """
    with one_line_errors(debug):
        comparison = maglev.compare(name, controllers, watch=progress_of, say=say, **options)
        missing = lacking("matplotlib", "report", "a picture")
        files = comparison.write(out, picture=not missing)
        if json:
            print_json(comparison.as_data())
        else:
            comparison.show(report_console())
            typer.echo(f"results: {', '.join(map(str, files))}")
            if missing:
                say(missing)
        for label, failure in comparison.failures.items():
            say(f"{label}: {failure}")
        if comparison.failures:
            raise typer.Exit(2)
