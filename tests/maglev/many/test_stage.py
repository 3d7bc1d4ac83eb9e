"""The environments: Gymnasium's contract, the loop of `maglev.run` bit for bit, physics by hand, and refusals."""

import pickle
import zipfile
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from environments import STAGE_NAMES, environment, same_bits, simulated
from facts import raises
from gymnasium.utils.env_checker import check_env

import maglev
import maglev.gym  # noqa: F401 - registers
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import FmuError, MaglevError, ScenarioError, UnknownName
from maglev.many.environment import StageEnv

Make = Callable[..., Any]


@pytest.mark.few(6)
@pytest.mark.parametrize("stage", STAGE_NAMES)
@pytest.mark.parametrize("options", [{}, {"action": "phases"}, {"sample_time": "2 ms"}, {"reference": "sinusoids"}],
                         ids=str)
@pytest.mark.filterwarnings("ignore:.*normalized space")
def test_checker_of_gymnasium(make: Make, stage: str, options: dict[str, Any]) -> None:
    check_env(make(stage, **options))


def gap_column(stage: str) -> int:
    """Of an observation: the air gap, or that of the first motor of a platform that tilts."""
    return len(PACKAGED_STAGES[stage].horizontal) if PACKAGED_STAGES[stage].rotations else 0


@pytest.mark.parametrize("stage", STAGE_NAMES)
def test_seeds(make: Make, stage: str) -> None:
    """The same seed gives the same bits, in the same environment and another one; another seed others."""
    axis = PACKAGED_STAGES[stage].vertical.name
    options = {f"{axis}.mass": (0.9 * PACKAGED_STAGES[stage].vertical.mass, 1.1 * PACKAGED_STAGES[stage].vertical.mass)}
    env = make(stage, **options)
    env.action_space.seed(5)
    actions = 0.3 * np.array([env.action_space.sample() for _ in range(200)])
    first = simulated(env, actions, seed=1)
    assert same_bits(first, simulated(env, actions, seed=1))
    assert same_bits(first, simulated(make(stage, **options), actions, seed=1))
    other = simulated(env, actions, seed=2)
    references = slice(-len(PACKAGED_STAGES[stage].axes), None)
    assert not np.array_equal(first[0, references], other[0, references])
    assert np.ptp(first[:, gap_column(stage)]) > 1e-4, "something has to move for this to mean anything"
    # Without a seed the next episode is another one.
    assert not np.array_equal(simulated(env, actions)[0], simulated(env, actions)[0])


@pytest.mark.parametrize("stage", STAGE_NAMES)
def test_free_fall(make: Make, stage: str) -> None:
    """Without motors, friction and ripple the mover falls: g = g0 + (G + bias) t²/2."""
    of = PACKAGED_STAGES[stage]
    axis = of.vertical.name
    off = {constant.name: 0.0 for constant in of.constants}
    off |= {f"{axis}.friction.coulomb": 0.0, f"{axis}.friction.viscous": 0.0, f"{axis}.bias": 0.25}
    off |= {"encoder.resolution": 0.0, f"{axis}.position_start": 0.020}
    off |= {"y.ripple.amplitude": 0.0} if axis == "y" else {}
    env = make(stage, reference="hold", duration=0.03, **off)
    found = simulated(env, np.zeros((10_000, *env.action_space.shape)))
    time = of.sample_time * np.arange(len(found))
    assert len(found) == 1 + round(0.03 / of.sample_time)
    assert np.allclose(found[:, gap_column(stage)], 0.020 + 0.5 * (9.81 + 0.25) * time**2, rtol=0.0, atol=1e-12)
    # The observer lags behind by half a sample of differentiation and twice by its filter of 1 ms, sampled.
    lag = 0.5 * of.sample_time + 2.0 * of.sample_time / np.expm1(of.sample_time / 1e-3)
    late = time > 0.028
    speed = found[late, found.shape[1] - 2 * len(of.axes)]
    assert np.allclose(speed, (9.81 + 0.25) * (time[late] - lag), rtol=0.0, atol=1e-9)


