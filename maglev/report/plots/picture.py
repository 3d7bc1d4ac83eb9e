"""Picture of a run: positions with their references, absolute errors, commands and phase currents."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from maglev.cosim.master import Recording
from maglev.experiment.execution import RunResult
from maglev.pages.shell import colour
from maglev.panels import PANELS
from maglev.pictures import FAINT, new_figure
from maglev.report.plots.figures import own_outputs, run_colours, shown_commands
from maglev.report.plots.marks import limits
from maglev.report.status import events, shown_until

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BESIDE: dict[str, Any] = {"loc": "center left", "bbox_to_anchor": (1.0, 0.5), "fontsize": "small"}   # legends
STYLES = ("-", "--", ":", "-.")   # of runs
CURRENTS = {"commands": ("direct", "quadrature"), "currents": ("phase-0", "phase-1", "phase-2")}   # colours, in turn


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
    first = next(iter(runs.values())).plan
    rows = len(first.axes) + len(first.motors)
    figure = new_figure(12, 2.3 * max(rows, 1))
    figure.suptitle(title)
    until = shown_until((run.metrics, float(run.time[-1])) for run in runs.values())
    if until is not None:
        end = max(run.time[-1] for run in runs.values())
        figure.suptitle(f"{title}\nthe first {until:.2g} s of {end:g} s")
        runs = {label: before(run, until) for label, run in runs.items()}
    if not rows:
        figure.text(0.5, 0.5, "no axis and no motor", horizontalalignment="center")
        return figure
    own = {name: None for run in runs.values() for name in own_outputs(run.plan, run.columns)}
    if own:
        rows += 1
        figure.set_figheight(2.3 * rows)
    panels = figure.subplots(rows, 2, sharex=True, squeeze=False)
    for name, row in zip(first.axes, panels, strict=False):
        draw_axis(name, row, runs)
    for name, row in zip(first.motors, panels[len(first.axes):], strict=False):
        draw_motor(name, row, runs)
    if own:
        draw_own(list(own), panels[-1], runs)
    for panel in panels[-1]:
        panel.set_xlabel("time (s)")
    mark_limits(figure, [*first.axes, *first.motors], runs.values())
    mark_windows(figure, runs.values())
    mark_events(figure, runs)
    legends(figure.axes, len(runs) > 1)
    for axis, row in zip(first.axes.values(), panels, strict=False):
        if axis.vertical and PANELS["position"].place:
            row[0].invert_yaxis()   # an air gap grows downwards
    return figure


def looks(runs: Mapping[str, RunResult]) -> Iterator[tuple[str, RunResult, dict[str, Any]]]:
    """Runs with their labels, and how their lines are drawn, as in the pages."""
    for k, (label, number) in enumerate((label, run_colours(runs)[label]) for label in runs):
        yield label, runs[label], {"color": colour(f"run-{number}"), "linestyle": STYLES[k % len(STYLES)]}


def legends(panels: Iterable["Axes"], once: bool) -> None:
    """Put a legend beside each panel; with `once`, what is named beside one is not named again."""
    told: set[str] = set()
    for panel in panels:
        named = [line for line in panel.lines if not str(line.get_label()).startswith("_")
                 and not (once and line.get_label() in told)]
        told |= {str(line.get_label()) for line in named}
        if named:
            panel.legend(handles=named, **BESIDE)


def mark_limits(figure: "Figure", rows: Sequence[str], runs: Iterable[RunResult]) -> None:
    """Mark end stops and limits of currents, each once, of whichever runs have it."""
    marked: set[tuple[str, str, float]] = set()
    drawn = [panel.get_ylim() for panel in figure.axes]   # of the signals alone: a mark widens its panel
    for limit in (limit for run in runs for limit in limits(run.plan, run.parameters)):
        number = 2 * rows.index(limit.of) + (limit.kind == "currents")
        panel, (low, high) = figure.axes[number], drawn[number]
        label = limit.text
        for value in (PANELS[limit.kind].scale * value for value in limit.values):
            place = (limit.kind, limit.of, value)
            # Further off it would flatten what is drawn.
            if 2.0 * low - high <= value <= 2.0 * high - low and place not in marked:
                marked.add(place)
                panel.axhline(value, color="0.3", linewidth=0.8, linestyle="-.", label=label)
                label = "_"   # in the legend once


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


def mark_events(figure: "Figure", runs: Mapping[str, RunResult]) -> None:
    """Mark when a stop was touched or the controller tripped; of several runs in their colours."""
    for label, run, look in looks(runs):
        for event in events(run.metrics):
            who = f"{label} " if label else ""
            figure.suptitle(f"{figure.get_suptitle()}\n{who}{event.words} at {event.time:.3f} s (dashed)")
            for panel in figure.axes:
                panel.axvline(event.time, color=look["color"] if label else colour("bad"), linewidth=1.0,
                              linestyle="--")


def draw_axis(name: str, row: Sequence["Axes"], runs: Mapping[str, RunResult]) -> None:
    """Positions of an axis with the reference on the left, absolute errors on the right."""
    left, right = row
    places, errors = PANELS["position"], PANELS["error"]
    for number, (label, run, look) in enumerate(looks(runs)):
        axis = run.plan.axes[name]
        position, reference = (places.scale * run.columns[column] for column in (axis.position, axis.reference))
        if number == 0:
            left.plot(run.time, reference, **FAINT, label="reference")
            for band in run.plan.metrics.bands_of(axis):
                right.axhline(errors.scale * band, **FAINT, linestyle="--")
        left.plot(run.time, position, linewidth=1.0, label=label or "position", **look)
        right.semilogy(run.time, np.maximum(np.abs(position - reference), errors.drawn_floor or 0.0), linewidth=0.8,
                       **look)
    left.set_ylabel(places.title(name, axis.unit, axis.vertical))
    right.set_ylabel(errors.title(name, axis.unit, axis.vertical))


def draw_own(names: Sequence[str], row: Sequence["Axes"], runs: Mapping[str, RunResult]) -> None:
    """Outputs of a user's own, as they come: the first half on the left, the others on the right."""
    half = (len(names) + 1) // 2
    for panel, shown in zip(row, (names[:half], names[half:]), strict=True):
        for label, run in runs.items():
            for name in (name for name in shown if name in run.columns):
                panel.plot(run.time, run.columns[name], linewidth=0.8,
                           label=f"{label} {name}".strip())
        panel.set_ylabel("own outputs")


def draw_motor(name: str, row: Sequence["Axes"], runs: Mapping[str, RunResult]) -> None:
    """Commands of a motor on the left, currents of its phases, as delivered, on the right."""
    # Of the commands the direct and the quadrature current, where there are some.
    for panel, kind in zip(row, ("commands", "currents"), strict=True):
        for label, run, look in looks(runs):
            motor = run.plan.motors[name]
            for k, variable in enumerate(shown_commands(motor) if kind == "commands" else motor.currents):
                own = look | {"linewidth": 0.4 if k else 0.9} if label else {
                    "color": colour(CURRENTS[kind][k % len(CURRENTS[kind])]), "linewidth": 0.8,
                    "label": variable.rpartition(".")[2]}
                panel.plot(run.time, run.columns[variable], **own)
        panel.set_ylabel(PANELS[kind].title(name))
