"""Linear model of the measurement between encoders and controller: a delay, and the slope of the periodic error."""

from dataclasses import replace
from math import cos, pi
from typing import Any

import numpy as np

from controller_fmu.measurement_variables import encoders
from controller_fmu.sampling_instant import SLOTS
from maglev.files.errors import LinearModelError
from maglev.linear.model import Equilibrium, LinearModel
from maglev.linear.parameters import prepare_fixed
from maglev.linear.places import MotorPlaces
from pmlsm.stage_description import StageDescription


def linear_measurement(name: str, stage: StageDescription, block: Any, at: Equilibrium) -> LinearModel:
    """Linearise a measurement: exact, with the samples that a delay needs as its states, from each encoder on.

    Measured is (1 − f) q[k − n] + f q[k − n − 1], times the slope of q + A sin(2π q/p), for a delay of n + f samples.
    Offset, drift and noise are added to it. LinearModelError if it is not linear: jitter, lost samples, a frozen one.
    """
    prepare_fixed(name, block)
    parts = list(encoders(stage))
    faults = {"jitter": block.instant.jitter}
    for (owner, _, _), encoder in zip(parts, block.encoders, strict=True):
        faults |= {f"{owner}.lost": encoder.lost, f"{owner}.frozen": encoder.frozen}
    for fault, value in faults.items():
        if value:
            raise LinearModelError(f"{name}: {fault} = {value}, expected 0: noise and faults have no linear model")
    instant, whole = block.instant, 0
    if instant.late:
        instant.advance(0, 0, block.sample_time)
        whole = (instant.newest - instant.slot) % SLOTS
    kept, many = whole + (instant.fraction > 0.0), len(parts)
    positions = [*(at.positions[axis.name] for axis in stage.measured),
                 *(MotorPlaces.of(stage).gaps @ list(at.positions.values()) if stage.rotations else ())]
    slopes = np.eye(many)
    for k, (encoder, position) in enumerate(zip(block.encoders, positions, strict=True)):
        error = encoder.interpolation
        if error.at(error.period / 4.0):   # where its sine is largest
            slopes[k, k] += 2.0 * pi * error.amplitude / error.period * cos(2.0 * pi * position / error.period)
    weights = np.zeros(kept + 1)
    weights[whole], weights[kept] = 1.0 - instant.fraction, instant.fraction if kept > whole else 1.0
    by_sample = np.kron(weights, slopes).astype(np.float64)   # (many, (kept + 1) many), newest first
    inputs, outputs = tuple(encoder for _, encoder, _ in parts), tuple(of.name for _, _, of in parts)
    states = tuple(f"{encoder}.{age}" for age in range(1, kept + 1) for encoder in inputs)
    return LinearModel(name, states, inputs, outputs, np.eye(kept * many, k=-many), np.eye(kept * many, many),
                       by_sample[:, many:], by_sample[:, :many],
                       {signal: of.unit for k, (_, _, of) in enumerate(parts)
                        for signal in (inputs[k], outputs[k], *states[k::many])}, block.sample_time, at)


def behind(measurement: LinearModel, controller: LinearModel) -> LinearModel:
    """A controller that measures through a measurement, as one model; LinearModelError if their samples differ."""
    if measurement.sample_time != controller.sample_time:
        raise LinearModelError(f"{measurement.name}, sample time {measurement.sample_time} s, before "
                               f"{controller.name}, {controller.sample_time} s: expected the same sample time of both")
    own = measurement.outputs
    others = tuple(name for name in controller.inputs if name not in own)
    given = controller.select((*others, *own), controller.outputs)
    b, d, n = given.B[:, len(others):], given.D[:, len(others):], len(measurement.states)
    return replace(
        given, name=f"{measurement.name} and {controller.name}", states=(*measurement.states, *given.states),
        A=np.block([[measurement.A, np.zeros((n, len(given.A)))], [b @ measurement.C, given.A]]),
        B=np.block([[np.zeros((n, len(others))), measurement.B], [given.B[:, :len(others)], b @ measurement.D]]),
        C=np.hstack([d @ measurement.C, given.C]), D=np.hstack([given.D[:, :len(others)], d @ measurement.D]),
        units={**measurement.units, **given.units})