@pytest.mark.parametrize("stage", STAGE_NAMES)
def test_ends_at_a_stop(make: Make, stage: str) -> None:
    """Without currents the mover sticks to the iron or falls, and the episode ends there, inside the spaces."""
    of, column = PACKAGED_STAGES[stage], gap_column(stage)
    env = make(stage)
    for start in (0.5, 0.9):
        low, high = env.lowest[column], env.highest[column]
        env.reset(options={"parameters": {f"{of.vertical.name}.position_start": low + start * (high - low)}})
        terminated = truncated = False
        while not terminated:
            observation, reward, terminated, truncated, _ = env.step(np.zeros(env.action_space.shape))
            assert not truncated and 0.0 < reward <= 1.0
            assert env.observation_space.contains(observation)
        place = of.motor_names[0] if of.rotations else of.vertical.name
        lower, upper = (env.parameters.own(f"{place}.stop.{end}") for end in ("lower", "upper"))
        gaps = observation[column:column + (len(of.motors) if of.rotations else 1)]
        assert min((gaps - lower).min(), (upper - gaps).min()) < 1e-4


@pytest.mark.parametrize("value", [np.nan, np.inf, 2000.0])
def test_ends_where_a_current_is_refused(make: Make, value: float) -> None:
    env = make("3dof")
    before, _ = env.reset(seed=1)
    observation, reward, terminated, truncated, info = env.step(np.full(4, value))
    assert (terminated, truncated, reward) == (True, False, 0.0)
    assert "alpha.i_d_reference" in info["refused"] and "\n" not in info["refused"]
    assert np.array_equal(observation, before)
    # The next episode knows nothing of it.
    actions = np.ones((50, 4))
    assert same_bits(simulated(env, actions, seed=3), simulated(make("3dof"), actions, seed=3))


@pytest.mark.parametrize("action", [0.5, [0.5], np.zeros((1, 4)), np.zeros(3), np.zeros(5), [[0.0]] * 4, []],
                         ids=lambda action: str(np.shape(action)))
def test_an_action_of_another_shape_is_refused(make: Make, action: Any) -> None:
    """And nothing is done: what numpy would broadcast is no action for each current."""
    env = make("3dof")
    env.reset(seed=1)
    with raises(ScenarioError, "action", np.shape(action), "(4,)", "A"):
        env.step(action)
    first = env.step([0.1, 0.2, 0.3, 0.4])[0]
    other = make("3dof")
    other.reset(seed=1)
    assert np.array_equal(first, other.step(np.array([0.1, 0.2, 0.3, 0.4]))[0])


def test_truncated_at_the_end(make: Make) -> None:
    env = make("2dof", reference="hold", duration="5 ms")
    env.reset()
    ends = [env.step(np.zeros(2))[3] for _ in range(10)]
    assert ends == [False] * 9 + [True]


def test_samples_of_several(make: Make) -> None:
    """An environment of 1 ms holds an action for five samples of the stage's; commutation continues."""
    actions = np.linspace(-1.0, 1.0, 4 * 40).reshape(40, 4)
    fine = simulated(make("3dof"), np.repeat(actions, 5, axis=0), seed=1)
    coarse = simulated(make("3dof", sample_time="1 ms"), actions, seed=1)
    assert np.array_equal(fine[::5, :3], coarse[:, :3])
    assert np.ptp(coarse[:, 0]) > 1e-4


def test_a_change_acts_when_it_says(make: Make) -> None:
    """A push of 6.6 N for 10 ms on 6.6 kg, from 4 ms on, as Newton has it; with a saved state in its middle."""
    off = {constant.name: 0.0 for constant in PACKAGED_STAGES["3dof"].constants}
    off |= {f"x.{name}": 0.0 for name in ("friction.coulomb", "friction.viscous", "ripple.amplitude", "bias")}
    env = make("3dof", reference="hold", **off, **{
        "x.mass": 6.6, "x.force": {"at": "4 ms", "then": "6.6 N", "for": 0.01}})
    for _ in range(2):   # nothing of an episode is left in the next one
        _, info = env.reset()
        assert info["changes"] == {"x.force": {"at": 0.004, "then": 6.6, "for": 0.01}}
        found = []
        for k in range(100):
            if k == 50:
                state = env.clone_state()
                env.reset()
                env.restore_state(state)
            env.step(np.zeros(4))
            found.append(float(env.compiled.positions[1]))
        since = np.clip(0.2e-3 * np.arange(1, 101) - 0.004, 0.0, None)
        expected = 0.5 * np.minimum(since, 0.01)**2 + 0.01 * np.clip(since - 0.01, 0.0, None)
        assert np.allclose(found, expected, rtol=1e-9, atol=1e-15)


def test_currents_are_limited_to_the_peak(make: Make) -> None:
    env = make("3dof", reference="hold")
    assert env.action_space.high.tolist() == [5.0] * 4
    most = simulated(env, np.full((50, 4), 5.0))
    assert same_bits(most, simulated(env, np.full((50, 4), 500.0)))


