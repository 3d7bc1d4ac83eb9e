"""What episodes draw: the distributions that are asked for, changes in mid-run, and refusals of the rest."""

from typing import Any

import numpy as np
import pytest
from facts import raises
from fmpy.model_description import ScalarVariable
from scipy import stats

from maglev.files.errors import MaglevError, ScenarioError, UnknownName
from maglev.many.episode_draws import Draw, Parameters, Settings, sample_of


def variable(name: str, kind: str = "Real", unit: str | None = None, low: str | None = None,
             variability: Any = "tunable", start: str = "1") -> ScalarVariable:
    return ScalarVariable(name=name, valueReference=0, type=kind, unit=unit, min=low,
                          causality="parameter", variability=variability, start=start)


KNOWN = {each.name: each for each in (
    variable("y.mass", unit="kg", low="0.001"), variable("x.mass", unit="kg", low="2"), variable("delay", unit="s",
                                                                                               variability="fixed"),
    variable("open", "Boolean", start="false"), variable("y.stop.upper", unit="m"))}


def parameters(settings: Settings) -> Parameters:
    return Parameters("plant", KNOWN, settings)


DISTRIBUTIONS: dict[str, tuple[Any, Any]] = {
    "pair": (("6 kg", "8 kg"), stats.uniform(6.0, 2.0)),
    "pair of NumPy": (np.array([6, 8]), stats.uniform(6.0, 2.0)),
    "uniform": ({"uniform": (6.0, 8.0)}, stats.uniform(6.0, 2.0)),
    "log-uniform": ({"log-uniform": ("100 g", "10 kg")}, stats.loguniform(0.1, 10.0)),
    "normal": ({"normal": ("7 kg", "200 g")}, stats.norm(7.0, 0.2)),
    "normal, cut off": ({"normal": (1.0, 1.0)}, stats.truncnorm(0.001 - 1.0, np.inf, 1.0, 1.0))}


@pytest.mark.parametrize("what", DISTRIBUTIONS)
def test_draws_have_the_distribution_that_is_asked_for(what: str) -> None:
    setting, expected = DISTRIBUTIONS[what]
    random, asked = np.random.default_rng(1), parameters({"y.mass": setting})
    found = [asked.draw(random, {}).values["y.mass"] for _ in range(1000)]
    assert stats.kstest(found, expected.cdf).pvalue > 0.01
    assert stats.kstest(found, stats.uniform(5.0, 4.0).cdf).pvalue < 1e-6, "another one is told from it"


def test_choices_are_equally_likely_and_several_names_have_one_value() -> None:
    random, asked = np.random.default_rng(2), parameters({"y.mass, x.mass": {"choice": [3.0, "4 kg", 5.0, 6.0]}})
    assert parameters({"y.mass": {"choice": np.array([3, 4])}}).extremes("y.mass") == (3.0, 4.0)
    found = [asked.draw(random, {}).values for _ in range(800)]
    assert all(each["y.mass"] == each["x.mass"] for each in found)
    counts = np.unique([each["y.mass"] for each in found], return_counts=True)
    assert counts[0].tolist() == [3.0, 4.0, 5.0, 6.0]
    assert stats.chisquare(counts[1]).pvalue > 0.01


def test_a_function_gives_a_table_for_an_episode() -> None:
    """By the episode's random numbers, in which what it gives can be drawn again."""
    asked = parameters(lambda random: {"y.mass": 5.0 + random.random(), "open": {"choice": [True, False]}})
    first, again, other = (asked.draw(np.random.default_rng(seed), {}).values for seed in (3, 3, 4))
    assert first == again != other
    assert first["y.mass"] == 5.0 + np.random.default_rng(3).random() and isinstance(first["open"], bool)


def test_changes_are_drawn() -> None:
    asked = parameters({"y.mass": {"at": ("0.2 s", "0.4 s"), "then": {"normal": (8.0, 0.1)}, "for": "20 ms"},
                        "open": {"at": 1.0, "then": True}})
    drawn = asked.draw(np.random.default_rng(5), {})
    assert drawn.values == {} and drawn.changes["open"] == {"at": 1.0, "then": True}
    assert 0.2 <= drawn.changes["y.mass"]["at"] <= 0.4 and drawn.changes["y.mass"]["for"] == 0.02
    assert asked.draw(np.random.default_rng(5), {"y.mass": 7.0}).values == {"y.mass": 7.0}


