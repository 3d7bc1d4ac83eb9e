"""A stage to begin with: a commented description, and a scenario of set-points beside it."""

from pathlib import Path

from maglev.errors import RigError, nearest
from maglev.own_stage.new_scenario import file_named, write_new
from maglev.own_stage.reading import read_own
from maglev.own_stage.template import scenario_text, stage_text
from pmlsm.rigs import EXAMPLE, RIGS


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
        raise RigError(f"--like {like}: expected one of {', '.join(RIGS)}; nearest is {nearest(like, RIGS)}")
    scenario = file.with_name(f"{file.stem}-setpoints.toml")
    write_new(file, stage_text(RIGS[like], file))
    try:
        write_new(scenario, scenario_text(read_own(file), scenario, file.name, more=False))
    except RigError:
        file.unlink()
        raise
    return file, scenario