OPTIONS = {
    "y.friction.coulomb": 0.0, "y.friction.viscous": 40.0, "encoder.resolution": 1e-4, "y.ripple.amplitude": 0.0,
    "y.bias": 0.5, "attraction_modulation": 0.1, "y.mass": "7.9 kg", "y.position_start": "24 mm",
    "alpha.amplifier.lag": "2 ms", "alpha.amplifier.peak": 1.0, "alpha.amplifier.continuous": 0.1,
    "alpha.amplifier.thermal_time": "1 ms", "x.locked": True, "C5": 0.0}


@pytest.mark.parametrize("name", OPTIONS)
def test_every_option_acts(make: Make, name: str) -> None:
    """Where the environment is made, and in the same way in the options of an episode."""
    # Half a slot pitch off, where the attraction is least, and with a continuous current that limits at all.
    base = {"x.position_start": 9.5e-3, "alpha.amplifier.continuous": 1.0}
    base = {key: value for key, value in base.items() if key != name}
    actions = np.tile([2.0, 2.0, 0.0, 0.0], (150, 1))
    plain = simulated(make("3dof", reference=[[25e-3, 0.0, 0.0]], **base), actions)
    env = make("3dof", reference=[[25e-3, 0.0, 0.0]], **base, **{name: OPTIONS[name]})
    changed = simulated(env, actions)
    assert not same_bits(plain, changed)
    other = make("3dof", reference=[[25e-3, 0.0, 0.0]], **base)
    assert same_bits(changed, simulated(other, actions, options={"parameters": {name: OPTIONS[name]}}))
    assert same_bits(plain, simulated(other, actions)), "options of an episode are for that one alone"


def test_drawn_parameters(make: Make) -> None:
    """Between the two of a pair, others in every episode; what was drawn is told, and is what runs."""
    env = make("3dof", **{"y.position_start": ("23 mm", "27 mm"), "x.friction.coulomb": (0.0, 3.0)})
    drawn = [env.reset(seed=4 if i == 0 else None)[1]["parameters"] for i in range(50)]
    starts = [each["y.position_start"] for each in drawn]
    assert 23e-3 <= min(starts) < 24e-3 and 26e-3 < max(starts) <= 27e-3
    assert len({each["x.friction.coulomb"] for each in drawn}) == 50
    assert env.compiled.positions[0] == starts[-1]


@pytest.mark.parametrize("kind", ["hold", "setpoints", "sinusoids"])
def test_references(make: Make, kind: str) -> None:
    """Inside the travel, in the observation; setpoints for a second each, sinusoids of 1.5π rad/s."""
    env = make("3dof", reference=kind, duration=3.0, sample_time="1 ms")
    for seed in range(20):
        first, _ = env.reset(seed=seed)
        episode = np.array([env.references.at(k, *env.episode) for k in range(3001)])
        assert np.array_equal(first[6:], episode[0])
        assert np.array_equal(env.step(np.zeros(4))[0][6:], episode[1])
        assert (episode >= env.lowest[6:]).all() and (episode <= env.highest[6:]).all()
        changes = np.flatnonzero(np.diff(episode[:, 0])) + 1
        if kind == "hold":
            assert (episode == [25e-3, 0.0, 0.0]).all()
        elif kind == "setpoints":
            assert changes.tolist() == [1000, 2000, 3000]
        else:
            time = 1e-3 * np.arange(3001)
            basis = np.sin(1.5 * np.pi * time)
            moved = episode - [25e-3, 0.0, 0.0]
            assert np.allclose(moved, np.outer(basis, basis @ moved / (basis @ basis)), rtol=0.0, atol=1e-15)


@pytest.mark.parametrize("kind", [gymnasium.vector.SyncVectorEnv, gymnasium.vector.AsyncVectorEnv])
def test_vector_environments(make: Make, folder: Path, kind: Any) -> None:
    """Several at once run as each alone does."""
    actions = 0.5 * np.ones((30, 2))
    envs = kind([partial(environment, "2dof", folder)] * 3)
    found = [envs.reset(seed=7)[0]] + [envs.step(np.tile(action, (3, 1)))[0] for action in actions]
    envs.close()
    for i in range(3):
        alone = simulated(make("2dof"), actions, seed=7 + i)
        assert same_bits(alone, np.ascontiguousarray(np.array(found)[:, i]))


