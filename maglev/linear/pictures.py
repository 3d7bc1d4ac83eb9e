"""Bode and Nyquist pictures of a loop opened at some of its signals."""

from pathlib import Path

import numpy as np

from maglev.files.pictures import FAINT, new_figure, write_figure
from maglev.linear.loop import Loop
from maglev.linear.margins import frequencies_of

JUMP = 1.5     # rad, of phase between neighbouring frequencies
WIDEST = 4.0   # of the Nyquist picture to either side: the part near −1 counts


def write_bode(path: Path, loop: Loop, signals: tuple[str, ...]) -> None:
    """Write a PNG with gain and phase of the loop opened at each of the signals, and the gain of its sensitivity.

    Errors as in `Loop.opened`, and MaglevError without matplotlib.
    """
    figure = new_figure(8, 8)
    gain, phase, sensitivity = figure.subplots(3, 1, sharex=True)
    figure.suptitle(loop.closed.name)
    for signal in signals:
        opened = loop.opened(signal)
        frequencies = frequencies_of(opened)
        values = opened.frequency_response(frequencies)[:, 0, 0]
        gain.loglog(frequencies, np.abs(values), linewidth=1.0, label=loop.opening(signal))
        phase.semilogx(frequencies, np.degrees(np.unwrap(np.angle(values))), linewidth=1.0)
        sensitivity.loglog(frequencies, np.abs(1.0 / (1.0 + values)), linewidth=1.0)
    gain.axhline(1.0, **FAINT)
    sensitivity.axhline(1.0, **FAINT)
    gain.legend(fontsize="small")
    for panel, label in ((gain, "|L|"), (phase, "phase of L (°)"), (sensitivity, "|S| = |1/(1 + L)|")):
        panel.set_ylabel(label)
    sensitivity.set_xlabel("frequency (rad/s)")
    write_figure(path, figure)


def write_nyquist(path: Path, loop: Loop, signals: tuple[str, ...]) -> None:
    """Write a PNG with the Nyquist curve, near −1, of the loop opened at each of the signals.

    The radius of the circle about −1 is the distance that the largest peak of the sensitivity leaves. Errors as in
    `write_bode`, and LinearModelError if the loop is unstable.
    """
    figure = new_figure(7, 7)
    from matplotlib.patches import Circle  # an extra: only who plots needs it

    panel = figure.subplots()
    figure.suptitle(loop.closed.name)
    for signal in signals:
        opened = loop.opened(signal)
        values = opened.frequency_response(frequencies_of(opened))[:, 0, 0]
        # At a pole on the unit circle the curve goes through infinity: no line back.
        values[1:][np.abs(np.angle(values[1:] / values[:-1])) > JUMP] = np.nan
        line, = panel.plot(values.real, values.imag, linewidth=1.0, label=loop.opening(signal))
        panel.plot(values.real, -values.imag, linewidth=0.6, color=line.get_color(), linestyle="--")
    nearest = 1.0 / max(loop.margins(signal).sensitivity_peak for signal in signals)
    panel.add_patch(Circle((-1.0, 0.0), nearest, fill=False, **FAINT))
    panel.plot(-1.0, 0.0, "+", color="0.2")
    panel.set(xlim=(-WIDEST, WIDEST), ylim=(-WIDEST, WIDEST), aspect="equal", xlabel="Re L", ylabel="Im L")
    panel.legend(fontsize="small")
    write_figure(path, figure)
