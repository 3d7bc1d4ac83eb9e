"""Linear model of a stage with its amplifiers."""

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from typing import Any

import numpy as np

from maglev.files.arrays import Array
from maglev.fmi.definition import read, write
from maglev.linear.model import Equilibrium, LinearModel
from maglev.linear.places import MotorPlaces
from maglev.linear.tangent import derivatives
from plant_fmu.places import place
from pmlsm.stage_description import StageDescription
from pmlsm.velocity_rows import GRAVITY

BALANCED = 1e-12 * GRAVITY   # m/s², largest residual of an equilibrium


@np.errstate(over="ignore", invalid="ignore")   # values that are no numbers raise later
def linear_plant(name: str, stage: StageDescription, block: Any, at: Equilibrium, phases: bool, amplifier: bool,
                 forces: bool,
                 hold: float | None) -> LinearModel:
    """Linearise a stage about an equilibrium; see `maglev.linear.linearise.linearise` for arguments and contents."""
    axes, motors = len(stage.axes), len(stage.motors)
    flexible = [axis for axis in stage.axes if block.axes[stage.axis_number(axis.name)].mode.frequency > 0.0]
    modes = {f"{axis.name}.mode.{part}": axis.unit(unit) for axis in flexible
             for part, unit in (("deflection", "m"), ("rate", "m/s"))}
    motion = {**{f"{axis.name}.position": axis.unit("m") for axis in stage.axes},
              **{f"{axis.name}.velocity": axis.unit("m/s") for axis in stage.axes}, **modes}
    n = len(motion)
    resting = at_rest(stage, block, at.positions)
    rotation, park = np.hsplit(seen_currents(stage, resting, at), [axes])
    for name_of_current, current in at.currents.items():
        write(resting, place(stage, name_of_current), current)
    inputs = [*motion, *stage.dq_names, *(axis.external for axis in stage.axes)]
    slopes = derivatives(resting, {**({"place_motors": ()} if stage.rotations else {}), "add_slope": (1.0, 0.0)},
                         [place(stage, one) for one in inputs], [f"{place(stage, one)}_sum" for one in motion])
    by_motion, by_current, by_force = np.split(slopes, [n, n + 2 * motors], axis=1)
    lags = [motor.amplifier.lag if amplifier else 0.0 for motor in block.motors for _ in "dq"]
    lagged = np.array([lag > 0.0 for lag in lags])
    follow = np.array([1.0 / lag if lag > 0.0 else 0.0 for lag in lags])
    # Commands seen in the frame of the mover: phase currents stay where they are while it moves. Those in d and q move
    # with it, unless they are held from sample to sample.
    turned, turning = np.zeros((2, 2 * motors, n))
    turned[:, axes:2 * axes] = rotation * lagged[:, None]
    turning[:, :axes] = rotation if phases or hold is not None else 0.0
    at_once = by_current * ~lagged
    moved = np.block([[by_motion + at_once @ turning, by_current * lagged],
                      [follow[:, None] * turning + turned, -np.diag(follow)]])
    drive = np.vstack([at_once, np.diag(follow)])
    if phases:
        drive = drive @ park
    push = np.vstack([by_force, np.zeros((2 * motors, axes))])

    units = {**motion, **dict.fromkeys(stage.dq_names, "A")}
    order = [*range(2 * axes), *(n + np.flatnonzero(lagged)), *range(2 * axes, n)]
    names = tuple(list(units)[k] for k in order)
    commands = tuple(f"{current}_cmd" for current in (stage.phase_names if phases else stage.dq_names))
    external = {axis.external: axis.unit("N") for axis in stage.axes}
    rows = measured_rows(stage, resting, list(motion))
    outputs = np.pad(np.array(list(rows.values())), ((0, 0), (0, 2 * motors)))[:, order]
    model = LinearModel(name, names, (*commands, *external), tuple(rows), moved[np.ix_(order, order)],
                        np.hstack([drive, push])[order], outputs, np.zeros((len(rows), len(commands) + axes)),
                        {**{name: units[name] for name in names}, **external,
                         **{row: "m" for row in rows if row not in units}, **dict.fromkeys(commands, "A")}, None, at)
    if hold is not None:
        model = held_phases(model, rotation @ measuring(stage, MotorPlaces.of(stage, block), model.outputs), phases,
                            hold)
    return model if forces else model.select(commands, model.outputs)


