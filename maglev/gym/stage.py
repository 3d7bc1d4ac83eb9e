"""A stage as a Gymnasium environment: to be levitated by an agent that commands currents."""

import weakref
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt

from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from maglev.arrays import Array
from maglev.errors import QuantityError, ScenarioError
from maglev.gym.compiled_stage import CompiledStage
from maglev.gym.episode import PlantParameters, References, Setting
from maglev.linear.motors.places import MotorPlaces
from maglev.own_stage.adoption import rig_named
from maglev.units import parse_quantity
from pmlsm.rig import RigAxis

HIGHEST_SPEED = 10.0   # m/s, more than twice what the amplifiers' peak current reaches between the stops

ACTIONS = ("dq", "phases")


class Stage(gymnasium.Env[Array, Array]):
    """Stage of a rig, as the native FMU of its plant, sampled as the rig's controllers are.

    An action is held for a sample: direct and quadrature current of each motor (A), which the rig's commutation turns
    into phase currents with the measured displacements, or the phase currents. They are limited to the peak current.
    An observation has what the encoders measure (m), the positions of all axes or, where the platform tilts, those of
    the horizontal axes and the gaps at the motors; then the velocities of all axes that the controllers' observer makes
    of it (m/s, rad/s of a tilt), then their references (m, rad).

    The reward of a sample is 1 − error_weight · mean((reference − position)² / travel²)
    − current_weight · mean(current² / peak²), with true positions and delivered direct and quadrature currents. An
    episode is terminated when an axis is beyond an end stop, or when a current is refused, which is not a number or
    beyond 1000 A (the reward is then 0, and `info["refused"]` says why), and truncated at its end.

    Parameters
    ----------
    rig : str
        "2dof", "3dof", "5dof", or the description of a stage of the user's, "mine.toml".
    action : "dq" or "phases"
    reference : str or array_like, shape (samples, axes)
        "setpoints", "hold", "sinusoids" or references (m), see `References`.
    duration : float or str
        Longest episode, s or with a unit.
    sample_time : float or str, optional
        Of the environment, s or with a unit: the rig's or a multiple, in which the commutation goes on with the rig's.
    error_weight, current_weight : float
        Of the reward.
    fmus : path
        Folder of FMUs; the native ones are in its folder `native`.
    **parameters
        Parameters of the plant by their names, such as "y.friction.coulomb": SI or text with a unit, or a pair between
        which every episode draws one. `reset(options=…)` takes them for one episode.

    Raises
    ------
    MaglevError
        If an option cannot be used, or there is no native FMU.
    """

    metadata: dict[str, Any] = {"render_modes": []}

    def __init__(self, rig: str, action: str = "dq", reference: str | npt.ArrayLike = "setpoints",
                 duration: float | str = 2.0, sample_time: float | str | None = None, error_weight: float = 1.0,
                 current_weight: float = 0.1, fmus: str | Path = "fmus", **parameters: Setting):
        if action not in ACTIONS:
            raise ScenarioError(f"action = {action!r}, expected 'dq' or 'phases'")
        self.rig = rig_named(rig)
        self.samples = whole_samples(sample_time, self.rig.sample_time)
        self.sample_time = self.samples * self.rig.sample_time
        self.last = round(seconds("duration", duration) / self.sample_time)
        if self.last < 1:
            raise ScenarioError(f"duration = {duration!r}, expected at least a sample of {self.sample_time} s")
        self.stage = CompiledStage(self.rig, Path(fmus) / "native", action == "phases")
        # An environment that nobody closed leaves no unpacked FMU behind.
        self.freed = weakref.finalize(self, self.stage.close)
        self.parameters = PlantParameters(self.stage.plant.variables, parameters)

        stops = [self.travel(axis) for axis in self.rig.axes]
        low, high = (np.array(ends) for ends in zip(*stops, strict=True))
        # Tilts and the gap at the centre follow from the gaps at the motors.
        self.measuring = MotorPlaces.of(self.rig).measuring(self.rig)
        seen = [self.ends(name.rpartition(".")[0]) for name in self.rig.encoders]
        seen_low, seen_high = (np.array(ends) for ends in zip(*seen, strict=True))
        self.peak = self.parameters.own(f"{self.rig.motor_names[0]}.amplifier.peak")
        self.references = References(reference, low, high, self.last + 1, self.sample_time)
        self.action_space = gymnasium.spaces.Box(-self.peak, self.peak, self.stage.commands.shape, np.float64)
        speeds = np.array([HIGHEST_SPEED / self.rig.arm if axis.rotation else HIGHEST_SPEED for axis in self.rig.axes])
        rounding = self.parameters.extremes("encoder.resolution")[1]   # beyond a stop, at most
        self.lowest = np.concatenate([seen_low - rounding, -speeds, low])
        self.highest = np.concatenate([seen_high + rounding, speeds, high])
        self.observation_space = gymnasium.spaces.Box(self.lowest, self.highest, dtype=np.float64)

        self.error_weights = [error_weight / len(stops) / (upper - lower) ** 2 for lower, upper in stops]
        self.current_weight = current_weight / self.stage.currents.size / self.peak**2
        self.observer_filter = ObserverFilter()
        self.observer_filter.prepare(self.sample_time)
        self.observers = [VelocityObserver() for _ in stops]
        self.episode = np.zeros((1, len(stops)))   # references, sample by sample
        self.sample = 0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin an episode; `info["parameters"]` has the plant's parameters that are not its own."""
        super().reset(seed=seed)
        for name in options or {}:
            if ".stop." in name:
                raise ScenarioError(f"{name} in the options of reset, expected where the environment is made: the "
                                    "observation space has the stops")
        drawn = self.parameters.draw(self.np_random, options or {})
        stage = self.stage
        stage.start(drawn, self.peak)
        self.episode = self.references.draw(self.np_random, stage.positions)
        stage.references[:] = self.episode[0]
        for observer, measured in zip(self.observers, self.measured(), strict=True):
            observer.seed(measured)
        self.sample = 0
        return stage.observation.copy(), {"parameters": drawn}

    def step(self, action: Array) -> tuple[Array, float, bool, bool, dict[str, Any]]:
        """Hold the currents (A) of an action for a sample."""
        stage = self.stage
        stage.commands[:] = action
        if not stage.advance(self.samples):
            return stage.observation.copy(), 0.0, True, False, {"refused": stage.said()}
        self.sample += 1
        references = self.episode[min(self.sample, self.last)]
        stage.references[:] = references
        reward = 1.0
        for weight, reference, position in zip(self.error_weights, references.tolist(), stage.positions.tolist(),
                                               strict=True):
            reward -= weight * (reference - position) ** 2
        for current in stage.currents.tolist():
            reward -= self.current_weight * current * current
        velocities = stage.velocities
        for i, measured in enumerate(self.measured()):
            observer = self.observers[i]
            observer.update(measured, self.observer_filter, self.sample_time)
            velocities[i] = observer.velocity
        observation = stage.observation.copy()
        if stage.at_stop():
            # An encoder reads on beyond its stop.
            return np.clip(observation, self.lowest, self.highest), reward, True, False, {}
        return observation, reward, False, self.sample >= self.last, {}

    def measured(self) -> list[float]:
        """Measured positions of the axes, m and rad."""
        encoders = self.stage.encoders
        found: list[float] = (self.measuring @ encoders if self.rig.rotations else encoders).tolist()
        return found

    def ends(self, place: str) -> tuple[float, float]:
        """Stops of an axis or at a motor, m."""
        return self.parameters.extremes(f"{place}.stop.lower")[0], self.parameters.extremes(f"{place}.stop.upper")[1]

    def travel(self, axis: RigAxis) -> tuple[float, float]:
        """Where an axis can be, m or rad: between its stops, or what those at the motors leave."""
        if axis.stop is not None:
            return self.ends(axis.name)
        lower, upper = zip(*(self.ends(motor) for motor in self.rig.motor_names), strict=True)
        if not axis.rotation:
            return min(lower), max(upper)
        k = self.rig.axis_names.index(axis.name)
        tilt = (max(upper) - min(lower)) / (2.0 * float(np.abs(MotorPlaces.of(self.rig).gaps[:, k]).max()))
        return -tilt, tilt

    def close(self) -> None:
        self.freed()


def seconds(name: str, value: float | str) -> float:
    """A time (s); ScenarioError if it is none above zero."""
    try:
        found = parse_quantity(value, "s")
    except QuantityError as error:
        raise ScenarioError(f"{name} = {error}") from None
    if found <= 0.0:
        raise ScenarioError(f"{name} = {value!r}, expected a time above 0 s")
    return found


def whole_samples(sample_time: float | str | None, own: float) -> int:
    """Samples of the rig (s) in one of the environment; ScenarioError if they are not whole."""
    if sample_time is None:
        return 1
    ratio = seconds("sample_time", sample_time) / own
    if round(ratio) < 1 or abs(ratio - round(ratio)) > 1e-9 * ratio:
        raise ScenarioError(f"sample_time = {sample_time!r}, expected a multiple of the rig's, {own} s")
    return round(ratio)
