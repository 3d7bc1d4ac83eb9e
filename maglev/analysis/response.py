"""A measured frequency response: the multisine that excites the loop, margins, text, JSON and a picture.

A multisine is a sum of sines with a common period.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import degrees, inf, isnan, nan, pi
from textwrap import fill
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline

from maglev.files.arrays import Array, Complex
from maglev.files.errors import LinearModelError, extra
from maglev.files.pictures import FAINT, new_figure
from maglev.files.text_columns import aligned
from maglev.linear.loop import Loop
from maglev.linear.margins import Margins, frequencies_of, margins_between, margins_of
from maglev.linear.model import Equilibrium
from maglev.scenario.waves import period_of

FINE = 50   # frequencies between two lines on which crossings and peaks are looked for
TITLES = {"gain_down": "gain down to", "gain_up": "gain up to", "phase": "phase (°)", "delay": "delay (ms)",
          "sensitivity_peak": "Ms", "disk": "disk"}
SCALES = {"phase": degrees(1.0), "delay": 1e3}
WIDTH = 80
MANY = 4   # lines, with which there are margins

# Styles of both curves.
MEASURED = {"marker": "o", "markersize": 3.0, "linestyle": "", "linewidth": 0.8}
LINEAR = {"linewidth": 1.0, "color": "0.45"}

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


@dataclass(frozen=True, eq=False)
class FrequencyResponse:
    """Response of a loop measured in a run, opened at one signal.

    Attributes
    ----------
    name : str
        Plant and controller.
    at : str
        The signal.
    equilibrium : Equilibrium
        The point of the run.
    grid : Grid
    amplitude : float
        Peak of the added signal, m or rad.
    crest : float
        Its crest factor.
    periods : int
        Recorded periods of each multisine.
    returned, measured : ndarray of complex, shape (realisations, lines)
        The returned signal, −y, and the controller's measurement, y + r, over the added signal.
    coherence : ndarray, shape (lines,)
        Of the returned with the added signal, 0…1: the linear share of the answer.
    linear : Loop or None
        The linear loop, if it was asked for and exists.
    why_not : str
        The reason if there is no linear loop.
    """

    name: str
    at: str
    equilibrium: Equilibrium
    grid: Grid
    amplitude: float
    crest: float
    periods: int
    returned: Complex
    measured: Complex
    coherence: Array
    linear: Loop | None
    why_not: str

    @property
    def frequencies(self) -> Array:
        """Lines, rad/s, shape (lines,)."""
        return self.grid.frequencies

    @property
    def loop(self) -> Complex:
        """L of 1 + L at the lines, shape (lines,)."""
        return np.asarray(self.returned.mean(axis=0) / self.measured.mean(axis=0))

    @property
    def error(self) -> Array:
        """Standard error of L, shape (lines,): of its mean over the multisines, by leaving out one at a time."""
        errors: Array = jackknife(np.array([returned / measured for returned, measured in self.left_out()]))
        return errors

    def left_out(self) -> list[tuple[Complex, Complex]]:
        """Return the means of returned and measured signals without each of the multisines in turn."""
        return [(np.delete(self.returned, k, axis=0).mean(axis=0), np.delete(self.measured, k, axis=0).mean(axis=0))
                for k in range(len(self.returned))]

    @property
    def linear_loop(self) -> Complex | None:
        """L of the linear loop at the lines; None if there is none."""
        if self.linear is None:
            return None
        return np.asarray(self.linear.opened(self.at).frequency_response(self.frequencies)[:, 0, 0])

    @property
    def margins(self) -> Margins:
        """Return the margins between the lowest and the highest line, L interpolated between the lines; NaN if there is
        none.

        `unknown` has the reasons.
        """
        return self.between(self.returned.mean(axis=0), self.measured.mean(axis=0))[0]

    @property
    def unknown(self) -> dict[str, str]:
        """Return the reasons for NaN in `margins`, by their names: the lines do not determine these numbers."""
        return self.between(self.returned.mean(axis=0), self.measured.mean(axis=0))[1]

    @property
    def margin_errors(self) -> dict[str, float]:
        """Standard errors of the numbers in `margins`, by their names.

        NaN where a margin is, and infinite where it is not always found.
        """
        left_out = [vars(self.between(*means)[0]) for means in self.left_out()]
        errors = {}
        for name, value in vars(self.margins).items():
            if isinstance(value, float):
                values = np.array([other[name] for other in left_out])
                errors[name] = nan if isnan(value) else float(jackknife(values)) if np.isfinite(values).all() else inf
        return errors

    @property
    def linear_margins(self) -> Margins | None:
        """Margins of the linear loop, at all frequencies; None if there is none."""
        return None if self.linear is None else margins_of(self.linear.opened(self.at), self.at)

    def between(self, returned: Complex, measured: Complex) -> tuple[Margins, dict[str, str]]:
        """Return the margins of a loop with these responses at the lines, and the reasons for NaN by their names."""
        if len(returned) < MANY:
            raise LinearModelError(f"{self.name}: {len(returned)} lines, expected at least {MANY} for margins")
        # Both are bounded where L is not: at a pole on the imaginary axis, as of an internal model.
        log = np.log(self.frequencies)
        back, seen = CubicSpline(log, returned), CubicSpline(log, measured)

        def response(frequency: float) -> complex:
            return complex(back(np.log(frequency)) / seen(np.log(frequency)))

        fine = np.exp(np.interp(np.arange(FINE * (len(log) - 1) + 1) / FINE, np.arange(len(log)), log))
        loop = back(np.log(fine)) / seen(np.log(fine))
        margins = margins_between(self.at, fine, loop, response)
        unknown = untold(margins, fine, loop)
        return replace(margins, **dict.fromkeys(unknown, nan)), unknown   # type: ignore[arg-type]  # numbers all

    def to_control(self) -> Any:
        """L as python-control's FrequencyResponseData; LinearModelError if it is not installed."""
        return extra("control", "design", "to_control", LinearModelError).frd(
            self.loop, self.frequencies, self.grid.step, name=self.at.replace(".", "_"))

    def as_data(self) -> dict[str, Any]:
        """Return the result in JSON form."""
        loop, linear, margins = self.loop, self.linear_loop, self.linear_margins
        return {"name": self.name, "at": self.at, "equilibrium": {
                    "positions": self.equilibrium.positions, "currents": self.equilibrium.currents},
                "amplitude": self.amplitude, "crest_factor": self.crest, "period": self.grid.period,
                "realisations": len(self.returned), "periods": self.periods,
                "frequencies": self.frequencies.tolist(), "loop": [[z.real, z.imag] for z in loop.tolist()],
                "error": self.error.tolist(), "coherence": self.coherence.tolist(),
                "linear": None if linear is None else [[z.real, z.imag] for z in linear.tolist()],
                "margins": known(vars(self.margins)), "margin_errors": known(self.margin_errors),
                "margins_unknown": self.unknown,
                "linear_margins": None if margins is None else vars(margins), "why_not_linear": self.why_not}

    def __str__(self) -> str:
        """Return a summary, a table of the lines, and one of the margins."""
        parts = [head_text(self), lines_text(self), *([margins_text(self)] if len(self.frequencies) >= MANY else [])]
        return "\n\n".join(parts) + "\n"

    __repr__ = __str__

    def plot(self) -> Any:
        """Figure of matplotlib: gain, phase, sensitivity and coherence, measured and linear; MaglevError without it."""
        lines, loop, error = self.frequencies, self.loop, self.error
        figure = new_figure(8, 9)
        gain, phase, sensitivity, agreement = figure.subplots(4, 1, sharex=True, height_ratios=(3, 2, 3, 1))
        figure.suptitle(f"{self.name}, opened at {self.at}")
        angle = np.unwrap(np.angle(loop))
        if self.linear is not None:
            opened = self.linear.opened(self.at)
            grid = frequencies_of(opened)
            grid = grid[(grid >= 0.7 * lines[0]) & (grid <= 1.4 * lines[-1])]
            values = opened.frequency_response(grid)[:, 0, 0]
            smooth = np.unwrap(np.angle(values))
            # Both begin within half a turn of each other.
            smooth += 2.0 * np.pi * np.round((angle[0] - np.interp(lines[0], grid, smooth)) / (2.0 * np.pi))
            gain.loglog(grid, np.abs(values), label="linear", **LINEAR)
            phase.semilogx(grid, np.degrees(smooth), **LINEAR)
            sensitivity.loglog(grid, np.abs(1.0 / (1.0 + values)), **LINEAR)
        gain.errorbar(lines, np.abs(loop), yerr=np.minimum(error, 0.99 * np.abs(loop)),
                      label="measured, ± standard error", **MEASURED)
        phase.errorbar(lines, np.degrees(angle), yerr=np.degrees(np.minimum(error / np.abs(loop), np.pi)), **MEASURED)
        sensitivity.loglog(lines, np.abs(1.0 / (1.0 + loop)), **MEASURED)
        agreement.semilogx(lines, self.coherence, **MEASURED)
        gain.set(xscale="log", yscale="log")
        gain.axhline(1.0, **FAINT)
        sensitivity.axhline(1.0, **FAINT)
        agreement.set_ylim(0.0, 1.05)
        gain.legend(fontsize="small")
        for panel, label in ((gain, "|L|"), (phase, "phase of L (°)"), (sensitivity, "|S| = |1/(1 + L)|"),
                             (agreement, "coherence")):
            panel.set_ylabel(label)
        agreement.set_xlabel("frequency (rad/s)")
        return figure