def moved(description: StageDescription, stage: Any, currents: Sequence[float] | Array,
          wanted: Sequence[str] = ()) -> tuple[Array, Array]:
    """Results of the motion of a stage at rest under i_d, i_q of each motor (A), and derivatives by these.

    The accelerations of the axes, unless something else is wanted.
    """
    wanted = wanted or [f"{axis}.acceleration" for axis in description.axis_names]
    for name, current in zip(description.dq_names, currents, strict=True):
        write(stage, place(description, name), float(current))
    stage.add_slope(1.0, 0.0)
    paths = [place(description, name) for name in wanted]
    return (np.array([read(stage, path) for path in paths]),
            derivatives(stage, {"add_slope": (1.0, 0.0)}, [place(description, name) for name in description.dq_names],
                        paths))


def at_rest(stage: StageDescription, block: Any, positions: Mapping[str, float]) -> Any:
    """A copy of a stage at rest at positions of its axes (m), without currents and terms that are not smooth."""
    block = deepcopy(block)
    block.encoder.resolution = 0.0
    for name, position in positions.items():
        axis = block.axes[stage.axis_number(name)]
        axis.position, axis.friction.coulomb, axis.roughness.rms = position, 0.0, 0.0
        axis.flexible = axis.mode.start()
    block.derive()
    block.mover.start()   # what it keeps for a gap has no derivative
    return block


def measured_rows(stage: StageDescription, block: Any, motion: Sequence[str]) -> dict[str, Array]:
    """Outputs by positions, velocities and modes: positions, gaps, and encoder readings where these see a mode.

    Where the platform tilts, its encoders are at the motors: if one of them sees a mode, all do.
    """
    gaps = [f"{motor}.gap" for motor in stage.motor_names if stage.rotations]
    names = [*(f"{axis}.position" for axis in stage.axis_names), *gaps, *stage.encoders]
    slopes = derivatives(block, {"derive": (), "measure": ()}, [place(stage, name) for name in motion],
                         [place(stage, name) for name in names])
    rows = dict(zip(names, slopes, strict=True))
    true = {name: rows[name.replace("gap_encoder", "gap").replace(".encoder", ".position")] for name in stage.encoders}
    alike = {name for name, row in true.items() if (row == rows[name]).all()}
    if not {f"{gap}_encoder" for gap in gaps} <= alike:
        alike -= {f"{gap}_encoder" for gap in gaps}
    return {name: row for name, row in rows.items() if name not in alike}


def measuring(stage: StageDescription, places: MotorPlaces, outputs: Sequence[str]) -> Array:
    """Positions that a controller commutates with, by the outputs, (axes, outputs): encoders, or true positions."""
    shown = [name if name in outputs else name.replace("gap_encoder", "gap").replace(".encoder", ".position")
             for name in stage.encoders]
    matrix = np.zeros((len(stage.axes), len(outputs)))
    matrix[:, [outputs.index(name) for name in shown]] = places.measuring(stage)
    return matrix


def seen_currents(stage: StageDescription, block: Any, at: Equilibrium) -> Array:
    """Derivatives of all i_d, i_q by positions (A/m) and by phase currents, shape (2 motors, axes + 3 motors).

    By the positions while the phase currents stay: the mover turns under them. By these, the matrix of (2.1).
    """
    flowing = deepcopy(block)
    for name, current in at.phases.items():
        write(flowing, place(stage, name), current)
    known = [*(f"{axis}.position" for axis in stage.axis_names), *stage.phase_names]
    return derivatives(flowing, {"derive": ()}, [place(stage, name) for name in known],
                       [place(stage, name) for name in stage.dq_names])


def held_phases(model: LinearModel, rotation: Array, phases: bool, hold: float) -> LinearModel:
    """Hold the phase currents between samples; commands in d and q are turned into them by the displacement sampled.

    `rotation` is that of i_d, i_q by the outputs, A/m, shape (2 motors, outputs).
    """
    held = model.discretise(hold)
    if phases:
        return held
    commutation = np.zeros((len(held.inputs), len(held.outputs)))
    commutation[:len(rotation)] = -rotation
    return replace(held, A=held.A + held.B @ commutation @ held.C, commutation=commutation)
