"""Train a small agent that levitates the 2-DOF stage and brings it to set-points, with nothing but NumPy.

The agent is linear: each current is a weighted sum of the errors, of what they add up to, of the velocities and of one.
Its weights are found by the cross-entropy method: try many, keep the best, draw around these the next ones.

    python gym_levitate.py
"""

import argparse
from time import perf_counter
from typing import Any

import gymnasium
import numpy as np

import maglev.gym  # noqa: F401 - registers the environments

SAMPLE_TIME = 2e-3     # s, four samples of the rig
TRAINING = {"sample_time": SAMPLE_TIME, "duration": 1.0, "reference": "setpoints", "error_weight": 10.0,
            "parameters": {"v.position_start": ("15 mm", "22 mm"), "h.position_start": ("-5 mm", "5 mm")}}

CANDIDATES = 64        # in a generation
BEST = 10              # of them draw the next one
EPISODES = 3           # for each candidate, the same for all of a generation


class Agent:
    """Linear law from an observation to i_d and i_q (A): i_d lifts and i_q drives, each looks at its own axis."""

    # Currents (A) for an error of 1 m, 1 m s, a speed of 1 m/s, and always: what a weight of 1 means.
    SCALES = np.array([[500.0, 500.0, 20.0, 1.0], [50.0, 50.0, 5.0, 1.0]])

    def __init__(self, weights: np.ndarray):
        self.gains = weights.reshape(2, 4) * self.SCALES
        self.parts = np.ones((2, 4))
        self.sums = np.zeros(2)   # m s

    def act(self, observation: np.ndarray) -> np.ndarray:
        """Currents at an observation: positions, velocities, references."""
        errors = observation[4:] - observation[:2]
        self.sums += SAMPLE_TIME * errors
        self.parts[:, 0] = errors
        self.parts[:, 1] = self.sums
        self.parts[:, 2] = observation[2:4]
        return (self.gains * self.parts).sum(axis=1)


def fly(env: Any, weights: np.ndarray, seed: int) -> tuple[float, np.ndarray, bool]:
    """Return of an episode, its errors (m), shape (samples, 2), and whether it ended at a stop."""
    agent = Agent(weights)
    observation, _ = env.reset(seed=seed)
    total, errors, ended, crashed = 0.0, [], False, False
    while not ended:
        observation, reward, crashed, truncated, _ = env.step(agent.act(observation))
        ended = crashed or truncated
        total += reward
        errors.append(observation[4:] - observation[:2])
    return total, np.array(errors), crashed


def train(env: Any, seed: int, generations: int) -> np.ndarray:
    """Weights that the cross-entropy method finds."""
    random = np.random.default_rng(seed)
    mean, spread = np.zeros(8), np.ones(8)
    begin = perf_counter()
    for generation in range(generations):
        candidates = mean + spread * random.standard_normal((CANDIDATES, 8))
        seeds = random.integers(2**31, size=EPISODES)
        returns = [np.mean([fly(env, weights, int(each))[0] for each in seeds]) for weights in candidates]
        best = candidates[np.argsort(returns)[-BEST:]]
        # A little spread more than the best have, less and less of it, keeps the search from stopping too soon.
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.2 * 0.9**generation
        print(f"generation {generation + 1:3}: best return {max(returns):6.1f}, mean {np.mean(returns):6.1f} of 500, "
              f"{perf_counter() - begin:4.0f} s", flush=True)
    return mean


def main() -> None:
    """Train, then fly episodes of 5 s with set-points that the agent has not seen."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", help="folder with the folder native, in place of FMUs that are built")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--generations", type=int, default=20)
    asked = parser.parse_args()
    env = gymnasium.make("maglev/Stage2DOF-v0", fmus=asked.fmus, **TRAINING)
    weights = train(env, asked.seed, asked.generations)
    env.close()
    print("gains (A/m, A/(m s), A s/m, A) of i_d:", *np.round(Agent(weights).gains[0], 2))
    print("gains (A/m, A/(m s), A s/m, A) of i_q:", *np.round(Agent(weights).gains[1], 2))
    test = gymnasium.make("maglev/Stage2DOF-v0", fmus=asked.fmus, **{**TRAINING, "duration": 5.0})
    flights = [fly(test, weights, 1_000_000 + seed) for seed in range(20)]
    test.close()
    held = [errors for _, errors, crashed in flights if not crashed]
    print(f"{len(held)} of {len(flights)} episodes of 5 s held")
    if held:
        # Over 0.2 s; the last error of each second is already that of the next set-point.
        late = np.array([errors.reshape(5, -1, 2)[:, -101:-1] for errors in held])
        rms = 1e3 * np.sqrt(np.mean(late**2, axis=(0, 1, 2)))
        print(f"RMS error at the end of a set-point: v {rms[0]:.2f} mm, h {rms[1]:.2f} mm")


if __name__ == "__main__":
    main()