def untold(margins: Margins, frequencies: Array, loop: Complex) -> dict[str, str]:
    """Return the margins that a loop between two frequencies (rad/s) does not show, by their names, with the reasons.

    Beyond the frequencies may be a crossing, or a larger peak.
    """
    lowest, highest = f"{frequencies[0]:.3g}", f"{frequencies[-1]:.4g} rad/s"
    reasons = {}
    for name, none, where in (("gain_down", 0.0, "beyond"), ("gain_up", inf, "within")):
        if getattr(margins, name) == none:
            reasons[name] = f"L does not cross the negative real axis {where} −1 from {lowest} to {highest}"
    last = abs(loop[-1])
    if last >= 1.0 or margins.phase == inf:
        why = f"|L| is never 1 from {lowest} to {highest}" if last < 1.0 else (
            f"|L| is {last:.3g} at {highest}, and crosses 1 beyond")
        reasons |= dict.fromkeys(("phase", "phase_frequency", "delay"), why)
    sensitivity = 1.0 / (1.0 + loop)
    for names, values in ((("sensitivity_peak", "sensitivity_frequency"), sensitivity), (("disk",), sensitivity - 0.5)):
        k = int(np.argmax(np.abs(values)))
        if k in (0, len(loop) - 1):
            reasons |= dict.fromkeys(names, f"the peak is at {frequencies[k]:.4g} rad/s, the end of the lines: it may "
                                     "be larger beyond")
    return reasons


