"""The result of `region`: largest steps, certified, simulated and run, as text, data and picture."""

from dataclasses import dataclass
from textwrap import fill
from typing import TYPE_CHECKING, Any

import numpy as np

from maglev.analysis.axis_loop import AxisLoop
from maglev.analysis.certificate import LARGEST_STEP, Certificate
from maglev.analysis.region_simulation import Response, comes_back
from maglev.files.arrays import Array
from maglev.files.errors import StabilityError
from maglev.files.pictures import new_figure
from maglev.files.text_columns import aligned

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LEFT_OUT = ("certified and simulated: the linear loop with its limit; "
            "held: the FMUs, with friction, stops and a moving gap")

WIDTH = 80   # of the text
COLORS = ("tab:blue", "tab:orange", "tab:green")
GRID = 21        # simulated states along each side
WIDER = 3.0      # than the ellipse


@dataclass(frozen=True, eq=False)
class RunSteps:
    response: Response   # of the whole stage to the step of the region
    held: bool   # whether it ends within 1 mm of every reference, without having touched a stop
    largest: float   # largest step that is held, m
    largest_locked: float | None   # the same with the gap held by force, m; None of a vertical axis
    room: float   # largest step in either direction that begins and ends off the stops, m: no larger one is run

    def written(self, step: float) -> str:
        """A largest step as text, mm or mrad."""
        return f"{'≥ ' if step >= self.room else ''}{1e3 * step:.1f}"


@dataclass(frozen=True, eq=False)
class Candidate:
    """The results for one choice of antiwindup gains."""

    name: str   # "as set", "without" or "synthesised"
    unit: str   # of the axis, "m" or "rad"
    certificate: Certificate   # ellipsoid and largest certified step
    simulated: float   # largest step of the linear loop with its limit, m; LARGEST_STEP if every step comes back
    response: Response   # of that loop to the step of the region
    run: RunSteps | None   # by the FMUs, if asked for: effects outside the certificate may leave less, or more

    @property
    def gains(self) -> Array:
        """Ec, shape (3,): m s²/A, m s/A, m/A."""
        return self.certificate.gains

    @property
    def largest(self) -> tuple[str, str]:
        """Largest step that is certified, and that the FMUs hold, as text, mm or mrad: neither implies the other."""
        return (f"{1e3 * self.certificate.step:.1f}",
                self.run.written(self.run.largest) if self.run else "not run")

    @property
    def title(self) -> str:
        certified, held = self.largest
        unit = f"m{self.unit}"
        return f"{self.name}: {certified} {unit} certified, {held}{f' {unit} held' if self.run else ''}"

    @property
    def responses(self) -> dict[str, Response]:
        """Return the responses by source: "linear" and, if it was run, "run"."""
        return {"linear": self.response, **({"run": self.run.response} if self.run else {})}

    def row(self) -> dict[str, str]:
        """Return the cells of the candidate, by the titles of the lines."""
        cells = {"anti-windup": self.name, **{f"Ec{k}": f"{gain:.3g}" for k, gain in enumerate(self.gains, 1)}}
        unit = f"(m{self.unit})"
        cells[f"certified {unit}"], cells[f"held {unit}"] = self.largest
        if self.run and self.run.largest_locked is not None:
            cells[f"gap locked {unit}"] = self.run.written(self.run.largest_locked)
        cells[f"simulated {unit}"] = f"{'≥ ' if self.simulated >= LARGEST_STEP else ''}{1e3 * self.simulated:.1f}"
        cells["overshoot (%)"], cells["settling (s)"] = response_cells(self.response)
        if self.run:
            cells["overshoot, held (%)"], cells["settling, held (s)"] = (
                response_cells(self.run.response) if self.run.held else ("not held", "not held"))
        return cells

    def as_data(self) -> dict[str, Any]:
        """Candidate as JSON has it, SI."""
        certificate, run = self.certificate, self.run
        return {"Ec": certificate.gains.tolist(), "certified_step": certificate.step, "P": certificate.P.tolist(),
                "G": certificate.G.tolist(), "T": certificate.T.tolist(), "decrease": certificate.decrease,
                "simulated_step": self.simulated,
                "simulated": response_data(self.response),
                "run": None if run is None else {
                    "held": run.held, "largest_step": run.largest, "largest_step_gap_locked": run.largest_locked,
                    "room": run.room, **response_data(run.response)}}


