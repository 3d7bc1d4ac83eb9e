"""The commands that run a scenario several times: `maglev study`, `maglev tune` and `maglev compare`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import maglev
from maglev.cli.options import Debug, Jobs, Out, pairs, run_names, with_run_options
from maglev.cli.terminal import one_line_errors, print_json, progress_of, report_console, say
from maglev.files.errors import ScenarioError
from maglev.files.extras import lacking

Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", show_default=False, help="Dask scheduler, such as "
                                               "tcp://host:8786, whose workers take the place of this machine's.")]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with what an interrupted one has done.")]
SampleTimeout = Annotated[str | None, typer.Option(metavar="TIME", show_default="none", help="Longest wall time of a "
                                                   "sample; of one that takes longer a row says so; 600 s with "
                                                   "third-party FMUs.")]


@with_run_options(without=("timeout", "parameters"))
def study(what: Annotated[str, typer.Argument(metavar="STUDY", help="A study of the package, or a TOML file; with "
                                              "--vary a scenario.", autocompletion=run_names)],
          vary: Annotated[list[str] | None, typer.Option("--vary", metavar="FMU.variable=VALUES", help="What varies, "
                                                         "without a file: FROM:TO:NUMBER, or values with commas "
                                                         "between. May be repeated.")] = None,
          samples: Annotated[int | None, typer.Option(min=1, help="With --vary: number of samples, a Latin "
                                                      "hypercube of ranges, LOW:HIGH or ±20%, instead of every "
                                                      "combination.")] = None,
          seed: Annotated[int, typer.Option(min=0, help="With --samples: the same seed gives the same.")] = 0,
          keep: Annotated[list[str] | None, typer.Option("--keep", metavar="FMU.variable", help="With --vary: keep the "
                                                         "trajectory of a signal; to be repeated.")] = None,
          name: Annotated[str | None, typer.Option(help="With --vary: name of the results.",
                                                   show_default="SCENARIO.study")] = None,
          out: Out = Path("results"), jobs: Jobs = None, scheduler: Scheduler = None,
          resume: Resume = False, sample_timeout: SampleTimeout = None, debug: Debug = False, **options: Any) -> None:
    """Run a scenario many times, with varied values.

    A TOML file has the varied quantities, the design and the kept columns (docs/studies.md). Or --vary has the values:
    every combination is run, or --samples of ranges. Several variables, with commas between, take the same values.

    The results are `NAME.parquet`, a row for each sample with parameters and metrics, and the page `NAME.html`. After
    Ctrl-C, `--resume` continues.

    **Examples:**

    `maglev study payload-friction`

    `maglev study my_study.toml --scheduler tcp://host:8786`

    `maglev study 3dof-setpoints --vary controller.y.k1=-2000:-800:20`

    `maglev study 2dof-setpoints --vary plant.v.mass=4:5:5 --vary reference.v.amplitude=0.5,1,1.5`

    `maglev study 3dof-setpoints --vary plant.x.friction.coulomb=±20% --samples 200 --controller mine.py`
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
    from maglev.pages.study_text import show_study

    table = study.to_arrow()
    show_study(report_console(), table, study.about)
    typer.echo(f"results: {study.path}, {study.write_page(study.path.with_suffix('.html'))}")
    if table["failure"].null_count == 0:
        say(f"{study.name}: none of {table.num_rows} samples was completed; of the first: {table['failure'][0]}")
        raise typer.Exit(2)


@with_run_options(without=("timeout", "parameters"))
def tune(file: Annotated[str, typer.Argument(metavar="TUNING", help="A tuning file of the package, or a TOML file.")],
         out: Out = Path("results"), jobs: Jobs = None, scheduler: Scheduler = None,
         resume: Resume = False, debug: Debug = False, **options: Any) -> None:
    """Search gains of a controller by metrics on many plants.

    The result is `NAME.toml`, which a scenario extends, and the metrics before and after, also on plants that were
    not searched with. After Ctrl-C, `--resume` continues.

    **Examples:**

    `maglev tune horizontal-3dof`

    `maglev tune my_tuning.toml --scheduler tcp://host:8786`
    """
    with one_line_errors(debug):
        tuned = maglev.tune(file, out=out, jobs=jobs, scheduler=scheduler, resume=resume, watch=progress_of,
                            say=say, **options)
        tuned.show(report_console())
        typer.echo(f"results: {tuned.path}")


@with_run_options(without=("controller",))
def compare(name: Annotated[str, typer.Argument(metavar="SCENARIO", help="A scenario without variants, a variant, or a "
                                                "TOML file.", autocompletion=run_names)],
            controllers: Annotated[list[str], typer.Option(
                "--controller", metavar="[LABEL=]CONTROLLER", help="A controller: an FMU of this project by its name, "
                "an FMU or a Python file. To be repeated.")],
            out: Out = Path("results"),
            json: Annotated[bool, typer.Option("--json", help="Print the comparison as JSON.")] = False,
            debug: Debug = False, **options: Any) -> None:
    """Run a scenario with several controllers, and put the runs side by side.

    Written are `NAME@LABEL.csv` and `.json` of each run, then `NAME.compare.json`, `.txt`, `.html`, and `.png` where
    matplotlib is installed. Nothing of another run is overwritten.

    **Examples:**

    `maglev compare 3dof-setpoints --controller Regulator3DOF --controller PID3DOF`

    `maglev compare 2dof-setpoints --controller Regulator2DOF --controller lqi.py --controller old=old/lqi.py`
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
