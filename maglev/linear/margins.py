"""Stability margins of a loop opened at one signal."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import degrees, inf, pi

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq, minimize_scalar

from maglev.files.arrays import Array, Complex
from maglev.linear.model import LinearModel

LOWEST = 1e-2          # rad/s, where frequencies begin
PER_DECADE = 300       # frequencies on which crossings and peaks are looked for, before they are refined
FREQUENCY = 1e-10      # relative accuracy of a refined frequency
NOTHING = 1e-300       # gain of a loop that is open, instead of 0
AT_REST = 1e-6         # distance from z = 1 within which a pole is taken for an integrator


@dataclass(frozen=True)
class Margins:
    """Distance of a stable loop L, opened at one signal, from instability.

    Attributes
    ----------
    at : str
        The signal.
    gain_down, gain_up : float
        The loop stays stable while its gain is multiplied by a factor between these; 0 and inf where there is no end.
        An unstable plant has a lower end: it needs feedback.
    phase : float
        Smallest angle of L from −1 where |L| = 1, rad; inf if |L| is never 1.
    phase_frequency : float
        Where that is, rad/s.
    delay : float
        Smallest delay that, added to the loop, brings it to the limit, s; of a lag of phase, not of an advance.
    sensitivity_peak : float
        Ms, the peak of |S|, S = 1/(1 + L): its inverse is the smallest distance of L from −1.
    sensitivity_frequency : float
        Where that is, rad/s.
    disk : float
        Disk margin α = 1/max |S − 1/2|: the loop stays stable while its gain and phase are changed together, by a
        factor (1 + δ/2)/(1 − δ/2) with any complex |δ| < α.
    """

    at: str
    gain_down: float
    gain_up: float
    phase: float
    phase_frequency: float
    delay: float
    sensitivity_peak: float
    sensitivity_frequency: float
    disk: float

    @property
    def disk_gain(self) -> tuple[float, float]:
        """Return the factors of gain between which the disk margin keeps the loop stable, at any phase within it."""
        up = (2.0 + self.disk) / (2.0 - self.disk) if self.disk < 2.0 else inf
        return 1.0 / up, up

    @property
    def disk_phase(self) -> float:
        """Angle (rad) up to which the disk margin keeps the loop stable."""
        return 2.0 * float(np.arctan(self.disk / 2.0))

    def __str__(self) -> str:
        """The margins in one line; "?" for an unknown one."""
        text = (f"{self.at}: gain {self.gain_down:.3g}…{self.gain_up:.3g}, phase {degrees(self.phase):.1f}° at "
                f"{self.phase_frequency:.4g} rad/s, delay {1e3 * self.delay:.3g} ms, Ms {self.sensitivity_peak:.3g} at "
                f"{self.sensitivity_frequency:.4g} rad/s, disk {self.disk:.3g}")
        return text.replace("nan", "?")


def frequencies_of(loop: LinearModel) -> Array:
    """Frequencies (rad/s) on which a sampled loop is looked at, up to that of half a sample rate."""
    assert loop.sample_time is not None
    highest = pi / loop.sample_time
    return np.geomspace(LOWEST, highest, int(PER_DECADE * np.log10(highest / LOWEST)))


def margins_of(loop: LinearModel, at: str) -> Margins:
    """Margins of a sampled loop L with one input and one output, stable when it is closed by 1 + L."""
    grid = frequencies_of(loop)
    values = loop.frequency_response(grid)[:, 0, 0]

    def response(frequency: float) -> complex:
        return complex(loop.frequency_response(np.array([frequency]))[0, 0, 0])

    ends = [float(values[-1].real)]   # at half the sample rate, and at rest where L has no pole there
    if np.abs(loop.poles - 1.0).min() > AT_REST:
        ends.append(response(0.0).real)
    return margins_between(at, grid, values, response, ends)


def margins_between(at: str, grid: Array, values: Complex, response: Callable[[float], complex],
                    ends: Sequence[float] = ()) -> Margins:
    """Margins of a loop L, stable when it is closed by 1 + L, from its response between two frequencies.

    Crossings and peaks are searched on a grid of frequencies, rad/s, (n,), where L has these values, (n,). `response`
    gives L at any frequency between, and `ends` are values of L where it is real beyond the grid.
    """
    real_axis = [response(w).real for w in crossings(grid, values.imag, lambda w: response(w).imag)]
    real_axis += ends
    negative = [-value for value in real_axis if value < 0.0]
    circle = crossings(grid, np.log(np.maximum(np.abs(values), NOTHING)), lambda w: float(np.log(abs(response(w)))))
    # Angle of L past −1, 0…2π: the lag that brings L to −1; less the other way round.
    lags = [float(np.angle(-response(w)) % (2.0 * pi)) for w in circle]
    phase, at_frequency = min(((min(lag, 2.0 * pi - lag), w) for lag, w in zip(lags, circle, strict=True)),
                              default=(inf, inf))
    sensitivity, peak_frequency = peak(grid, np.abs(1.0 / (1.0 + values)), lambda w: abs(1.0 / (1.0 + response(w))))
    balanced, _ = peak(grid, np.abs(1.0 / (1.0 + values) - 0.5), lambda w: abs(1.0 / (1.0 + response(w)) - 0.5))
    return Margins(at, gain_down=max((1.0 / value for value in negative if value > 1.0), default=0.0),
                   gain_up=min((1.0 / value for value in negative if value < 1.0), default=inf),
                   phase=phase, phase_frequency=at_frequency,
                   delay=min((lag / w for lag, w in zip(lags, circle, strict=True)), default=inf),
                   sensitivity_peak=sensitivity, sensitivity_frequency=peak_frequency, disk=1.0 / balanced)


def crossings(grid: Array, values: Array, function: Callable[[float], float]) -> list[float]:
    """Frequencies (rad/s) at which a function that has these values on the grid is zero."""
    changes: NDArray[np.intp] = np.flatnonzero(np.diff(np.signbit(values)))
    roots = [float(brentq(function, grid[k], grid[k + 1], rtol=FREQUENCY)) for k in changes]
    # At a pole on the unit circle, as of an internal model, the sign changes without a zero: values are large there.
    return [w for k, w in zip(changes, roots, strict=True)
            if abs(function(w)) <= max(abs(values[k]), abs(values[k + 1]))]


def peak(grid: Array, values: Array, function: Callable[[float], float]) -> tuple[float, float]:
    """Largest value of a function that has these values on the grid, and where it is (rad/s)."""
    k = int(np.argmax(values))
    least = minimize_scalar(lambda w: -function(w), method="bounded",
                            bounds=(grid[max(k - 1, 0)], grid[min(k + 1, len(grid) - 1)]),
                            options={"xatol": FREQUENCY * float(grid[k])})
    return (float(-least.fun), float(least.x)) if -least.fun > values[k] else (float(values[k]), float(grid[k]))
