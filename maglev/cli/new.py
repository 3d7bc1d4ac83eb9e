"""The commands `maglev new`, which writes files to begin with, and `maglev stage`, which evaluates a description."""

import shlex
from pathlib import Path
from typing import Annotated

import typer

import maglev
from maglev.cli.options import STAGE_NAMES, AsJson, Debug, run_names
from maglev.cli.terminal import one_line_errors, progress_of, say, write_json
from maglev.descriptions.packaged import EXAMPLE, PACKAGED_STAGES, SINGLE
from maglev.files.errors import visible

MOTOR_KEYS = ("force_constant", "attraction", "attraction_gap", "pole_pitch", "peak", "currents", "at", "continuous",
              "lag", "resistance", "inductance", "slot_pitch", "slot_width", "magnet_height", "gap", "mass")

PythonFile = Annotated[Path, typer.Argument(metavar="NAME", help="The file, NAME.py; nothing is overwritten.")]
TomlFile = Annotated[Path, typer.Argument(metavar="NAME", help="The file, NAME.toml; nothing is overwritten.")]
OfStage = Annotated[str, typer.Option(help=f"{STAGE_NAMES}, or the description of your own stage.")]

new = typer.Typer(no_args_is_help=True, rich_markup_mode="markdown",
                  help="Write a file to begin with: a controller, scenario, study, stage …")


@new.command()
def controller(path: PythonFile, stage: OfStage = EXAMPLE, debug: Debug = False) -> None:
    """Write a controller in Python that runs as it is, for you to change.

    **Examples:**

    `maglev new controller lqi --stage 3dof`

    `maglev run 3dof-setpoints --controller lqi.py`
    """
    with one_line_errors(debug):
        say_how(maglev.new_controller(path, stage), stage, "--controller")


@new.command()
def plant(path: PythonFile, stage: OfStage = EXAMPLE, debug: Debug = False) -> None:
    """Write a plant in Python that runs as it is, an ideal levitated mass with the ports of a stage.

    **Examples:**

    `maglev new plant mover --stage 2dof`

    `maglev run 2dof-setpoints --plant mover.py`
    """
    with one_line_errors(debug):
        say_how(maglev.new_plant(path, stage), stage, "--plant")


def say_how(file: Path, stage: str, option: str) -> None:
    """Print the command that runs a controller or a plant of a stage."""
    setpoints = Path(stage).with_name(f"{Path(stage).stem}-setpoints{Path(stage).suffix}")
    say_command(file, "run", setpoints, option, file)


def say_command(written: str | Path, *words: str | Path) -> None:
    """Print the command that runs what was written, for a shell."""
    typer.echo(visible(f"{written}: run it with `{shlex.join(['maglev', *map(str, words)])}`"))


@new.command()
def scenario(path: TomlFile, stage: OfStage = EXAMPLE, debug: Debug = False) -> None:
    """Write a scenario that runs as it is, with comments on further keys, for you to change.

    **Examples:**

    `maglev new scenario mine --stage 2dof`

    `maglev run mine.toml --plot`
    """
    with one_line_errors(debug):
        file = maglev.new_scenario(path, stage)
        say_command(file, "run", file, "--plot")


@new.command()
def study(path: TomlFile, scenario: Annotated[str, typer.Option(
              help="What it runs: a run of the package, or a scenario of yours, without variants.",
              autocompletion=run_names)] = f"{EXAMPLE}-setpoints", debug: Debug = False) -> None:
    """Write a study that runs as it is, with comments on further keys, for you to change.

    **Examples:**

    `maglev new study robust --scenario mine.toml`

    `maglev study robust.toml`
    """
    with one_line_errors(debug):
        file = maglev.new_study(path, scenario)
        say_command(file, "study", file)


@new.command()
def tuning(path: TomlFile, scenario: Annotated[str, typer.Option(
               help="What it runs: a run of the package, or a scenario of yours, without variants.",
               autocompletion=run_names)] = f"{EXAMPLE}-setpoints",
           controller: Annotated[Path | None, typer.Option(
               metavar="FILE", help="A controller of yours, a Python file, whose parameters are searched; without it "
               "the poles of the scenario's regulator are.", show_default=False)] = None, debug: Debug = False) -> None:
    """Write a tuning that runs as it is, with comments on further keys, for you to change.

    **Examples:**

    `maglev new tuning quicker --scenario mine.toml`

    `maglev new tuning quicker --controller lqi.py`

    `maglev tune quicker.toml`
    """
    with one_line_errors(debug):
        file = maglev.new_tuning(path, scenario, controller)
        typer.echo(f"{file}: run it with `maglev tune {file}`")


@new.command()
def repository(path: Annotated[Path, typer.Argument(metavar="FOLDER", help="The folder; it must not be there.")],
               stage: OfStage = EXAMPLE, debug: Debug = False) -> None:
    """Write a repository: a controller, its experiment and baseline, and the jobs of GitHub and GitLab at every push.

    **Examples:**

    `maglev new repository levitate --stage 2dof`
    """
    with one_line_errors(debug):
        folder = maglev.new_repository(path, stage, watch=progress_of, say=say)
        typer.echo(f"{folder}: begin with {folder / 'README.md'}; what runs at every push installs a wheel, which "
                   f"{folder / 'wheels' / 'README.md'} tells how to make")


@new.command("stage")
def stage_file(path: Annotated[Path, typer.Argument(metavar="NAME", help="The file, NAME.toml, with a name of small "
                                                    "letters and digits; nothing is overwritten.")],
               like: Annotated[str | None, typer.Option(help="Stage whose axes and motors it begins with: "
                                                        f"{', '.join(PACKAGED_STAGES)}, side-by-side: two motors under "
                                                        "one axis, which tilt it.",
                                                        show_default=f"{EXAMPLE}, with --motor {SINGLE}")] = None,
               motor: Annotated[list[str] | None, typer.Option(
                   metavar="NAME|KEY=VALUE", help="Other motors in its places: `small`, `medium` or `large`, typical "
                   "of catalogues; or, over these or alone, numbers of a data sheet, may be repeated: "
                   f"{', '.join(MOTOR_KEYS)}; gap and mass are the stage's.", show_default=False)] = None,
               debug: Debug = False) -> None:
    """Write the description of a stage that runs as it is, for you to change, and a scenario next to it.

    **Examples:**

    `maglev new stage mine --like 3dof`

    `maglev new stage heavy --motor medium --motor mass=12kg`

    `maglev new stage yours --motor force_constant=93 --motor attraction=950 --motor attraction_gap=0.9mm --motor
    pole_pitch=12mm --motor peak=6.5`

    `maglev stage mine.toml` says what follows from it

    `maglev run mine-setpoints.toml --plot`
    """
    with one_line_errors(debug):
        file, scenario = maglev.new_stage(path, like, motor or ())
        say_command(f"{file}, {scenario}", "run", scenario, "--plot")


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
        consequences = maglev.stage(description)
        typer.echo(str(consequences), nl=False)
        if as_json is not None:
            write_json(as_json, consequences.as_data())
