"""The commands that fly a scenario many times: `maglev study`, `maglev sweep` and `maglev tune`."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from maglev.cli.options import Debug, Out, run_names, with_flight_options
from maglev.cli.terminal import one_line_errors, progress_of, report_console, say
from maglev.errors import ScenarioError

if TYPE_CHECKING:
    from maglev.api.many.studying import Study

Processes = Annotated[int | None, typer.Option("--jobs", min=1, help="Processes of this machine; as many as processors "
                                               "if not given.", show_default=False)]
Scheduler = Annotated[str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler, such as tcp://host:8786, whose "
                                               "workers fly in place of this machine's.", show_default=False)]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with what an interrupted one has done.")]
SampleTimeout = Annotated[str | None, typer.Option(metavar="TIME", help="Longest wall time of a sample; of one that "
                                                   "takes longer a row says so; 600 s with FMUs that are not of this "
                                                   "project.", show_default="none")]


@with_flight_options("timeout", "parameters")
def study(file: Annotated[str, typer.Argument(metavar="STUDY", help="A study of the package, or a TOML file.")],
          out: Out = Path("results"), jobs: Processes = None, scheduler: Scheduler = None, resume: Resume = False,
          sample_timeout: SampleTimeout = None, debug: Debug = False, **options: Any) -> None:
    """Fly a scenario many times: what varies, by which design, and what is kept is in a TOML file (docs/studies.md).

    The results are `NAME.parquet`, a row for each sample with parameters and metrics, and the page `NAME.html`. After
    Ctrl-C, `--resume` goes on.

    **Examples:**

    `maglev study payload-friction`

    `maglev study my_study.toml --scheduler tcp://host:8786`
    """
    with one_line_errors(debug):
        from maglev.api.many.studying import study as fly_study

        finish(fly_study(file, out=out, jobs=jobs, scheduler=scheduler, resume=resume,
                         sample_timeout=sample_timeout, watch=progress_of, say=say, **options))


@with_flight_options("timeout", "parameters")
def sweep(scenario: Annotated[str, typer.Argument(metavar="SCENARIO", help="A scenario without variants, a variant, or "
                                                  "a TOML file.", autocompletion=run_names)],
          vary: Annotated[list[str], typer.Argument(metavar="FMU.variable=FROM:TO:NUMBER", help="What varies; several: "
                                                    "every combination. Also single values, with commas between.")],
          samples: Annotated[int | None, typer.Option(min=1, help="Fly so many samples, a Latin hypercube, in place of "
                                                      "every combination; for ranges, FMU.variable=LOW:HIGH and ±20%.",
                                                      show_default=False)] = None,
          seed: Annotated[int, typer.Option(min=0, help="Of --samples: the same gives the same.")] = 0,
          keep: Annotated[list[str] | None, typer.Option("--keep", metavar="FMU.variable", help="Keep the trajectory "
                                                         "of a signal; to be repeated.", show_default=False)] = None,
          name: Annotated[str | None, typer.Option(help="Name of the results.", show_default="SCENARIO.sweep")] = None,
          out: Out = Path("results"), jobs: Processes = None, scheduler: Scheduler = None, resume: Resume = False,
          sample_timeout: SampleTimeout = None, debug: Debug = False, **options: Any) -> None:
    """Fly a scenario with every combination of values, or --samples of ranges, a study without a file.

    Results are those of `maglev study`. Several variables, with commas between, take the same values.

    **Examples:**

    `maglev sweep 3dof-setpoints controller.y.k1=-2000:-800:20`

    `maglev sweep 2dof-setpoints plant.v.mass=4:5:5 reference.v.amplitude=0.5,1,1.5`

    `maglev sweep 3dof-setpoints plant.x.friction.coulomb=±20% --samples 200 --controller mine.py`
    """
    with one_line_errors(debug):
        from maglev.api.many.studying import sweep as fly_sweep

        finish(fly_sweep(scenario, values_of(vary), name=name, keep=keep or (), samples=samples, seed=seed, out=out,
                         jobs=jobs, scheduler=scheduler, resume=resume, sample_timeout=sample_timeout,
                         watch=progress_of, say=say, **options))


def values_of(vary: list[str]) -> dict[str, str]:
    """What varies, by name."""
    found: dict[str, str] = {}
    for each in vary:
        target, equals, values = each.partition("=")
        if not equals or not values:
            raise ScenarioError(f"{each}: expected FMU.variable=FROM:TO:NUMBER, such as plant.y.mass=6:8:5")
        if target in found:
            raise ScenarioError(f"{each}: {target} is given twice, expected once")
        found[target] = values
    return found


def finish(flown: "Study") -> None:
    """Write the page, and print what the study found; exits with 2 if no sample came to its end."""
    from maglev.studies.page.text import show_study

    table = flown.to_arrow()
    show_study(report_console(), table, flown.about)
    typer.echo(f"results: {flown.path}, {flown.write_page()}")
    if table["failure"].null_count == 0:
        say(f"{flown.name}: none of {table.num_rows} samples was completed; of the first: {table['failure'][0]}")
        raise typer.Exit(2)


@with_flight_options("timeout", "parameters")
def tune(file: Annotated[str, typer.Argument(metavar="TUNING", help="A tuning file of the package, or a TOML file.")],
         out: Out = Path("results"), jobs: Processes = None, scheduler: Scheduler = None, resume: Resume = False,
         debug: Debug = False, **options: Any) -> None:
    """Search parameters of a controller for the least of what is measured on many plants (docs/studies.md).

    The result is `NAME.toml`, which a scenario extends, and the metrics before and after, also on plants that were
    not searched with. After Ctrl-C, `--resume` goes on.

    **Examples:**

    `maglev tune horizontal-3dof`

    `maglev tune my_tuning.toml --scheduler tcp://host:8786`
    """
    with one_line_errors(debug):
        from maglev.api.many.tuning import tune as search

        tuned = search(file, out=out, jobs=jobs, scheduler=scheduler, resume=resume, watch=progress_of, say=say,
                       **options)
        tuned.show(report_console())
        typer.echo(f"results: {tuned.path}")
