"""Picture of a run: positions with their references, absolute errors, commands and phase currents."""

from collections.abc import Iterable, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from fmi_export.whole_file import whole_file
from maglev.cosim.master import Recording
from maglev.errors import ScenarioError
from maglev.judging.metrics import Metrics
from maglev.report.plots.figures import shown_commands
from maglev.report.plots.limits import limits
from maglev.report.status import events
from maglev.schema.run_plan import RunPlan

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SMALLEST_ERROR = 1e-3   # mm, lower end of the logarithmic error axis
BESIDE: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "fontsize": "small"}   # legends
FAINT: dict[str, Any] = {"color": "0.6", "linewidth": 0.8}


class Drawn(NamedTuple):
    """A run to draw: its plan and columns, the parameters (SI) that it started with, and what was measured."""

    plan: RunPlan
    recording: Recording
    parameters: Mapping[str, float] = {}
    metrics: Metrics | None = None


def require_matplotlib() -> None:
    """Raise ScenarioError if matplotlib, an extra of this project, is not installed."""
    if find_spec("matplotlib") is None:
        raise ScenarioError("--plot needs matplotlib, expected it to be installed: pip install 'maglev-fmus[report]'")


def write_figure(path: Path, figure: "Figure") -> None:
    """Write a figure as PNG."""
    with whole_file(path) as unfinished:
        figure.savefig(unfinished, dpi=110, format="png")


def figure_of(plan: RunPlan, recording: Recording, parameters: Mapping[str, float] | None = None,
              metrics: Metrics | None = None) -> "Figure":
    """Draw a recording: a row for each axis and each motor.

    Parameters
    ----------
    plan : RunPlan
        Names the columns of axes and motors, and the settling bands.
    recording : Recording
    parameters : mapping of str to float, optional
        What the run started with, SI: end stops and limits of currents are marked.
    metrics : Metrics, optional
        When a stop was touched, or the controller tripped, is marked.

    Returns
    -------
    matplotlib.figure.Figure
        Bound to no window: save it, or show it in a notebook.
    """
    return overlay(f"{plan.name}: {plan.title}", {"": Drawn(plan, recording, parameters or {}, metrics)})


def overlay(title: str, runs: Mapping[str, Drawn]) -> "Figure":
    """Draw runs with the same axes over each other, by label; of a motor each run in a colour of its own.

    A run alone has a colour for each of its currents, and no label. End stops and limits of currents are marked, and
    when a stop was touched or the controller tripped.
    """
    from matplotlib.figure import Figure  # an extra: only who plots needs it

    first = next(iter(runs.values())).plan
    rows = len(first.axes) + len(first.motors)
    figure = Figure(figsize=(12, 2.3 * max(rows, 1)), layout="constrained")
    figure.suptitle(title)
    if not rows:
        figure.text(0.5, 0.5, "no axis and no motor", horizontalalignment="center")
        return figure
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False)
    for name, row in zip(first.axes, panels, strict=False):
        draw_axis(name, row, runs)
    for name, row in zip(first.motors, panels[len(first.axes):], strict=True):
        draw_motor(name, row, runs)
    for panel in panels[-1]:
        panel.set_xlabel("time (s)")
    mark_limits(figure, [*first.axes, *first.motors], runs.values())
    mark_events(figure, runs)
    return figure


def mark_limits(figure: "Figure", rows: Sequence[str], runs: Iterable[Drawn]) -> None:
    """Mark end stops and limits of currents, each once, of whichever runs have it."""
    marked: set[tuple[str, str, float]] = set()
    drawn = [panel.get_ylim() for panel in figure.axes]   # of the signals alone: a mark widens its panel
    for limit in (limit for run in runs for limit in limits(run.plan, run.parameters)):
        number = 2 * rows.index(limit.of) + (limit.kind == "currents")
        panel, (low, high) = figure.axes[number], drawn[number]
        label = limit.text
        for value in (1e3 * value if limit.kind == "position" else value for value in limit.values):
            place = (limit.kind, limit.of, value)
            # Further off it would flatten what is drawn.
            if 2.0 * low - high <= value <= 2.0 * high - low and place not in marked:
                marked.add(place)
                panel.axhline(value, color="0.3", linewidth=0.8, linestyle="-.", label=label)
                label = "_"   # in the legend once
        panel.legend(**BESIDE)


def mark_events(figure: "Figure", runs: Mapping[str, Drawn]) -> None:
    """Mark when a stop was touched or the controller tripped; of several runs in their colours."""
    for number, (label, run) in enumerate(runs.items()):
        for event in events(run.metrics):
            who = f"{label} " if label else ""
            figure.suptitle(f"{figure.get_suptitle()}\n{who}{event.words} at {event.time:.3f} s (dashed)")
            for panel in figure.axes:
                panel.axvline(event.time, color=f"C{number}" if label else "C3", linewidth=1.0, linestyle="--")


def draw_axis(name: str, row: Sequence["Axes"], runs: Mapping[str, Drawn]) -> None:
    """Positions of an axis with the reference on the left, absolute errors on the right."""
    left, right = row
    for number, (label, (plan, recording, _, _)) in enumerate(runs.items()):
        axis = plan.axes[name]
        position, reference = 1e3 * recording.columns[axis.position], 1e3 * recording.columns[axis.reference]
        if number == 0:
            left.plot(recording.time, reference, **FAINT, label="reference")
            for band in plan.metrics.bands:
                right.axhline(1e3 * band, **FAINT, linestyle="--")
        left.plot(recording.time, position, linewidth=1.0, label=label or "position", color=f"C{number}")
        right.semilogy(recording.time, np.maximum(np.abs(position - reference), SMALLEST_ERROR), linewidth=0.8,
                       color=f"C{number}")
    left.set_ylabel(f"{name} (mm)")
    left.legend(**BESIDE)
    right.set_ylabel(f"|error| of {name} (mm)")


def draw_motor(name: str, row: Sequence["Axes"], runs: Mapping[str, Drawn]) -> None:
    """Commands of a motor on the left, currents of its phases, as delivered, on the right."""
    # Of the commands the direct and the quadrature current, where there are some.
    for panel, what in zip(row, ("commands", "phase currents"), strict=True):
        for number, (label, (plan, recording, _, _)) in enumerate(runs.items()):
            motor = plan.motors[name]
            shown = shown_commands(motor) if what == "commands" else motor.currents
            for variable in shown:
                own = {"color": f"C{number}", "label": label if variable == shown[0] else None} if label else {
                    "label": variable.rpartition(".")[2]}
                panel.plot(recording.time, recording.columns[variable], linewidth=0.8, **own)
        panel.set_ylabel(f"{name} {what} (A)")
        if panel.lines:
            panel.legend(**BESIDE)
