"""A stage whose axes, motors and constants are called as its description calls them."""

from typing import Any

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.fmi.definition import slot
from plant_fmu.places import MAGNETICS, constant_place
from plant_fmu.stage import Stage
from pmlsm.stage_description import StageDescription


class NamedStage:
    """A `Stage` with attributes such as y, alpha, alpha_mount, roll_guide, C1 and payload."""

    def __init__(self, description: StageDescription, block: Stage | None = None):
        self.__dict__.update(stage=description, block=block or Stage(description), parts={})
        stage = self.block
        self.parts.update({name: stage.axes[description.axis_number(name)] for name in description.axis_names})
        self.parts.update(zip(description.motor_names, stage.motors, strict=True))
        if description.rotations:
            self.parts.update(zip((f"{name}_mount" for name in description.motor_names), stage.mover.mounts,
                                  strict=True))
            self.parts.update(zip((f"{tilt.name}_guide" for tilt in description.rotations), stage.mover.guides,
                                  strict=True))

    def slot(self, name: str) -> tuple[Any, str | int]:
        """Object or list that has an attribute of the stage, and what it calls it."""
        place = constant_place(self.stage, name) or (f"magnetics.{MAGNETICS[name]}" if name in MAGNETICS else name)
        owner, key = slot(self.block, place)
        return (self.block.mover, key) if isinstance(key, str) and not hasattr(owner, key) else (owner, key)

    def __getattr__(self, name: str) -> Any:
        if name in self.parts:
            return self.parts[name]
        owner, key = self.slot(name)
        return owner[key] if isinstance(key, int) else getattr(owner, key)

    def __setattr__(self, name: str, value: Any) -> None:
        owner, key = self.slot(name)
        if isinstance(key, int):
            owner[key] = value
        else:
            setattr(owner, key, value)


class Stage2DOF(NamedStage):
    """The 2-DOF stage."""

    def __init__(self) -> None:
        super().__init__(PACKAGED_STAGES["2dof"])


class Stage3DOF(NamedStage):
    """The 3-DOF stage."""

    def __init__(self) -> None:
        super().__init__(PACKAGED_STAGES["3dof"])


class Stage5DOF(NamedStage):
    """The 5-DOF stage."""

    def __init__(self) -> None:
        super().__init__(PACKAGED_STAGES["5dof"])
