"""`maglev pack`: what goes into an FMU that there is."""

from pathlib import Path
from typing import Annotated, Any

import typer

from maglev.cli.options import Debug, run_names, with_run_options
from maglev.cli.terminal import one_line_errors, progress_of

pack = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown", help="Put an experiment into an FMU.")


@pack.callback()
def main() -> None:
    """Put an experiment into an FMU."""


@pack.command()
@with_run_options("fmus")
def ref(fmu: Annotated[Path, typer.Argument(metavar="FMU", help="An FMU for co-simulation.")],
        scenario: Annotated[str, typer.Argument(metavar="SCENARIO", help="A run of the package, or a TOML file.",
                                                autocompletion=run_names)],
        name: Annotated[str | None, typer.Option(
            "--as", "--name", help="What the FMU takes the place of in the scenario, `controller` or `plant`; not "
            "needed where the scenario names its file.", show_default=False)] = None,
        out: Annotated[Path | None, typer.Option(help="Where to write it.", show_default="the FMU itself")] = None,
        debug: Debug = False, **options: Any) -> None:
    """Fly a scenario with an FMU, and put what it was given and gave there into it, as an experiment of its own.

    `maglev check` and other tools that know the layered standard FMI-LS-REF can then fly it alone. The table `check` of
    the scenario says what is compared, and how closely.

    **Examples:**

    `maglev pack ref mine.fmu 2dof-smooth-nonlinear --as controller`

    `maglev check mine.fmu`
    """
    with one_line_errors(debug):
        from maglev.fmu_experiments.pack import pack_reference

        with progress_of([scenario]) as watch:
            result = pack_reference(fmu, scenario, name=name, out=out, watch=watch, **options)
        typer.echo(f"{out or fmu}: carries {result.name}; run alone, {result.message}")
