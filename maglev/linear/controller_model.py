"""Linear models of the controllers, and of the measurement between encoders and controller, all sampled."""

from collections.abc import Iterable
from copy import deepcopy
from dataclasses import replace
from math import cos, pi
from typing import Any

import numpy as np

from controller_fmu.measurement_variables import encoders
from controller_fmu.places import axis_number, place
from controller_fmu.sampling_instant import SLOTS
from maglev.descriptions.registry import known_stages
from maglev.files.errors import LinearModelError
from maglev.fmi.definition import read, write
from maglev.linear.model import Equilibrium, LinearModel
from maglev.linear.parameters import prepare_fixed, regulator_in
from maglev.linear.places import MotorPlaces
from maglev.linear.plant_model import BALANCED, moved
from maglev.linear.tangent import derivatives
from pmlsm.stage_description import StageDescription

# States of an axis, with their units on a translation, where its law has them: of the observer, then of the internal
# model, or of pre-filter and integral.
STATES = {"observer.position": "m", "observer.velocity": "m/s", "model.xi1": "m.s3", "model.xi2": "m.s2",
          "model.xi3": "m.s", "filter.position": "m", "filter.rate": "m/s", "integral": "m.s"}

ITERATIONS = 60   # more than Newton's method takes where there is a solution
SELDOM = 1e-6     # weight of states moved only if no integral holds a current
SETTLED = 1e-10   # A, last step of the currents; the one after it would be of the size of its square


def linear_controller(name: str, stage: StageDescription, block: Any, at: Equilibrium, phases: bool) -> LinearModel:
    """Linearise a controller about an equilibrium; see `maglev.linear.linearise.linearise`.

    LinearModelError if its parameters are refused, or at this equilibrium no direct current changes the levitation.
    """
    prepare_fixed(name, block)
    states = states_of(stage, block)
    variables = known_stages().definition(regulator_in(name)).variables
    inputs = [variable for variable in variables if variable.causality == "input"]
    commands = tuple(f"{current}_cmd" for current in (stage.phase_names if phases else stage.dq_names))
    come_to_rest(name, stage, block, at, [state for state in states if ".observer." not in state])
    n = len(states)
    places = places_of(stage, states)
    slopes = derivatives(block, {"sample": ()}, [*places, *(entry.place for entry in inputs)],
                         [*places, *places_of(stage, commands)])
    (a, b), (c, d) = (np.hsplit(rows, [n]) for rows in np.vsplit(slopes, [n]))
    return LinearModel(name, tuple(states), tuple(entry.name for entry in inputs), commands, a, b, c, d,
                       {**states, **{entry.name: entry.unit for entry in inputs}, **dict.fromkeys(commands, "A")},
                       block.sample_time, at)


def states_of(stage: StageDescription, block: Any) -> dict[str, str]:
    return {f"{axis.name}.{state}": f"rad{unit[1:]}" if axis.rotation else unit
            for axis in stage.axes for state, unit in STATES.items()
            if has(block.axes[axis_number(stage, axis.name)], state)}


def places_of(stage: StageDescription, names: Iterable[str]) -> list[str]:
    """Paths of states and variables of a controller, by their names."""
    return [place(stage, name) for name in names]


def commanded(name: str, description: StageDescription, block: Any, stage: Any, at: Equilibrium) -> Equilibrium:
    """Return the equilibrium that a controller reaches on a level stage at rest whose motors differ.

    Where that is in between them follows from its law: its integrals move until no axis accelerates.
    """
    prepare_fixed(name, block)
    measure(description, block, at)
    integrals = places_of(description,
                          [state for state in states_of(description, block) if state.endswith((".xi1", ".integral"))])
    commands = places_of(description, [f"{current}_cmd" for current in description.dq_names])
    for _ in range(ITERATIONS):
        ahead = deepcopy(block)
        ahead.sample()
        currents = [read(ahead, command) for command in commands]
        rates, by_current = moved(description, stage, currents)
        if np.abs(rates).max() < BALANCED:
            return replace(at, i_d=tuple(currents[0::2]), i_q=tuple(currents[1::2]))
        change = np.linalg.solve(by_current @ derivatives(block, {"sample": ()}, integrals, commands), rates)
        for path, step in zip(integrals, change.tolist(), strict=True):
            write(block, path, read(block, path) - step)
    raise LinearModelError(f"{name} at {at}: has no equilibrium, expected a larger gap or other constants")


def has(axis: Any, state: str) -> bool:
    """Return True if the law of an axis has a state; a pre-filter without a corner passes its input through."""
    part = state.partition(".")[0]
    return hasattr(axis, part) and not (part == "filter" and axis.prefilter == 0.0)


def measure(stage: StageDescription, block: Any, at: Equilibrium) -> None:
    """Let a controller without limits measure an equilibrium for the first time."""
    for limit in ("current_limit", "trip_error", "trip_tilt"):
        if hasattr(block, limit):
            setattr(block, limit, 0.0)
    positions = list(at.positions.values())
    for axis, position in at.positions.items():
        part = block.axes[axis_number(stage, axis)]
        part.reference = part.measured = position
    if stage.rotations:
        gaps = (MotorPlaces.of(stage, block).gaps @ positions).tolist()
        for motor, gap in zip(block.platform.places, gaps, strict=True):
            motor.gap_measured = gap
    block.sample()   # observers begin at the measurement


def come_to_rest(name: str, stage: StageDescription, block: Any, at: Equilibrium, states: list[str]) -> None:
    """Let a controller without limits measure an equilibrium, and move states until it commands its currents.

    As nearly as it can, where its law cannot command them. At rest the integrals do it alone; other states and the
    references move with them only where a law has none.
    """
    measure(stage, block, at)
    variables = places_of(stage, [*states, *(f"{axis}.reference" for axis in stage.axis_names)])
    commands = places_of(stage, [f"{current}_cmd" for current in stage.dq_names])
    start = np.array([read(block, path) for path in variables])
    change = np.zeros(len(variables))
    weights = np.array([1.0 if path.endswith((".xi1", ".integral")) else SELDOM for path in variables])
    for _ in range(ITERATIONS):
        for path, value in zip(variables, (start + change).tolist(), strict=True):
            write(block, path, value)
        ahead = deepcopy(block)
        ahead.sample()
        if not ahead.feasible:   # a step too far: in its model no current meets the law's demand there
            change /= 2.0
            continue
        slopes = derivatives(block, {"sample": ()}, variables, commands)
        missing = at.dq - [read(ahead, command) for command in commands]
        start, change = start + change, weights * np.linalg.lstsq(slopes * weights, missing, rcond=None)[0]
        if np.abs(slopes @ change).max() < SETTLED:
            return
    raise LinearModelError(f"{name} at {at}: in its model more direct current no longer lifts, expected an "
                           "equilibrium with less current")


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