@pytest.mark.parametrize(("time", "sample"), [(0.0, 0), (0.4e-3, 2), (0.41e-3, 3), (3 * 0.2e-3, 3), (1e-9, 1)])
def test_a_change_acts_from_the_first_sample_on_that_begins_then(time: float, sample: int) -> None:
    assert sample_of(time, 0.2e-3) == sample


@pytest.mark.parametrize(("settings", "kind", "facts"), [
    ({"y.mass": {"gaussian": (1.0, 2.0)}}, ScenarioError,
     ["y.mass", "'gaussian'", "'uniform', 'log-uniform', 'normal', 'choice'"]),
    ({"y.mass": {"normol": (1.0, 2.0)}}, ScenarioError, ["y.mass", "'normol'", "'normal'"]),
    ({"y.mass": {}}, ScenarioError, ["y.mass", "'uniform'"]),
    ({"y.mass": {"uniform": (1.0, 2.0), "normal": (1.0, 2.0)}}, ScenarioError, ["y.mass", "one of"]),
    ({"y.mass": {"normal": 7.0}}, ScenarioError, ["y.mass", "mean", "deviation", "0"]),
    ({"y.mass": {"normal": (7.0, 0.0)}}, ScenarioError, ["y.mass", "mean", "deviation", "0"]),
    ({"y.mass": {"normal": (-7.0, 1.0)}}, ScenarioError, ["y.mass", "-7 kg", "0.001"]),
    ({"y.mass": {"normal": ("7 mm", 1.0)}}, ScenarioError, ["y.mass", "'7 mm'", "kg"]),
    ({"y.mass": {"log-uniform": (3.0, 2.0)}}, ScenarioError, ["y.mass", "lower value"]),
    ({"delay": {"log-uniform": (0.0, 2.0)}}, ScenarioError, ["delay", "0"]),
    ({"y.mass": {"choice": []}}, ScenarioError, ["y.mass", "one value"]),
    ({"y.mass, x.mass": 1.0}, ScenarioError, ["y.mass, x.mass", "1 kg", "2"]),
    ({"y.mass, w.mass": 1.0}, UnknownName, ["plant", "'w.mass'", "'y.mass'"]),
    ({"open": {"normal": (True, False)}}, ScenarioError, ["open", "mean", "deviation"]),
    ({"open": {"at": 1.0}}, ScenarioError, ["open", "'at'", "'then'"]),
    ({"open": {"at": 1.0, "then": True, "until": 2.0}}, ScenarioError, ["open", "'until'", "'at'", "'then'", "'for'"]),
    ({"open": {"at": -1.0, "then": True}}, ScenarioError, ["open", "at", "-1 s", "0"]),
    ({"delay": {"at": 1.0, "then": 0.1}}, ScenarioError, ["delay", "episode"]),
    ("y.mass=7", ScenarioError, ["plant", "'y.mass=7'", "table"]), ({7: 1.0}, ScenarioError, ["plant", "7", "table"]),
    (lambda _: {"y.maas": 1.0}, UnknownName, ["plant", "'y.maas'", "'y.mass'"]),
    (lambda _: {"y.stop.upper": 1.0}, ScenarioError, ["y.stop.upper"]),
    (lambda _: 7.0, ScenarioError, ["7.0", "table"])],
                         ids=lambda given: "a function" if callable(given) else str(given))
def test_refused(settings: Settings, kind: type[MaglevError], facts: list[str]) -> None:
    with raises(kind, *facts):
        parameters(settings)


def test_what_the_observation_space_needs_has_ends() -> None:
    assert parameters({"y.stop.upper": {"choice": [0.03, 0.02]}}).extremes("y.stop.upper") == (0.02, 0.03)
    with raises(ScenarioError, "y.stop.upper", "choice"):
        parameters({"y.stop.upper": {"normal": (0.03, 0.001)}}).extremes("y.stop.upper")


def test_a_normal_value_that_never_fits_is_refused() -> None:
    with raises(ScenarioError, "1000 draws"):
        Draw("normal", (0.0, 1e9), 0.0, 1e-3).drawn(np.random.default_rng(0))
