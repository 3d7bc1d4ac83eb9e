"""Many stages in one environment: the bits of Gymnasium's vector of single ones, through ends and beginnings."""

from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from facts import raises
from gymnasium.vector import AutoresetMode

import maglev.gym  # noqa: F401 - registers
from maglev.files.errors import ScenarioError
from maglev.many import vector_environment as stages

OPTIONS: dict[str, tuple[str, dict[str, Any]]] = {
    "3-DOF, drawn": ("Stage3DOF", {
        "measurement": lambda random: {"y.noise": {"log-uniform": (1e-7, 1e-5)}, "delay": 1e-4 * random.random(),
                                       "y.frozen": {"at": (0.0, 0.02), "then": True, "for": 0.005}},
        "parameters": {"y.mass, x.mass": {"normal": (7.0, 0.2)}, "alpha.amplifier.off": {"choice": [True, False]},
                       "y.force": {"at": (0.0, 0.03), "then": (-50.0, 50.0), "for": 0.004},
                       "bus_voltage": {"at": 0.01, "then": 12.0}},
        "reward": lambda seen: np.exp(-1e3 * abs(seen["y.reference"] - seen["y.position"])) - np.sin(
            seen["alpha.i_d"] * seen["x.velocity"]) - 5.0 * seen["at_stop"], "reference": "hold"}),
    "2-DOF": ("Stage2DOF", {"parameters": {"v.mass": (4.0, 5.0), "v.position_start": (0.015, 0.024)}}),
    "3-DOF, measured": ("Stage3DOF", {"measurement": {"y.noise": "1 um", "delay": "0.4 ms"}, "reference": "hold"}),
    "2-DOF, phases": ("Stage2DOF", {"action": "phases", "reference": "sinusoids"}),
    "3-DOF, weights": ("Stage3DOF", {"reward": {"y.error": -2.0, "speed": -0.3, "alive": 1.0, "stop": -5.0,
                                                "current": -0.1, "error": -1.0},
                                     "reference": [[0.025, 0.0, 0.0], [0.024, 0.001, 0.0]], "sample_time": "2 ms"}),
    "3-DOF, slow samples": ("Stage3DOF", {"sample_time": "2 ms",
                                          "reference": [[0.025, 0.0, 0.0], [0.024, 0.001, 0.0]]}),
    "5-DOF": ("Stage5DOF", {"sample_time": "1 ms"})}


@pytest.mark.few(2)   # the first, in which all kinds of values are drawn, and one of phase currents
@pytest.mark.parametrize("what", OPTIONS)
def test_it_has_the_bits_of_single_stages(folder: Path, what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(stages, "FEWEST", 2)   # so that there are threads
    name, options = OPTIONS[what]
    options = {"duration": 0.04, "fmus": folder, **options}
    ours = gymnasium.make_vec(f"maglev/{name}-v0", 5, "vector_entry_point", threads=2, **options)
    theirs = gymnasium.make_vec(f"maglev/{name}-v0", 5, "sync", **options)
    assert ours.metadata["autoreset_mode"] == theirs.metadata["autoreset_mode"] == AutoresetMode.NEXT_STEP
    for space in ("observation_space", "action_space", "single_observation_space", "single_action_space"):
        assert getattr(ours, space) == getattr(theirs, space)
    found, expected = ours.reset(seed=7), theirs.reset(seed=7)
    require_same(found, expected)
    theirs.action_space.seed(3)
    ends = 0
    for k in range(int(0.1 / theirs.envs[0].unwrapped.sample_time)):   # type: ignore[attr-defined]
        actions = theirs.action_space.sample()
        if k == 30:
            actions[1, 0] = np.nan
            actions[2, 1] = 1e6
        one, other = ours.step(actions), theirs.step(actions)
        require_same(one, other)
        if k == 20:
            mask = np.array([False, True, False, True, False])
            require_same(*(vector.reset(seed=11, options={"reset_mask": mask}) for vector in (ours, theirs)))
        ends += int((one[2] | one[3]).sum())
        assert ours.observation_space.contains(one[0]) or k >= 30
    assert ends > 5
    ours.close()
    theirs.close()


def require_same(found: tuple[Any, ...], expected: tuple[Any, ...]) -> None:
    for one, other in zip(found[:-1], expected[:-1], strict=True):
        assert one.dtype == other.dtype
        assert one.tobytes() == other.tobytes()
    require_same_info(found[-1], expected[-1])


def require_same_info(found: dict[str, Any], expected: dict[str, Any]) -> None:
    assert {*found} >= {*expected}
    for name, values in expected.items():
        if isinstance(values, dict):
            require_same_info(found[name], values)
        else:
            assert np.array_equal(found[name], values), (name, found[name], values)


def test_actions_of_another_shape_or_too_soon_are_refused(folder: Path) -> None:
    envs = stages.StageVectorEnv(3, "2dof", fmus=folder)
    with raises(gymnasium.error.ResetNeeded, "step()", "reset()"):
        envs.step(np.zeros((3, 2)))
    with raises(gymnasium.error.ResetNeeded, "reset_mask", "reset()"):
        envs.reset(options={"reset_mask": np.ones(3, bool)})
    envs.reset(seed=1)
    with raises(ScenarioError, "actions", "(2,)", "(3, 2)"):
        envs.step(np.zeros(2))
    for mask in (np.zeros(3, bool), np.ones(2, bool), [1, 0, 0]):
        with raises(ScenarioError, "reset_mask", "3 Booleans"):
            envs.reset(options={"reset_mask": mask})
    with raises(ScenarioError, "seed", 2, 3):
        envs.reset(seed=[1, 2])
    envs.close()
    for number in (0, 1.5):
        with raises(ScenarioError, "num_envs", number, 1):
            stages.StageVectorEnv(number, "2dof", fmus=folder)   # type: ignore[arg-type]