@dataclass(frozen=True, eq=False)
class Region:
    """Stability of one limited axis about a gap.

    Attributes
    ----------
    loop : AxisLoop
        The linear loop and its limit.
    step : float
        Step of the responses, m.
    candidates : tuple of Candidate
        As set, without anti-windup, and synthesised, as far as there are such.
    """

    loop: AxisLoop
    step: float
    candidates: tuple[Candidate, ...]

    def __getitem__(self, name: str) -> Candidate:
        """Return the candidate of a name."""
        for candidate in self.candidates:
            if candidate.name == name:
                return candidate
        raise StabilityError(f"region: no candidate {name!r}, expected one of "
                             f"{', '.join(candidate.name for candidate in self.candidates)}")

    def __str__(self) -> str:
        """Limit, gains, and a column for each candidate."""
        loop, unit = self.loop, f"m{self.loop.unit}"
        rows = [candidate.row() for candidate in self.candidates]
        others = f"; its limits move {' and '.join(loop.axes[1:])}, too" if loop.axes[1:] else ""
        about = (f"{loop.name}: {1e3 * loop.sample_time:g} ms, command {loop.at_rest:.4g} A at rest, "
                 f"{loop.at_rest + loop.lower[0]:g}…{loop.at_rest + loop.upper[0]:g} A{others}",
                 f"largest steps; overshoot and settling into 0.1 {unit} for a step of {1e3 * self.step:.4g} {unit}",
                 LEFT_OUT)
        return "\n".join([*(fill(line, WIDTH) for line in about), "",
                          aligned([[title, *(row[title] for row in rows)] for title in rows[0]]), ""])

    __repr__ = __str__

    def as_data(self) -> dict[str, Any]:
        """Everything as JSON has it, SI; a settling time of null is one that does not end within the response."""
        loop = self.loop
        return {"name": loop.name, "axis": loop.axis, "axes": list(loop.axes), "sample_time": loop.sample_time,
                "states": list(loop.states), "commands": [list(currents) for currents in loop.commands],
                "command_at_rest": loop.at_rest, "lower": loop.lower.tolist(), "upper": loop.upper.tolist(),
                "step": self.step,
                "poles": [[rate.real, rate.imag] for rate in loop.rates.tolist()],
                "candidates": {candidate.name: candidate.as_data() for candidate in self.candidates}}

    def plot(self) -> "Figure":
        """Picture, a matplotlib Figure; MaglevError without matplotlib.

        A panel for each candidate: states off the reference in position and velocity that come back (filled) or do not
        (rings), and the certified ellipsoid's section with them (line) and its shadow (dashed). Below, the responses.
        """
        loop, step = self.loop, self.step
        figure = new_figure(4.0 * max(2, len(self.candidates)), 8.0)
        figure.suptitle(loop.name)
        halves: Any = figure.subfigures(2, 1)
        upper, lower = halves
        panels = np.atleast_1d(upper.subplots(1, len(self.candidates)))
        position, command = lower.subplots(2, 1, sharex=True)
        for panel, candidate, color in zip(panels, self.candidates, COLORS, strict=False):
            draw_plane(panel, loop, candidate.certificate, color)
            panel.set_title(candidate.title.replace(": ", "\n", 1), fontsize="medium")
            for what, response in candidate.responses.items():
                style = ":" if what == "run" else "-"
                position.plot(response.time, 1e3 * response.position, style, color=color, linewidth=1.0,
                              label=f"{candidate.name}, {what}")
                command.plot(response.time, response.command, style, color=color, linewidth=1.0)
        position.axhline(1e3 * step, color="0.6", linewidth=0.8)
        position.set_ylabel(f"from the start (m{loop.unit})")
        position.set_ylim(-0.1e3 * step, 1.9e3 * step)   # those that are lost leave the picture
        position.legend(fontsize="small", loc="lower right")
        command.set(xlabel="time (s)", ylabel="command (A)")
        return figure


def response_cells(response: Response) -> tuple[str, str]:
    return f"{100.0 * response.overshoot:.1f}", f"{response.settling:.2f}"


def response_data(response: Response) -> dict[str, Any]:
    settling = response.settling
    return {"overshoot": response.overshoot, "settling": settling if settling < float("inf") else None}


def draw_plane(panel: Any, loop: AxisLoop, certificate: Certificate, color: str) -> None:
    plane = np.column_stack([loop.at_step, loop.in_motion])
    section, shadow = ellipse(certificate.section(plane)), ellipse(certificate.shadow())
    reach = WIDER * np.abs(section).max(axis=1)
    grid = np.array(np.meshgrid(*(np.linspace(-side, side, GRID) for side in reach))).reshape(2, -1)
    back = comes_back(loop, certificate, plane @ grid)
    panel.plot(1e3 * grid[0, back], grid[1, back], ".", color=color, markersize=3)
    panel.plot(1e3 * grid[0, ~back], grid[1, ~back], "o", color="0.7", markersize=3, fillstyle="none")
    panel.plot(1e3 * section[0], section[1], color="k", linewidth=1.2)
    panel.plot(1e3 * shadow[0], shadow[1], "--", color="k", linewidth=0.8)
    panel.set(xlim=(-1e3 * reach[0], 1e3 * reach[0]), ylim=(-reach[1], reach[1]), xlabel=f"position (m{loop.unit})",
              ylabel=f"velocity ({loop.unit}/s)")


def ellipse(shape: Array) -> Array:
    """Points c with cᵀ shape c = 1, shape (2, points)."""
    angle = np.linspace(0.0, 2.0 * np.pi, 200)
    return np.asarray(np.linalg.solve(np.linalg.cholesky(shape).T, np.array([np.cos(angle), np.sin(angle)])))
