"""Train a small agent that levitates the 2-DOF stage and brings it to setpoints, with nothing but NumPy.

The agent is linear: each current is a weighted sum of the errors, of what they add up to, of the velocities and of one.
Its weights are found by the cross-entropy method: try many, keep the best, draw around these the next ones. All
candidates of a generation run side by side in one vector environment. What was learned becomes a controller file:

    python gym_levitate.py
    maglev compare 2dof-setpoints --controller Regulator2DOF --controller learned.py
"""

import argparse
from pathlib import Path
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

# Currents (A) for an error of 1 m, 1 m s, a speed of 1 m/s, and always: what a weight of 1 means. i_d lifts and i_q
# drives, each looks at its own axis.
SCALES = np.array([[500.0, 500.0, 20.0, 1.0], [50.0, 50.0, 5.0, 1.0]])

CONTROLLER = '''"""Linear law of the 2-DOF stage, learned by examples/gym_levitate.py.

    maglev run 2dof-setpoints --controller {name}
"""

from controller_fmu.motor_command import MotorCommand
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from pmlsm.motor_geometry import MotorGeometry

SAMPLES = {samples}   # of the rig in one of the law, which learned with {sample_time} s


class Axis:
    """One axis: from reference and measurement to a current."""

    def __init__(self, position: float, error: float, total: float, speed: float, always: float):
        self.reference = position       # m, input
        self.reference_rate = 0.0       # m/s, input
        self.measured = position        # m, input
        self.error = error              # A/m
        self.total = total              # A/(m s)
        self.speed = speed              # A s/m
        self.always = always            # A
        self.observer = VelocityObserver()
        self.sum = 0.0                  # m s, state

    def current(self, observer: ObserverFilter, dt: float) -> float:
        """Current (A) of a sample."""
        self.observer.update(self.measured, observer, dt)
        error = self.reference - self.measured
        self.sum += dt * error
        return self.error * error + self.total * self.sum + self.speed * self.observer.velocity + self.always


class Learned:
    """Both axes; the commutation goes on between their samples, as in the environment."""

    inputs = {{"v.reference": "m", "v.reference_rate": "m/s", "v.measured": "m",
              "h.reference": "m", "h.reference_rate": "m/s", "h.measured": "m"}}
    outputs = {{"motor.i_a_cmd": "A", "motor.i_b_cmd": "A", "motor.i_c_cmd": "A", "motor.i_d_cmd": "A",
               "motor.i_q_cmd": "A"}}
    parameters = {{"limit": "A"}}

    def __init__(self) -> None:
        self.sample_time = {rig_time}       # s
        self.limit = {limit}                # A, parameter: of i_d and i_q
        self.v = Axis(0.02, {v})
        self.h = Axis(0.0, {h})
        self.observer = ObserverFilter()
        self.geometry = MotorGeometry()
        self.motor = MotorCommand()
        self.i_d = 0.0                  # A, held
        self.i_q = 0.0
        self.waiting = 0                # samples of the rig until the next one of the law
        self.started = False

    def start(self) -> None:
        """Compute what follows from the parameters."""
        self.geometry.prepare()
        self.observer.prepare(SAMPLES * self.sample_time)

    def step(self, t: float) -> None:
        """Read the inputs, set the outputs; t is the time (s)."""
        if not self.started:
            if self.v.measured <= 0.0:
                return          # in another tool: nothing has been measured yet
            self.v.observer.seed(self.v.measured)
            self.h.observer.seed(self.h.measured)
            self.started = True
        if self.waiting == 0:
            self.i_d = self.v.current(self.observer, SAMPLES * self.sample_time)
            self.i_q = self.h.current(self.observer, SAMPLES * self.sample_time)
            self.waiting = SAMPLES
        self.waiting -= 1
        self.motor.command(self.i_d, self.i_q, self.limit, self.geometry.electrical_angle(self.h.measured))
'''


