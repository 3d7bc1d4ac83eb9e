"""The command `maglev stage`."""

from pathlib import Path
from typing import Annotated

import typer

from maglev.cli.options import AsJson, Debug
from maglev.cli.terminal import one_line_errors, write_json

Description = Annotated[Path, typer.Argument(metavar="TOML", help="Description of your own stage; `maglev new stage` "
                                             "writes one.", show_default=False)]


def stage(description: Description, as_json: AsJson = None, debug: Debug = False) -> None:
    """Say what follows from the description of your own stage: forces, currents, times, gains, margins, warnings.

    Margins are those of the closed loop with lag, hold, observer and controller, opened at the measurement of each
    axis: at the start and at both ends of the travel of the air gap.

    **Examples:**

    `maglev stage mine.toml`
    """
    with one_line_errors(debug):
        from maglev.own_stage.consequences import stage as follow

        found = follow(description)
        typer.echo(str(found), nl=False)
        if as_json is not None:
            write_json(as_json, found.as_data())
