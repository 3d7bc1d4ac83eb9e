"""A stage of the user's in this process: its FMUs are built from its description, as ours are."""

import re
from pathlib import Path

from maglev.descriptions.packaged import RIGS
from maglev.descriptions.registry import STAGES, OwnStage
from maglev.descriptions.writer import module_texts
from maglev.files.copies import copied
from maglev.files.errors import RigError, one_of
from maglev.user.reading import read_own
from pmlsm.stage_description import Rig


def know_stage(path: str | Path) -> Rig:
    """Read the description of a stage, and let its FMUs be built, recognised and linearised in this process.

    Parameters
    ----------
    path : path
        The description, NAME.toml.

    Returns
    -------
    Rig
        What it describes.

    Raises
    ------
    RigError, ScenarioError
        If the file is no description, or has the name of something else.

    Examples
    --------
    >>> import maglev
    >>> description, _ = maglev.new_stage("mine.toml")
    >>> maglev.know_stage(description).axis_names
    ('y', 'x', 'z')
    >>> round(float(maglev.linearise("PlantMine", {"y": "25 mm"}, amplifier=False).poles.real.max()))
    39
    """
    file = Path(path)
    rig = read_own(file)
    known = STAGES.own.get(rig.name)
    if known is None or known.rig != rig:
        require_free_name(file, rig.name)
        texts = {place: text.encode("utf-8") for place, text in module_texts(rig).items()}
        STAGES.add(OwnStage(rig, copied(texts, file.absolute().parent), file))
    return rig


def rig_named(rig: str | Path) -> Rig:
    """A rig by its name, or a stage of the user's by the file of its description, NAME.toml.

    RigError if there is no such rig, or as of `know_stage`.
    """
    if str(rig).endswith(".toml"):
        return know_stage(rig)
    known = STAGES.rigs
    if rig not in known:
        raise RigError(f"stage = {rig!r}, expected "
                       f"{one_of(rig, known, 'or a description NAME.toml', '.toml')}")
    return known[str(rig)]


def require_free_name(file: Path, name: str) -> None:
    """Refuse a name whose FMUs are others."""
    if not re.fullmatch("[a-z][a-z0-9]*", name):
        raise RigError(f"{file}: name: {name!r}, expected small letters and digits, a letter first: the FMUs are named "
                       "after it")
    if name in RIGS:
        raise RigError(f"{file}: name: {name!r}, expected another one: a stage of this project is called so")
