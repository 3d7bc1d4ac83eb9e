"""The sampled loop of controller and stage blocks, called directly."""

from collections.abc import Callable
from typing import Any

import numpy as np

from maglev.descriptions.packaged import PACKAGED_STAGES

STAGE_2DOF = PACKAGED_STAGES["2dof"]
STAGE_3DOF = PACKAGED_STAGES["3dof"]


# Axes, motors and communication step (s).
LAYOUTS = {len(stage.axes): (stage.axis_names, stage.motor_names, stage.sample_time)
           for stage in (STAGE_2DOF, STAGE_3DOF)}

Reference = Callable[[float], tuple[float, float]]   # time (s) to reference (m) and its rate (m/s)


def simulate(description: int, controller: Any, stage: Any, references: dict[str, Reference],
             stop_time: float) -> np.ndarray:
    """Errors position − reference (m) at every sample, shape (samples, axes)."""
    axes, motors, dt = LAYOUTS[description]
    assert controller.start() == 0
    assert stage.start() == 0
    errors = []
    for k in range(round(stop_time / dt)):
        row = []
        for name in axes:
            axis = getattr(controller, name)
            if name in references:
                axis.reference, axis.reference_rate = references[name](k * dt)
            axis.measured = getattr(stage, name).encoder
            row.append(getattr(stage, name).position - axis.reference)
        errors.append(row)
        assert controller.step(k * dt, dt) == 0
        for name in motors:
            to, source = getattr(stage, name), getattr(controller, name)
            to.i_a_cmd, to.i_b_cmd, to.i_c_cmd = source.i_a_cmd, source.i_b_cmd, source.i_c_cmd
        assert stage.step(k * dt, dt) == 0
    return np.array(errors)


def idealise(description: int, stage: Any, controller: Any) -> None:
    """Switch every effect of a stage off, and give it the controller's constants."""
    axes, motors, _ = LAYOUTS[description]
    for name in ("C1", "C2", "C3", "C4", "C5")[:4 if description == 2 else 5]:
        setattr(stage, name, getattr(controller, name))
    stage.attraction_modulation = stage.encoder.resolution = 0.0
    for name in axes:
        axis = getattr(stage, name)
        axis.bias = axis.friction.coulomb = axis.friction.viscous = axis.ripple.amplitude = 0.0
        axis.stop.stiffness = axis.stop.damping = 0.0
    for name in motors:
        amplifier = getattr(stage, name).amplifier
        amplifier.lag = amplifier.continuous = 0.0
        amplifier.peak = 1000.0   # the largest command
