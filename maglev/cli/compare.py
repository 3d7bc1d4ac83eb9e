"""The command `maglev compare`."""

from pathlib import Path
from typing import Annotated, Any

import typer

from maglev.cli.options import Debug, Out, run_names, with_run_options
from maglev.cli.terminal import one_line_errors, print_json, progress_of, report_console, say


@with_run_options(without=("controller",))
def compare(name: Annotated[str, typer.Argument(metavar="SCENARIO", help="A scenario without variants, a variant, or a "
                                                "TOML file.", autocompletion=run_names)],
            controllers: Annotated[list[str], typer.Option(
                "--controller", metavar="[LABEL=]CONTROLLER", help="A controller: an FMU of this project by its name, "
                "an FMU or a Python file. To be repeated.")],
            out: Out = Path("results"),
            json: Annotated[bool, typer.Option("--json", help="Print the comparison as JSON.")] = False,
            debug: Debug = False, **options: Any) -> None:
    """Run a scenario with several controllers, and put the runs side by side.

    Written are `NAME@LABEL.csv` and `.json` of each run, then `NAME.compare.json`, `.txt`, `.html`, and `.png` where
    matplotlib is installed. Nothing of another run is overwritten.

    **Examples:**

    `maglev compare 3dof-setpoints --controller Regulator3DOF --controller PID3DOF`

    `maglev compare 2dof-setpoints --controller Regulator2DOF --controller lqi.py --controller old=old/lqi.py`
    """
    with one_line_errors(debug):
        from maglev.api.comparing import compare as compare_runs
        from maglev.comparison.files import show_comparison
        from maglev_files.extras import lacking

        found = compare_runs(name, controllers, watch=progress_of, say=say, **options)
        missing = lacking("matplotlib", "report", "a picture")
        files = found.write(out, picture=not missing)
        if json:
            print_json(found.as_data())
        else:
            show_comparison(report_console(), found.name, found.title, found.results)
            typer.echo(f"results: {', '.join(map(str, files))}")
            if missing:
                say(missing)
        for label, failure in found.failures.items():
            say(f"{label}: {failure}")
        if found.failures:
            raise typer.Exit(2)
