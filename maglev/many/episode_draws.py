"""Random draws of an episode: parameters of a part, their changes, by users' tables or functions; and references."""

from collections.abc import Callable, Mapping, Sequence
from math import ceil, inf, pi
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from fmpy.model_description import ScalarVariable

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError, UnknownName, nearest, require_table, shortened, similar
from maglev.fmi.parameter import Parameter, require_parameter
from maglev.scenario.waves import sines_cosines
from pmlsm.exponential import exponential
from pmlsm.logarithm import logarithm

Value = float | str | bool                                # SI, or text with a unit such as "25 mm"
Setting = Value | Sequence[Value] | Mapping[str, Any]     # a pair: drawn between the two, in every episode
Table = Mapping[str, Setting]
Settings = Table | Callable[[np.random.Generator], Table]

KINDS = ("uniform", "log-uniform", "normal", "choice")
CHANGE = ("at", "then", "for")
MOST_DRAWS = 1000   # of a normal value until one is in the parameter's range
TIME, SPAN = (Parameter("s", low=low, high=1e6) for low in (0.0, 1e-6))   # s: when something changes, and for how long
REFERENCES = ("hold", "setpoints", "sinusoids")
OMEGA0 = 1.5 * pi      # rad/s, the sinusoids of the thesis (section 5.6.4)
SETPOINT_TIME = 1.0    # s from one setpoint to the next


class Draw(NamedTuple):
    """The distribution of a value: its kind, of `KINDS`, its numbers in SI, and the allowed range."""

    kind: str
    values: tuple[float | bool, ...]
    low: float
    high: float

    def drawn(self, random: np.random.Generator) -> float | bool:
        """A value for one episode."""
        first, last = self.values[0], self.values[-1]
        if self.kind == "choice":
            return self.values[int(random.integers(len(self.values)))]
        if self.kind == "normal":
            for _ in range(MOST_DRAWS):
                value = float(random.normal(first, last))
                if self.low <= value <= self.high:
                    return value
            raise ScenarioError(f"normal, {first:g}, {last:g}: {MOST_DRAWS} draws are all out of range, expected a "
                                f"deviation that fits {self.low:g} to {self.high:g}")
        if first == last:
            return first
        if isinstance(first, bool):
            return bool(random.integers(2))
        if self.kind == "log-uniform":
            return min(max(first * exponential(random.uniform(0.0, logarithm(last / first))), first), last)
        return float(random.uniform(first, last))


def read_draw(place: str, setting: Any, parameter: Parameter) -> Draw:
    """A draw as a user writes it: a value, a pair, or a table such as {"normal": ("7 kg", "0.2 kg")}."""
    setting = plain_numbers(setting)
    if not isinstance(setting, Mapping):
        pair = setting if isinstance(setting, Sequence) and not isinstance(setting, str) else (setting, setting)
        if len(pair) != 2:
            raise ScenarioError(f"{place} = {setting!r}, expected a value or a pair of values, low and high")
        kind, given = "uniform", pair
    else:
        if len(setting) != 1 or (kind := next(iter(setting))) not in KINDS:
            wrong = next((kind for kind in setting if kind not in KINDS), "")
            raise ScenarioError(f"{place} = {dict(setting)!r}, expected one of {', '.join(map(repr, KINDS))} with its "
                                f"values{similar(wrong, KINDS)}")
        given = plain_numbers(setting[kind])
        count = len(given) if isinstance(given, Sequence) and not isinstance(given, str) else 0
        if not count or (kind != "choice" and count != 2):
            raise ScenarioError(f"{place} = {dict(setting)!r}, expected {wanted(kind)}")
    # A deviation is a difference, which no range of the parameter is about.
    ranged = [parameter] * len(given) if kind != "normal" else [parameter, parameter._replace(low=0.0, high=inf)]
    values = tuple(known.read(value, place, ScenarioError) for value, known in zip(given, ranged, strict=True))
    if kind == "normal" and (isinstance(values[0], bool) or not values[1] > 0.0):
        raise ScenarioError(f"{place} = {setting!r}, expected {wanted(kind)}")
    if kind in KINDS[:2] and not values[0] <= values[1]:
        raise ScenarioError(f"{place} = {setting!r}, expected the lower value first")
    if kind == "log-uniform" and (isinstance(values[0], bool) or not values[0] > 0.0):
        raise ScenarioError(f"{place} = {setting!r}, expected values above 0, for the scale is logarithmic")
    return Draw(kind, values, parameter.low, parameter.high)


