"""A stage to begin with: a commented description, and a scenario of set-points beside it."""

from pathlib import Path

from maglev.errors import RigError, nearest
from maglev.own_stage.reading import read_own
from maglev.own_stage.template import stage_text
from pmlsm.rig import Rig
from pmlsm.rigs import DESCRIBED, EXAMPLE

# Set-points of the scenario, as shares of the way from the start to the nearer stop, for every axis in turn; of a tilt
# that of the outermost motor.
SHARES = ((0.0, 0.2, -0.2, 0.1), (0.0, 0.08, -0.08, 0.12), (0.0, -0.08, 0.08, -0.12), (0.0, 0.1, -0.1, 0.05),
          (0.0, -0.1, 0.05, 0.1))
TIMES = (0, 1, 6, 11)   # s

SCENARIO = '''# Set-points of the {title} of {file}: its loop and FMUs follow from the description.
#
#     maglev build --rig {file}
#     maglev run {scenario} --plot

rig = "{file}"

name = "{name}-setpoints"
title = "{title}: a sequence of set-points"
stop_time = "16 s"
{signals}'''

SIGNAL = '''
[[signals]]
to = "controller.{axis}.reference"
kind = "steps"
unit = "{unit}"
times = {times}
values = {values}
'''


def new_stage(path: str | Path, like: str = EXAMPLE) -> tuple[Path, Path]:
    """Write the description of a stage, and a scenario that flies it, to begin with; nothing is overwritten.

    Parameters
    ----------
    path : path
        The file, NAME.toml; the FMUs of the stage are named after it.
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
    file = Path(path)
    if like not in DESCRIBED:
        raise RigError(f"--like {like}: expected one of {', '.join(DESCRIBED)}; nearest is {nearest(like, DESCRIBED)}")
    if file.suffix != ".toml":
        raise RigError(f"{file}: expected a name that ends in .toml, such as {file.stem or 'mine'}.toml")
    scenario = file.with_name(f"{file.stem}-setpoints.toml")
    for each in (file, scenario):
        if each.exists():
            raise RigError(f"{each}: it is there already, expected the name of a new file")
    if not file.parent.is_dir():
        raise RigError(f"{file}: there is no folder {file.parent}, expected one")
    file.write_text(stage_text(DESCRIBED[like], file), encoding="utf-8")
    try:
        rig = read_own(file)
    except RigError:
        file.unlink()
        raise
    scenario.write_text(scenario_text(rig, file, scenario), encoding="utf-8")
    return file, scenario


def scenario_text(rig: Rig, file: Path, scenario: Path) -> str:
    """Text of a scenario of set-points that lie well between the stops."""
    signals = []
    for axis, shares in zip(rig.axes, SHARES, strict=False):
        stop, start = axis.stop or rig.gap_stop, rig.vertical.start if axis.rotation else axis.start
        way = min(start - stop.lower, stop.upper - start) / (rig.arm if axis.rotation else 1.0)
        values = [round(1e3 * (axis.start + share * way), 1) for share in shares]
        signals.append(SIGNAL.format(axis=axis.name, times=list(TIMES), values=values,
                                     unit="mrad" if axis.rotation else "mm"))
    return SCENARIO.format(title=rig.title, file=file.name, scenario=scenario.name, name=rig.name,
                           signals="".join(signals))
