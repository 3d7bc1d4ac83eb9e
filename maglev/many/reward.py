"""The reward of a sample: weights of named terms, or a function of users, for one environment or for many."""

from collections.abc import Callable, Mapping, Sequence
from math import isfinite
from numbers import Real
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError, in_one_line, nearest
from pmlsm.stage_description import StageDescription

Signals = Mapping[str, npt.NDArray[Any]]   # by name, shape (environments,)
Weights = Mapping[str, float]
Columns = Sequence[float] | Array
Function = Callable[[Signals], npt.ArrayLike]

DEFAULT: Weights = {"alive": 1.0, "error": -1.0, "current": -0.1}


class Seen(NamedTuple):
    """A sample: of each axis, or motor current, a number, or an array of as many as there are environments."""

    positions: Columns    # true, m and rad
    references: Columns
    velocities: Columns   # measured, m/s and rad/s
    currents: Columns     # delivered direct and quadrature currents, A
    at_stop: Any


class Reward:
    """The reward of a sample, with travels of the axes between their stops (m, rad) and the peak of the currents (A).

    `given` are weights of terms. "alive" is 1, and "stop" is 1 where an axis is beyond an end stop. "error" is the mean
    over axes of ((reference − position) / travel)², "y.error" that of one axis. "current" is the mean of (current /
    peak)², and "speed" the mean over axes of (velocity · 1 s / travel)².

    Instead of weights, a function of signals can return the rewards, shape (environments,). The signals are by name,
    such as "y.position", "y.reference", "y.velocity", "alpha.i_d" and "at_stop", each of the same shape.

    ScenarioError if a term is unknown, a weight is no number, or the function gives none for an environment.
    """

    def __init__(self, given: Weights | Function, stage: StageDescription, travels: Sequence[float], peak: float):
        self.function = given if callable(given) else None
        self.names = [f"{axis}.{what}" for what in ("position", "reference", "velocity") for axis in stage.axis_names]
        self.names += stage.dq_names
        self.alive = 0.0
        self.terms: list[tuple[str, Callable[[Seen], Any]]] = []   # by their names in `info`
        if self.function is not None:
            count = 2   # a function that takes one environment only is refused here, too
            self.called({**{name: np.zeros(count) for name in self.names}, "at_stop": np.zeros(count, bool)}, count)
            return
        if not isinstance(given, Mapping):
            raise ScenarioError(f"reward = {given!r}, expected weights by term, such as {dict(DEFAULT)}, or a function")
        known = ["alive", "error", *(f"{axis}.error" for axis in stage.axis_names), "current", "speed", "stop"]
        for name, weight in given.items():
            if name not in known:
                raise ScenarioError(f"reward: there is no term {name!r}; {nearest(str(name), known)}")
            if isinstance(weight, bool) or not isinstance(weight, Real) or not isfinite(weight):
                raise ScenarioError(f"reward: {name} = {weight!r}, expected a number")
            if name == "alive":
                self.alive = float(weight)
            else:
                self.terms.append((f"reward_{name}", term(name, float(weight), stage, travels, peak)))

    def of(self, seen: Seen) -> tuple[Any, dict[str, Any]]:
        """Reward of a sample, and the terms in it with their weights, as `info` has them."""
        if self.function is not None:
            columns = [*seen.positions, *seen.references, *seen.velocities, *seen.currents]
            # In a row each, so that a library computes one environment like many.
            signals = {name: np.array(column, np.float64, ndmin=1) for name, column in
                       zip(self.names, columns, strict=True)} | {"at_stop": np.array(seen.at_stop, bool, ndmin=1)}
            rewards = self.called(signals, len(signals["at_stop"]))
            return (float(rewards[0]) if isinstance(seen.at_stop, bool) else rewards), {}
        reward: Any = self.alive
        terms: dict[str, Any] = {}
        for name, value_of in self.terms:
            terms[name] = value = value_of(seen)
            reward = reward + value
        return reward, terms

    def called(self, signals: dict[str, npt.NDArray[Any]], count: int) -> Any:
        """Return the rewards of the user's function."""
        assert self.function is not None
        try:
            rewards = np.asarray(self.function(Named(signals)), np.float64)
        except ScenarioError:
            raise
        except Exception as error:
            raise ScenarioError(f"reward: the function ends with {in_one_line(error)}, expected one of arrays of shape "
                                "(environments,)") from error
        if rewards.shape != (count,):
            raise ScenarioError(f"reward: the function gives the shape {rewards.shape}, expected ({count},): a number "
                                "for each environment")
        finite = np.isfinite(rewards)
        if not finite.all():
            raise ScenarioError(f"reward: the function gives {rewards[~finite][0]}, expected a number for each "
                                "environment")
        return rewards


class Named(dict[str, npt.NDArray[Any]]):
    def __missing__(self, name: str) -> npt.NDArray[Any]:
        raise ScenarioError(f"reward: there is no signal {name!r}; {nearest(str(name), self)}")


def term(name: str, weight: float, stage: StageDescription, travels: Sequence[float], peak: float) -> Callable[[Seen],
                                                                                                               Any]:
    """A term with its weight; sums go in the order of axes and currents, for one environment as for many."""
    axes = slice(None)
    if name.endswith(".error"):
        k = stage.axis_names.index(name.removesuffix(".error"))
        axes = slice(k, k + 1)
    scales = [weight / len(travels[axes]) / travel**2 for travel in travels[axes]]
    of_current = weight / len(stage.dq_names) / peak**2

    def error(seen: Seen) -> Any:
        total = 0.0
        for scale, reference, position in zip(scales, seen.references[axes], seen.positions[axes], strict=True):
            total += scale * ((reference - position) * (reference - position))
        return total

    def current(seen: Seen) -> Any:
        total = 0.0
        for value in seen.currents:
            total += of_current * value * value
        return total

    def speed(seen: Seen) -> Any:
        total = 0.0
        for scale, velocity in zip(scales, seen.velocities, strict=True):
            total += scale * (velocity * velocity)
        return total

    def stop(seen: Seen) -> Any:
        return weight * seen.at_stop

    return {"current": current, "speed": speed, "stop": stop}.get(name, error)
