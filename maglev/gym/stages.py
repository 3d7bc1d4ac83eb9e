"""Many stages as one Gymnasium vector environment: their blocks lie side by side, and one C function steps them."""

from collections.abc import Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from ctypes import CDLL, POINTER, c_double, c_int64, c_void_p
from typing import Any

import gymnasium
import numpy as np
import numpy.typing as npt
from gymnasium.vector import AutoresetMode, VectorEnv
from gymnasium.vector.utils import batch_space

from fmi_export.definition import Variable
from maglev.arrays import Array
from maglev.cosim.blocks.block_loop import Part, indented, loop_of, out_of_range, parts_of
from maglev.errors import FmuError, ScenarioError
from maglev.gym.compiled_stage import CompiledStage
from maglev.gym.reward import Seen
from maglev.gym.stage import Due, Stage, positions
from maglev.processes import processors
from maglev.schema.options import formerly

FEWEST = 32   # environments for which a thread is worth its start
NEVER = np.iinfo(np.int64).max

SOURCE = """\
#include "instance.h"
{includes}

#if defined _WIN32
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

/* The blocks of one stage. */
struct stage {{
    {members}
}};

EXPORT int64_t maglev_stage_size(void);
int64_t maglev_stage_size(void) {{ return (int64_t)sizeof(struct stage); }}

/* Take over the blocks of instances that have just been started. */
EXPORT void maglev_take(struct Instance *const *instances, struct stage *stage);
void maglev_take(struct Instance *const *instances, struct stage *stage)
{{
    {take}
}}

/* Give an input or a parameter of a stage another value; it is one of the list that is made with this. */
EXPORT void maglev_change(struct stage *stage, int64_t what, double value);
void maglev_change(struct stage *stage, int64_t what, double value)
{{
    switch (what) {{
    {changes}
    default: break;
    }}
}}

/* Go on by samples with stages first to before last, from the numbers of samples that they have made on; each has a row
   as compiled_stage.py says. A stage that refuses a command says so, and stays as it was. */
EXPORT void maglev_advance(struct stage *stages, double *rows, int64_t width, const int64_t *made, double step,
                           int64_t samples, int64_t first, int64_t last, int64_t *refused, int64_t *at_stop);
void maglev_advance(struct stage *stages, double *rows, int64_t width, const int64_t *made, double step,
                    int64_t samples, int64_t first, int64_t last, int64_t *refused, int64_t *at_stop)
{{
    for (int64_t i = first; i < last; ++i) {{
        struct stage *const stage = &stages[i];
        double *const row = rows + i * width;
        bool wrong = {wrong};
        for (int64_t k = made[i]; !wrong && k < made[i] + samples; ++k) {{
            const double time = (double)k * step;
{step}
        }}
        refused[i] = wrong;
        at_stop[i] = {at_stop};
    }}
}}
"""


def sources_of(stage: CompiledStage, changing: Sequence[tuple[str, str]]) -> dict[str, str]:
    """C files by name; FmuError where an FMU is none of this installation.

    `changing` are parts and names of what can change in an episode.
    """
    collected = parts_of(stage.parts.values())
    if collected is None:
        raise FmuError("expected native FMUs of this installation")
    files, by_fmu = collected
    parts: dict[str, Part] = {name: by_fmu[id(fmu)] for name, fmu in stage.parts.items()}

    def variable(part: str, name: str) -> Variable:
        return next(known for known in parts[part].what.variables if known.name == name)

    def value(part: str, name: str) -> str:
        return f"stage->{part}.{variable(part, name).place}"

    lines, wrong = [], ["false"]
    for verb, part, names, where in stage.exchanges:
        if verb == "step":
            time = "(double)(k + 1) * step" if where == "end" else "time"
            lines.append(f"wrong = wrong || {parts[part].what.struct}__step(&stage->{part}, {time}, step) != 0;")
        for i, name in enumerate(names):
            other = value(where, name) if isinstance(where, str) else f"row[{where + i}]"
            if verb == "Get":
                lines.append(f"{other} = {value(part, name)};")
                continue
            lines.append(f"{value(part, name)} = {other};")
            if isinstance(where, int) and where + i < stage.commands.size:
                wrong.append(out_of_range(variable(part, name), other))
    blocks = {name: part.what.struct for name, part in parts.items()}
    return {**files, "stages.c": SOURCE.format(
        includes="\n".join(f'#include "{part.what.header}"' for part in parts.values()),
        members="\n    ".join(f"struct {block} {name};" for name, block in blocks.items()),
        take="\n    ".join(f"stage->{name} = *(const struct {blocks[name]} *)instances[{part.number}]->state->block;"
                           for name, part in parts.items()),
        changes="\n    ".join(f"case {k}: {value(*place)} = value{' != 0' if variable(*place).boolean else ''}; break;"
                              for k, place in enumerate(changing)),
        wrong=" || ".join(wrong), step=indented(lines, 12), at_stop=value("plant", "at_stop"))}


