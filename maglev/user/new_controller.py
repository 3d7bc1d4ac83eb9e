"""A controller or a plant to begin with, as a file."""

from pathlib import Path

from maglev.descriptions import EXAMPLE
from maglev.descriptions.writer import written_class
from maglev.files.errors import ControllerError, StageError, option
from maglev.user.adoption import stage_named
from maglev.user.new_stage import file_named, write_new

LONGEST_SHORT_NAME = 4   # letters, of names such as lqi and mpc, whose classes are LQI and MPC


def new_controller(path: str | Path, stage: str = EXAMPLE) -> Path:
    """Write a controller that works, to begin with; nothing is overwritten.

    Parameters
    ----------
    path : path
        The file, NAME or NAME.py; the class in it is named after it.
    stage : str
        Name of a stage, or the description of your own, NAME.toml.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    ControllerError
        If the file exists already, or its name or the stage is not valid.

    Examples
    --------
    >>> import maglev
    >>> maglev.new_controller("my_regulator.py", stage="2dof").name
    'my_regulator.py'
    """
    return new_class("controller", path, stage)


def new_plant(path: str | Path, stage: str = EXAMPLE) -> Path:
    """Write a plant that works, an ideal levitated mass with the ports of a stage; nothing is overwritten.

    Parameters, file and errors are those of `new_controller`.

    Examples
    --------
    >>> import maglev
    >>> file = maglev.new_plant("mover.py", stage="2dof")
    >>> run = maglev.run("2dof-setpoints", plant=file, set={"plant.v.mass": "4.5 kg"})
    >>> bool(run["plant.at_stop"].any())
    False
    """
    return new_class("plant", path, stage)


def new_class(kind: str, path: str | Path, stage: str) -> Path:
    """Write a "controller" or a "plant"."""
    file = file_named(path, ".py")
    try:
        description = stage_named(stage)
    except StageError as error:
        raise ControllerError(f"{option('stage', str(stage))}: {error}") from None
    # LQI in lqi.py, MyRegulator in my_regulator.py
    name = file.stem.upper() if len(file.stem) <= LONGEST_SHORT_NAME and file.stem.isalpha() else "".join(
        part[:1].upper() + part[1:] for part in file.stem.replace("-", "_").split("_"))
    if not (name.isidentifier() and name.isascii()):
        raise ControllerError(f"{file}: expected a name of ASCII letters, digits and underscores, a letter first: the "
                              "class in it is named after it")
    text = written_class(kind, description, name, file.name)
    text = text.replace(f"{description.name}-setpoints", f"{description.name}-setpoints{Path(stage).suffix}")
    write_new(file, text, ControllerError)
    return file