def plain_numbers(given: Any) -> Any:
    """An array of NumPy, or a Series of pandas, as its numbers."""
    return given.tolist() if hasattr(given, "tolist") else given


def wanted(kind: str) -> str:
    """Return the expected arguments of a kind in words."""
    return {"choice": "at least one value to choose from",
            "normal": "a mean and a deviation above 0"}.get(kind, "two values, low and high")


# A parameter that changes at a time (s), perhaps for a limited time: "at", "then" and perhaps "for".
Change = dict[str, Draw]


class Drawn(NamedTuple):
    """The draw of one episode: values by name, and changes by name, with "at", "then" and maybe "for"."""

    values: dict[str, float | bool]
    changes: dict[str, dict[str, float | bool]]


class Parameters:
    """Start values of the `plant`, or of another part, by their names, such as "y.friction.coulomb".

    Names with commas between have one value. `known` are the variables that can be given. UnknownName for another one,
    ScenarioError if a value cannot be used.
    """

    def __init__(self, part: str, known: Mapping[str, ScalarVariable], settings: Settings):
        self.part = part
        self.known = known
        if not callable(settings):
            require_table(settings, f"parameters of the {part}", ScenarioError, "{'NAME': 4.5}, or a function")
        self.function = settings if callable(settings) else lambda _: {}
        self.draws = {} if callable(settings) else self.read(settings)
        self.read(self.given(np.random.default_rng(0)))   # wrong names are refused where the environment is made

    def given(self, random: np.random.Generator) -> Table:
        """Return the value of the user's function for an episode."""
        drawn = self.function(random)
        if not isinstance(drawn, Mapping):
            raise ScenarioError(f"the function of the {self.part}'s parameters gives {drawn!r}, expected a table: "
                                "values by name")
        self.require_free(drawn, f"the function of the {self.part}'s parameters")
        return drawn

    def require_free(self, names: Mapping[str, Any], origin: str) -> None:
        """Refuse a parameter that the observation space depends on."""
        for name in names:
            if ".stop." in name:
                raise ScenarioError(f"{name} in {origin}, expected in the table where the environment is made: the "
                                    "observation space has the stops")

    def read(self, settings: Table) -> dict[str, Draw | Change]:
        return {key: self.read_one(key, setting) for key, setting in settings.items()}

    def read_one(self, key: str, setting: Setting) -> Draw | Change:
        """Draw or change of a name, or of several with commas between."""
        names = key_names(key)
        for name in names:
            require_parameter(name, self.known, f"the {self.part}", UnknownName)
        given = [Parameter.described(self.known[name]) for name in names]
        if not isinstance(setting, Mapping) or not {*setting} & {*CHANGE}:
            return self.of_all(key, setting, given)
        for word in setting:
            if word not in CHANGE:
                raise ScenarioError(f"{key}: {word!r}, expected 'at', 'then' and 'for'; {nearest(word, CHANGE)}")
        if not {"at", "then"} <= {*setting}:
            raise ScenarioError(f"{key} = {dict(setting)!r}, expected 'at' and 'then': when it changes, and to what")
        for name in names:
            if not can_change(self.known[name]):
                raise ScenarioError(f"{name} = {dict(setting)!r}, expected a value or a draw: it cannot change in an "
                                    "episode")
        taken = {"at": [TIME], "then": given, "for": [SPAN]}
        return {word: self.of_all(f"{key}: {word}", setting[word], taken[word]) for word in CHANGE if word in setting}

    def of_all(self, place: str, setting: Setting, given: Sequence[Parameter]) -> Draw:
        """The draw of several parameters, which each of them has to be able to take."""
        draws = [read_draw(place, setting, parameter) for parameter in given]
        return draws[0]._replace(low=max(draw.low for draw in draws), high=min(draw.high for draw in draws))

    def extremes(self, name: str) -> tuple[float, float]:
        """Smallest and largest value that a parameter can have; the part's own if none is given."""
        matching = [draw for key, draw in self.draws.items() if name in key_names(key)]
        if not matching:
            return self.own(name), self.own(name)
        last = matching[-1]
        if not isinstance(last, Draw) or last.kind == "normal":
            raise ScenarioError(f"{name}: expected a value, a pair or a choice, for the observation space has its ends")
        return float(min(last.values)), float(max(last.values))

    def own(self, name: str) -> float:
        """Value that the part has if none is given."""
        start = self.known[name].start
        return float({"true": 1.0, "false": 0.0}.get(start, start))

    def draw(self, random: np.random.Generator, settings: Table) -> Drawn:
        """Values for one episode, in which some settings go before those of all episodes."""
        draws = {**self.draws, **self.read(self.given(random)), **self.read(settings)}
        values: dict[str, float | bool] = {}
        changes: dict[str, dict[str, float | bool]] = {}
        for key, draw in draws.items():
            if isinstance(draw, Draw):
                values |= dict.fromkeys(key_names(key), draw.drawn(random))
            else:
                change = {word: made.drawn(random) for word, made in draw.items()}
                changes |= dict.fromkeys(key_names(key), change)
        return Drawn(values, changes)


