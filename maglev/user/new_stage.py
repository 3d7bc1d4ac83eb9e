"""Files for a user's first step: a stage with a scenario next to it, or a scenario."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from maglev.descriptions import EXAMPLE
from maglev.descriptions.data_sheet import Catalogue, Field
from maglev.descriptions.packaged import PACKAGED_STAGES, SINGLE
from maglev.descriptions.registry import known_stages
from maglev.descriptions.writer import render
from maglev.files.errors import MaglevError, StageError, one_of, option
from maglev.user.adoption import require_free_name, stage_named
from maglev.user.motor import SIDE_BY_SIDE, Motor, read_motor, sheet_of, two_motors, with_motor
from maglev.user.reading import read_own
from maglev.user.scenario_loop import TIMES, setpoints, settling_band
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import StageDescription


def new_stage(path: str | Path, like: str | None = None, motor: Sequence[str] = ()) -> tuple[Path, Path]:
    """Write the description of a stage, and a scenario for it, to begin with; nothing is overwritten.

    Parameters
    ----------
    path : path
        The file, NAME or NAME.toml; the FMUs of the stage are named after it.
    like : str, optional
        Stage whose axes and motors it begins with: the 3-DOF stage, with a motor the 2-DOF stage.
    motor : sequence of str
        Other motors in its places: "small", "medium" or "large", typical of catalogues, and numbers of a data sheet as
        "KEY=VALUE", such as "force_constant=93 N/A". Travel, encoders, sample time and limits go with them.

    Returns
    -------
    tuple of Path
        Description, and scenario NAME-setpoints.toml next to it.

    Raises
    ------
    StageError
        If a file is there already, or its name, the stage or the motor is unknown, or nothing works with it.

    Examples
    --------
    >>> import maglev
    >>> [file.name for file in maglev.new_stage("mine.toml", like="2dof")]
    ['mine.toml', 'mine-setpoints.toml']
    """
    file = file_named(path, ".toml")
    like = like or (SINGLE if motor else EXAMPLE)
    if like not in (*PACKAGED_STAGES, SIDE_BY_SIDE):
        raise StageError(f"{option('like', like)}: expected {one_of(like, (*PACKAGED_STAGES, SIDE_BY_SIDE))}")
    stage = two_motors() if like == SIDE_BY_SIDE else PACKAGED_STAGES[like]
    scenario = file.with_name(f"{file.stem}-setpoints.toml")
    require_free_name(file, file.stem)
    write_new(file, stage_text(stage, file, read_motor(motor) if motor else None))
    with undone(file):
        write_new(scenario, scenario_text(read_own(file), scenario, file.name, more=False))
        if motor:
            from maglev.user.consequences import runnable  # linear models: scipy takes its time to load

            with undone(scenario):
                runnable(file)
    return file, scenario


@contextmanager
def undone(file: Path) -> Iterator[None]:
    """Remove a file if a later step fails."""
    try:
        yield
    except MaglevError:
        file.unlink()
        raise


def new_scenario(path: str | Path, stage: str | Path = EXAMPLE) -> Path:
    """Write a scenario that runs, to begin with; nothing is overwritten.

    Parameters
    ----------
    path : path
        The file, NAME or NAME.toml; the run in it is named after it.
    stage : str or path
        Name of a stage, or the description of your own, NAME.toml.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    StageError
        If the file exists already, or its name or the stage is not valid.

    Examples
    --------
    >>> import maglev
    >>> maglev.new_scenario("hold.toml", stage="2dof").name
    'hold.toml'
    """
    description = stage_named(str(stage))
    file = toml_file(path)
    own = seen_from(file, stage) if description.name in known_stages().own else None
    write_new(file, scenario_text(description, file, own, more=True))
    return file


def toml_file(path: str | Path) -> Path:
    """File NAME.toml by its path or by NAME; StageError if no run can have the name."""
    file = file_named(path, ".toml")
    if not file.stem.replace("-", "_").replace(".", "_").isidentifier() or not file.stem.isascii():
        raise StageError(f"{file}: expected a name of letters, digits and - _ ., a letter first: results have it")
    return file


def seen_from(file: Path, other: str | Path) -> str:
    """A file as one next to it, or elsewhere, names it."""
    there = Path(other).absolute()
    return there.name if there.parent == file.absolute().parent else str(there)


def file_named(path: str | Path, suffix: str) -> Path:
    """A new file by its path, with its suffix or without."""
    return Path(path) if Path(path).suffix == suffix else Path(f"{path}{suffix}")


def write_new(file: Path, text: str, error: type[MaglevError] = StageError) -> None:
    """Write a new file; an error if it is there already, or has no folder."""
    if not file.parent.is_dir():
        raise error(f"{file}: the folder {file.parent} does not exist")
    try:
        with file.open("x", encoding="utf-8", newline="\n") as written:
            written.write(text)
    except FileExistsError:
        raise error(f"{file}: already exists, expected the name of a new file") from None


def stage_text(stage: StageDescription, file: Path, motor: Motor | None = None) -> str:
    """Text of a description that begins as a stage is, a first motor's numbers those of all; or with a given motor."""
    if motor is None:
        sheet, field = sheet_of_stage(stage), Field(stage.motor().field.lower, stage.motor().field.upper)
    else:
        sheet, (stage, field) = sheet_of(motor), with_motor(stage, motor)
    known = stage.motor().field
    gaps = [known.lower + k * (known.upper - known.lower) / 8.0 for k in range(9)]
    return render("new/stage.toml.j2", stage, file=file.name, name=file.stem,
                  suffix=file.stem[:1].upper() + file.stem[1:], sharing=f"{stage.sharing:g}", geometry=stage.motor(),
                  sheet=sheet, field=field, gaps=[round(gap, 6) for gap in gaps],
                  B=[float(f"{known.value(gap):.5g}") for gap in gaps])


def sheet_of_stage(description: StageDescription) -> Catalogue:
    """Data sheet from which the constants of a stage follow, of its first motor."""
    first, vertical = description.horizontal[0], description.vertical
    plant, motor = description.plant, description.motors[0]
    f1, f2, f3, f4 = gap_functions(description.motor(), vertical.start)
    printed = [float(f"{value:.4g}") for value in (
        plant.thrust[first.name] * first.mass * f1, plant.attraction * vertical.mass * f2,
        plant.coils * vertical.mass * f3, plant.iron * vertical.mass * f4)]
    return Catalogue("peak", printed[0], vertical.start, printed[1], vertical.start, printed[2], printed[3],
                     motor.amplifier.peak, motor.amplifier.continuous,
                     resistance=round(description.sharing * motor.winding.resistance, 6),
                     inductance=round(description.sharing * motor.winding.inductance, 6))


def scenario_text(stage: StageDescription, scenario: Path, own: str | None, more: bool, controller: str = "") -> str:
    """Text of a scenario of setpoints that the stage can follow.

    `own` is the description of a user's stage. With `more` the scenario has the setpoints themselves, claims, and
    comments on further keys; or instead of these the file of a `controller` and the values that a baseline keeps.
    """
    return render("new/scenario.toml.j2", stage, own=own, name=scenario.stem, scenario=scenario.name,
                  setpoints=setpoints(stage) if more else {}, times=list(TIMES),
                  band=f"{1e3 * settling_band(stage):g} mm", more=more, controller=controller)
