"""Many stages as one Gymnasium vector environment: their blocks are in lanes, which one C function steps."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from maglev.cosim.lane_loop import DONE, Varied, lane_loop
from maglev.cosim.wiring import Wiring, wire
from maglev.files.arrays import Array
from maglev.files.errors import FmuError, ScenarioError, shortened
from maglev.files.side_by_side import processors
from maglev.files.units import whole_number
from maglev.many.compiled_stage import CompiledStage
from maglev.many.environment import Due, StageEnv, positions
from maglev.many.reward import Seen

FEWEST = 32   # environments for which a thread is worth its start
NEVER = np.iinfo(np.int64).max


def wiring_of(stage: CompiledStage, points: int) -> tuple[Wiring, list[str]]:
    """Return the FMUs of a stage as a co-simulation over communication points, and its outputs.

    The outputs are the flag of the stops, the positions, the delivered currents, and the encoders.
    """
    fmus = {fmu.name: fmu for part in dict.fromkeys(each.part for each in stage.exchanges)
            for fmu in [stage.parts[part]]}
    row: dict[int, str] = {}   # source of each number of the row
    connections: list[tuple[str, str]] = []
    drives: dict[str, Array] = {}
    for verb, part, names, where in stage.exchanges:
        if verb == "Get" and isinstance(where, int):
            row |= {where + i: f"{stage.parts[part].name}.{name}" for i, name in enumerate(names)}
    for verb, part, names, where in stage.exchanges:
        for i, name in enumerate(names if verb == "Set" else ()):
            target = f"{stage.parts[part].name}.{name}"
            source = f"{stage.parts[where].name}.{name}" if isinstance(where, str) else row.get(where + i)
            if source is None:
                drives[target] = np.zeros(points)
            else:
                connections.append((source, target))
    outputs = [row[i] for i in range(stage.ends[1], stage.ends[4])]
    return wire(fmus, connections, drives, points, stage.step.value), [f"{stage.plant.name}.at_stop", *outputs]


class StageVectorEnv(VectorEnv[Array, Array, npt.NDArray[Any]]):
    """Environments like `StageEnv`, with its options, side by side: the same episodes, bit for bit, in one step.

    Environment i has the seed `seed + i`, as in Gymnasium's own vectors. One that is done begins again in the next
    step, whose action it ignores (`AutoresetMode.NEXT_STEP`).

    Parameters
    ----------
    num_envs : int
    stage, **options
        As of `StageEnv`.
    threads : int, optional
        As many as processors if not given.

    Raises
    ------
    MaglevError
        If an option cannot be used, or there is no compiler for the loop, which is kept in the user's cache.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP}

    def __init__(self, num_envs: int, stage: str | Path, threads: int | None = None, **options: Any):
        num_envs = whole_number(num_envs, ScenarioError, "num_envs")
        self.one = StageEnv(stage, **options)   # begins every episode
        self.num_envs = num_envs
        self.single_action_space: gymnasium.Space[Any] = self.one.action_space
        self.single_observation_space: gymnasium.Space[Any] = self.one.observation_space
        self.action_space = batch_space(self.one.action_space, num_envs)
        self.observation_space = batch_space(self.one.observation_space, num_envs)
        one, compiled = self.one, self.one.compiled
        self.wiring, outputs = wiring_of(compiled, one.samples + 1)
        changing = {f"{compiled.parts[part].name}.{name}": (part, name) for part, name in one.changing()}
        self.number_of = {place: number for number, place in enumerate(changing.values())}
        given = {"plant": one.parameters, "measurement": one.measurement}
        varied = {f"{fmu.name}.{name}" for part, fmu in compiled.parts.items() if part in given
                  for name in given[part].known}
        loop = lane_loop(self.wiring, outputs, (), Varied(frozenset(varied), True, True), build=True,
                         changing=[*changing])
        if loop is None:
            raise FmuError("expected native FMUs of this installation")
        self.loop = loop
        groups = -(-num_envs // loop.width)
        self.taken = loop.begin(groups)
        self.seen = np.zeros((groups, one.samples + 1, len(outputs), loop.width))
        self.sizes = np.zeros((groups, 0, 2, loop.width))
        self.commands, = self.taken.signals.values()   # shape (lanes, currents, points)
        # Rows for each environment: outputs, velocities, references.
        axes = len(one.stage.axes)
        self.rows = np.zeros((len(outputs) + 2 * axes, num_envs))
        self.outputs = self.rows[:len(outputs)]
        ends = np.cumsum([1, axes, len(compiled.currents), len(compiled.encoders), axes])
        (self.at_stop,), self.positions, self.currents, self.encoders, self.velocities, self.references = np.split(
            self.rows, ends)
        self.observed = self.rows[ends[2]:]
        points = {"table": 0, "setpoints": one.references.most}.get(one.references.kind, 1)   # of each
        self.filtered = np.zeros((axes, num_envs))    # positions, of the velocity observers
        # A table has the same values for all.
        self.points = np.zeros((axes, num_envs, points)) if points else one.references.given.T
        self.amplitudes = np.zeros((axes, num_envs))
        self.everyone = np.arange(num_envs)
        self.clipped = np.zeros(num_envs, bool)       # whose observations are within the space by force
        self.sample = np.zeros(num_envs, np.int64)    # of the environment
        self.over = np.zeros(num_envs, bool)
        self.due: list[list[Due]] = [[] for _ in range(num_envs)]
        self.next_due = np.full(num_envs, NEVER)      # samples at which something changes
        self.generators: list[np.random.Generator | None] = [None] * num_envs
        count = max(1, min(processors(threads, "threads"), num_envs // FEWEST))
        self.shares = [slice(groups * i // count, groups * (i + 1) // count) for i in range(count)]
        self.pool = ThreadPoolExecutor(count) if count > 1 else None

    def reset(self, *, seed: int | Sequence[int | None] | None = None,
              options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin an episode everywhere; `info["parameters"]` has the parameters of each environment.

        With Gymnasium's option `reset_mask`, Booleans of shape (num_envs,), only the chosen ones begin again.
        """
        seeds = [None if seed is None else seed + i for i in range(self.num_envs)] \
            if seed is None or isinstance(seed, int) else list(seed)
        if len(seeds) != self.num_envs:
            raise ScenarioError(f"seed: {len(seeds)} of them, expected {self.num_envs}")
        others = {**(options or {})}
        chosen = self.chosen(others.pop("reset_mask")) if "reset_mask" in others else range(self.num_envs)
        begun = self.begin({i: seeds[i] for i in chosen}, others)
        return self.observations(), self.told(begun)

    def chosen(self, mask: Any) -> list[int]:
        """Environments of a mask."""
        which = np.asarray(mask)
        if which.dtype != bool or which.shape != (self.num_envs,) or not which.any():
            raise ScenarioError(f"reset_mask = {shortened(mask)}, expected {self.num_envs} Booleans, one of them True")
        if self.generators[0] is None:
            raise gymnasium.error.ResetNeeded("reset_mask before reset(), expected an episode to have begun everywhere")
        chosen: list[int] = np.flatnonzero(which).tolist()
        return chosen

    def begin(self, seeds: Mapping[int, int | None],
              options: dict[str, Any] | None = None) -> dict[int, dict[str, Any]]:
        """Begin an episode of environments, by number; return the `StageEnv.reset` infos of each."""
        one, infos = self.one, {}
        row = one.compiled.row
        _, _, positions, currents, encoders, velocities, references = np.split(row, one.compiled.ends)
        for i, seed in seeds.items():
            if seed is None:
                one.np_random = self.generators[i] or np.random.default_rng()   # continues
            _, infos[i] = one.reset(seed=seed, options=options)
            self.generators[i] = one.np_random
            for call in self.wiring.initial:
                call.at(0)
            status = self.loop.take(self.taken, i)
            assert status == DONE, "lanes differ in all that can differ"
            points, self.amplitudes[:, i] = one.episode
            if self.points.ndim == 3:
                self.points[:, i] = points.T
            self.rows[:, i] = np.concatenate([[0.0], positions, currents, encoders, velocities, references])
            self.filtered[:, i] = [observer.position for observer in one.observers]
            self.due[i] = [*one.due]
            self.next_due[i] = self.due[i][-1].sample if self.due[i] else NEVER
        numbers = [*seeds]
        self.sample[numbers] = 0
        self.clipped[numbers] = False
        self.over[numbers] = False
        return infos

    def change(self) -> None:
        """Make the changes that are due."""
        for i in np.flatnonzero(self.next_due <= self.sample).tolist():
            due = self.due[i]
            while due and due[-1].sample <= self.sample[i]:
                _, part, name, value = due.pop()
                self.loop.change(self.taken, i, self.number_of[part, name], value)
            self.next_due[i] = due[-1].sample if due else NEVER

    def step(self, actions: Array) -> tuple[Array, npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any],
                                            dict[str, Any]]:
        """Hold the currents (A) of actions, shape (num_envs, currents), for a sample."""
        one = self.one
        if self.generators[0] is None:
            raise gymnasium.error.ResetNeeded("step() before reset(), expected an episode to have begun")
        actions = np.asarray(actions, np.float64)
        if actions.shape != self.action_space.shape:
            raise ScenarioError(f"actions of shape {actions.shape}, expected {self.action_space.shape}: for each "
                                "environment the currents (A) of the action space")
        begun = np.flatnonzero(self.over)
        for k in range(one.samples):
            self.commands[:self.num_envs, :, k] = actions
        self.change()
        taken = self.advance()
        refused, crashed = ~taken, taken & (self.at_stop != 0.0)
        self.sample += taken
        sample = np.minimum(self.sample, one.last)
        which, wave = one.references.which[sample], one.references.wave[sample]
        points = self.points[:, which] if self.points.ndim == 2 else self.points[:, self.everyone, which]
        np.copyto(self.references, points + wave * self.amplitudes, where=taken)
        self.observe(taken)
        reward, terms = one.reward.of(Seen(self.positions, self.references, self.velocities, self.currents, crashed))
        rewards = np.where(taken, reward, 0.0)
        self.clipped[:] = crashed if one.compiled.measurement is None else taken
        observations = self.observations()
        terminated, truncated = crashed | refused, ~crashed & taken & (self.sample >= one.last)
        infos: dict[int, dict[str, Any]] = {int(i): {"refused": self.why(actions[i])} for i in
                                            np.flatnonzero(refused & ~self.over).tolist()}
        going = taken
        if len(begun):
            infos |= self.begin(dict.fromkeys(begun.tolist()))
            observations[begun], rewards[begun] = self.observed[:, begun].T, 0.0
            terminated[begun] = truncated[begun] = going[begun] = False
        self.over = terminated | truncated
        told = self.told(infos)
        if terms:
            for name, values in terms.items():
                told |= {name: np.where(going, values, 0.0), f"_{name}": going.copy()}
        return observations, rewards, terminated, truncated, told

    def advance(self) -> npt.NDArray[np.bool_]:
        """Step all stages, those that are over as well: they begin again. Return True for each that was not refused."""
        def share(groups: slice) -> None:
            self.loop.run(self.taken, 0, self.one.samples, self.seen[groups], self.sizes[groups], groups.start)

        for _ in map(share, self.shares) if self.pool is None else self.pool.map(share, self.shares):
            pass
        taken: npt.NDArray[np.bool_] = self.taken.status[:self.num_envs] == DONE
        outputs = self.seen[:, -1].swapaxes(0, 1).reshape(len(self.outputs), -1)[:, :self.num_envs]
        np.copyto(self.outputs, outputs, where=taken)
        return taken

    def observations(self) -> Array:
        """Return encoders, velocities and references, shape (num_envs, …), within the space where they are clipped."""
        observed = self.observed.T.copy()
        if self.clipped.any():
            return np.where(self.clipped[:, None], np.clip(observed, self.one.lowest, self.one.highest), observed)
        return observed

    def observe(self, chosen: Any) -> None:
        """Velocities of the chosen environments, as `VelocityObserver` has them."""
        shares, sample_time = self.one.observer_filter, self.one.sample_time
        change = shares.share1 * (np.array(positions(self.one.measuring, self.encoders)) - self.filtered)
        np.add(self.filtered, change, out=self.filtered, where=chosen)
        velocities = self.velocities + shares.share2 * (change / sample_time - self.velocities)
        np.copyto(self.velocities, velocities, where=chosen)

    def why(self, action: Array) -> str:
        """Return the message of an FMU that failed on an action."""
        stage = self.one.compiled
        stage.start({}, self.one.peak, {})
        stage.commands[:] = action
        return "" if stage.advance(1) else stage.said()

    def told(self, infos: Mapping[int, Mapping[str, Any]]) -> dict[str, Any]:
        """Infos of environments as those of Gymnasium's vectors."""
        all_infos: dict[str, Any] = {}
        for i, info in infos.items():
            all_infos = self._add_info(all_infos, dict(info), i)
        return all_infos

    def close_extras(self, **_: Any) -> None:
        if self.pool is not None:
            self.pool.shutdown()
        self.one.close()
