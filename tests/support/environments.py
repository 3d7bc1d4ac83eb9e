"""Environments of the tests, and what an episode gives."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np

import maglev.gym  # noqa: F401 - registers

RIG_NAMES = ("2dof", "3dof", "5dof")


def environment(rig: str, folder: Path, **options: Any) -> gymnasium.Env[Any, Any]:
    return gymnasium.make(f"maglev/Stage{rig.upper()}-v0", fmus=folder, **options)


def flown(env: Any, actions: Any, **reset: Any) -> np.ndarray:
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