def can_change(variable: ScalarVariable) -> bool:
    return bool(variable.causality == "input" or variable.variability == "tunable")


def key_names(key: str) -> list[str]:
    return [name.strip() for name in key.split(",")]


def sample_of(time: float, sample_time: float) -> int:
    """Number of the first sample that begins at a time (s), or after it."""
    return ceil(time / sample_time - 1e-9)


class References:
    """References of every sample of an episode, of `count` samples with both its ends, `sample_time` (s) apart.

    "hold": where the mover starts. "setpoints": a new setpoint for every axis each second, from the middle half of its
    travel between `low` and `high`, (axes,), m. "sinusoids": about where the mover starts, with ω0 = 1.5π rad/s and an
    amplitude of up to a quarter of the travel. Or references (m) of the samples, (samples, axes); after the last one it
    holds. ScenarioError if the kind is unknown, or the table does not fit.
    """

    def __init__(self, kind: str | npt.ArrayLike, low: Array, high: Array, count: int, sample_time: float):
        self.kind = kind if isinstance(kind, str) else "table"
        if isinstance(kind, str) and kind not in REFERENCES:
            raise ScenarioError(f"reference = {kind!r}, expected {', '.join(map(repr, REFERENCES))}, or an array")
        self.low, self.high = low, high
        times = sample_time * np.arange(count)
        self.given = table_references(kind, low, high)[:count] if self.kind == "table" else np.zeros((0, len(low)))
        self.most = int(times[-1] / SETPOINT_TIME) + 2   # setpoints: one more than a rounding of times can ask for
        self.which = np.zeros(count, int)   # of the points of an episode, by sample
        self.wave = np.zeros(count)         # times the amplitudes of an episode
        if self.kind == "table":
            self.which = np.minimum(np.arange(count), len(self.given) - 1)
        elif self.kind == "setpoints":
            self.which = (times / SETPOINT_TIME + 1e-9).astype(int)
        elif self.kind == "sinusoids":
            self.wave = sines_cosines(OMEGA0 * times)[0]

    def draw(self, random: np.random.Generator, start: Array) -> tuple[Array, Array]:
        """Return points, shape (points, axes), and amplitudes, shape (axes,), of an episode that starts at places (m).
        """
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
        reference: Array = points[self.which[sample]] + self.wave[sample] * amplitudes
        return reference


def table_references(given: npt.ArrayLike, low: Array, high: Array) -> Array:
    """References of a user's table, shape (samples, axes)."""
    try:
        rows = np.asarray(given, dtype=np.float64)
    except (TypeError, ValueError):
        raise ScenarioError(f"reference = {shortened(given)}, expected an array of numbers, (samples, {len(low)})"
                            ) from None
    if rows.ndim != 2 or rows.shape[1] != len(low) or not len(rows):
        raise ScenarioError(f"reference of shape {rows.shape}, expected (samples, {len(low)}), an axis a column")
    if not ((rows >= low) & (rows <= high)).all():
        raise ScenarioError(f"reference from {rows.min()} m to {rows.max()} m, expected every axis between its stops")
    return rows
