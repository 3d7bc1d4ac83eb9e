"""The rigs of this project, by their names in the names of experiments."""

from collections.abc import Collection, Iterable

from pmlsm.rig import Rig
from pmlsm.rig_2dof import RIG as RIG_2DOF
from pmlsm.rig_3dof import RIG as RIG_3DOF
from pmlsm.rig_5dof import RIG as RIG_5DOF

RIGS = {rig.name: rig for rig in (RIG_2DOF, RIG_3DOF, RIG_5DOF)}
EXAMPLE = RIG_3DOF.name   # of what is written for any rig, if none is named
SINGLE = RIG_2DOF.name    # of one motor: what a stage with a motor of a user's begins with


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
