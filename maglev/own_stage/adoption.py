"""A stage of the user's in this process: modules are written from its description and imported as ours are."""

import importlib
import re
import sys
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

from maglev.copies import copied
from maglev.errors import RigError, nearest
from maglev.linear import parameters
from maglev.own_stage.reading import read_own
from maglev.rig.modules import MODULES, PAGES, written
from pmlsm.rig import Rig
from pmlsm.rigs import RIGS


class OwnStage(NamedTuple):
    """A stage of the user's: its description, the folder with the modules that are written from it, and its file."""

    rig: Rig
    folder: Path
    file: Path


OWN: dict[str, OwnStage] = {}   # those that this process knows, by name


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
    known = OWN.get(rig.name)
    if known is None or known.rig != rig:
        require_free_name(file, rig.name)
        forget(rig.name)
        texts = {place: text.encode("utf-8") for place, text in written(rig).items()}
        folder = copied(texts, file.absolute().parent)
        for package in packages():
            importlib.import_module(package).__path__.append(str(folder / package))
        importlib.invalidate_caches()
        OWN[rig.name] = OwnStage(rig, folder, file)
        parameters.know(rig)
    return rig


def rig_named(rig: str) -> Rig:
    """A rig by its name, or a stage of the user's by the file of its description, NAME.toml.

    RigError if there is no such rig, or as of `know_stage`.
    """
    if rig.endswith(".toml"):
        return know_stage(rig)
    known = {**RIGS, **{name: own.rig for name, own in OWN.items()}}
    if rig not in known:
        raise RigError(f"rig = {rig!r}, expected one of {', '.join(known)}, or a description NAME.toml; nearest is "
                       f"{nearest(rig, known)}")
    return known[rig]


def forget(name: str) -> None:
    """Take back what was imported of a stage."""
    known = OWN.pop(name, None)
    if known is not None:
        parameters.forget(known.rig)
        for package in packages():
            importlib.import_module(package).__path__.remove(str(known.folder / package))
        for module in modules(name):
            sys.modules.pop(module, None)


def packages() -> set[str]:
    """Packages that have modules of a rig."""
    return {path.partition("/")[0] for path in MODULES + PAGES}


def modules(name: str) -> list[str]:
    return [path.format(name).removesuffix(".py").replace("/", ".") for path in MODULES]


def require_free_name(file: Path, name: str) -> None:
    """Refuse a name whose modules or FMUs are others."""
    if not re.fullmatch("[a-z][a-z0-9]*", name):
        raise RigError(f"{file}: name: {name!r}, expected small letters and digits, a letter first: the FMUs are named "
                       "after it")
    if name in RIGS or (name not in OWN and any(find_spec(module) is not None for module in modules(name))):
        raise RigError(f"{file}: name: {name!r}, expected another one: modules of this project are called so")