@pytest.mark.parametrize(("options", "error", "facts"), [
    ({"y.masss": 7.0}, UnknownName, ["'y.masss'", "'y.mass'"]),
    ({"y.mass": "7 mm"}, ScenarioError, ["y.mass", "'7 mm'", "kg"]),
    ({"y.mass": -1.0}, ScenarioError, ["y.mass", "-1 kg", "0.001"]),
    ({"y.mass": float("nan")}, ScenarioError, ["y.mass", "nan"]),
    ({"y.mass": (7.0, 6.0)}, ScenarioError, ["y.mass", "lower value"]),
    ({"y.mass": (6.0, 7.0, 8.0)}, ScenarioError, ["y.mass", "pair"]),
    ({"C1": "0.6 m"}, ScenarioError, ["C1", "'0.6 m'", "m/(s2.A)"]),
    ({"y.locked": 1.0}, ScenarioError, ["y.locked", "true", "false"]),
    ({"action": "volts"}, ScenarioError, ["action", "'volts'"]),
    ({"reference": "ramp"}, ScenarioError, ["reference", "'ramp'"]),
    ({"reference": [[0.025, 0.0]]}, ScenarioError, ["reference", "(samples, 3)"]),
    ({"reference": [[0.025, 0.0, 1.0]]}, ScenarioError, ["reference", "stops"]),
    ({"sample_time": "0.3 ms"}, ScenarioError, ["sample_time", "0.3 ms"]),
    ({"sample_time": "0 s"}, ScenarioError, ["sample_time", "0 s"]),
    ({"duration": "2 mm"}, ScenarioError, ["duration", "'2 mm'", "s"]),
    ({"duration": 1e12}, ScenarioError, ["duration", "1000000000000.0", "1e+08 samples"]),
    ({"reference": [[0.025, 0.0, 0.0], [0.025]]}, ScenarioError, ["reference", "(samples, 3)"]),
    ({"duration": 1e-5}, ScenarioError, ["duration", "1e+08 samples", "0.0002 s"])], ids=str)
def test_refused_options(make: Make, options: dict[str, Any], error: type[MaglevError], facts: list[str]) -> None:
    with raises(error, *facts):
        make("3dof", **options)


def test_refused_in_an_episode(make: Make) -> None:
    env = make("3dof")
    with raises(ScenarioError, "y.stop.upper"):
        env.reset(options={"parameters": {"y.stop.upper": 0.04}})
    with raises(FmuError, "y.position_start", "0.04 m"):
        env.reset(options={"parameters": {"y.position_start": 0.04}})
    with raises(ScenarioError, "options of reset", "'y.mass'", "parameters", "measurement"):
        env.reset(options={"y.mass": 7.0})
    env.reset()


def test_closed(make: Make) -> None:
    env = make("2dof")
    env.reset()
    env.close()
    with raises(FmuError, "closed"):
        env.step(np.zeros(2))
    with raises(FmuError, "closed"):
        env.reset()


def test_tilts_are_seen_in_the_gaps(make: Make) -> None:
    """The tilts seen are those of the run, to the rounding of the encoders; their ends are those of the gaps."""
    tilts = {"roll.position_start": "5 mrad", "pitch.position_start": "-8 mrad"}
    env = make("5dof", **{"y.position_start": 24e-3}, **tilts)
    observation, _ = env.reset()
    assert observation[2:6] == pytest.approx([23e-3, 25e-3, 22.4e-3, 25.6e-3], abs=5.1e-6)
    assert env.measured() == pytest.approx([24e-3, 0.0, 0.0, 5e-3, -8e-3], abs=5e-5)
    assert env.compiled.positions.tolist() == [24e-3, 0.0, 0.0, 5e-3, -8e-3]
    assert env.highest[-5:] == pytest.approx([32e-3, 62e-3, 62e-3, 33.75e-3, 33.75e-3])
    loaded = make("5dof", **{"payload.mass": "0.5 kg", "payload.x": "0.1 m"}, reference="hold")
    pushed, alone = (simulated(env, np.tile([-1.12, 0.0], (200, 4)))
                     for env in (loaded, make("5dof", reference="hold")))
    lowered = pushed[-1, 2:6] - alone[-1, 2:6]
    assert lowered[2] - lowered[3] > 1e-4, "the motor under the payload goes down"


