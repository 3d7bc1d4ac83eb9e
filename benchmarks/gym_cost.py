"""Cost of a step of the Gymnasium environments beside that of gym-electric-motor's `Cont-CC-PMSM-v0`, in one run.

Both with the wrappers of `gymnasium.make`, all currents at zero, resets left out. Without gym-electric-motor, which is
no dependency (`pip install gym-electric-motor==3.0.2`), it says so.
"""

import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.table import Table

from maglev.catalogue import HOST, build

LARGEST_SHARE = 0.1   # of the peer's cost
STEPS = {"Stage2DOF": 250, "Stage3DOF": 250, "Cont-CC-PMSM": 25}   # about as long, so that as much disturbs them
ROUNDS = 200          # the fastest counts, which is the least disturbed

FMUS = ("Plant2DOF", "Commutation2DOF", "Plant3DOF", "Commutation3DOF")
NEEDED = ("gymnasium", "pyccel", "ziglang")


def step_time(env: Any, action: Any, steps: int) -> float:
    """Time of one step from the beginning of an episode on, s."""
    env.reset(seed=1)
    begin = perf_counter()
    for _ in range(steps):
        env.step(action)
    return (perf_counter() - begin) / steps


def main() -> int:
    """Print the table; return 1 if an environment costs more than its share of the peer."""
    console = Console(width=110)
    missing = [name for name in NEEDED if find_spec(name) is None]
    if missing:
        console.print(f"left out: cost of the Gymnasium environments, for {', '.join(missing)} is not installed")
        return 0
    import gymnasium

    import maglev.gym  # noqa: F401 - registers

    with tempfile.TemporaryDirectory() as folder:
        build(FMUS, Path(folder) / "native", HOST)
        envs = {name: gymnasium.make(f"maglev/{name}-v0", reference="hold", fmus=folder)
                for name in ("Stage2DOF", "Stage3DOF")}
        if find_spec("gym_electric_motor") is None:
            console.print("without gym-electric-motor, which is not installed")
        else:
            import gym_electric_motor

            envs["Cont-CC-PMSM"] = gym_electric_motor.make("Cont-CC-PMSM-v0")
        actions = {name: 0.0 * env.action_space.sample() for name, env in envs.items()}
        times: dict[str, list[float]] = {name: [] for name in envs}
        for _ in range(ROUNDS):   # in turn, so that a disturbance meets all of them
            for name, env in envs.items():
                times[name].append(step_time(env, actions[name], STEPS[name]))
        for name in ("Stage2DOF", "Stage3DOF"):
            envs[name].close()
    costs = {name: min(found) for name, found in times.items()}
    peer = costs.get("Cont-CC-PMSM", 0.0)
    table = Table("environment", "step (µs)", "of Cont-CC-PMSM", title="Cost of a step of an environment")
    for name, cost in costs.items():
        table.add_row(name, f"{1e6 * cost:.2f}", f"{cost / peer:.3f}" if peer else "")
    console.print(table)
    too_slow = [name for name in ("Stage2DOF", "Stage3DOF") if peer and costs[name] > LARGEST_SHARE * peer]
    for name in too_slow:
        console.print(f"{name}: {costs[name] / peer:.3f} of Cont-CC-PMSM, expected at most {LARGEST_SHARE}")
    return 1 if too_slow else 0


if __name__ == "__main__":
    sys.exit(main())
