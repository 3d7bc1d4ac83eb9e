"""References of an episode, drawn or of the user's."""

from math import pi

import numpy as np
import numpy.typing as npt

from maglev.arrays import Array
from maglev.errors import ScenarioError
from maglev.waves import sines_cosines

KINDS = ("hold", "setpoints", "sinusoids")
OMEGA0 = 1.5 * pi      # rad/s, the sinusoids of the thesis (section 5.6.4)
SETPOINT_TIME = 1.0    # s from one setpoint to the next


class References:
    """References of every sample of an episode, of `count` samples with both its ends, `sample_time` (s) apart.

    "hold": where the mover starts. "setpoints": a new setpoint for every axis each second, from the middle half of its
    travel between `low` and `high`, (axes,), m. "sinusoids": about where the mover starts, with ω0 = 1.5π rad/s and an
    amplitude of up to a quarter of the travel. Or references (m) of the samples, (samples, axes); after the last one it
    holds. ScenarioError if the kind is unknown, or the table does not fit.
    """

    def __init__(self, kind: str | npt.ArrayLike, low: Array, high: Array, count: int, sample_time: float):
        self.kind = kind if isinstance(kind, str) else "table"
        if isinstance(kind, str) and kind not in KINDS:
            raise ScenarioError(f"reference = {kind!r}, expected {', '.join(map(repr, KINDS))}, or an array")
        self.low, self.high = low, high
        times = sample_time * np.arange(count)
        self.given = table(kind, low, high)[:count] if self.kind == "table" else np.zeros((0, len(low)))
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
        reference: Array = points[self.which[sample]] + self.wave[sample] * amplitudes
        return reference


def table(given: npt.ArrayLike, low: Array, high: Array) -> Array:
    """References of a user's table, shape (samples, axes)."""
    rows = np.asarray(given, dtype=np.float64)
    if rows.ndim != 2 or rows.shape[1] != len(low) or not len(rows):
        raise ScenarioError(f"reference of shape {rows.shape}, expected (samples, {len(low)}), an axis a column")
    if not ((rows >= low) & (rows <= high)).all():
        raise ScenarioError(f"reference from {rows.min()} m to {rows.max()} m, expected every axis between its stops")
    return rows
