"""Controllers and estimators whose axes, motors and constants are called as their description calls them."""

from collections.abc import Sequence
from copy import deepcopy
from typing import Any

from controller_fmu.adaptive_regulator import AdaptiveRegulator
from controller_fmu.commutation import Commutation
from controller_fmu.estimator import Estimator
from controller_fmu.gain_point import GainPoint
from controller_fmu.motor_command import MotorCommand
from controller_fmu.pid import PID
from controller_fmu.places import constant_place
from controller_fmu.regulator import Regulator
from controller_fmu.status import NONLINEAR
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.fmi.definition import read, write
from pmlsm.stage_description import StageAxis, StageDescription


class Named:
    """A block with attributes such as y, alpha, alpha_place, C1, geometry and table.

    Its parts are those of `axes` and `motors`, by the names that a description has for them.
    """

    def __init__(self, block: Any, stage: StageDescription, names: Sequence[StageAxis], axes: Sequence[Any]):
        parts = {axis.name: part for axis, part in zip(names, axes, strict=True)}
        parts.update(zip(stage.motor_names, block.motors, strict=True))
        parts.update(zip((f"{motor}_place" for motor in stage.motor_names), block.platform.places, strict=False))
        self.__dict__.update(block=block, stage=stage, parts=parts)

    def place(self, name: str) -> str:
        """Path in the block of an attribute."""
        if constant := constant_place(self.stage, name):
            return constant
        return next((f"{owner}.{name}" for owner in ("currents", "currents.gains", "holding", "model", "platform")
                     if not hasattr(self.block, name) and holds(self.block, owner, name)), name)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("__"):
            raise AttributeError(name)
        if name in self.parts:
            return self.parts[name]
        if name == "geometry":
            layout = getattr(self.block, "layout", None) or self.block.model.layout
            return layout.kinds[0].geometry
        return read(self.block, self.place(name))

    def __setattr__(self, name: str, value: Any) -> None:
        write(self.block, self.place(name), value)


def holds(block: Any, owner: str, name: str) -> bool:
    """Whether a part of a block has an attribute."""
    try:
        return hasattr(read(block, owner), name)
    except AttributeError:
        return False


class Controller(Named):
    """A block with all axes."""

    def __init__(self, block: Any, stage: StageDescription):
        super().__init__(block, stage, (stage.vertical, *stage.horizontal, *stage.rotations), block.axes)

    def currents(self, *demands: float) -> tuple[float, ...]:
        """i_d, and i_q of each horizontal axis, of a level stage without limit by a regulator for demands (m/s²)."""
        block = self.block
        axes = deepcopy(block.axes)
        for axis, demand in zip(axes, demands, strict=True):
            axis.demand = lambda demand=demand: demand
        commands = [MotorCommand() for _ in block.motors]
        self.feasible = block.currents.command(axes, commands, block.model, block.platform, 0.0)
        drives = block.model.layout.drives
        return commands[0].i_d_cmd, *(commands[drives.index(k)].i_q_cmd for k in range(len(self.stage.horizontal)))

    @property
    def here(self) -> GainPoint:
        """What an interpolated law has at the measured gap."""
        vertical, point = self.block.currents.vertical, GainPoint()
        point.current, point.gain, point.f1 = vertical.forward, vertical.linear.gain, vertical.linear.f1
        return point


class Rows(Named):
    """An estimator, whose axes are rows."""

    def __init__(self, block: Any, stage: StageDescription):
        super().__init__(block, stage, (stage.vertical, *stage.horizontal), [block.vertical, *block.horizontal])


class Adaptive:
    """An `AdaptiveRegulator` whose parts are named."""

    def __init__(self, stage: StageDescription, block: AdaptiveRegulator | None = None):
        self.block = block or AdaptiveRegulator(stage)
        self.regulator: Any = Controller(self.block.regulator, stage)
        self.estimator: Any = Rows(self.block.estimator, stage)
        self.adaptation = self.block.adaptation

    def __getattr__(self, name: str) -> Any:
        return getattr(self.block, name)


class Regulator2DOF(Controller):
    def __init__(self, law: int = NONLINEAR):
        super().__init__(Regulator(PACKAGED_STAGES["2dof"], law), PACKAGED_STAGES["2dof"])


class PID2DOF(Controller):
    def __init__(self) -> None:
        super().__init__(PID(PACKAGED_STAGES["2dof"]), PACKAGED_STAGES["2dof"])


class Commutation2DOF(Named):
    def __init__(self) -> None:
        block, stage = Commutation(PACKAGED_STAGES["2dof"]), PACKAGED_STAGES["2dof"]
        super().__init__(block, stage, stage.horizontal, block.axes)


class Estimator2DOF(Rows):
    def __init__(self) -> None:
        super().__init__(Estimator(PACKAGED_STAGES["2dof"]), PACKAGED_STAGES["2dof"])


class AdaptiveRegulator2DOF(Adaptive):
    def __init__(self) -> None:
        super().__init__(PACKAGED_STAGES["2dof"])


class Regulator3DOF(Controller):
    def __init__(self, law: int = NONLINEAR):
        super().__init__(Regulator(PACKAGED_STAGES["3dof"], law), PACKAGED_STAGES["3dof"])


class PID3DOF(Controller):
    def __init__(self) -> None:
        super().__init__(PID(PACKAGED_STAGES["3dof"]), PACKAGED_STAGES["3dof"])


class Commutation3DOF(Named):
    def __init__(self) -> None:
        block, stage = Commutation(PACKAGED_STAGES["3dof"]), PACKAGED_STAGES["3dof"]
        super().__init__(block, stage, stage.horizontal, block.axes)


class Estimator3DOF(Rows):
    def __init__(self) -> None:
        super().__init__(Estimator(PACKAGED_STAGES["3dof"]), PACKAGED_STAGES["3dof"])


class AdaptiveRegulator3DOF(Adaptive):
    def __init__(self) -> None:
        super().__init__(PACKAGED_STAGES["3dof"])


class Regulator5DOF(Controller):
    def __init__(self, law: int = NONLINEAR):
        super().__init__(Regulator(PACKAGED_STAGES["5dof"], law), PACKAGED_STAGES["5dof"])


class PID5DOF(Controller):
    def __init__(self) -> None:
        super().__init__(PID(PACKAGED_STAGES["5dof"]), PACKAGED_STAGES["5dof"])


class Commutation5DOF(Named):
    def __init__(self) -> None:
        block, stage = Commutation(PACKAGED_STAGES["5dof"]), PACKAGED_STAGES["5dof"]
        super().__init__(block, stage, stage.horizontal, block.axes)


class Estimator5DOF(Rows):
    def __init__(self) -> None:
        super().__init__(Estimator(PACKAGED_STAGES["5dof"]), PACKAGED_STAGES["5dof"])


class AdaptiveRegulator5DOF(Adaptive):
    def __init__(self) -> None:
        super().__init__(PACKAGED_STAGES["5dof"])
