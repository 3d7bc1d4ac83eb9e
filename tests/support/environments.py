"""Environments of the tests, and what an episode gives."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import maglev.gym  # noqa: F401 - registers

STAGE_NAMES = ("2dof", "3dof", "5dof")
OPTIONS = ("action", "reference", "duration", "sample_time", "reward", "measurement", "render_mode")


def environment(stage: str, folder: Path, **options: Any) -> gymnasium.Env[Any, Any]:
    """Environment with options; those that are not its own are parameters of the plant."""
    parameters = {name: value for name, value in options.items() if name not in OPTIONS}
    return gymnasium.make(f"maglev/Stage{stage.upper()}-v0", fmus=folder, parameters=parameters,
                          **{name: value for name, value in options.items() if name in OPTIONS})


def simulated(env: Any, actions: Any, **reset: Any) -> np.ndarray:
    """Observations of an episode with actions, shape (samples + 1, observation)."""
    found = [env.reset(**reset)[0]]
    for action in actions:
        observation, _, terminated, truncated, _ = env.step(action)
        found.append(observation)
        if terminated or truncated:
            break
    return np.array(found)


def same_bits(first: np.ndarray, second: np.ndarray) -> bool:
    return first.shape == second.shape and np.array_equal(first.view(np.int64), second.view(np.int64))
