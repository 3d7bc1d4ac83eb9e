"""A user's stage in this process: its FMUs are built from its description, as ours are."""

import re
from pathlib import Path

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.registry import OwnStage, known_stages
from maglev.descriptions.writer import page_texts
from maglev.files.copies import copied
from maglev.files.errors import StageError, one_of
from maglev.user.reading import read_own
from pmlsm.stage_description import StageDescription


def know_stage(path: str | Path) -> StageDescription:
    """Read the description of a stage, and let its FMUs be built, recognised and linearised in this process.

    Parameters
    ----------
    path : path
        The description, NAME.toml.

    Returns
    -------
    Stage
        What it describes.

    Raises
    ------
    StageError, ScenarioError
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
    stage = read_own(file)
    known = known_stages().own.get(stage.name)
    if known is None or known.description != stage:
        require_free_name(file, stage.name)
        texts = {place: text.encode("utf-8") for place, text in page_texts(stage).items()}
        known_stages().add(OwnStage(stage, copied(texts, file.absolute().parent), file))
    return stage


def stage_named(stage: str | Path) -> StageDescription:
    """A stage by its name, or a user's stage by the file of its description, NAME.toml.

    StageError if there is no such stage, or as in `know_stage`.
    """
    if str(stage).endswith(".toml"):
        return know_stage(stage)
    known = known_stages().stages
    if stage not in known:
        raise StageError(f"stage = {stage!r}, expected "
                       f"{one_of(stage, known, 'or a description NAME.toml', '.toml')}")
    return known[str(stage)]


def require_free_name(file: Path, name: str) -> None:
    """Raise if other FMUs have this name."""
    if not re.fullmatch("[a-z][a-z0-9]*", name):
        raise StageError(f"{file}: name: {name!r}, expected lower-case letters and digits, a letter first: the FMUs "
                         "are named after it")
    if name in PACKAGED_STAGES:
        raise StageError(f"{file}: name: {name!r}, expected another name: a stage of this project has it")