class Stages(VectorEnv[Array, Array, npt.NDArray[Any]]):
    """Environments like `Stage`, with its options, side by side: the same episodes, bit for bit, in one step.

    Environment i has the seed `seed + i`, as in Gymnasium's own vectors. One that is done begins anew in the next step,
    whose action it ignores (`AutoresetMode.NEXT_STEP`).

    Parameters
    ----------
    num_envs : int
    rig, **options
        As of `Stage`.
    threads : int, optional
        As many as processors if not given.

    Raises
    ------
    MaglevError
        If an option cannot be used, or there is no compiler for the loop, which is kept in the user's cache.
    """

    metadata: dict[str, Any] = {"autoreset_mode": AutoresetMode.NEXT_STEP}

    @formerly(stage="rig")
    def __init__(self, num_envs: int, stage: str, threads: int | None = None, **options: Any):
        if num_envs < 1:
            raise ScenarioError(f"num_envs = {num_envs}, expected at least 1")
        self.one = Stage(stage, **options)   # begins every episode
        self.num_envs = num_envs
        self.single_action_space: gymnasium.Space[Any] = self.one.action_space
        self.single_observation_space: gymnasium.Space[Any] = self.one.observation_space
        self.action_space = batch_space(self.one.action_space, num_envs)
        self.observation_space = batch_space(self.one.observation_space, num_envs)
        compiled = self.one.stage
        changing = [*self.one.changing()]
        self.number_of = {place: number for number, place in enumerate(changing)}
        library = loop_of(sources_of(compiled, changing), build=True)
        assert library is not None
        self.c = CDLL(str(library.path.absolute()))
        self.c.maglev_stage_size.restype = c_int64
        self.c.maglev_take.argtypes = [POINTER(c_void_p), c_void_p]
        self.c.maglev_change.argtypes = [c_void_p, c_int64, c_double]
        self.c.maglev_advance.argtypes = [c_void_p, c_void_p, c_int64, c_void_p, c_double, c_int64, c_int64, c_int64,
                                          c_void_p, c_void_p]
        self.instances = (c_void_p * len(compiled.parts))(*(fmu.handle() for fmu in compiled.parts.values()))
        size = int(self.c.maglev_stage_size())
        self.blocks = np.zeros((num_envs, size // 8), np.int64)   # aligned as doubles are
        self.rows = np.zeros((num_envs, compiled.row.size))
        axes = len(self.one.rig.axes)
        (self.commands, _, self.positions, self.currents, self.encoders, self.velocities,
         self.references) = np.split(self.rows, compiled.ends, axis=1)
        self.observations = self.rows[:, compiled.ends[3]:]
        self.made = np.zeros(num_envs, np.int64)      # samples of the rig
        self.sample = np.zeros(num_envs, np.int64)    # of the environment
        self.refused, self.at_stop = np.zeros(num_envs, np.int64), np.zeros(num_envs, np.int64)
        self.over = np.zeros(num_envs, bool)
        self.due: list[list[Due]] = [[] for _ in range(num_envs)]
        self.next_due = np.full(num_envs, NEVER)      # samples at which something changes
        self.filtered = np.zeros((num_envs, axes))    # positions, of the velocity observers
        # Those of a table are one for all.
        self.points = np.zeros((0 if self.one.references.kind == "table" else num_envs,
                                self.one.references.most if self.one.references.kind == "setpoints" else 1, axes))
        self.everyone = np.arange(num_envs)
        self.amplitudes = np.zeros((num_envs, axes))
        self.generators: list[np.random.Generator | None] = [None] * num_envs
        count = max(1, min(processors(threads, "threads"), num_envs // FEWEST))
        self.shares = [(num_envs * i // count, num_envs * (i + 1) // count) for i in range(count)]
        self.pool = ThreadPoolExecutor(count) if count > 1 else None

    def reset(self, *, seed: int | Sequence[int | None] | None = None,
              options: dict[str, Any] | None = None) -> tuple[Array, dict[str, Any]]:
        """Begin an episode everywhere; `info["parameters"]` has the parameters of each environment."""
        seeds = [None if seed is None else seed + i for i in range(self.num_envs)] \
            if seed is None or isinstance(seed, int) else list(seed)
        if len(seeds) != self.num_envs:
            raise ScenarioError(f"seed: {len(seeds)} of them, expected {self.num_envs}")
        drawn = {i: self.begin(i, seed, options) for i, seed in enumerate(seeds)}
        return self.observations.copy(), self.told(drawn)

    def begin(self, i: int, seed: int | None, options: dict[str, Any] | None = None) -> dict[str, Any]:
        """Begin an episode of an environment; what `Stage.reset` tells of it."""
        one = self.one
        if seed is None and self.generators[i] is not None:
            one.np_random = self.generators[i]   # type: ignore[assignment]  # goes on
        elif seed is None:
            one.np_random = np.random.default_rng()
        _, info = one.reset(seed=seed, options=options)
        self.generators[i] = one.np_random
        self.c.maglev_take(self.instances, self.blocks[i].ctypes.data)
        self.rows[i] = one.stage.row
        points, self.amplitudes[i] = one.episode
        if len(self.points):
            self.points[i] = points
        self.filtered[i] = [observer.position for observer in one.observers]
        self.made[i] = self.sample[i] = 0
        self.over[i] = False
        self.due[i] = [*one.due]
        self.next_due[i] = self.due[i][-1].sample if self.due[i] else NEVER
        return info

    def change(self, i: int) -> None:
        due = self.due[i]
        while due and due[-1].sample <= self.sample[i]:
            _, part, name, value = due.pop()
            self.c.maglev_change(self.blocks[i].ctypes.data, self.number_of[part, name], value)
        self.next_due[i] = due[-1].sample if due else NEVER

    def step(self, actions: Array) -> tuple[Array, npt.NDArray[Any], npt.NDArray[Any], npt.NDArray[Any],
                                            dict[str, Any]]:
        """Hold the currents (A) of actions, shape (num_envs, currents), for a sample."""
        actions = np.asarray(actions, np.float64)
        if actions.shape != self.commands.shape:
            raise ScenarioError(f"actions of shape {actions.shape}, expected {self.commands.shape}: for each "
                                "environment the currents (A) of the action space")
        one, begun = self.one, np.flatnonzero(self.over)
        self.commands[:] = actions
        for i in np.flatnonzero(self.next_due <= self.sample).tolist():
            self.change(i)
        self.advance()
        refused = self.refused != 0
        self.made += one.samples
        self.sample += ~refused
        sample = np.minimum(self.sample, one.last)
        which, wave = one.references.which[sample], one.references.wave[sample]
        points = self.points[self.everyone, which] if len(self.points) else one.references.given[which]
        np.copyto(self.references, points + wave[:, None] * self.amplitudes, where=~refused[:, None])
        self.observe(~refused)
        observations = self.observations.copy()
        crashed = (self.at_stop != 0) & ~refused
        reward, terms = one.reward.of(Seen(self.positions.T, self.references.T, self.velocities.T, self.currents.T,
                                           crashed))
        rewards = np.where(refused, 0.0, reward)
        clipped = ~refused if one.stage.measurement is not None else crashed
        observations[clipped] = np.clip(observations[clipped], one.lowest, one.highest)
        terminated, truncated = crashed | refused, ~crashed & ~refused & (self.sample >= one.last)
        infos: dict[int, dict[str, Any]] = {int(i): {"refused": self.why(actions[i])} for i in np.flatnonzero(
            refused & ~self.over)}
        for i in begun.tolist():
            infos[i] = self.begin(i, None)
            observations[i], rewards[i] = self.observations[i], 0.0
            terminated[i] = truncated[i] = False
        self.over = terminated | truncated
        going = ~refused
        going[begun] = False
        told = self.told(infos)
        for name, values in terms.items():
            told |= {name: np.where(going, values, 0.0), f"_{name}": going.copy()}
        return observations, rewards, terminated, truncated, told

    def advance(self) -> None:
        """Step all stages, those that are over as well: they begin anew."""
        def share(ends: tuple[int, int]) -> None:
            self.c.maglev_advance(self.blocks.ctypes.data, self.rows.ctypes.data, self.rows.shape[1],
                                  self.made.ctypes.data, self.one.rig.sample_time, self.one.samples, *ends,
                                  self.refused.ctypes.data, self.at_stop.ctypes.data)

        for _ in map(share, self.shares) if self.pool is None else self.pool.map(share, self.shares):
            pass

    def observe(self, chosen: npt.NDArray[np.bool_]) -> None:
        """Velocities of the chosen environments, as `VelocityObserver` has them."""
        one = self.one
        shares = one.observer_filter
        measured = positions(one.measuring if one.rig.rotations else None, self.encoders.T)
        for k, of_axis in enumerate(measured):
            change = shares.share1 * (of_axis - self.filtered[:, k])
            velocity = self.velocities[:, k]
            self.filtered[:, k] = np.where(chosen, self.filtered[:, k] + change, self.filtered[:, k])
            velocity[:] = np.where(chosen, velocity + shares.share2 * (change / one.sample_time - velocity), velocity)

    def why(self, action: Array) -> str:
        """What an FMU says of an action that is refused."""
        stage = self.one.stage
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
