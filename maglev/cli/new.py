"""The commands `maglev new`, which writes files to begin with, and `maglev stage`, which evaluates a description."""

import shlex
from pathlib import Path
from typing import Annotated

import typer

import maglev
from maglev.cli.help_text import Group
from maglev.cli.options import ANY_STAGE, AsJson, Debug, run_names
from maglev.cli.terminal import one_line_errors, progress_of, say, write_json
from maglev.descriptions import EXAMPLE
from maglev.files.errors import visible

PythonFile = Annotated[Path, typer.Argument(metavar="NAME", help="File NAME.py to write.")]
TomlFile = Annotated[Path, typer.Argument(metavar="NAME", help="File NAME.toml to write.")]
OfStage = Annotated[str, typer.Option(metavar="STAGE", help=ANY_STAGE)]
OfScenario = Annotated[str, typer.Option(metavar="SCENARIO", help="A run, or a TOML file.",
                                         autocompletion=run_names)]

new = Group(help="Write a first controller, scenario, study or stage.")


@new.command()
def controller(path: PythonFile, stage: OfStage = EXAMPLE, debug: Debug = False) -> None:
    """Write a controller in Python that runs, for you to change.

    Write one, and run it:

        maglev new controller lqi.py
        maglev run 3dof-setpoints --controller lqi.py
    """
    with one_line_errors(debug):
        say_how(maglev.new_controller(path, stage), stage, "--controller")


@new.command()
def plant(path: PythonFile, stage: OfStage = EXAMPLE, debug: Debug = False) -> None:
    """Write a plant in Python that runs: an ideal levitated mass.

    It has the ports of a stage.

        maglev new plant mover.py --stage 2dof
        maglev run 2dof-setpoints --plant mover.py
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
    """Write a scenario that runs, for you to change.

    Comments in it list further keys.

        maglev new scenario mine.toml --stage 2dof
        maglev run mine.toml --plot
    """
    with one_line_errors(debug):
        file = maglev.new_scenario(path, stage)
        say_command(file, "run", file, "--plot")


@new.command()
def study(path: TomlFile, scenario: OfScenario = f"{EXAMPLE}-setpoints", debug: Debug = False) -> None:
    """Write a parameter study that runs, for you to change.

    Comments in it list further keys.

        maglev new study robust.toml --scenario 3dof-setpoints
        maglev study robust.toml
    """
    with one_line_errors(debug):
        file = maglev.new_study(path, scenario)
        say_command(file, "study", file)


@new.command()
def tuning(path: TomlFile, scenario: OfScenario = f"{EXAMPLE}-setpoints",
           controller: Annotated[Path | None, typer.Option(
               metavar="FILE", help="Your own controller, whose parameters are tuned.", show_default=False)] = None,
           debug: Debug = False) -> None:
    """Write a tuning that runs, for you to change.

    Comments in it list further keys.

    Tune the poles of the scenario's regulator, or the parameters of your own controller:

        maglev new tuning quicker.toml
        maglev new controller lqi.py
        maglev new tuning lqi-gains.toml --controller lqi.py
        maglev tune lqi-gains.toml
    """
    with one_line_errors(debug):
        file = maglev.new_tuning(path, scenario, controller)
        typer.echo(f"{file}: run it with `maglev tune {file}`")


@new.command()
def repository(path: Annotated[Path, typer.Argument(metavar="FOLDER", help="Folder to write; it must not exist.")],
               stage: OfStage = EXAMPLE, debug: Debug = False) -> None:
    """Write a repository: controller, experiment, baseline, CI jobs.

    The jobs are for GitHub and GitLab.

        maglev new repository levitate --stage 2dof
    """
    with one_line_errors(debug):
        folder = maglev.new_repository(path, stage, watch=progress_of, say=say)
        typer.echo(f"{folder}: begin with {folder / 'README.md'}; the CI jobs install a wheel, see "
                   f"{folder / 'wheels' / 'README.md'}")


@new.command("stage")
def stage_file(path: Annotated[Path, typer.Argument(
                   metavar="NAME", help="File NAME.toml: lower-case letters, digits.")],
               like: Annotated[str | None, typer.Option(
                   metavar="STAGE", help="Stage to copy, such as `2dof`, or `side-by-side`.",
                   show_default=False)] = None,
               motor: Annotated[list[str] | None, typer.Option(
                   metavar="SIZE|KEY=VALUE", help="Motor from a catalogue or data sheet. Repeatable.",
                   show_default=False)] = None,
               debug: Debug = False) -> None:
    """Write the description of a stage, and a scenario for it.

    Both run as they are, for you to change.

    Copy a stage, print the consequences of its numbers, and run it:

        maglev new stage mine.toml --like 3dof
        maglev stage mine.toml
        maglev run mine-setpoints.toml --plot

    Describe your motor by size (`small`, `medium`, `large`), or by numbers of its data sheet:

        maglev new stage heavy.toml --motor medium --motor mass=12kg
        maglev new stage yours.toml --motor force_constant=93 \\
            --motor attraction=950 --motor attraction_gap=0.9mm \\
            --motor pole_pitch=12mm --motor peak=6.5

    Keys: force_constant, attraction, attraction_gap, pole_pitch, peak, currents, at, continuous, lag, resistance,
    inductance, slot_pitch, slot_width, magnet_height, and gap and mass of the stage.

    `--like side-by-side` has two motors under one axis, which tilt it. Without `--like` it copies 3dof, or with
    `--motor` 2dof.
    """
    with one_line_errors(debug):
        file, scenario = maglev.new_stage(path, like, motor or ())
        say_command(f"{file}, {scenario}", "run", scenario, "--plot")


Description = Annotated[Path, typer.Argument(
    metavar="TOML", help="Description from `maglev new stage`.", show_default=False)]


def stage(description: Description, as_json: AsJson = None, debug: Debug = False) -> None:
    """Evaluate a stage: forces, currents, gains, margins, warnings.

    Margins are those of the sampled loop with amplifiers, observer and controller, at the start and at both ends of the
    air gap's travel. Each is opened at the measurement of one axis.

        maglev new stage mine.toml
        maglev stage mine.toml
    """
    with one_line_errors(debug):
        consequences = maglev.stage(description)
        typer.echo(str(consequences), nl=False)
        if as_json is not None:
            write_json(as_json, consequences.as_data())
