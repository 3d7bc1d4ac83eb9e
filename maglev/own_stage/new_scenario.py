"""A scenario to begin with, as a file."""

from pathlib import Path

from maglev.errors import MaglevError, RigError
from maglev.own_stage.adoption import OWN, rig_named
from maglev.own_stage.template import scenario_text
from pmlsm.rigs import EXAMPLE


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
    >>> maglev.new_scenario("mine.toml", stage="2dof").name
    'mine.toml'
    """
    rig = rig_named(str(stage))
    file, own = toml_file(path), None
    if rig.name in OWN:
        description = Path(stage).absolute()
        own = description.name if description.parent == file.absolute().parent else str(description)
    write_new(file, scenario_text(rig, file, own, more=True))
    return file


def toml_file(path: str | Path) -> Path:
    """File NAME.toml by its path or by NAME; RigError of a name after which no run can be named."""
    file = file_named(path, ".toml")
    if not file.stem.replace("-", "_").replace(".", "_").isidentifier() or not file.stem.isascii():
        raise RigError(f"{file}: expected a name of letters, digits and - _ ., a letter first: results have it")
    return file


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
