"""Many stages as one Gymnasium vector environment: their blocks lie side by side, and one C function steps them."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from ctypes import CDLL, POINTER, Structure, addressof, c_double, c_int64, c_void_p
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from maglev.cosim.native_blocks import Part, compile_blocks, filled_in, indented, native_parts, out_of_range
from maglev.files.arrays import Array
from maglev.files.errors import FmuError, ScenarioError, shortened
from maglev.files.side_by_side import processors
from maglev.files.units import whole_number
from maglev.fmi.block_code import c_path
from maglev.fmi.definition import Variable
from maglev.many.compiled_stage import CompiledStage
from maglev.many.environment import Due, StageEnv, positions
from maglev.many.reward import Seen

FEWEST = 32   # environments for which a thread is worth its start
NEVER = np.iinfo(np.int64).max

SOURCE = Path(__file__).with_name("stages.c")


class Batch(Structure):
    """The struct batch."""

    _fields_ = (("stages", c_void_p), ("rows", c_void_p), ("width", c_int64), ("made", c_void_p),
                ("step", c_double), ("samples", c_int64), ("refused", c_void_p), ("at_stop", c_void_p),
                ("changes", c_void_p), ("changing", c_int64))


Change = np.dtype([("stage", np.int64), ("what", np.int64), ("value", np.float64)])   # the struct change


def stage_sources(stage: CompiledStage, changing: Sequence[tuple[str, str]]) -> dict[str, str]:
    """Return C files by name, with the changeable inputs by part and name; FmuError for an FMU of another installation.
    """
    collected = native_parts(stage.parts.values())
    if collected is None:
        raise FmuError("expected native FMUs of this installation")
    files, by_fmu = collected
    parts: dict[str, Part] = {name: by_fmu[id(fmu)] for name, fmu in stage.parts.items()}

    def variable(part: str, name: str) -> Variable:
        return next(known for known in parts[part].variables if known.name == name)

    def value(part: str, name: str) -> str:
        return f"stage->{part}.{c_path(variable(part, name).place)}"

    lines, wrong = [], ["false"]
    for verb, part, names, where in stage.exchanges:
        if verb == "step":
            time = "(double)(k + 1) * step" if where == "end" else "time"
            lines.append(f"wrong = wrong || {parts[part].step}(&stage->{part}, {time}, step) != 0;")
        for i, name in enumerate(names):
            other = value(where, name) if isinstance(where, str) else f"row[{where + i}]"
            if verb == "Get":
                lines.append(f"{other} = {value(part, name)};")
                continue
            lines.append(f"{value(part, name)} = {other};")
            if isinstance(where, int) and where + i < stage.commands.size:
                wrong.append(out_of_range(variable(part, name), other))
    blocks = {name: part.type for name, part in parts.items()}
    made = {
        "includes": "\n".join(f'#include "{part.header}"' for part in parts.values()),
        "members": "\n    ".join(f"{block} {name};" for name, block in blocks.items()),
        "take": "\n    ".join(f"stage->{name} = *(const {blocks[name]} *)instances[{part.number}]->state->block;"
                              for name, part in parts.items()),
        "changes": "\n        ".join(
            f"case {k}: {value(*place)} = value{' != 0' if variable(*place).boolean else ''}; break;"
            for k, place in enumerate(changing)),
        "wrong": " || ".join(wrong), "step": indented(lines, 8), "at_stop": value("plant", "at_stop")}
    return {**files, "stages.c": filled_in(SOURCE, **made)}


class StageVectorEnv(VectorEnv[Array, Array, npt.NDArray[Any]]):
    """Environments like `StageEnv`, with its options, side by side: the same episodes, bit for bit, in one step.

    Environment i has the seed `seed + i`, as in Gymnasium's own vectors. One that is done begins again in the next
    step,
    whose action it ignores (`AutoresetMode.NEXT_STEP`).

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
        compiled = self.one.compiled
        changing = [*self.one.changing()]
        self.number_of = {place: number for number, place in enumerate(changing)}
        self.c = CDLL(str(compile_blocks(stage_sources(compiled, changing)).path.absolute()))
        self.c.maglev_stage_size.restype = c_int64
        self.c.maglev_take.argtypes = [POINTER(c_void_p), c_void_p]
        self.c.maglev_advance.argtypes = [c_void_p, c_int64, c_int64]
        self.c.maglev_change.argtypes = [c_void_p]
        self.instances = (c_void_p * len(compiled.parts))(*(fmu.handle() for fmu in compiled.parts.values()))
        axes = len(self.one.stage.axes)
        self.size = int(self.c.maglev_stage_size()) // 8
        points = {"table": 0, "setpoints": self.one.references.most}.get(self.one.references.kind, 1)   # of each
        self.blocks = np.zeros((num_envs, self.size), np.int64)   # aligned as doubles are
        self.rows = np.zeros((num_envs, compiled.row.size))
        (self.commands, _, self.positions, self.currents, self.encoders, self.velocities,
         self.references) = np.split(self.rows, compiled.ends, axis=1)
        self.observations = self.rows[:, compiled.ends[3]:]
        self.made, self.refused, self.at_stop = (np.zeros(num_envs, np.int64) for _ in range(3))
        self.filtered = np.zeros((num_envs, axes))    # positions, of the velocity observers
        # Those of a table are one for all.
        self.points = np.zeros((num_envs, points, axes)) if points else self.one.references.given
        self.amplitudes = np.zeros((num_envs, axes))
        self.everyone = np.arange(num_envs)
        self.clipped = np.zeros(num_envs, bool)       # whose observations are within the space by force
        self.sample = np.zeros(num_envs, np.int64)    # of the environment
        self.over = np.zeros(num_envs, bool)
        self.due: list[list[Due]] = [[] for _ in range(num_envs)]
        self.next_due = np.full(num_envs, NEVER)      # samples at which something changes
        self.generators: list[np.random.Generator | None] = [None] * num_envs
        self.batch = Batch(
            self.blocks.ctypes.data, self.rows.ctypes.data, compiled.row.size, self.made.ctypes.data,
            self.one.stage.sample_time, self.one.samples, self.refused.ctypes.data, self.at_stop.ctypes.data)
        count = max(1, min(processors(threads, "threads"), num_envs // FEWEST))
        self.shares = [(num_envs * i // count, num_envs * (i + 1) // count) for i in range(count)]
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
        return np.where(self.clipped[:, None], np.clip(self.observations, self.one.lowest, self.one.highest),
                        self.observations), self.told(begun)

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
        blocks = np.empty((len(seeds), self.size), np.int64)
        starts: list[tuple[Array, ...]] = []
        for k, (i, seed) in enumerate(seeds.items()):
            if seed is None:
                one.np_random = self.generators[i] or np.random.default_rng()   # continues
            _, infos[i] = one.reset(seed=seed, options=options)
            self.generators[i] = one.np_random
            self.c.maglev_take(self.instances, blocks[k].ctypes.data)
            points, amplitudes = one.episode
            starts.append((one.compiled.row.copy(), np.array([observer.position for observer in one.observers]),
                           amplitudes, points))
            self.due[i] = [*one.due]
            self.next_due[i] = self.due[i][-1].sample if self.due[i] else NEVER
        numbers = [*seeds]
        arrays = [self.rows, self.filtered, self.amplitudes]
        if self.points.ndim == 3:
            arrays.append(self.points)
        for array, given in zip((self.blocks, *arrays), (blocks, *map(np.array, zip(*starts, strict=True))),
                                strict=False):
            array[numbers] = given
        self.made[numbers] = self.sample[numbers] = 0
        self.clipped[numbers] = False
        self.over[numbers] = False
        return infos

    def change(self) -> None:
        """Make the changes that are due."""
        made = []
        for i in np.flatnonzero(self.next_due <= self.sample).tolist():
            due = self.due[i]
            while due and due[-1].sample <= self.sample[i]:
                _, part, name, value = due.pop()
                made.append((i, self.number_of[part, name], value))
            self.next_due[i] = due[-1].sample if due else NEVER
        if made:
            changes = np.array(made, Change)
            self.batch.changes, self.batch.changing = changes.ctypes.data, len(made)
            self.c.maglev_change(addressof(self.batch))

    def step(self, actions: Array) -> tuple[Array, npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any],
                                            dict[str, Any]]:
        """Hold the currents (A) of actions, shape (num_envs, currents), for a sample."""
        one = self.one
        if self.generators[0] is None:
            raise gymnasium.error.ResetNeeded("step() before reset(), expected an episode to have begun")
        actions = np.asarray(actions, np.float64)
        if actions.shape != self.commands.shape:
            raise ScenarioError(f"actions of shape {actions.shape}, expected {self.commands.shape}: for each "
                                "environment the currents (A) of the action space")
        begun = np.flatnonzero(self.over)
        self.commands[:] = actions
        self.change()
        self.advance()
        refused, at_stop = self.refused != 0, self.at_stop != 0
        self.sample += ~refused
        sample = np.minimum(self.sample, one.last)
        which, wave = one.references.which[sample], one.references.wave[sample]
        points = self.points[which] if self.points.ndim == 2 else self.points[self.everyone, which]
        taken = ~refused
        self.references[:] = np.where(taken[:, None], points + wave[:, None] * self.amplitudes, self.references)
        self.observe(taken)
        observations = self.observations.copy()
        crashed = at_stop & ~refused
        reward, terms = one.reward.of(Seen(self.positions.T, self.references.T, self.velocities.T, self.currents.T,
                                           crashed))
        rewards = np.where(taken, reward, 0.0)
        self.clipped[:] = crashed if one.compiled.measurement is None else taken
        if one.compiled.measurement is not None or crashed.any():
            observations = np.where(self.clipped[:, None], np.clip(observations, one.lowest, one.highest),
                                    observations)
        terminated, truncated = crashed | refused, ~crashed & ~refused & (self.sample >= one.last)
        infos: dict[int, dict[str, Any]] = {int(i): {"refused": self.why(actions[i])} for i in
                                            np.flatnonzero(refused & ~self.over).tolist()}
        going = ~refused
        if len(begun):
            infos |= self.begin(dict.fromkeys(begun.tolist()))
            observations[begun], rewards[begun] = self.observations[begun], 0.0
            terminated[begun] = truncated[begun] = going[begun] = False
        self.over = terminated | truncated
        told = self.told(infos)
        if terms:
            for name, values in terms.items():
                told |= {name: np.where(going, values, 0.0), f"_{name}": going.copy()}
        return observations, rewards, terminated, truncated, told

    def advance(self) -> None:
        """Step all stages, those that are over as well: they begin again."""
        def share(ends: tuple[int, int]) -> None:
            self.c.maglev_advance(addressof(self.batch), *ends)

        for _ in map(share, self.shares) if self.pool is None else self.pool.map(share, self.shares):
            pass

    def observe(self, chosen: Any) -> None:
        """Velocities of the chosen environments, as `VelocityObserver` has them."""
        one = self.one
        shares = one.observer_filter
        for k, of_axis in enumerate(positions(one.measuring, self.encoders.T)):
            change = shares.share1 * (of_axis - self.filtered[:, k])
            velocity = self.velocities[:, k]
            self.filtered[:, k] = np.where(chosen, self.filtered[:, k] + change, self.filtered[:, k])
            velocity[:] = np.where(chosen, velocity + shares.share2 * (change / one.sample_time - velocity), velocity)

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