def simulate(envs: Any, weights: np.ndarray, seeds: list[int]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """An episode in each environment, with weights of shape (environments, 8).

    Returns of the episodes, their errors (m), shape (samples, environments, 2), and whether they ended at a stop.
    """
    gains = weights.reshape(-1, 2, 4) * SCALES
    observations, _ = envs.reset(seed=seeds)
    parts = np.ones((len(weights), 2, 4))
    sums = np.zeros((len(weights), 2))   # m s
    returns, crashed, going = np.zeros(len(weights)), np.zeros(len(weights), bool), np.ones(len(weights), bool)
    errors = []
    while going.any():
        parts[:, :, 0] = observations[:, 4:] - observations[:, :2]   # positions, velocities, references
        sums += SAMPLE_TIME * parts[:, :, 0]
        parts[:, :, 1], parts[:, :, 2] = sums, observations[:, 2:4]
        # Currents beyond the peak are limited; those beyond 1000 A would be refused.
        observations, rewards, terminated, truncated, _ = envs.step(np.clip((gains * parts).sum(axis=2), -900.0, 900.0))
        returns += np.where(going, rewards, 0.0)
        crashed |= going & terminated
        going &= ~(terminated | truncated)
        errors.append(observations[:, 4:] - observations[:, :2])
    return returns, np.array(errors), crashed


def train(envs: Any, seed: int, generations: int) -> np.ndarray:
    """Weights that the cross-entropy method finds."""
    random = np.random.default_rng(seed)
    mean, spread = np.zeros(8), np.ones(8)
    begin = perf_counter()
    for generation in range(generations):
        candidates = mean + spread * random.standard_normal((CANDIDATES, 8))
        seeds = random.integers(2**31, size=EPISODES).tolist()
        found, _, _ = simulate(envs, np.repeat(candidates, EPISODES, axis=0), seeds * CANDIDATES)
        returns = found.reshape(CANDIDATES, EPISODES).mean(axis=1)
        best = candidates[np.argsort(returns)[-BEST:]]
        # A little spread more than the best have, less and less of it, keeps the search from stopping too soon.
        mean, spread = best.mean(axis=0), best.std(axis=0) + 0.2 * 0.9**generation
        print(f"generation {generation + 1:3}: best return {max(returns):6.1f}, mean {np.mean(returns):6.1f} of 500, "
              f"{perf_counter() - begin:4.1f} s", flush=True)
    return mean


def main() -> None:
    """Train, run episodes of 5 s with setpoints that the agent has not seen, and write the controller."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--fmus", help="folder with the folder native, in place of FMUs that are built")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--generations", type=int, default=20)
    parser.add_argument("--out", type=Path, default=Path("learned.py"), help="controller file")
    asked = parser.parse_args()

    def stages(number: int, **options: Any) -> Any:
        return gymnasium.make_vec("maglev/Stage2DOF-v0", number, "vector_entry_point", fmus=asked.fmus,
                                  **{**TRAINING, **options})

    envs = stages(CANDIDATES * EPISODES)
    weights = train(envs, asked.seed, asked.generations)
    limit = float(envs.single_action_space.high[0])
    envs.close()
    gains = weights.reshape(2, 4) * SCALES
    print("gains (A/m, A/(m s), A s/m, A) of i_d:", *np.round(gains[0], 2))
    print("gains (A/m, A/(m s), A s/m, A) of i_q:", *np.round(gains[1], 2))
    test = stages(20, duration=5.0)
    _, errors, crashed = simulate(test, np.tile(weights, (20, 1)), list(range(1_000_000, 1_000_020)))
    test.close()
    print(f"{(~crashed).sum()} of {len(crashed)} episodes of 5 s held")
    if not crashed.all():
        # Over 0.2 s; the last error of each second is already that of the next setpoint.
        late = errors[:, ~crashed].reshape(5, -1, (~crashed).sum(), 2)[:, -101:-1]
        rms = 1e3 * np.sqrt(np.mean(late**2, axis=(0, 1, 2)))
        print(f"RMS error at the end of a setpoint: v {rms[0]:.2f} mm, h {rms[1]:.2f} mm")
    v, h = (", ".join(repr(float(gain)) for gain in row) for row in gains)
    asked.out.write_text(CONTROLLER.format(name=asked.out.name, samples=4, sample_time=SAMPLE_TIME,
                                           rig_time=SAMPLE_TIME / 4, limit=limit, v=v, h=h), encoding="utf-8")
    print(f"wrote {asked.out}")


if __name__ == "__main__":
    main()
