"""What friction, bias, ripple and modulation do to an estimate whose model leaves them out."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import exp, pi

import numpy as np

from maglev.arrays import Array
from maglev.identification.recording import MotionRecording
from maglev.identification.rigs import RowData, functions
from plant_fmu.ripple import RIPPLE_PHASE, SHORTEST_RIPPLE
from pmlsm.rig import RigAxis

Again = Callable[[Sequence[RowData]], Mapping[str, float]]   # constants of an estimator that sees other rows


def left_out(recording: MotionRecording, rows: Sequence[RowData], delayed: Callable[[Array], Array],
             constants: Mapping[str, float], again: Again) -> dict[str, float]:
    """How far constants could be off by what the model leaves out: a bound, by constant.

    The recording is identified again by a model that has one of the effects, of the size that the description of the
    stage assumes, along the recorded motion; the changes by all effects are added whatever their signs. The estimator
    `again` found `found` in the rows; `delayed` is what the velocities have gone through, of signals with shape (n, m).
    """
    bound = dict.fromkeys(constants, 0.0)
    for changed in rows_by_effect(recording, rows, delayed):
        for name, value in again(changed).items():
            bound[name] += abs(value - constants[name])
    return bound


def rows_by_effect(recording: MotionRecording, rows: Sequence[RowData],
                     delayed: Callable[[Array], Array]) -> Iterator[list[RowData]]:
    """The rows of models that have one of the effects, each in turn, as far as the stage has it."""
    described = recording.rig.described
    for effect in (friction, bias, ripple):
        added = np.stack([effect(axis, x, data.velocity) for axis, x, data in
                          zip(described.axes, recording.positions.T, rows, strict=False)], axis=1)
        if added.any():
            yield [replace(data, b=data.b + part) for data, part in zip(rows, delayed(added).T, strict=True)]
    if described.modulation:
        yield modulated(recording, rows, delayed)


def friction(axis: RigAxis, x: Array, velocity: Array) -> Array:
    """Acceleration (m/s²) by the guide, as of `plant_fmu.guide`, at positions (m) and velocities (m/s)."""
    guide, deflection, path = axis.friction, 0.0, [0.0]
    on = guide.presliding > 0.0 and guide.coulomb > 0.0
    for way in np.diff(x).tolist():
        if way and on:   # w' = v/δ (1 − w sgn v), exact along a way in one direction
            end = 1.0 if way > 0.0 else -1.0
            deflection = end + (deflection - end) * exp(-abs(way) / guide.presliding)
        path.append(deflection)
    return -(guide.coulomb * np.array(path) + guide.viscous * velocity) / axis.mass


def bias(axis: RigAxis, x: Array, _velocity: Array) -> Array:
    """Constant acceleration (m/s²) of an axis."""
    return np.full(len(x), axis.bias)


def ripple(axis: RigAxis, x: Array, _velocity: Array) -> Array:
    """Periodic acceleration (m/s²) of an axis, as of `plant_fmu.ripple`."""
    if axis.ripple.amplitude == 0.0 or axis.ripple.period < SHORTEST_RIPPLE:
        return np.zeros(len(x))
    return np.asarray(axis.ripple.amplitude * np.sin(2.0 * pi * x / axis.ripple.period + RIPPLE_PHASE))


def modulated(recording: MotionRecording, rows: Sequence[RowData], delayed: Callable[[Array], Array]) -> list[RowData]:
    """Rows with the attraction of each motor times 1 − k sin²(π d/t1), as of `plant_fmu.attraction`."""
    rig, k = recording.rig, recording.rig.described.modulation
    f = functions(rig, recording.positions)
    pitches = np.array([of.slot_pitch for of in rig.geometries.values()])
    factor = 1.0 - k * np.sin(pi * recording.positions @ rig.places.slots.T / pitches) ** 2
    with_slots = np.broadcast_to(f, (*f.shape[:2], factor.shape[1])).copy()
    with_slots[1] *= factor
    left = []
    for data in rows:
        plain, changed = (data.row.columns(factors, recording.i_d, recording.i_q) for factors in (f, with_slots))
        left.append(replace(data, a=data.a + delayed(changed - plain)))
    return left
