"""Train a small agent, with NumPy only, that levitates the 2-DOF stage and moves it to setpoints.

The first agent is linear: each current is a weighted sum of errors, their integrals, velocities and a constant. The
second adds a network, whose hidden units see errors, velocities and the gap. The cross-entropy method searches the
weights: it tries many, keeps the best, and draws the next generation around them. One vector environment runs all
candidates of a generation. The result is a controller file:

    python gym_levitate.py
    maglev compare 2dof-setpoints --controller Regulator2DOF --controller learned.py
"""

import argparse
from pathlib import Path
from time import perf_counter
from typing import Any

import gymnasium
import numpy as np
from jinja2 import Template

import maglev.gym  # noqa: F401 - registers the environments

SAMPLE_TIME = 2e-3     # s, four samples of the stage
TRAINING = {"sample_time": SAMPLE_TIME, "duration": 1.0, "reference": "setpoints",
            "reward": {"alive": 1.0, "error": -10.0, "current": -0.1},
            "parameters": {"v.position_start": ("13 mm", "24 mm"), "h.position_start": ("-5 mm", "5 mm")}}

CANDIDATES = 64        # in a generation; twice as many for a network
BEST = 8               # the best of this many candidates draws the next generation
EPISODES = 3           # for each candidate, equal for all of a generation

# Meaning of a weight of 1: the current (A) for an error of 1 m, 1 m s, a speed of 1 m/s, and always. i_d lifts and i_q
# drives; each depends on its own axis.
SCALES = np.array([[500.0, 500.0, 20.0, 1.0], [50.0, 50.0, 5.0, 1.0]])
LINEAR = SCALES.size

# A unit of the network sums the error (m) and speed (m/s) of v, the error of h, the gap (m) and one, with weights in
# units of these. It gives x / (1 + |x|) of the sum to both currents, with weights in A.
INPUT_SCALES = np.array([500.0, 10.0, 500.0, 250.0, 1.0])
MIDDLE = 18e-3         # m, from which a unit takes the gap
OUTPUT_SCALE = 4.0     # A
UNIT = len(INPUT_SCALES) + 2

CONTROLLER = Path(__file__).with_name("gym_learned.py.j2")   # template of an agent's file


def agent_currents(weights: np.ndarray, parts: np.ndarray, gaps: np.ndarray) -> np.ndarray:
    """Currents (A) of agents, shape (environments, 2).

    `weights` has a row for each; `parts`, shape (environments, 2, 4), errors, their sums, velocities and one by axis.
    """
    linear = (weights[:, :LINEAR].reshape(-1, 2, 4) * SCALES * parts).sum(axis=2)
    units = weights[:, LINEAR:].reshape(len(weights), -1, UNIT)
    taken = INPUT_SCALES * np.stack([parts[:, 0, 0], parts[:, 0, 2], parts[:, 1, 0], gaps - MIDDLE, parts[:, 0, 3]], 1)
    total = (units[:, :, :-2] * taken[:, None]).sum(axis=2)
    return linear + OUTPUT_SCALE * (units[:, :, -2:] * (total / (1.0 + np.abs(total)))[:, :, None]).sum(axis=1)


