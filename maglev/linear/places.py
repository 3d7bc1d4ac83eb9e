"""Positions of the motors of a stage: from positions of axes to gaps and displacements, and from forces to axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from maglev.files.arrays import Array
from pmlsm.stage_description import StageDescription


@dataclass(frozen=True, eq=False)
class MotorPlaces:
    """Matrices of the motors' places, with n axes and m motors."""

    gaps: Array    # J, (m, n): derivatives of the motors' air gaps with respect to the positions
    along: Array   # J, (m, n): derivatives of their displacements
    # (m, n), of the displacement along which the slots modulate the attraction: where no platform tilts, of the first
    # horizontal axis; otherwise of the motor's own.
    slots: Array
    # (n, 2 m): accelerations of the axes, at the masses of the description, by those that motors give the vertical
    # axis and the one that they drive, motor by motor.
    effects: Array
    # (2 m, n): currents, or forces, that are spread evenly: a common value, two slopes over the platform, and one value
    # for the motors of each horizontal axis.
    even: Array

    @classmethod
    def of(cls, stage: StageDescription, block: Any = None) -> "MotorPlaces":
        """Places of the motors of a plant or controller of a stage; without one, of the stage's description."""
        if block is None or not stage.rotations:
            return cls.at(stage, stage.motors, stage.height)
        if hasattr(block, "mover"):
            return cls.at(stage, block.mover.mounts, block.mover.height)
        return cls.at(stage, block.platform.places, block.platform.height)

    def measuring(self, stage: StageDescription) -> Array:
        """Positions of the axes by the encoders, where a platform tilts by least squares of the gaps at the motors."""
        if not stage.rotations:
            return np.eye(len(stage.axes))
        straight = np.eye(len(stage.axes))[:, [stage.axes.index(axis) for axis in stage.measured]]
        return np.hstack([straight, np.linalg.pinv(self.gaps)])

    @classmethod
    def at(cls, stage: StageDescription, spots: Sequence[Any], height: float) -> "MotorPlaces":
        """Places of motors that are at x and z (m) of a platform."""
        motors, axes = np.arange(len(stage.motors)), len(stage.axes)
        gaps, along, slots = np.zeros((3, len(motors), axes))
        gaps[:, 0] = along[motors, list(stage.driven)] = slots[:, 1] = 1.0
        if stage.rotations:
            roll, *others = (stage.axis_names.index(tilt.name) for tilt in stage.rotations)
            gaps[:, roll] = [-spot.z for spot in spots]
            for pitch in others:   # guides hold it where there is one horizontal axis
                gaps[:, pitch] = [spot.x for spot in spots]
                along[:,
                      pitch] = [-height if motor.drives == stage.horizontal[0].name else 0.0 for motor in stage.motors]
                along[:, roll] = [height if motor.drives == stage.horizontal[1].name else 0.0 for motor in stage.motors]
            slots = along
        mass = np.array([axis.mass for axis in stage.axes])
        effects, even = np.zeros((axes, 2 * len(motors))), np.zeros((2 * len(motors), axes))
        effects[:, 0::2] = gaps.T * mass[0] / mass[:, None]
        effects[:, 1::2] = along.T * mass[list(stage.driven)] / mass[:, None]
        even[0::2], even[2 * motors + 1, list(stage.driven)] = gaps, 1.0
        return cls(gaps, along, slots, effects, even)
