"""Options that commands of the command line share."""

from pathlib import Path
from typing import Annotated

import typer

from scenarios.errors import ScenarioError
from scenarios.quantity import number_or_text, parse_quantity

Debug = Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")]
Fmus = Annotated[Path, typer.Option("--fmus", help="Folder with the built FMUs.")]
Native = Annotated[bool, typer.Option("--native", help="The FMUs that need no Python, of the folder's folder native.")]
Names = Annotated[list[str] | None, typer.Argument(
    metavar="SCENARIO", help="Scenarios or variants (see `maglev list`), or TOML files.", show_default=False)]
Everything = Annotated[bool, typer.Option("--all", help="Every scenario of the package.")]
Settings = Annotated[list[str] | None, typer.Option(
    "--set", metavar="FMU.variable=value", help="Start value that goes before the scenario's; may carry a unit and may "
    "be repeated.", show_default=False)]
Plant = Annotated[Path | None, typer.Option(help="Another plant FMU with the same ports.", show_default=False)]
Controller = Annotated[Path | None, typer.Option(help="Another controller FMU with the same ports.",
                                                 show_default=False)]
Step = Annotated[str | None, typer.Option(help="Communication step, in s or with a unit.", show_default=False)]
Out = Annotated[Path, typer.Option(help="Folder for the results.")]
Jobs = Annotated[int | None, typer.Option(
    min=1, help="Runs at a time, each in a process of its own; as many as processors if not given.",
    show_default=False)]


def replacements(plant: Path | None, controller: Path | None) -> dict[str, Path]:
    """FMU files that take the place of a scenario's, by participant."""
    return {name: path for name, path in (("plant", plant), ("controller", controller)) if path is not None}


def chosen_folder(fmus: Path, native: bool) -> Path:
    """Folder of the FMUs of this project."""
    return fmus / "native" if native else fmus


def read_step(text: str | None) -> float | None:
    """Communication step (s) of the option --step."""
    if text is None:
        return None
    try:
        return parse_quantity(number_or_text(text), "s")
    except ValueError as error:
        raise ScenarioError(f"--step {text}: {error}") from error
