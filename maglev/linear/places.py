"""Where the motors of a rig are: how positions make gaps and displacements, and how their forces move the axes."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from maglev.files.arrays import Array
from pmlsm.stage_description import Rig


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
    # (2 m, n): currents, or forces, that are spread evenly: one value that all motors have in common, two slopes over
    # the platform, and one for the motors of each horizontal axis.
    even: Array

    @classmethod
    def of(cls, rig: Rig, block: Any = None) -> "MotorPlaces":
        """Places of the motors of a plant or controller of a rig; without one, of the rig's description."""
        if block is None or not rig.rotations:
            return cls.at(rig, rig.motors, rig.height)
        if hasattr(block, "mover"):
            return cls.at(rig, block.mover.mounts, block.mover.height)
        return cls.at(rig, block.platform.places, block.platform.height)

    def measuring(self, rig: Rig) -> Array:
        """Positions of the axes by the encoders, where a platform tilts by least squares of the gaps at the motors."""
        if not rig.rotations:
            return np.eye(len(rig.axes))
        straight = np.eye(len(rig.axes))[:, [rig.axes.index(axis) for axis in rig.measured]]
        return np.hstack([straight, np.linalg.pinv(self.gaps)])

    @classmethod
    def at(cls, rig: Rig, spots: Sequence[Any], height: float) -> "MotorPlaces":
        """Places of motors that are at x and z (m) of a platform."""
        motors, axes = np.arange(len(rig.motors)), len(rig.axes)
        gaps, along, slots = np.zeros((3, len(motors), axes))
        gaps[:, 0] = along[motors, list(rig.driven)] = slots[:, 1] = 1.0
        if rig.rotations:
            roll, *others = (rig.axis_names.index(tilt.name) for tilt in rig.rotations)
            gaps[:, roll] = [-spot.z for spot in spots]
            for pitch in others:   # guides hold it where there is one horizontal axis
                gaps[:, pitch] = [spot.x for spot in spots]
                along[:, pitch] = [-height if motor.drives == rig.horizontal[0].name else 0.0 for motor in rig.motors]
                along[:, roll] = [height if motor.drives == rig.horizontal[1].name else 0.0 for motor in rig.motors]
            slots = along
        mass = np.array([axis.mass for axis in rig.axes])
        effects, even = np.zeros((axes, 2 * len(motors))), np.zeros((2 * len(motors), axes))
        effects[:, 0::2] = gaps.T * mass[0] / mass[:, None]
        effects[:, 1::2] = along.T * mass[list(rig.driven)] / mass[:, None]
        even[0::2], even[2 * motors + 1, list(rig.driven)] = gaps, 1.0
        return cls(gaps, along, slots, effects, even)
