"""Picture of a run: positions with their references, absolute errors, commands and phase currents."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from maglev.cosim.master import Recording
from maglev.files.pictures import new_figure
from maglev.pages.figures import Panel, axis_of, own_outputs, recorded_columns, run_colours
from maglev.pages.lines import panel_levels, panel_lines
from maglev.pages.panels import PANELS
from maglev.pages.shell import colour
from maglev.pages.status import shown_until
from maglev.runs.endings import events
from maglev.runs.execution import RunResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
    from matplotlib.lines import Line2D

STYLES: dict[str, Any] = {"solid": "-", "dash": "--", "dot": ":", "dashdot": "-.",
                          "dashdotdot": (0, (6, 1.5, 1, 1.5, 1, 1.5)), "long": (0, (12, 2))}


def figure_of(run: RunResult) -> "Figure":
    """Draw a run, a row for each axis and each motor: a matplotlib figure bound to no window, to save or to show."""
    return overlay(f"{run.plan.name}: {run.plan.title}", {"": run})


def before(run: RunResult, until: float) -> RunResult:
    """The run to a time (s)."""
    rows = run.time <= until
    columns = {name: values[rows] for name, values in run.columns.items()}
    return replace(run, recording=Recording(run.time[rows], columns))


def overlay(title: str, runs: Mapping[str, RunResult]) -> "Figure":
    """Draw runs with the same axes over each other, by label, each in the colour of its controller and its own dash.

    A run alone has a colour for each of its currents, and no label. End stops and limits of currents are marked, and
    when a stop was touched or the controller tripped.
    """
    until = shown_until((run.metrics, float(run.time[-1])) for run in runs.values())
    if until is not None:
        end = max(run.time[-1] for run in runs.values())
        title += f"\nthe first {until:.2g} s of {end:g} s"
        runs = {label: before(run, until) for label, run in runs.items()}
    rows = [*picture_rows(runs)]
    figure = new_figure(12, 2.3 * max(len(rows), 1))
    if not rows:
        figure.text(0.5, 0.5, "no axis and no motor", horizontalalignment="center")
    else:
        panels = figure.subplots(len(rows), 2, sharex=True, squeeze=False)
        for row, shown in zip(panels, rows, strict=True):
            for axes, each in zip(row, shown, strict=True):
                draw_panels(axes, each, runs)
        for axes in panels[-1]:
            axes.set_xlabel("time (s)")
        mark_windows(figure, runs.values())
        title += "".join(mark_events(figure, runs))
        legends(figure.axes)
    figure.suptitle(title)
    return figure


def picture_rows(runs: Mapping[str, RunResult]) -> Iterator[tuple[list[Panel], list[Panel]]]:
    """Return the panels on the left and on the right of each row; outputs of a user's own share the last one."""
    first = next(iter(runs.values())).plan
    for axis in first.axes:
        yield [Panel("position", axis)], [Panel("error", axis)]
    for motor in first.motors:
        yield [Panel("commands", motor)], [Panel("currents", motor)]
    own = [Panel("own", name) for name in dict.fromkeys(
        name for run in runs.values() for name in own_outputs(run.plan, run.columns))]
    if own and first.axes.keys() | first.motors.keys():
        half = (len(own) + 1) // 2
        yield own[:half], own[half:]


def draw_panels(axes: "Axes", panels: Sequence[Panel], runs: Mapping[str, RunResult]) -> None:
    """Draw what panels of a kind show, with the levels that are near: one farther off would flatten it."""
    for panel in panels:
        kind, floor = PANELS[panel.kind], PANELS[panel.kind].drawn_floor
        for line in panel_lines(panel, runs, run_colours(runs)):
            values = kind.scale * recorded_columns(runs[line.run])[line.signal]
            axes.plot(runs[line.run].time, values if floor is None else np.maximum(np.abs(values), floor),
                      color=colour(line.css), linestyle=STYLES[line.dash], linewidth=0.4 if line.thin else 0.9,
                      label=f"{line.name} {panel.of}".strip() if panel.kind == "own" else line.of or line.name)
        if floor is not None:
            axes.set_yscale("log")
        low, high = axes.get_ylim()
        near = (2.0 * low - high, 2.0 * high - low) if floor is None else (0.1 * low, 10.0 * high)
        for level in panel_levels(panel, runs):
            if near[0] <= level.value <= near[1]:
                axes.axhline(level.value, color=colour(level.css), linewidth=0.8, linestyle=STYLES[level.dash],
                             label=level.name)
        unit, gap = axis_of(runs.values(), panel)
        axes.set_ylabel("own outputs" if panel.kind == "own" else kind.title(panel.of, unit, gap))
        if kind.place and gap:
            axes.invert_yaxis()   # an air gap grows downwards


def legends(panels: Iterable["Axes"]) -> None:
    """Put a legend next to each panel; a name appears in one legend only."""
    told: set[str] = set()
    for panel in panels:
        named: dict[str, Line2D] = {}
        for line in panel.lines:
            name = str(line.get_label())
            if name and not name.startswith("_") and name not in told:
                named.setdefault(name, line)
        told |= named.keys()
        if named:
            panel.legend(handles=[*named.values()], loc="center left", bbox_to_anchor=(1.0, 0.5), fontsize="small")


def mark_windows(figure: "Figure", runs: Iterable[RunResult]) -> None:
    """Mark the windows of the scenarios' events, each once, with their names above the panels on top."""
    for name, start, end in dict.fromkeys(window for run in runs for window in run.plan.windows):
        for panel in figure.axes:
            panel.axvspan(start, end, color=colour("open"), alpha=0.12, linewidth=0)
            panel.axvline(start, color=colour("open"), linewidth=0.6)
        for panel in figure.axes[:2]:
            panel.annotate(name, (start, 1.0), (0, 2), xycoords=panel.get_xaxis_transform(), fontsize="small",
                           textcoords="offset points", verticalalignment="bottom", color=colour("open"),
                           annotation_clip=True)


def mark_events(figure: "Figure", runs: Mapping[str, RunResult]) -> Iterator[str]:
    """Mark when a stop was touched or the controller tripped, of several runs in their colours; lines that say so."""
    for label, run in runs.items():
        css = f"run-{run_colours(runs)[label]}" if label else "bad"
        for event in events(run.metrics):
            yield f"\n{label} {event.text()} (dashed)".replace("\n ", "\n")
            for panel in figure.axes:
                panel.axvline(event.time, color=colour(css), linewidth=1.0, linestyle="--")