def run_episodes(envs: Any, weights: np.ndarray, seeds: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """An episode in each environment, with weights of shape (environments, weights).

    Returns of the episodes, their errors (m), shape (samples, environments, 2), and whether they ended at a stop.
    """
    observations, _ = envs.reset(seed=seeds)
    parts = np.ones((len(weights), 2, 4))
    sums = np.zeros((len(weights), 2))   # m s
    returns, crashed, going = np.zeros(len(weights)), np.zeros(len(weights), bool), np.ones(len(weights), bool)
    errors = []
    while going.any():
        parts[:, :, 0] = observations[:, 4:] - observations[:, :2]   # positions, velocities, references
        sums += SAMPLE_TIME * parts[:, :, 0]
        parts[:, :, 1], parts[:, :, 2] = sums, observations[:, 2:4]
        # Currents beyond the peak are limited; a current beyond 1000 A would be an error.
        asked = np.clip(agent_currents(weights, parts, observations[:, 0]), -900.0, 900.0)
        observations, rewards, terminated, truncated, _ = envs.step(asked)
        returns += np.where(going, rewards, 0.0)
        crashed |= going & terminated
        going &= ~(terminated | truncated)
        errors.append(observations[:, 4:] - observations[:, :2])
    return returns, np.array(errors), crashed


def train(envs: Any, random: np.random.Generator, generations: int, mean: np.ndarray, spread: np.ndarray,
          floor: float) -> np.ndarray:
    """Weights that the cross-entropy method finds from a mean and a spread, each of shape (weights,)."""
    candidates, begin = envs.num_envs // EPISODES, perf_counter()
    for generation in range(generations):
        tried = mean + spread * random.standard_normal((candidates, mean.size))
        seeds = random.integers(2**31, size=EPISODES).tolist()
        rewards, _, _ = run_episodes(envs, np.repeat(tried, EPISODES, axis=0), seeds * candidates)
        returns = rewards.reshape(candidates, EPISODES).mean(axis=1)
        best = tried[np.argsort(returns)[-candidates // BEST:]]
        # A little more spread than that of the best, less and less of it, keeps the search from stopping too soon.
        mean, spread = best.mean(axis=0), best.std(axis=0) + floor * 0.9**generation
        print(f"generation {generation + 1:3}: best return {max(returns):6.1f}, mean {np.mean(returns):6.1f} of 500, "
              f"{perf_counter() - begin:4.1f} s", flush=True)
    return mean


def tested(envs: Any, weights: np.ndarray) -> str:
    """Evaluate an agent in episodes of 5 s, with setpoints that it has not seen."""
    count = envs.num_envs
    _, errors, crashed = run_episodes(envs, np.tile(weights, (count, 1)), list(range(1_000_000, 1_000_000 + count)))
    text = f"{(~crashed).sum()} of {count} episodes of 5 s held"
    if crashed.all():
        return text
    # Over 0.2 s; the last error of each second is already that of the next setpoint.
    late = errors[:, ~crashed].reshape(5, -1, (~crashed).sum(), 2)[:, -101:-1]
    rms = 1e3 * np.sqrt(np.mean(late**2, axis=(0, 1, 2)))
    return f"{text}; RMS error at the end of a setpoint: v {rms[0]:.3f} mm, h {rms[1]:.3f} mm"


def controller_text(weights: np.ndarray, limit: float, name: str) -> str:
    """Controller file of an agent: scales become part of its weights."""
    v, h = (", ".join(map(repr, row)) for row in (weights[:LINEAR].reshape(2, 4) * SCALES).tolist())
    units = []
    for unit in weights[LINEAR:].reshape(-1, UNIT):
        taken = unit[:-2] * INPUT_SCALES
        taken[-1] -= taken[-2] * MIDDLE
        units.append((taken.tolist(), (OUTPUT_SCALE * unit[-2:]).tolist()))
    template = Template(CONTROLLER.read_text(encoding="utf-8"), trim_blocks=True, keep_trailing_newline=True)
    return template.render(name=name, samples=4, sample_time=SAMPLE_TIME, stage_time=SAMPLE_TIME / 4, limit=limit, v=v,
                           h=h, units=units)


def main() -> None:
    """Train, run episodes of 5 s with setpoints that the agent has not seen, and write the controller."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", help="folder with the folder native, instead of FMUs that are built")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--generations", type=int, default=20, help="of the linear agent; of the network twice as many")
    parser.add_argument("--units", type=int, default=6, help="of the network; 0 ends with the linear agent")
    parser.add_argument("--out", type=Path, default=Path("learned.py"), help="controller file")
    asked = parser.parse_args()

    def stages(number: int, **options: Any) -> Any:
        return gymnasium.make_vec("maglev/Stage2DOF-v0", number, "vector_entry_point", fmus=asked.fmus,
                                  **{**TRAINING, **options})

    random, test = np.random.default_rng(asked.seed), stages(20, duration=5.0)
    limit = float(test.single_action_space.high[0])
    envs = stages(CANDIDATES * EPISODES)
    weights = train(envs, random, asked.generations, np.zeros(LINEAR), np.ones(LINEAR), 0.2)
    envs.close()
    print(f"linear: {tested(test, weights)}")
    if asked.units:
        # Small outputs at first: the network begins as the linear agent.
        spread = np.tile([*np.ones(UNIT - 2), 0.3, 0.3], asked.units)
        envs = stages(2 * CANDIDATES * EPISODES)
        weights = train(envs, random, 2 * asked.generations, np.concatenate([weights, np.zeros(spread.size)]),
                        np.concatenate([0.02 + 0.05 * np.abs(weights), spread]), 0.05)
        envs.close()
        print(f"network: {tested(test, weights)}")
    test.close()
    asked.out.write_text(controller_text(weights, limit, asked.out.name), encoding="utf-8")
    print(f"wrote {asked.out}")


if __name__ == "__main__":
    main()
