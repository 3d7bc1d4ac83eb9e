"""Picture of a frequency response that was flown, over the linear one."""

from typing import Any

import numpy as np

from maglev.arrays import Array, Complex
from maglev.linear.margins import frequencies_of
from maglev.linear.model import LinearModel
from maglev.pictures import FAINT, require_matplotlib

FLOWN = {"marker": "o", "markersize": 3.0, "linestyle": "", "linewidth": 0.8}
LINEAR = {"linewidth": 1.0, "color": "0.45"}


def response_figure(title: str, lines: Array, loop: Complex, error: Array, coherence: Array,
                    opened: LinearModel | None) -> Any:
    """Figure with gain, phase, sensitivity and coherence of a loop at lines (rad/s); opened is the linear one.

    MaglevError without matplotlib.
    """
    require_matplotlib()
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 9), layout="constrained")
    gain, phase, sensitivity, agreement = figure.subplots(4, 1, sharex=True, height_ratios=(3, 2, 3, 1))
    figure.suptitle(title)
    angle = np.unwrap(np.angle(loop))
    if opened is not None:
        grid = frequencies_of(opened)
        grid = grid[(grid >= 0.7 * lines[0]) & (grid <= 1.4 * lines[-1])]
        values = opened.frequency_response(grid)[:, 0, 0]
        smooth = np.unwrap(np.angle(values))
        # Both begin within half a turn of each other.
        smooth += 2.0 * np.pi * np.round((angle[0] - np.interp(lines[0], grid, smooth)) / (2.0 * np.pi))
        gain.loglog(grid, np.abs(values), label="linear", **LINEAR)
        phase.semilogx(grid, np.degrees(smooth), **LINEAR)
        sensitivity.loglog(grid, np.abs(1.0 / (1.0 + values)), **LINEAR)
    gain.errorbar(lines, np.abs(loop), yerr=np.minimum(error, 0.99 * np.abs(loop)), label="flown, ± standard error",
                  **FLOWN)
    phase.errorbar(lines, np.degrees(angle), yerr=np.degrees(np.minimum(error / np.abs(loop), np.pi)), **FLOWN)
    sensitivity.loglog(lines, np.abs(1.0 / (1.0 + loop)), **FLOWN)
    agreement.semilogx(lines, coherence, **FLOWN)
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