def test_a_foreign_fmu_under_our_name(folder: Path, tmp_path: Path) -> None:
    """What this installation does not build is not loaded into the process, whatever it is called."""
    (tmp_path / "native").mkdir()
    for name in ("Plant2DOF", "Commutation2DOF"):
        (tmp_path / "native" / f"{name}.fmu").write_bytes((folder / "native" / f"{name}.fmu").read_bytes())
    environment("2dof", tmp_path).close()
    with zipfile.ZipFile(tmp_path / "native" / "Plant2DOF.fmu", "a") as archive:
        archive.writestr("resources/other.txt", "somebody's")
    with raises(FmuError, "Plant2DOF", "--kind native"):
        environment("2dof", tmp_path)


def test_missing_fmu(tmp_path: Path) -> None:
    with raises(FmuError, tmp_path / "native/Plant2DOF.fmu", "`maglev build --kind native"):
        environment("2dof", tmp_path)


@pytest.mark.parametrize("stage", STAGE_NAMES)
def test_a_state_is_saved_and_gone_back_to(make: Make, stage: str) -> None:
    """In the same environment and in another one, through a file, with the noise and what is drawn later."""
    column = gap_column(stage)
    options = {"measurement": {f"{PACKAGED_STAGES[stage].horizontal[0].name}.noise": 1e-6}, "reference": "hold"}
    env = make(stage, **options)
    actions = 0.2 * np.random.default_rng(1).standard_normal((60, *env.action_space.shape))
    env.reset(seed=3)
    for action in actions[:20]:
        env.step(action)
    saved = pickle.dumps(env.clone_state())

    def rest(of: Any) -> np.ndarray:
        return np.array([of.step(action)[0] for action in actions[20:]] + [of.reset()[0]])

    first = rest(env)
    assert np.ptp(first[:, column]) > 1e-5, "something has to move for this to mean anything"
    env.restore_state(pickle.loads(saved))
    assert same_bits(rest(env), first)
    other = make(stage, **options)
    other.reset(seed=99)
    other.restore_state(pickle.loads(saved))
    assert same_bits(rest(other), first)
    for foreign, kind, fact in ((None, ScenarioError, "clone_state"),
                                (make(stage).clone_state(), FmuError, "another environment")):
        with raises(kind, "state", fact):
            env.restore_state(foreign)


def test_forces_act_and_are_those_that_are_asked_for(make: Make) -> None:
    """Without motors and friction a force of 6.6 N makes as much of the mass as Newton says, along x alone."""
    off = {constant.name: 0.0 for constant in PACKAGED_STAGES["3dof"].constants}
    off |= {f"x.{name}": 0.0 for name in ("friction.coulomb", "friction.viscous", "ripple.amplitude", "bias")}
    off["x.mass"] = 6.6

    def way(env: Any, force: float | None, **reset: Any) -> float:
        env.reset(**reset)
        if force is not None:
            env.push(x=force)
        for _ in range(50):
            env.step(np.zeros(4))
        return float(env.compiled.positions[1])

    env = make("3dof", reference="hold", **off)
    expected = 0.5 * 0.01**2
    assert way(env, None) == 0.0
    assert way(env, 6.6) == pytest.approx(expected, rel=1e-9)
    assert way(env, None) == 0.0, "a push ends with its episode"
    assert way(env, None, options={"parameters": {"x.force": "6.6 N"}}) == pytest.approx(expected, rel=1e-9)
    assert way(make("3dof", reference="hold", **off, **{"x.force": 6.6}), None) == pytest.approx(expected, rel=1e-9)
    with raises(UnknownName, "w", "'y', 'x', 'z'"):
        env.push(w=1.0)
    with raises(ScenarioError, "x.force", "nan"):
        env.push(x=float("nan"))


def test_a_measurement_is_seen_and_drawn(make: Make) -> None:
    """Noise has the standard deviation that is asked for, other noise in each episode; without any nothing is done."""
    still = {"y.locked": True, "x.locked": True, "z.locked": True, "encoder.resolution": 0.0, "reference": "hold"}
    env = make("3dof", measurement={"x.noise": "5 um"}, duration="1 s", **still)
    actions = np.zeros((2000, 4))
    noisy, other = (simulated(env, actions, seed=seed) for seed in (1, 2))
    assert np.std(noisy[:, 1]) == pytest.approx(5e-6, rel=0.05)
    assert abs(np.corrcoef(noisy[:, 1], other[:, 1])[0, 1]) < 0.1
    assert (noisy[:, [0, 2]] == noisy[0, [0, 2]]).all()
    assert same_bits(simulated(env, actions, seed=1), noisy)
    assert env.reset(options={"measurement": {"x.noise": 0.0}})[1]["measurement"]["x.noise"] == 0.0
    moving = make("3dof", reference="hold", measurement={})
    assert same_bits(*(simulated(env, actions[:200] + 1.0) for env in (moving, make("3dof", reference="hold"))))
    with raises(UnknownName, "measurement", "'y.noize'", "'y.noise'"):
        make("3dof", measurement={"y.noize": 1e-6})
    with raises(ScenarioError, "measurement", "reset"):
        make("3dof").reset(options={"measurement": {"y.noise": 1e-6}})


