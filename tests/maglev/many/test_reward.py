"""Rewards of the environments, of terms and of functions, by hand; and those that are refused."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from facts import raises

from maglev.files.errors import ScenarioError

Make = Callable[..., Any]


def test_reward_by_hand(make: Make) -> None:
    """With an error of 1 mm in y, and the currents that the amplifiers deliver."""
    env = make("3dof", reference=[[26e-3, 0.0, 2e-3]], reward={"alive": 1.0, "error": -3.0, "current": -0.5})
    env.reset()
    for _ in range(10):
        _, reward, *_, info = env.step(np.array([1.0, 0.5, 0.0, -2.0]))
    y, x, z = env.compiled.positions
    errors = [(26e-3 - y) / 13.5e-3, x / 124e-3, (2e-3 - z) / 124e-3]
    currents = env.compiled.currents / 5.0
    assert reward == pytest.approx(1.0 - 3.0 * np.mean(np.square(errors)) - 0.5 * np.mean(np.square(currents)), 1e-12)
    assert abs(currents[3]) > 0.3
    assert info == {"reward_error": pytest.approx(-3.0 * np.mean(np.square(errors)), 1e-12),
                    "reward_current": pytest.approx(-0.5 * np.mean(np.square(currents)), 1e-12)}


def test_rewards_of_terms_and_functions_by_hand(make: Make) -> None:
    """The same of weights, of a function of signals, and of the numbers of the stage."""
    terms = {"x.error": np.int64(-2), "speed": np.float32(-0.5), "stop": -3.0}

    def function(seen: Any) -> Any:
        off = (seen["x.reference"] - seen["x.position"]) / 124e-3
        speeds = [seen["y.velocity"] / 13.5e-3, seen["x.velocity"] / 124e-3, seen["z.velocity"] / 124e-3]
        return -2.0 * off**2 - 0.5 * sum(speed**2 for speed in speeds) / 3.0 - 3.0 * seen["at_stop"]

    rewards: list[list[float]] = []
    for given in (terms, function):
        env = make("3dof", reference=[[25e-3, 3e-3, 0.0]], reward=given)
        env.reset()
        rewards.append([])
        terminated = False
        while not terminated:
            _, reward, terminated, *_ = env.step(np.array([0.0, 1.0, 0.0, -2.0]))
            rewards[-1].append(reward)
    _, x, _ = env.compiled.positions
    speeds = env.compiled.velocities / [13.5e-3, 124e-3, 124e-3]
    assert rewards[0] == pytest.approx(rewards[1], rel=1e-12)
    assert rewards[0][-1] == pytest.approx(-2.0 * ((3e-3 - x) / 124e-3)**2 - 0.5 * np.mean(speeds**2) - 3.0, 1e-12)


@pytest.mark.parametrize(("reward", "facts"), [
    ({"eror": 1.0}, ["'eror'", "'error'"]), ({"error": "much"}, ["error", "'much'", "number"]),
    ({"error": float("nan")}, ["error", "nan", "number"]), (3.0, ["reward", "3.0"]),
    (lambda seen: seen["y.positon"], ["'y.positon'", "'y.position'"]),
    (lambda seen: 1.0 if seen["y.position"] > 0.0 else 0.0, ["(environments,)"]), (lambda seen: 1.0, ["()", "(2,)"]),
    (lambda seen: seen["y.position"] + np.inf, ["inf", "number"])],
                         ids=lambda given: "a function" if callable(given) else str(given))
def test_refused_rewards(make: Make, reward: Any, facts: list[str]) -> None:
    with raises(ScenarioError, *facts):
        make("3dof", reward=reward)
