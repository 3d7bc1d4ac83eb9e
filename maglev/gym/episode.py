"""What an episode begins with: parameters of the plant, fixed or drawn anew, and references, drawn or of the user's."""

from collections.abc import Mapping, Sequence
from math import pi
from typing import Any

import numpy as np
import numpy.typing as npt
from fmpy.model_description import ScalarVariable

from maglev.arrays import Array
from maglev.errors import ScenarioError, UnknownName
from maglev.parameter import Parameter, require_parameter
from maglev.waves import sines_cosines

Value = float | str | bool                # SI, or text with a unit such as "25 mm"
Setting = Value | Sequence[Value]         # a pair: drawn between the two, in every episode

KINDS = ("hold", "setpoints", "sinusoids")
OMEGA0 = 1.5 * pi      # rad/s, the sinusoids of the thesis (section 5.6.4)
SETPOINT_TIME = 1.0    # s from one set-point to the next


class Parameters:
    """Start values of the `plant`, or of another part, by their names, such as "y.friction.coulomb".

    `known` are its variables that can be given. UnknownName for another one, ScenarioError if a value cannot be used.
    """

    def __init__(self, part: str, known: Mapping[str, ScalarVariable], settings: Mapping[str, Setting]):
        self.part = part
        self.known = known
        self.ranges = {name: self.range_of(name, setting) for name, setting in settings.items()}

    def range_of(self, name: str, setting: Setting) -> tuple[float | bool, float | bool]:
        """Range in which a parameter is drawn; twice the same for a single value."""
        require_parameter(name, self.known, f"the {self.part}", UnknownName)
        pair = setting if isinstance(setting, Sequence) and not isinstance(setting, str) else (setting, setting)
        if len(pair) != 2:
            raise ScenarioError(f"{name} = {setting!r}, expected a value or a pair of values, low and high")
        low, high = (self.value_of(name, value) for value in pair)
        if not low <= high:
            raise ScenarioError(f"{name} = {setting!r}, expected the lower value first")
        return low, high

    def value_of(self, name: str, value: Any) -> float | bool:
        """A parameter's value in SI."""
        return Parameter.described(self.known[name]).read(value, name, ScenarioError)

    def extremes(self, name: str) -> tuple[float, float]:
        """Smallest and largest value that a parameter can have; the part's own if none is given."""
        low, high = self.ranges.get(name, (self.own(name), self.own(name)))
        return float(low), float(high)

    def own(self, name: str) -> float:
        """Value that the part has if none is given."""
        return float(self.known[name].start)

    def draw(self, random: np.random.Generator, settings: Mapping[str, Setting]) -> dict[str, float | bool]:
        """Values for one episode, in which some settings go before those of all episodes."""
        ranges = {**self.ranges, **{name: self.range_of(name, setting) for name, setting in settings.items()}}
        return {name: low if low == high else self.drawn(random, low, high) for name, (low, high) in ranges.items()}

    def drawn(self, random: np.random.Generator, low: float | bool, high: float | bool) -> float | bool:
        """A value between two, which are not the same; of a Boolean, either."""
        return bool(random.integers(2)) if isinstance(low, bool) else float(random.uniform(low, high))


class References:
    """References of every sample of an episode.

    Parameters
    ----------
    kind : str or array_like, shape (samples, axes)
        "hold": where the mover starts. "setpoints": a new set-point for every axis each second, from the middle half of
        its travel. "sinusoids": about where the mover starts, with ω0 = 1.5π rad/s and an amplitude of up to a quarter
        of the travel. Or references (m) of the samples; after the last one it holds.
    low, high : ndarray, shape (axes,)
        Ends of the travel, m.
    count : int
        Samples of an episode, both ends included.
    sample_time : float
        Of the environment, s.

    Raises
    ------
    ScenarioError
        If the kind is unknown, or the table does not fit.
    """

    def __init__(self, kind: str | npt.ArrayLike, low: Array, high: Array, count: int, sample_time: float):
        self.kind = kind if isinstance(kind, str) else "table"
        if isinstance(kind, str) and kind not in KINDS:
            raise ScenarioError(f"reference = {kind!r}, expected {', '.join(map(repr, KINDS))}, or an array")
        self.low, self.high = low, high
        times = sample_time * np.arange(count)
        self.given = table(kind, low, high)[:count] if self.kind == "table" else np.zeros((0, len(low)))
        self.most = int(times[-1] / SETPOINT_TIME) + 2   # set-points: one more than a rounding of times can ask for
        self.which = np.zeros(count, int)   # of the points of an episode, by sample
        self.wave = np.zeros(count)         # times the amplitudes of an episode
        if self.kind == "table":
            self.which = np.minimum(np.arange(count), len(self.given) - 1)
        elif self.kind == "setpoints":
            self.which = (times / SETPOINT_TIME + 1e-9).astype(int)
        elif self.kind == "sinusoids":
            self.wave = sines_cosines(OMEGA0 * times)[0]

    def draw(self, random: np.random.Generator, start: Array) -> tuple[Array, Array]:
        """Of an episode that starts at places (m): its points, shape (points, axes), and amplitudes, shape (axes,)."""
        points, amplitudes = start[None, :].copy(), np.zeros(len(self.low))
        if self.kind == "table":
            points = self.given
        elif self.kind == "setpoints":
            quarter = 0.25 * (self.high - self.low)
            points = random.uniform(self.low + quarter, self.high - quarter, (self.most, len(self.low)))
        elif self.kind == "sinusoids":
            room = np.minimum(start - self.low, self.high - start)
            amplitudes = random.uniform(0.0, np.minimum(room, 0.25 * (self.high - self.low)))
        return points, amplitudes

    def at(self, sample: int, points: Array, amplitudes: Array) -> Array:
        """References of a sample of an episode, m."""
        found: Array = points[self.which[sample]] + self.wave[sample] * amplitudes
        return found


def table(given: npt.ArrayLike, low: Array, high: Array) -> Array:
    """References of a user's table, shape (samples, axes)."""
    found = np.asarray(given, dtype=np.float64)
    if found.ndim != 2 or found.shape[1] != len(low) or not len(found):
        raise ScenarioError(f"reference of shape {found.shape}, expected (samples, {len(low)}), an axis a column")
    if not ((found >= low) & (found <= high)).all():
        raise ScenarioError(f"reference from {found.min()} m to {found.max()} m, expected every axis between its stops")
    return found
