"""A stage as a Gymnasium environment: to be levitated by an agent that commands currents."""

import weakref
from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from operator import add
from pathlib import Path
from typing import Any, NamedTuple

import gymnasium
import numpy as np
import numpy.typing as npt

from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError, UnknownName, nearest, shortened
from maglev.files.time_grid import MOST_STEPS
from maglev.files.units import positive_time
from maglev.fmi.parameter import Parameter
from maglev.linear.places import MotorPlaces
from maglev.many.compiled_stage import CompiledStage, Saved
from maglev.many.episode_draws import Drawn, Parameters, References, Setting, Settings, can_change, sample_of
from maglev.many.episode_picture import StagePicture
from maglev.many.reward import DEFAULT, Function, Reward, Seen, Weights
from maglev.scenario.fmus_for_runs import fmus_for_runs
from maglev.user.adoption import stage_named
from pmlsm.stage_description import StageAxis

HIGHEST_SPEED = 10.0   # m/s, more than twice what the amplifiers' peak current reaches between the stops

ACTIONS = ("dq", "phases")
RESET_OPTIONS = ("parameters", "measurement")
MOST_SEEDS = 2**32     # of a measurement


class Due(NamedTuple):
    """A parameter or input of a part that has another value from a sample on."""

    sample: int
    part: str
    name: str
    value: float | bool


class State(NamedTuple):
    """State of an environment between two samples."""

    stage: Saved
    episode: tuple[Array, Array]
    due: tuple[Due, ...]
    sample: int
    observers: tuple[tuple[float, float], ...]   # of each axis: position and velocity
    random: Mapping[str, Any]


