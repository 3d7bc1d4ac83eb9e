"""Picture of a region: the ellipsoid in the plane of position and velocity with simulated states, and responses."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from maglev.arrays import Array
from maglev.pictures import require_matplotlib
from maglev.stability.axis_loop import AxisLoop
from maglev.stability.certificate import Certificate
from maglev.stability.simulation import Response, comes_back

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLORS = ("tab:blue", "tab:orange", "tab:green")
GRID = 21        # simulated states along each side
WIDER = 3.0      # than the ellipse


def figure_of(loop: AxisLoop, step: float, candidates: Sequence[tuple[str, Certificate, Mapping[str, Response]]]
              ) -> "Figure":
    """Picture of a loop with a title, a certificate and responses to a step (m) by name for each of its candidates.

    MaglevError without matplotlib. A panel for each candidate: states off the reference in position and velocity
    that come back (filled) and that do not (rings), the certified ellipsoid's section with them (line) and its shadow
    (dashed). Below, the responses.
    """
    require_matplotlib()
    from matplotlib.figure import Figure  # an extra: only who plots needs it

    figure = Figure(figsize=(4.0 * max(2, len(candidates)), 8.0), layout="constrained")
    figure.suptitle(loop.name)
    halves: Any = figure.subfigures(2, 1)
    upper, lower = halves
    panels = np.atleast_1d(upper.subplots(1, len(candidates)))
    position, command = lower.subplots(2, 1, sharex=True)
    for panel, (title, found, responses), color in zip(panels, candidates, COLORS, strict=False):
        draw_plane(panel, loop, found, color)
        name, _, steps = title.partition(": ")
        panel.set_title(f"{name}\n{steps}", fontsize="medium")
        for what, response in responses.items():
            style = ":" if what == "flown" else "-"
            position.plot(response.time, 1e3 * response.position, style, color=color, linewidth=1.0,
                          label=f"{name}, {what}")
            command.plot(response.time, response.command, style, color=color, linewidth=1.0)
    position.axhline(1e3 * step, color="0.6", linewidth=0.8)
    position.set_ylabel(f"from the start (m{loop.unit})")
    position.set_ylim(-0.1e3 * step, 1.9e3 * step)   # those that are lost leave the picture
    position.legend(fontsize="small", loc="lower right")
    command.set(xlabel="time (s)", ylabel="command (A)")
    return figure


def draw_plane(panel: Any, loop: AxisLoop, found: Certificate, color: str) -> None:
    """Draw simulated states and the ellipsoid of one candidate."""
    plane = np.column_stack([loop.at_step, loop.in_motion])
    section, shadow = ellipse(found.section(plane)), ellipse(found.projection(0, 1))
    reach = WIDER * np.abs(section).max(axis=1)
    grid = np.array(np.meshgrid(*(np.linspace(-side, side, GRID) for side in reach))).reshape(2, -1)
    back = comes_back(loop, found, plane @ grid)
    panel.plot(1e3 * grid[0, back], grid[1, back], ".", color=color, markersize=3)
    panel.plot(1e3 * grid[0, ~back], grid[1, ~back], "o", color="0.7", markersize=3, fillstyle="none")
    panel.plot(1e3 * section[0], section[1], color="k", linewidth=1.2)
    panel.plot(1e3 * shadow[0], shadow[1], "--", color="k", linewidth=0.8)
    panel.set(xlim=(-1e3 * reach[0], 1e3 * reach[0]), ylim=(-reach[1], reach[1]), xlabel=f"position (m{loop.unit})",
              ylabel=f"velocity ({loop.unit}/s)")


def ellipse(shape: Array, points: int = 200) -> Array:
    """Points c with cᵀ shape c = 1, shape (2, points)."""
    angle = np.linspace(0.0, 2.0 * np.pi, points)
    return np.asarray(np.linalg.solve(np.linalg.cholesky(shape).T, np.array([np.cos(angle), np.sin(angle)])))
