"""Effects that the model leaves out: friction, bias, ripple and modulation, as the stage's description has them.

The change of the constants by each, and a check that the recording shows as much of it as the description states.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from math import exp, pi

import numpy as np

from maglev.files.arrays import Array
from maglev.identification.diagnostics import BLOCK, block_covariance, compared, least_squares
from maglev.identification.estimators import Estimate
from maglev.identification.recording import MotionRecording
from maglev.identification.regressors import RowData, functions
from plant_fmu.ripple import RIPPLE_PHASE, SHORTEST_RIPPLE
from pmlsm.stage_description import StageAxis

SURE = 3.0     # standard errors by which a recording has to differ from the description; assumed
OWN = 0.1      # share of an effect that constants and other effects must not be able to make up; assumed
WORTH = 0.1    # share of the uncertainty by which its bound has to grow for a warning; assumed

Again = Callable[[Sequence[RowData]], Mapping[str, float]]   # constants of an estimator that sees other rows


@dataclass(frozen=True)
class Effect:
    """One effect, with the size in the description, along the recorded motion."""

    name: str
    rows: list[RowData]   # of a model that has it
    added: dict[str, Array]   # by axis the acceleration by it, m/s², shape (n,), behind the filters of the velocity


def effects_of(recording: MotionRecording, rows: Sequence[RowData], delayed: Callable[[Array], Array],
               constants: Mapping[str, float]) -> list[Effect]:
    """The effects that the stage has; `delayed` applies the filters of the velocities to signals (n, m)."""
    return [*plain_effects(recording, rows, delayed), *modulations(recording, rows, delayed, constants)]


def plain_effects(recording: MotionRecording, rows: Sequence[RowData],
                  delayed: Callable[[Array], Array]) -> Iterator[Effect]:
    """Friction, bias and ripple, which add to b."""
    for effect in (friction, bias, ripple):
        added = np.stack([effect(axis, x, data.velocity) for axis, x, data in
                          zip(recording.stage.described.axes, recording.positions.T, rows, strict=False)], axis=1)
        if added.any():
            parts = {data.row.axis: part for data, part in zip(rows, delayed(added).T, strict=True)}
            yield Effect(effect.__name__, [replace(data, b=data.b + parts[data.row.axis]) for data in rows], parts)


def modulations(recording: MotionRecording, rows: Sequence[RowData], delayed: Callable[[Array], Array],
                constants: Mapping[str, float]) -> Iterator[Effect]:
    """The attraction of each motor times 1 − k sin²(π d/t1), as in `plant_fmu.attraction`."""
    stage, k = recording.stage, recording.stage.described.modulation
    if not k:
        return
    f = functions(stage, recording.positions)
    pitches = np.array([of.slot_pitch for of in stage.geometries.values()])
    factor = 1.0 - k * np.sin(pi * recording.positions @ stage.places.slots.T / pitches) ** 2
    with_slots = np.broadcast_to(f, (*f.shape[:2], factor.shape[1])).copy()
    with_slots[1] *= factor
    plain, changed = ([data.row.columns(of, recording.i_d, recording.i_q) for data in rows] for of in (f, with_slots))
    changed_rows = [replace(data, a=data.a + delayed(after - before))
                    for data, before, after in zip(rows, plain, changed, strict=True)]
    yield Effect("modulation", changed_rows, {
        data.row.axis: (other.a - data.a) @ np.array([constants[name] for name in data.row.constants])
        for data, other in zip(rows, changed_rows, strict=True)})


def friction(axis: StageAxis, x: Array, velocity: Array) -> Array:
    """Acceleration (m/s²) by the guide, as in `plant_fmu.guide`, at positions (m) and velocities (m/s)."""
    guide, deflection, path = axis.friction, 0.0, [0.0]
    on = guide.presliding > 0.0 and guide.coulomb > 0.0
    for way in np.diff(x).tolist():
        if way and on:   # w' = v/δ (1 − w sgn v), exact along a way in one direction
            end = 1.0 if way > 0.0 else -1.0
            deflection = end + (deflection - end) * exp(-abs(way) / guide.presliding)
        path.append(deflection)
    return -(guide.coulomb * np.array(path) + guide.viscous * velocity) / axis.mass


def bias(axis: StageAxis, x: Array, _velocity: Array) -> Array:
    """Constant acceleration (m/s²) of an axis."""
    return np.full(len(x), axis.bias)


def ripple(axis: StageAxis, x: Array, _velocity: Array) -> Array:
    """Periodic acceleration (m/s²) of an axis, as in `plant_fmu.ripple`."""
    if axis.ripple.amplitude == 0.0 or axis.ripple.period < SHORTEST_RIPPLE:
        return np.zeros(len(x))
    return np.asarray(axis.ripple.amplitude * np.sin(2.0 * pi * x / axis.ripple.period + RIPPLE_PHASE))


def changes(effects: Sequence[Effect], constants: Mapping[str, float], again: Again) -> list[dict[str, float]]:
    """Change of the constants by each effect, with its sign: they without it in the model, less they with it.

    The estimator `again` found `constants` in rows that have none.
    """
    return [{name: constants[name] - value for name, value in again(effect.rows).items()} for effect in effects]


def judge_description(data: RowData, effects: Sequence[Effect], by_effect: Sequence[Mapping[str, float]],
                      estimate: Estimate, errors: Mapping[str, float], bound: dict[str, float]) -> list[str]:
    """Enlarge the bounds of a row where the recording shows more of an effect than described, and say so.

    Least squares on the row find the constants and the multiple of each effect, whatever its sign, as far as the
    recording separates it from the others. If the multiple exceeds 1 by SURE standard errors, the bound counts that
    multiple of the change by the effect, and two standard errors more. A change of the constants by terms that add to b
    is proportional to it, that by the modulation nearly.
    """
    axis, dt = data.row.axis, float(estimate.time[-1] - estimate.time[0]) / (len(estimate.time) - 1)
    there = [(effect, change) for effect, change in zip(effects, by_effect, strict=True) if effect.added[axis].any()]
    if not there:
        return []
    a, c, added = compared(data, np.stack([effect.added[axis] for effect, _ in there], axis=1), dt, estimate.epsilon)
    known, seen = a, list[tuple[Effect, Mapping[str, float]]]()
    for each, column in zip(there, added.T, strict=True):
        if np.linalg.norm(column - known @ least_squares(known, column)) >= OWN * np.linalg.norm(column):
            known, seen = np.column_stack([known, column]), [*seen, each]
    times = least_squares(known, c)[a.shape[1]:]
    scatter = np.sqrt(np.diag(block_covariance(known, c, max(1, round(BLOCK / dt)))))[a.shape[1]:]
    told = []
    for (effect, change), found, error in zip(seen, times.tolist(), scatter.tolist(), strict=True):
        if abs(found) - SURE * error <= 1.0:
            continue
        grown = []
        for name in data.row.constants:
            before, growth = bound[name], (abs(found) + 2.0 * error - 1.0) * abs(change[name])
            bound[name] += growth
            if growth > WORTH * (before + 2.0 * errors[name]):
                grown.append(f"of {name} from {before:.2g} to {bound[name]:.2g}")
        if grown:
            told.append(f"axis {axis}: the recording contradicts the description: it shows {found:.2g} ± "
                        f"{2.0 * error:.1g} times the {effect.name} there, so the bound grows {', '.join(grown)}")
    return told
