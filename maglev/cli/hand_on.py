"""The commands `maglev target`, `maglev pack`, and `maglev cache`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import maglev
from maglev.cli.options import Debug, StageFile, run_names, with_run_options
from maglev.cli.terminal import one_line_errors, progress_of
from maglev.files import cache as kept
from maglev.files.units import number_or_text

ControllerName = Annotated[str, typer.Argument(metavar="CONTROLLER", show_default=False,
                                               help="A controller, or a Python file with one.")]
OnRun = Annotated[str | None, typer.Option("--run", metavar="SCENARIO", help="What it is measured on: a run of the "
                                           "package, or a TOML file.", show_default="the setpoints of its stage",
                                           autocompletion=run_names)]
TargetFolder = Annotated[Path, typer.Option("--out", help="Folder, in which one of the controller's name is written.")]
Clock = Annotated[str, typer.Option(help="Frequency of the processor, in Hz or with a unit, for the estimate.")]
Cycles = Annotated[float, typer.Option(help="Cycles of an instruction in the mean, for the estimate.")]


@with_run_options("fmus")
def target(controller: ControllerName, run: OnRun = None, stage: StageFile = None, out: TargetFolder = Path("target"),
           clock: Clock = "216 MHz", cycles: Cycles = 1.5, debug: Debug = False, **options: Any) -> None:
    """Write a controller as C for a microcontroller.

    It is measured on a Cortex-M7 in QEMU.

    `NAME.h` has the ports in SI units, `NAME.c` all that is behind them: C99 without a library and without memory that
    is allocated. Next to them lie an example, a file for CMake, and a report. For that a whole run is made twice, with
    the native FMU and with the emulated processor, sample by sample against the same plant: every signal has to have
    the same bits.

    **Examples:**

    `maglev target Regulator3DOF`

    `maglev target lqi.py --run 3dof-setpoints --clock "480 MHz"`

    `maglev target RegulatorMine --stage mine.toml --run mine-setpoints.toml`
    """
    with one_line_errors(debug):
        made = maglev.target(controller, run, stage=stage, out=out, clock=number_or_text(clock), cycles=cycles,
                             watch=progress_of, **options)
        typer.echo(made.report if made.report is not None else f"{controller}: {made.left_out}\n", nl=False)
        typer.echo(f"{made.folder}: {', '.join(str(file.relative_to(made.folder)) for file in made.files)}")


pack = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown", help="Put an experiment into an FMU.")


@pack.callback()
def about_pack() -> None:
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
    """Run a scenario with an FMU, and put its inputs and outputs there into it, as an experiment of its own.

    `maglev check` and other tools that know the layered standard FMI-LS-REF can then run it alone. The table `check` of
    the scenario says what is compared, and how closely.

    **Examples:**

    `maglev pack ref mine.fmu 2dof-smooth-nonlinear --as controller`

    `maglev check mine.fmu`
    """
    with one_line_errors(debug):
        with progress_of([scenario]) as watch:
            result = maglev.pack_reference(fmu, scenario, name=name, out=out, watch=watch, **options)
        typer.echo(f"{out or fmu}: carries {result.name}; run alone, {result.message}")


def cache(clear: Annotated[bool, typer.Option("--clear", help="Remove all of it: it is built again where it is needed."
                                              )] = False, debug: Debug = False) -> None:
    """Show where FMUs that were built for runs are kept.

    The names in it are digests of the sources: FMUs of other versions stay until it is cleared. The environment
    variable `MAGLEV_CACHE` sets another folder.
    """
    with one_line_errors(debug):
        sizes = kept.sizes()
        if clear:
            kept.clear()
        typer.echo(f"{kept.cache_folder()}: {len(sizes)} files, {1e-6 * sum(sizes):.1f} MB"
                   + (", cleared" if clear else ""))
