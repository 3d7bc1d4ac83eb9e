"""The commands `maglev target`, `maglev pack`, and `maglev cache`."""

from pathlib import Path
from typing import Annotated, Any

import typer

import maglev
from maglev.cli.help_text import Group
from maglev.cli.options import Debug, StageFile, run_names, with_run_options
from maglev.cli.terminal import one_line_errors, progress_of

ControllerName = Annotated[str, typer.Argument(metavar="CONTROLLER", show_default=False,
                                               help="A controller, or a Python file with one.")]
OnRun = Annotated[str | None, typer.Option(
    "--run", metavar="SCENARIO", help="Run to measure it on; by default the setpoints.", show_default=False,
    autocompletion=run_names)]
TargetFolder = Annotated[Path, typer.Option("--out", metavar="FOLDER", help="Folder for the controller's folder.")]
Clock = Annotated[str, typer.Option(metavar="FREQUENCY", help="Processor clock for the estimate.")]
Cycles = Annotated[float, typer.Option(metavar="X", help="Mean cycles of an instruction.")]


@with_run_options(["fmus"])
def target(controller: ControllerName, run: OnRun = None, stage: StageFile = None, out: TargetFolder = Path("target"),
           clock: Clock = "216 MHz", cycles: Cycles = 1.5, debug: Debug = False, **options: Any) -> None:
    """Write a controller as C for a microcontroller, and measure its time.

    `NAME.h` declares the ports in SI units, and `NAME.c` is C99 without libraries and without dynamic memory. An
    example, a CMake file and a report are written with them.

    For the report the C runs on a Cortex-M7 in QEMU next to the native FMU, against the same plant. Every signal must
    have the same bits at every sample.

    Write the regulator of the 3-DOF stage:

        maglev target Regulator3DOF

    Measure your own controller at another clock:

        maglev new controller lqi.py
        maglev target lqi.py --run 3dof-setpoints --clock "480 MHz"

    Write the regulator of your own stage:

        maglev new stage mine.toml
        maglev target RegulatorMine --stage mine.toml --run mine-setpoints.toml
    """
    with one_line_errors(debug):
        from maglev.files.units import number_or_text

        made = maglev.target(controller, run, stage=stage, out=out, clock=number_or_text(clock), cycles=cycles,
                             watch=progress_of, **options)
        typer.echo(made.report if made.report is not None else f"{controller}: {made.left_out}\n", nl=False)
        typer.echo(f"{made.folder}: {', '.join(str(file.relative_to(made.folder)) for file in made.files)}")


pack = Group(help="Put an experiment into an FMU.")


@pack.callback()
def about_pack() -> None:
    """Put an experiment into an FMU."""


@pack.command()
@with_run_options(["fmus"])
def ref(fmu: Annotated[Path, typer.Argument(metavar="FMU", help="An FMU for co-simulation.")],
        scenario: Annotated[str, typer.Argument(metavar="SCENARIO", help="A packaged run, or a TOML file.",
                                                autocompletion=run_names)],
        name: Annotated[str | None, typer.Option(
            "--as", "--name", metavar="PART", help="Part it replaces: `controller` or `plant`.",
            show_default=False)] = None,
        out: Annotated[Path | None, typer.Option(metavar="FILE", help="File to write; by default the FMU itself.",
                                                 show_default=False)] = None,
        debug: Debug = False, **options: Any) -> None:
    """Run a scenario with an FMU, and store its inputs and outputs in the FMU.

    `maglev check` and other tools that know the layered standard FMI-LS-REF can then check the FMU on its own. The
    table `check` of the scenario lists the compared signals and their tolerances.

    Build an FMU of your own controller, put a run into it, and check it alone:

        maglev new controller lqi.py
        maglev build lqi.py --fmus .
        maglev pack ref LQI.fmu 3dof-smooth-nonlinear --as controller
        maglev check LQI.fmu
    """
    with one_line_errors(debug):
        with progress_of([scenario]) as watch:
            result = maglev.pack_reference(fmu, scenario, name=name, out=out, watch=watch, **options)
        typer.echo(f"{out or fmu}: carries {result.name}; run alone, {result.message}")


def cache(clear: Annotated[bool, typer.Option("--clear", help="Remove all; runs rebuild what they need.")] = False,
          debug: Debug = False) -> None:
    """Show the cache of FMUs that were built for runs.

    File names contain digests of the sources, so FMUs of older versions stay until the cache is cleared. The
    environment variable `MAGLEV_CACHE` sets another folder.

    Show its size, or clear it:

        maglev cache
        maglev cache --clear
    """
    with one_line_errors(debug):
        from maglev.files import cache as kept

        sizes = kept.sizes()
        if clear:
            kept.clear()
        typer.echo(f"{kept.cache_folder()}: {len(sizes)} files, {1e-6 * sum(sizes):.1f} MB"
                   + (", cleared" if clear else ""))
