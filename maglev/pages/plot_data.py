"""Data of runs and figures for the page's scripts, in JSON form."""

from collections.abc import Mapping, Sequence
from typing import Any

from maglev.pages import live_content as content
from maglev.pages.charts import ShownChart, chart_data, shown_charts
from maglev.pages.figures import (
    Panel,
    Shown,
    axis_of,
    error_of,
    moving_runs,
    needed_tolerances,
    recorded_columns,
    run_colours,
)
from maglev.pages.lines import panel_levels, panel_lines
from maglev.pages.marks import figure_bounds, figure_marks
from maglev.pages.panels import PANELS, panel_kinds
from maglev.pages.series import pack
from maglev.pages.what_if import NOTHING, Again
from maglev.runs.endings import events
from maglev.runs.execution import RunResult
from maglev.runs.verdicts import Judgements

MOST_ROWS = 16000            # of a signal
FEWEST_ROWS = 900            # of a signal, however large the page
LARGEST_DATA = 8_200_000     # bytes of all signals; the rest is less than 2 million


def runs_data(results: Sequence[RunResult], shown: Sequence[Shown],
              frictionless: Sequence[RunResult] = ()) -> dict[str, dict[str, Any]]:
    """Recorded runs by name; many and noisy ones with fewer rows of each signal, so that the page stays small.

    Those of a procedure that no figure shows are left out.
    """
    most, films = MOST_ROWS, {run.plan.name for run in moving_runs(results)}
    while True:
        runs = {name: run_signals(result, shown, most, kinds, result.plan.name in films) for result, name, kinds in (
            *((result, result.plan.name, tuple(PANELS)) for result in results),
            # The motion shows the effects for which claims blame friction.
            *((result, again_name(result), panel_kinds("axis")) for result in frictionless))
            if len(result.time) and (result.plan.procedure is None or name in films
                                     or any(figure.has(result.plan.name) for figure in shown))}
        if sum(len(run["data"]) for run in runs.values()) <= LARGEST_DATA or most <= FEWEST_ROWS:
            return runs
        most //= 2


def again_name(result: RunResult) -> str:
    """Name in the page of a run that was made again without friction."""
    return f"{result.plan.name}, without friction"


def run_signals(result: RunResult, shown: Sequence[Shown], most: int, kinds: Sequence[str],
                moves: bool = False) -> dict[str, Any]:
    """Return the data of a run for the page's scripts: names of its signals by axis and motor, and those for some
    panels.
    """
    plan = result.plan
    packed = pack(result.time, recorded_columns(result), plan.output_interval,
                  needed_tolerances(result, shown, kinds, moves), most)
    return {
        "title": plan.title,
        "axes": {name: {"position": axis.position, "reference": axis.reference} for name, axis in plan.axes.items()},
        "motors": {name: {"currents": motor.currents} for name, motor in plan.motors.items()},
        "events": [{"time": event.time, "text": event.text()} for event in events(result.metrics)],
        "windows": plan.windows,
        **packed,
    }


def moving(runs: Mapping[str, RunResult]) -> dict[str, Any]:
    """Return the data of runs for the moving picture, by label: their stage and colours; empty if one is incomplete."""
    first, colours = next(iter(runs.values())).plan, run_colours(runs)
    errors = {error_of(axis) for axis in first.axes.values()}
    if first.stage is None or tuple(first.axes) != first.stage.axis_names or not all(
            len(run.time) > 1 and recorded_columns(run).keys() >= errors for run in runs.values()):
        return {}
    run, stage = content.live_run(first, first.stage), content.live_stage(first.stage)
    return {"stage": {**{key: run[key] for key in ("axes", "motors", "vertical", "drives", "rotations")},
                      "stage": {key: stage[key] for key in ("sheet", "room", "places", "tilts")}},
            "runs": [{"run": run.plan.name, "label": label, "css": f"run-{colours[label]}"}
                        for label, run in runs.items()]}


def panel_data(shown: Shown, panel: Panel, again: Mapping[str, RunResult]) -> dict[str, Any]:
    """Return the data of a panel for the page's scripts: lines and levels of its runs, and of repeated ones, by label.
    """
    runs = {shown.figure.runs[run.plan.name]: run for run in shown.recorded}
    names = {label: run.plan.name for label, run in runs.items()} | {
        label: again_name(run) for label, run in again.items()}
    colours = None if shown.colours is None else {label: shown.colours[run.plan.name] for label, run in runs.items()}
    lines = [*panel_lines(panel, runs, colours)]
    if PANELS[panel.kind].of == "axis":   # what claims blame friction for is seen in the motion
        lines += [line for line in panel_lines(panel, {**runs, **again}) if line.run in again and line.name in again]
    return {"kind": panel.kind, **PANELS[panel.kind].data(panel.of, *axis_of(shown.runs, panel)),
            "lines": [{**line._asdict(), "run": names[line.run]} for line in lines],
            "levels": [level._asdict() for level in panel_levels(panel, runs)]}


def figure_data(shown: Shown | ShownChart, judgements: Judgements,
                frictionless: Again = NOTHING) -> dict[str, Any]:
    if isinstance(shown, ShownChart):
        same = [chart for chart in shown_charts(frictionless.outcomes) if chart.id == shown.id]
        return {**chart_data(shown), **({"without": chart_data(same[0])["chart"]} if same else {})}
    labels = {run.plan.name: shown.figure.runs[run.plan.name] for run in shown.recorded}
    again = {"without friction" if len(labels) == 1 else f"{labels[run.plan.name]}, without friction": run
             for run in frictionless.runs if run.plan.name in labels and len(run.time)}
    return {"runs": [{"name": name, "label": label,
                      **({} if shown.colours is None else {"css": f"run-{shown.colours[name]}"})}
                     for name, label in labels.items()],
            "panels": [panel_data(shown, panel, again) for panel in shown.panels],
            "bounds": figure_bounds(shown, judgements),
            "marks": figure_marks(shown, judgements),
            **({"without": [{"name": again_name(run), "label": label} for label, run in again.items()]}
               if again else {}),
            **({} if shown.figure.until is None else {"until": shown.figure.until})}