def known(numbers: Mapping[str, Any]) -> dict[str, Any]:
    """Return numbers by name in JSON form: None for an unknown one."""
    return {name: None if isinstance(value, float) and isnan(value) else value for name, value in numbers.items()}


def jackknife(left_out: Any) -> Any:
    """Standard error of a mean from its values with one part left out at a time, along the first axis."""
    n = len(left_out)
    return np.sqrt((n - 1) / n * (np.abs(left_out - left_out.mean(axis=0)) ** 2).sum(axis=0))


def head_text(response: FrequencyResponse) -> str:
    lines, grid = response.frequencies, response.grid
    axis = response.at.rpartition(".")[0]
    unit = next((known.unit("m") for known in response.equilibrium.stage.axes if known.name == axis), "m")
    head = [f"{response.name}, opened at {response.at}, measured about {response.equilibrium}",
            f"{len(response.returned)} multisines with a peak of {1e6 * response.amplitude:g} µ{unit} and a crest "
            f"factor of {response.crest:.2f}: {len(lines)} lines from {lines[0]:.3g} to {lines[-1]:.4g} rad/s, "
            f"{response.periods} periods of {grid.period:.4g} s of each"]
    return "\n".join(fill(text, WIDTH) for text in head)


def lines_text(response: FrequencyResponse) -> str:
    loop, error, linear = response.loop, response.error, response.linear_loop
    rows = [["rad/s", "|L|", "±", "phase (°)", "±", "coherence"]]
    if linear is not None:
        rows[0] += ["linear |L|", "phase (°)"]
    for k, frequency in enumerate(response.frequencies):
        gain = abs(loop[k])
        cells = [f"{frequency:.4g}", f"{gain:.4g}", f"{error[k]:.1g}", f"{np.degrees(np.angle(loop[k])):.1f}",
                 f"{np.degrees(error[k] / gain):.1g}" if gain > error[k] else "", f"{response.coherence[k]:.4f}"]
        if linear is not None:
            cells += [f"{abs(linear[k]):.4g}", f"{np.degrees(np.angle(linear[k])):.1f}"]
        rows.append(cells)
    return aligned(rows) + ("\n" + fill(f"no linear loop: {response.why_not}", WIDTH) if linear is None else "")


def margins_text(response: FrequencyResponse) -> str:
    measured, errors, linear = vars(response.margins), response.margin_errors, response.linear_margins
    rows = [["margins", "measured", "±", *(["linear"] if linear is not None else [])]]
    for name, title in TITLES.items():
        by = SCALES.get(name, 1.0)
        missing = isnan(measured[name])
        cells = [title, "not among the lines" if missing else f"{by * measured[name]:.4g}",
                 "" if missing else f"{by * errors[name]:.1g}"]
        if linear is not None:
            cells.append(f"{by * vars(linear)[name]:.4g}")
        rows.append(cells)
    reasons: dict[str, list[str]] = {}
    for name, why in response.unknown.items():
        if name in TITLES:
            reasons.setdefault(why, []).append(TITLES[name].partition(" (")[0])
    return "\n".join([aligned(rows), *(fill(f"{', '.join(names)}: {why}", WIDTH) for why, names in reasons.items())])
