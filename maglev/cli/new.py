"""`maglev new`: files to begin with."""

from pathlib import Path
from typing import Annotated

import typer

from maglev.cli.options import Debug
from maglev.cli.terminal import one_line_errors

new = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown", help="Write a file to begin with.")


@new.callback()
def main() -> None:
    """Write a file to begin with."""


@new.command()
def controller(path: Annotated[Path, typer.Argument(metavar="FILE", help="The file, NAME.py; nothing is overwritten.")],
               stage: Annotated[str, typer.Option(help="`2dof` or `3dof`.")] = "3dof", debug: Debug = False) -> None:
    """Write a controller in Python that flies as it is, for you to change.

    **Examples:**

    `maglev new controller lqi.py --stage 3dof`

    `maglev run 3dof-setpoints --controller lqi.py`
    """
    with one_line_errors(debug):
        from maglev.written.new import new_controller

        file = new_controller(path, stage)
        typer.echo(f"{file}: flies with `maglev run {stage}-setpoints --controller {file}`")
