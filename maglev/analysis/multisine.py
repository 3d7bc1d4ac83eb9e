"""A sum of sines with a common period, which excites a loop: its lines, and its crest factor."""

from dataclasses import dataclass
from math import pi

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import LinearModelError
from maglev.scenario.waves import period_of

CLIP = 0.85          # of the peak, at which a signal is clipped before its phases are taken again
CLIPPINGS = 40
DIGITS = 9           # of a phase in rad: beyond them it is a library's, and another machine's others


@dataclass(frozen=True)
class Grid:
    samples: int                 # of a period
    harmonics: tuple[int, ...]   # numbers of the lines: periods of each in a period
    step: float                  # sample time, s

    @property
    def period(self) -> float:
        """Period of the whole signal, s."""
        return self.samples * self.step

    @property
    def frequencies(self) -> Array:
        """Frequencies of the lines, rad/s, shape (lines,)."""
        return 2.0 * pi / self.period * np.array(self.harmonics)


def make_grid(lowest: float, highest: float, lines: int, step: float) -> Grid:
    """Return lines spread evenly over the logarithm of the frequency, as far as they are harmonics of the lowest.

    `lowest`, from which the period follows, and `highest` are in rad/s, the sample time `step` in s. Where neighbouring
    lines would fall on one harmonic there are fewer. LinearModelError if that is no grid below half the sample rate.
    """
    if not (0.0 < lowest <= highest < pi / step and lines >= 1):
        raise LinearModelError(f"{lines} lines from {lowest:g} to {highest:g} rad/s, expected at least one, from above "
                               f"0 to below half the sample rate, {pi / step:g} rad/s")
    samples = max(2, round(2.0 * pi / (lowest * step)))
    most = int(highest * samples * step / (2.0 * pi) + 1e-9)
    return Grid(samples, tuple(np.unique(np.geomspace(1, max(most, 1), lines).round().astype(int)).tolist()), step)


def multisine(grid: Grid, peak: float, seed: int) -> Array:
    """Return one period, shape (samples,), of lines with one amplitude and random phases, scaled to a peak.

    The phases are improved by clipping (van der Ouderaa, Schoukens, Renneboog, IEEE Trans. Instrum. Meas. 37, 1988):
    the clipped signal keeps its phases, and gets its amplitudes back.
    """
    random = np.random.default_rng(seed)
    lines = np.array(grid.harmonics)
    phases = random.uniform(0.0, 2.0 * pi, len(lines))
    best, least = np.zeros(0), np.inf
    for _ in range(CLIPPINGS if len(lines) > 1 else 1):
        phases = phases.round(DIGITS)
        signal = period_of(grid.samples, grid.harmonics, phases)
        if crest_factor(signal) < least:
            best, least = signal, crest_factor(signal)
        most = CLIP * np.abs(signal).max()
        phases = np.angle(np.fft.rfft(np.clip(signal, -most, most))[lines])
    return np.asarray(peak / np.abs(best).max() * best)


def crest_factor(signal: Array) -> float:
    """Peak over root mean square."""
    return float(np.abs(signal).max() / np.sqrt(np.mean(signal ** 2)))