@pytest.mark.parametrize("stage", STAGE_NAMES)
def test_pictures(make: Make, stage: str) -> None:
    """What moves is seen to: the mover goes down in the picture, and its reference stays."""
    pytest.importorskip("matplotlib")
    env = make(stage, render_mode="rgb_array", reference="hold", sample_time="2 ms")
    assert env.metadata["render_fps"] == 500
    env.reset()
    pictures = [env.render()]
    for _ in range(15):
        env.step(np.zeros(env.action_space.shape))
    pictures.append(env.render())
    assert {(picture.shape, picture.dtype.name) for picture in pictures} == {((240, 480, 3), "uint8")}
    rows = [np.argwhere((picture == [31, 119, 180]).all(axis=2))[:, 0].mean() for picture in pictures]
    assert abs(rows[1] - rows[0]) > 2.0
    assert make(stage).render() is None
    with raises(ScenarioError, "render_mode", "'ansi'", "None", "'rgb_array'"):
        StageEnv(stage, render_mode="ansi")


def test_an_option_that_there_is_not(folder: Path) -> None:
    """Is no parameter of the plant either, as Python says."""
    for name in ("sampletime", "y.mass"):
        wrong: dict[str, Any] = {name: 1e-3}
        with raises(TypeError, f"'{name}'"):
            gymnasium.make("maglev/Stage3DOF-v0", fmus=folder, **wrong)


def test_videos_are_recorded(folder: Path, tmp_path: Path) -> None:
    """By Gymnasium's wrapper, which wants moviepy; without that, every picture that it would write."""
    env: Any = gymnasium.make("maglev/Stage3DOF-v0", fmus=folder, render_mode="rgb_array", sample_time="2 ms",
                              duration="20 ms")
    written = find_spec("moviepy") is not None
    video: Any = (gymnasium.wrappers.RecordVideo(env, str(tmp_path / "videos"), fps=50) if written
                  else gymnasium.wrappers.RenderCollection(env))
    video.reset(seed=1)
    while not video.step(np.zeros(4))[3]:
        pass
    if not written:
        frames = video.render()
        assert [frame.shape for frame in frames] == [(240, 480, 3)] * 11
        assert np.any(frames[0] != frames[-1])
    video.close()
    assert [path.stat().st_size > 1000 for path in tmp_path.rglob("*.mp4")] == [True] * written


def test_a_vector_as_others_make_it(folder: Path) -> None:
    """As stable-baselines3 does: a render mode that nobody asked for, keywords, seeds, new episodes."""
    given: dict[str, Any] = {"reference": "hold", "duration": "4 ms", "fmus": folder,
                             "parameters": {"y.position_start": "24 mm"}}
    envs: list[Any] = []
    for rank in range(3):
        envs.append(gymnasium.make("maglev/Stage3DOF-v0", **{"render_mode": "rgb_array", **given}))
        envs[rank].action_space.seed(3 + rank)
    assert len({id(env.unwrapped) for env in envs}) == 3
    assert [env.get_wrapper_attr("render_mode") for env in envs] == ["rgb_array"] * 3
    buffer = np.zeros((3, *envs[0].observation_space.shape), envs[0].observation_space.dtype)
    for rank, env in enumerate(envs):
        buffer[rank], _ = env.reset(seed=3 + rank, options={})
        for sample in range(20):
            buffer[rank], reward, terminated, truncated, info = env.step(env.action_space.sample())
            assert (terminated, truncated) == (False, sample == 19)
            assert isinstance(info, dict) and np.isfinite(reward)
        assert env.reset()[0][0] == 24e-3 != buffer[rank, 0]
        assert env.render().shape == (240, 480, 3)
        env.close()
    assert len({row.tobytes() for row in buffer}) == 3
    ours: Any = gymnasium.make_vec("maglev/Stage3DOF-v0", 2, "sync", render_mode="rgb_array", **given)
    ours.reset(seed=1)
    assert [picture.shape for picture in ours.render()] == [(240, 480, 3)] * 2
    ours.close()
