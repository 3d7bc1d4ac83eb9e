"""What a user begins with, as files: a stage with a scenario beside it, a scenario, the text of a study."""

from pathlib import Path

from maglev.errors import MaglevError, RigError, one_of
from maglev.own_stage.adoption import OWN, rig_named
from maglev.own_stage.reading import read_own
from maglev.rig.writer import render
from pmlsm.gap_functions import gap_functions
from pmlsm.rig import Rig
from pmlsm.rigs import EXAMPLE, RIGS

# Set-points of the scenario, as shares of the way from the start to the nearer stop, for every axis in turn; of a tilt
# that of the outermost motor.
SHARES = ((0.0, 0.2, -0.2, 0.1), (0.0, 0.08, -0.08, 0.12), (0.0, -0.08, 0.08, -0.12), (0.0, 0.1, -0.1, 0.05),
          (0.0, -0.1, 0.05, 0.1))


def new_stage(path: str | Path, like: str = EXAMPLE) -> tuple[Path, Path]:
    """Write the description of a stage, and a scenario that flies it, to begin with; nothing is overwritten.

    Parameters
    ----------
    path : path
        The file, NAME or NAME.toml; the FMUs of the stage are named after it.
    like : str
        Rig whose axes and motors it begins with.

    Returns
    -------
    tuple of Path
        Description, and scenario NAME-setpoints.toml beside it.

    Raises
    ------
    RigError
        If a file is there already, or its name or the rig is no such thing.

    Examples
    --------
    >>> import maglev
    >>> [file.name for file in maglev.new_stage("mine.toml", like="2dof")]
    ['mine.toml', 'mine-setpoints.toml']
    """
    file = file_named(path, ".toml")
    if like not in RIGS:
        raise RigError(f"--like {like}: expected {one_of(like, RIGS)}")
    scenario = file.with_name(f"{file.stem}-setpoints.toml")
    write_new(file, stage_text(RIGS[like], file))
    try:
        write_new(scenario, scenario_text(read_own(file), scenario, file.name, more=False))
    except RigError:
        file.unlink()
        raise
    return file, scenario


def new_scenario(path: str | Path, stage: str | Path = EXAMPLE) -> Path:
    """Write a scenario that flies, to begin with; nothing is overwritten.

    Parameters
    ----------
    path : path
        The file, NAME or NAME.toml; the run in it is named after it.
    stage : str or path
        Name of a rig, or the description of a stage of yours, NAME.toml.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    RigError
        If the file is there already, or its name or the stage is no such thing.

    Examples
    --------
    >>> import maglev
    >>> maglev.new_scenario("hold.toml", stage="2dof").name
    'hold.toml'
    """
    rig = rig_named(str(stage))
    file = toml_file(path)
    own = seen_from(file, stage) if rig.name in OWN else None
    write_new(file, scenario_text(rig, file, own, more=True))
    return file


def toml_file(path: str | Path) -> Path:
    """File NAME.toml by its path or by NAME; RigError of a name after which no run can be named."""
    file = file_named(path, ".toml")
    if not file.stem.replace("-", "_").replace(".", "_").isidentifier() or not file.stem.isascii():
        raise RigError(f"{file}: expected a name of letters, digits and - _ ., a letter first: results have it")
    return file


def seen_from(file: Path, other: str | Path) -> str:
    """A file as one beside it, or elsewhere, names it."""
    there = Path(other).absolute()
    return there.name if there.parent == file.absolute().parent else str(there)


def file_named(path: str | Path, suffix: str) -> Path:
    """A new file by its path, with its suffix or without."""
    return Path(path) if Path(path).suffix == suffix else Path(f"{path}{suffix}")


def write_new(file: Path, text: str, error: type[MaglevError] = RigError) -> None:
    """Write a new file; an error if it is there already, or has no folder."""
    if not file.parent.is_dir():
        raise error(f"{file}: there is no folder {file.parent}, expected one")
    try:
        with file.open("x", encoding="utf-8", newline="\n") as written:
            written.write(text)
    except FileExistsError:
        raise error(f"{file}: it is there already, expected the name of a new file") from None


def stage_text(rig: Rig, file: Path) -> str:
    """Text of a description that begins as a rig is; a first motor's numbers are those of all."""
    motor, first, vertical, stage = rig.motor(), rig.horizontal[0], rig.vertical, rig.stage
    f1, f2, f3, f4 = gap_functions(motor, vertical.start)
    gaps = [motor.field.lower + k * (motor.field.upper - motor.field.lower) / 8.0 for k in range(9)]
    return render(
        "new/stage.toml.j2", rig, file=file.name, name=file.stem, suffix=file.stem[:1].upper() + file.stem[1:],
        sharing=f"{rig.sharing:g}", geometry=motor, force=f"{stage.thrust[first.name] * first.mass * f1:.4g}",
        magnets=f"{stage.attraction * vertical.mass * f2:.4g}", direct=f"{stage.coils * vertical.mass * f3:.4g}",
        windings=f"{stage.iron * vertical.mass * f4:.4g}", gaps=[round(gap, 6) for gap in gaps],
        field=[float(f"{motor.field.value(gap):.5g}") for gap in gaps])


def scenario_text(rig: Rig, scenario: Path, own: str | None, more: bool, controller: str = "") -> str:
    """Text of a scenario of set-points that lie well between the stops.

    `own` is the description of a stage of the user's; with `more` it has claims, and comments on what else there is, or
    in place of these the file of a `controller` and what a baseline keeps.
    """
    setpoints = {}
    for axis, shares in zip(rig.axes, SHARES, strict=False):
        stop, start = axis.stop or rig.gap_stop, rig.vertical.start if axis.rotation else axis.start
        way = min(start - stop.lower, stop.upper - start) / (rig.arm if axis.rotation else 1.0)
        setpoints[axis.name] = [round(1e3 * (axis.start + share * way), 1) for share in shares]
    return render("new/scenario.toml.j2", rig, own=own, name=scenario.stem, scenario=scenario.name, setpoints=setpoints,
                  more=more, controller=controller)


def study_text(rig: Rig, file: Path, scenario: str) -> str:
    """Text of a study of a scenario: mass and friction."""
    return render("new/study.toml.j2", rig, file=file.name, name=file.stem, scenario=scenario)
