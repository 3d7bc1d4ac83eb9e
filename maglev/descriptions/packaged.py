"""The rigs of this project, by their names in the names of experiments."""

from collections.abc import Collection, Iterable

from maglev.descriptions.description_file import PACKAGED, Reader
from maglev.files.toml_file import read_toml
from pmlsm.stage_description import Rig

# That they fit together is for a test to check, not for every start of a command.
RIGS: dict[str, Rig] = {path.stem: Reader(path).read(Rig, read_toml(path), "")
                        for path in sorted(PACKAGED.glob("*.toml"))}
SINGLE = next(name for name, rig in RIGS.items() if len(rig.motors) == 1)   # what one with a user's motor begins with
EXAMPLE = next(name for name, rig in RIGS.items() if len(rig.motors) > 1)   # of what is for any rig, if none is named


def best_rig(models: Iterable[str], axes: Collection[str]) -> Rig | None:
    """Rig of FMUs by their names, or otherwise the one that has most of the axes, air gap included; None if none.

    Of FMUs of several rigs, such as a controller that knows of no tilt on a plant that tilts, it is the one with most
    of the axes: the plant's.
    """
    models = tuple(models)
    rigs = [rig for rig in RIGS.values() if any(model.endswith(rig.suffix) for model in models)]
    if rigs:
        return max(rigs, key=lambda rig: (len({*rig.axis_names} & {*axes}), len(rig.suffix)))
    rigs = [rig for rig in RIGS.values() if rig.vertical.name in axes]
    return max(rigs, key=lambda rig: (len({*rig.axis_names} & {*axes}), -len(rig.axes)), default=None)