class StageEnv(gymnasium.Env[Array, Array]):
    """Stage of a stage, as the FMU of its plant, sampled as the stage's controllers are.

    An action is held for a sample. It has the direct and quadrature current of each motor (A), which the stage's
    commutation turns into phase currents with the measured displacements, or the phase currents. They are limited to
    the peak current. An observation begins with the encoder readings (m): the positions of all axes or, where the
    platform tilts, those of the horizontal axes and the gaps at the motors. Then follow the velocities of all axes by
    the controllers' observer (m/s, rad/s of a tilt), then their references (m, rad).

    An episode is truncated at its end. It is terminated when an axis is beyond an end stop, or when a current is not a
    number or beyond 1000 A. Such a current is refused: the reward is 0, and `info["refused"]` gives the reason.

    Parameters
    ----------
    stage : str
        "2dof", "3dof", "5dof", or the description of a user's stage, "mine.toml".
    action : "dq" or "phases"
    reference : str or array_like, shape (samples, axes)
        "setpoints", "hold", "sinusoids" or references (m), see `References`.
    duration : float or str
        Longest episode, s or with a unit.
    sample_time : float or str, optional
        Of the environment, s or with a unit: the stage's or a multiple, in which the commutation continues with the
        stage's.
    reward : mapping of str to float, or callable, optional
        Weights of named terms, or a function of signals, see `Reward`.
    parameters : mapping, or callable, optional
        Parameters of the plant by their names, such as "y.friction.coulomb", several with commas between, and forces
        on it, such as "y.force": SI or text with a unit. Every episode draws a value between a pair, or from
        {"uniform", "log-uniform": (low, high)}, {"normal": (mean, deviation)} or {"choice": [...]}. A value changes in
        the episode by {"at": time, "then": value, "for": time}, each of them given or drawn. A function of the random
        numbers of an episode, a numpy.random.Generator, returns such a table for it. `reset(options={"parameters":
        …})` sets them for one episode.
    measurement : mapping, or callable, optional
        Parameters of the block between encoders and controller, such as "delay" and "y.noise", in the form of those of
        the plant. Every episode draws a seed if none is given. If this is not given, there is no such block.
    render_mode : "rgb_array", optional
        Result of `render`: a picture of the stage, ndarray of uint8, shape (240, 480, 3). It needs the extra `report`.
    fmus : path, optional
        Folder of FMUs; the native ones are in its folder `native`. If not given, missing FMUs are built, and kept in
        the user's cache: native where there is a compiler.

    Raises
    ------
    MaglevError
        If an option cannot be used, or there is no FMU.
    """

    metadata: dict[str, Any] = {"render_modes": ["rgb_array"]}

    def __init__(self, stage: str | Path, action: str = "dq", reference: str | npt.ArrayLike = "setpoints",
                 duration: float | str = 2.0, sample_time: float | str | None = None,
                 reward: Weights | Function = DEFAULT, parameters: Settings | None = None,
                 measurement: Settings | None = None, render_mode: str | None = None,
                 fmus: str | Path | None = None):
        if action not in ACTIONS:
            raise ScenarioError(f"action = {action!r}, expected 'dq' or 'phases'")
        if render_mode not in (None, *self.metadata["render_modes"]):
            raise ScenarioError(f"render_mode = {render_mode!r}, expected None or 'rgb_array'")
        self.stage = stage_named(stage)
        self.samples = whole_samples(sample_time, self.stage.sample_time)
        self.sample_time = self.samples * self.stage.sample_time
        self.last = round(positive_time(duration, ScenarioError, f"duration = {duration!r}") / self.sample_time)
        if not 1 <= self.last <= MOST_STEPS:
            raise ScenarioError(f"duration = {duration!r}, expected 1 to {MOST_STEPS:.0e} samples of "
                                f"{self.sample_time} s")
        asked = {"plant": True, "commutation": action == "dq", "measurement": measurement is not None}
        parts = [part for part, needed in asked.items() if needed]
        folder = fmus_for_runs([f"{part.title()}{self.stage.suffix}" for part in parts], fmus,
                               None if fmus is None else "native")
        self.compiled = CompiledStage(self.stage, folder, parts)
        # An environment that nobody closed leaves no unpacked FMU behind.
        self.freed = weakref.finalize(self, self.compiled.close)
        # External inputs of the plant can be given like its parameters; the sample time is that of the stage.
        currents = {f"{current}_cmd" for current in self.stage.phase_names}
        of_plant = {name: variable for name, variable in self.compiled.plant.variables.items()
                    if variable.causality == "parameter" or (variable.causality == "input" and name not in currents)}
        of_measurement = {} if self.compiled.measurement is None else {
            name: variable for name, variable in self.compiled.measurement.variables.items()
            if variable.causality == "parameter" and name != "sample_time"}
        self.parameters = Parameters("plant", of_plant, {} if parameters is None else parameters)
        self.measurement = Parameters("measurement", of_measurement, {} if measurement is None else measurement)
        self.render_mode = render_mode
        self.metadata = {**self.metadata, "render_fps": round(1.0 / self.sample_time)}
        self.picture: StagePicture | None = None

        stops = [self.travel(axis) for axis in self.stage.axes]
        low, high = (np.array(ends) for ends in zip(*stops, strict=True))
        # Tilts and the gap at the centre follow from the gaps at the motors.
        self.measuring = MotorPlaces.of(self.stage).measuring(self.stage) if self.stage.rotations else None
        seen = [self.ends(name.rpartition(".")[0]) for name in self.stage.encoders]
        seen_low, seen_high = (np.array(ends) for ends in zip(*seen, strict=True))
        peaks = [self.parameters.own(f"{motor}.amplifier.peak") for motor in self.stage.motor_names]
        self.peak = max(peaks)
        self.references = References(reference, low, high, self.last + 1, self.sample_time)
        bound = np.repeat(peaks, self.compiled.commands.size // len(peaks)).reshape(self.compiled.commands.shape)
        self.action_space = gymnasium.spaces.Box(-bound, bound, dtype=np.float64)
        speeds = np.array([HIGHEST_SPEED / self.stage.arm
                           if axis.rotation else HIGHEST_SPEED for axis in self.stage.axes])
        rounding = self.parameters.extremes("encoder.resolution")[1]   # beyond a stop, at most
        self.lowest = np.concatenate([seen_low - rounding, -speeds, low])
        self.highest = np.concatenate([seen_high + rounding, speeds, high])
        self.observation_space = gymnasium.spaces.Box(self.lowest, self.highest, dtype=np.float64)

        self.reward = Reward(reward, self.stage, [upper - lower for lower, upper in stops], self.peak)
        self.observer_filter = ObserverFilter()
        self.observer_filter.prepare(self.sample_time)
        self.observers = [VelocityObserver() for _ in stops]
        self.episode = np.zeros((1, len(stops))), np.zeros(len(stops))   # what `References` draws
        self.due: list[Due] = []   # what changes in the episode, the last one first
        self.sample = 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin an episode; `info["parameters"]` has the parameters of the plant that differ from its own."""
        super().reset(seed=seed)
        given = settings_of(options or {})
        self.parameters.require_free(given["parameters"], "the options of reset")
        stage = self.compiled
        drawn = {"parameters": self.parameters.draw(self.np_random, given["parameters"])}
        seed_of: dict[str, float | bool] = {}
        if stage.measurement is not None:
            drawn["measurement"] = self.measurement.draw(self.np_random, given["measurement"])
            seed_of["seed"] = float(self.np_random.integers(MOST_SEEDS))
        elif given["measurement"]:
            raise ScenarioError("measurement in the options of reset: give measurement to the environment, too, which "
                                "otherwise has no such block")
        started = {what: {**(seed_of if what == "measurement" else {}), **draw.values} for what, draw in drawn.items()}
        stage.start(started["parameters"], self.peak, started.get("measurement", {}))
        self.due = sorted((due for what, draw in drawn.items() for due in self.dues(what, draw)), reverse=True,
                          key=lambda due: due.sample)
        self.episode = self.references.draw(self.np_random, stage.positions)
        stage.references[:] = self.references.at(0, *self.episode)
        for observer, measured in zip(self.observers, self.measured(), strict=True):
            observer.seed(measured)
        self.sample = 0
        changes = {name: change for draw in drawn.values() for name, change in draw.changes.items()}
        return stage.observation.copy(), {**started, **({"changes": changes} if changes else {})}

    def dues(self, what: str, drawn: Drawn) -> Iterator[Due]:
        """Return the changes during an episode, of the parameters of the plant or of the measurement."""
        part, parameters = ("plant", self.parameters) if what == "parameters" else (what, self.measurement)
        for name, change in drawn.changes.items():
            before = drawn.values.get(name, parameters.own(name))
            yield Due(sample_of(change["at"], self.sample_time), part, name, change["then"])
            if "for" in change:
                yield Due(sample_of(change["at"] + change["for"], self.sample_time), part, name, before)

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold the currents (A) of an action for a sample."""
        stage = self.compiled
        if np.shape(action) != stage.commands.shape:   # which numpy would broadcast
            raise ScenarioError(f"action of shape {np.shape(action)}, expected {stage.commands.shape}: a current (A) "
                                "for each of the action space")
        while self.due and self.due[-1].sample <= self.sample:
            _, part, name, value = self.due.pop()
            stage.change(part, name, value)
        stage.commands[:] = action
        if not stage.advance(self.samples):
            return stage.observation.copy(), 0.0, True, False, {"refused": stage.said()}
        self.sample += 1
        references = self.references.at(min(self.sample, self.last), *self.episode)
        stage.references[:] = references
        velocities = stage.velocities
        for i, measured in enumerate(self.measured()):
            observer = self.observers[i]
            observer.update(measured, self.observer_filter, self.sample_time)
            velocities[i] = observer.velocity
        observation, crashed = stage.observation.copy(), stage.at_stop()
        reward, info = self.reward.of(Seen(stage.positions.tolist(), references.tolist(), velocities.tolist(),
                                           stage.currents.tolist(), crashed))
        if crashed or stage.measurement is not None:   # an encoder reads on beyond its stop, and noise has no end
            observation = np.clip(observation, self.lowest, self.highest)
        return observation, reward, crashed, not crashed and self.sample >= self.last, info

    def push(self, **forces: float | str) -> None:
        """Change inputs of the plant from the next sample on, until an episode begins: `push(y=5.0)` is 5 N along y.

        Forces along the axes (N), torques about those that are tilts (N m), or text with a unit. ScenarioError for an
        axis that there is not, or a force that cannot be used.
        """
        axes = {axis.name: axis.external for axis in self.stage.axes}
        for name in forces:
            if name not in axes:
                raise UnknownName(f"{name}: the stage has no such axis; {nearest(name, axes)}")
        for name, value in forces.items():
            described = Parameter.described(self.parameters.known[axes[name]])
            self.compiled.change("plant", axes[name], described.read(value, axes[name], ScenarioError))

    def clone_state(self) -> State:
        """Return the state, with the random numbers, for `restore_state`; it can be pickled."""
        observers = tuple((observer.position, observer.velocity) for observer in self.observers)
        return State(self.compiled.save(), self.episode, tuple(self.due), self.sample, observers,
                     self.np_random.bit_generator.state)

    def restore_state(self, state: State) -> None:
        """Go back to a state of this environment, or of one made with the same options that has been reset."""
        if not isinstance(state, State):
            raise ScenarioError(f"state = {shortened(state)}, expected one of clone_state")
        self.compiled.restore(state.stage)
        self.episode, self.due, self.sample = state.episode, [*state.due], state.sample
        for observer, (position, velocity) in zip(self.observers, state.observers, strict=True):
            observer.position, observer.velocity = position, velocity
        self.np_random.bit_generator.state = state.random

    def render(self) -> npt.NDArray[np.uint8] | None:
        """Return a picture of the present stage."""
        if self.render_mode is None:
            return None
        if self.picture is None:
            self.picture = StagePicture(self.stage, [self.travel(axis) for axis in self.stage.axes])
        stage = self.compiled
        return self.picture.drawn(stage.positions, stage.references, self.sample * self.sample_time)

    def changing(self) -> Iterator[tuple[str, str]]:
        """Return the parts and names of everything that can change in an episode."""
        for part, parameters in (("plant", self.parameters), ("measurement", self.measurement)):
            yield from ((part, name) for name, variable in parameters.known.items() if can_change(variable))

    def measured(self) -> list[float]:
        """Measured positions of the axes, m and rad."""
        return [float(position) for position in positions(self.measuring, self.compiled.encoders)]

    def ends(self, place: str) -> tuple[float, float]:
        """Stops of an axis or at a motor, m."""
        return self.parameters.extremes(f"{place}.stop.lower")[0], self.parameters.extremes(f"{place}.stop.upper")[1]

    def travel(self, axis: StageAxis) -> tuple[float, float]:
        """Return the range of an axis, m or rad: between its stops, or as far as those at the motors allow."""
        if axis.stop is not None:
            return self.ends(axis.name)
        lower, upper = zip(*(self.ends(motor) for motor in self.stage.motor_names), strict=True)
        if not axis.rotation:
            return min(lower), max(upper)
        k = self.stage.axis_names.index(axis.name)
        tilt = (max(upper) - min(lower)) / (2.0 * float(np.abs(MotorPlaces.of(self.stage).gaps[:, k]).max()))
        return -tilt, tilt

    def close(self) -> None:
        self.freed()


def positions(measuring: Array | None, encoders: Array) -> Sequence[Array]:
    """Positions of the axes, shape (axes, …), from encoders, shape (encoders, …): themselves, or by least squares.

    Sums go in the order of the encoders, whatever a library would do: one stage and many have the same bits.
    """
    if measuring is None:
        return [*encoders]
    return [reduce(add, (weight * encoder for weight, encoder in zip(row, encoders, strict=True)))
            for row in measuring.tolist()]


def settings_of(options: Mapping[str, Any]) -> dict[str, dict[str, Setting]]:
    """Return the settings of a reset by their part; ScenarioError if the options have something else."""
    for name in options:
        if name not in RESET_OPTIONS:
            raise ScenarioError(f"options of reset: {name!r}, expected {' or '.join(RESET_OPTIONS)}")
    return {part: {**options.get(part, {})} for part in RESET_OPTIONS}


def whole_samples(sample_time: float | str | None, own: float) -> int:
    """Return the number of stage samples (s) in one of the environment; ScenarioError if it is not whole."""
    if sample_time is None:
        return 1
    ratio = positive_time(sample_time, ScenarioError, f"sample_time = {sample_time!r}") / own
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-9 * ratio:
        raise ScenarioError(f"sample_time = {sample_time!r}, expected a multiple of the stage's, {own} s")
    return round(ratio)
