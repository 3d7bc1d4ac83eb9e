"""The command `maglev tune`."""

from pathlib import Path
from typing import Annotated

import typer

from maglev.cli.options import (
    Controller,
    Debug,
    Fmus,
    KeepSettings,
    Model,
    Native,
    Ordering,
    Out,
    Plant,
    PortsFile,
    Settings,
    Step,
)
from maglev.cli.study import Processes, Resume, Scheduler
from maglev.cli.terminal import one_line_errors, progress_of, report_console, say


def tune(file: Annotated[str, typer.Argument(metavar="TUNING", help="A tuning file of the package, or a TOML file.")],
         settings: Settings = None, model: Model = None, plant: Plant = None, controller: Controller = None,
         ports: PortsFile = None, keep_settings: KeepSettings = False, step: Step = None,
         order: Ordering = "sequential", out: Out = Path("results"),
         fmus: Fmus = Path("fmus"), native: Native = False, jobs: Processes = None, scheduler: Scheduler = None,
         resume: Resume = False, debug: Debug = False) -> None:
    """Search parameters of a controller for the least of what is measured on many plants (docs/tuning.md).

    The result is `NAME.toml`, which a scenario extends, and the metrics before and after, also on plants that were
    not searched with. After Ctrl-C, `--resume` goes on.

    **Examples:**

    `maglev tune horizontal-3dof --native`

    `maglev tune my_tuning.toml --native --scheduler tcp://host:8786`
    """
    with one_line_errors(debug):
        from maglev.api.tuning import tune as search

        tuned = search(file, out=out, jobs=jobs, scheduler=scheduler, resume=resume, watch=progress_of, say=say,
                       set=settings, model=model, plant=plant, controller=controller, ports=ports, step=step,
                       order=order, fmus=fmus, native=native, keep_settings=keep_settings)
        tuned.show(report_console())
        typer.echo(f"results: {tuned.path}")
