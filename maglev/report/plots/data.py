"""What the page's scripts know about runs and figures, as JSON has it."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

from maglev.experiment.execution import RunResult
from maglev.judging.verdicts import Judgements
from maglev.live.content import tilts
from maglev.panels import PANELS, kinds_of
from maglev.procedures.outcome import Outcome
from maglev.report.plots.charts import ShownChart, chart_data, shown_charts
from maglev.report.plots.figures import (
    MOVING,
    Shown,
    axis_of,
    error_of,
    needed_tolerances,
    recorded_columns,
    shown_commands,
    speed_of,
)
from maglev.report.plots.marks import figure_bounds, figure_marks, limits
from maglev.report.plots.series import pack
from maglev.report.status import events
from maglev.schema.run_plan import RunPlan
from pmlsm.motor_geometry import MotorGeometry

MOST_ROWS = 16000            # of a signal
FEWEST_ROWS = 1000           # of a signal, however large the page
LARGEST_DATA = 8_500_000     # bytes of all signals; the rest is less than 2 million


class Frictionless(NamedTuple):
    """Runs that were flown again without friction, and what procedures found in them."""

    runs: Sequence[RunResult] = ()
    outcomes: Sequence[Outcome] = ()


NOTHING = Frictionless()


def runs_data(results: Sequence[RunResult], shown: Sequence[Shown],
              frictionless: Sequence[RunResult] = ()) -> dict[str, dict[str, Any]]:
    """Recorded runs by name; many and noisy ones with fewer rows of each signal, so that the page stays small."""
    most = MOST_ROWS
    while True:
        runs = {name: run_data(result, shown, most, kinds) for result, name, kinds in (
            *((result, result.plan.name, tuple(PANELS)) for result in results),
            # What claims blame friction for is seen in the motion.
            *((result, again_name(result), kinds_of("axis")) for result in frictionless))
            if len(result.time) and is_drawn(result, shown)}
        if sum(len(run["data"]) for run in runs.values()) <= LARGEST_DATA or most <= FEWEST_ROWS:
            return runs
        most //= 2


def is_drawn(result: RunResult, shown: Iterable[Shown]) -> bool:
    """Whether the page's scripts need a run: not one of a procedure that no figure shows."""
    name = result.plan.name
    return result.plan.procedure is None or name in MOVING or any(each.has(name) for each in shown)


def again_name(result: RunResult) -> str:
    """Name in the page of a run that was flown again without friction."""
    return f"{result.plan.name}, without friction"


def run_data(result: RunResult, shown: Sequence[Shown], most: int, kinds: Sequence[str]) -> dict[str, Any]:
    """What the page's scripts know about a run: names of its signals by axis and motor, and those for some panels."""
    plan = result.plan
    motor = plan.rig.motor() if plan.rig else MotorGeometry()
    packed = pack(result.time, recorded_columns(result), plan.output_interval,
                  needed_tolerances(result, shown, kinds), most)
    return {
        "title": plan.title,
        "axes": {name: {"position": axis.position, "reference": axis.reference, "speed": speed_of(axis),
                        "error": error_of(axis), "vertical": axis.vertical, "rotation": axis.rotation,
                        "bands": plan.metrics.bands_of(axis)} for name, axis in plan.axes.items()},
        "sheet": {name: 1e3 * getattr(motor, name) for name in ("slot_pitch", "slot_width", "pole_pitch")},   # mm
        "drives": {motor.name: motor.drives for motor in plan.rig.motors} if plan.rig else {},
        "tilts": tilts(plan.rig) if plan.rig else {},
        "motors": {name: {"commands": shown_commands(motor), "currents": motor.currents}
                   for name, motor in plan.motors.items()},
        "limits": [limit._asdict() for limit in limits(plan, result.parameters)],
        "events": [{"time": event.time, "text": event.words} for event in events(result.metrics)],
        "windows": plan.windows,
        **packed,
    }


def readings(plan: RunPlan) -> list[dict[str, Any]]:
    """What the moving picture of a run prints below it: signals with their names, units and digits."""
    place = PANELS["position"]
    return [*({"signal": axis.position, "name": place.words(name, axis.vertical), **place.reading(axis.unit)}
              for name, axis in plan.axes.items()),
            *({"signal": signal, "name": " ".join(signal.split(".")[-2:]).replace("_cmd", ""), **PANELS[kind].reading()}
              for motor in plan.motors.values()
              for kind, signals in (("commands", shown_commands(motor)), ("currents", motor.currents))
              for signal in signals)]


def figure_data(shown: Shown | ShownChart, judgements: Judgements,
                frictionless: Frictionless = NOTHING) -> dict[str, Any]:
    """What the page's scripts know about a figure."""
    if isinstance(shown, ShownChart):
        same = [each for each in shown_charts(frictionless.outcomes) if each.id == shown.id]
        return {**chart_data(shown), **({"without": chart_data(same[0])["chart"]} if same else {})}
    labels = {run.plan.name: shown.figure.runs[run.plan.name] + (" (modified)" if run.modified else "")
              for run in shown.recorded}
    again = [{"name": again_name(run), "label": "without friction" if len(labels) == 1 else
              f"{labels[run.plan.name]}, without friction"} for run in frictionless.runs
             if run.plan.name in labels and len(run.time)]
    return {"runs": [{"name": name, "label": label} for name, label in labels.items()],
            "panels": [{"kind": panel.kind, **PANELS[panel.kind].data(panel.of, *axis_of(shown, panel))}
                       for panel in shown.panels],
            "bounds": figure_bounds(shown, judgements),
            "marks": figure_marks(shown, judgements),
            **({"without": again} if again else {}),
            **({} if shown.figure.until is None else {"until": shown.figure.until})}
