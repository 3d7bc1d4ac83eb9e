"""The command `maglev tune`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from maglev.cli.options import Debug, Out, with_flight_options
from maglev.cli.study import Processes, Resume, Scheduler
from maglev.cli.terminal import one_line_errors, progress_of, report_console, say


@with_flight_options("timeout")
def tune(file: Annotated[str, typer.Argument(metavar="TUNING", help="A tuning file of the package, or a TOML file.")],
         out: Out = Path("results"), jobs: Processes = None, scheduler: Scheduler = None, resume: Resume = False,
         debug: Debug = False, **options: Any) -> None:
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
                       **options)
        tuned.show(report_console())
        typer.echo(f"results: {tuned.path}")
