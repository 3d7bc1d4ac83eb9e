"""The command `maglev target`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from maglev.cli.options import Debug, RigFile, run_names, with_run_options
from maglev.cli.terminal import one_line_errors, progress_of
from maglev.units import number_or_text

ControllerName = Annotated[str, typer.Argument(metavar="CONTROLLER", show_default=False,
                                               help="A controller, or a Python file with one.")]
OnRun = Annotated[str | None, typer.Option("--run", metavar="SCENARIO", help="What it is measured on: a run of the "
                                           "package, or a TOML file.", show_default="the setpoints of its stage",
                                           autocompletion=run_names)]
TargetFolder = Annotated[Path, typer.Option("--out", help="Folder, in which one of the controller's name is written.")]
Clock = Annotated[str, typer.Option(help="Frequency of the processor, in Hz or with a unit, for the estimate.")]
Cycles = Annotated[float, typer.Option(help="Cycles of an instruction in the mean, for the estimate.")]


@with_run_options("fmus")
def target(controller: ControllerName, run: OnRun = None, rig: RigFile = None, out: TargetFolder = Path("target"),
           clock: Clock = "216 MHz", cycles: Cycles = 1.5, debug: Debug = False, **options: Any) -> None:
    """Write a controller as C for a microcontroller.

    It is measured on a Cortex-M7 in QEMU.

    `NAME.h` has the ports in SI units, `NAME.c` all that is behind them: C99 without a library and without memory that
    is allocated. Beside them lie an example, a file for CMake, and a report. For that a whole run is made twice, with
    the native FMU and with the emulated processor, sample by sample against the same plant: every signal has to have
    the same bits.

    **Examples:**

    `maglev target Regulator3DOF`

    `maglev target lqi.py --run 3dof-setpoints --clock "480 MHz"`

    `maglev target RegulatorMine --rig mine.toml --run mine-setpoints.toml`
    """
    with one_line_errors(debug):
        from maglev.microcontroller.target import target as written

        made = written(controller, run, rig=rig, out=out, clock=number_or_text(clock), cycles=cycles,
                       watch=progress_of, **options)
        typer.echo(made.report if made.report is not None else f"{controller}: {made.left_out}\n", nl=False)
        typer.echo(f"{made.folder}: {', '.join(str(file.relative_to(made.folder)) for file in made.files)}")
