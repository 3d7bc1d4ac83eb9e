"""The command `maglev cache`."""

from typing import Annotated

import typer

from maglev.cli.options import Debug
from maglev.cli.terminal import one_line_errors


def cache(clear: Annotated[bool, typer.Option("--clear", help="Remove all of it: it is built again where it is needed."
                                              )] = False, debug: Debug = False) -> None:
    """Show where FMUs that were built for runs are kept.

    What is there was built of sources that are known by their content: those of other versions stay until it is
    cleared. The environment variable `MAGLEV_CACHE` sets another folder.
    """
    with one_line_errors(debug):
        from maglev_files import cache as kept

        sizes = kept.sizes()
        if clear:
            kept.clear()
        typer.echo(f"{kept.cache_folder()}: {len(sizes)} files, {1e-6 * sum(sizes):.1f} MB"
                   + (", cleared" if clear else ""))
