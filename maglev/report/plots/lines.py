"""What a panel draws of runs, the same in pages and in pictures: lines with their looks, and levels across."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from maglev.experiment.execution import RunResult
from maglev.panels import PANELS
from maglev.report.plots.figures import Panel, needed_columns, shown_by
from maglev.schema.run_plan import RunPlan

DASHES = ("solid", "dash", "dot", "dashdot")   # of runs, in turn
HUES = 5                                       # of runs that have no colour of their controller
CURRENTS = {"commands": ("direct", "quadrature"), "currents": ("phase-0", "phase-1", "phase-2")}   # colours, in turn


class Line(NamedTuple):
    """A line of a panel: whose it is, by the run's label, what it shows, what it is called, and how it looks."""

    run: str
    signal: str               # column, or error of an axis
    name: str
    css: str                  # colour in the style sheet of all pages
    dash: str = "solid"
    thin: bool = False
    of: str | None = None     # what stands for it in a legend of all panels, if its name does not


class Level(NamedTuple):
    """A level across a panel, in the unit that this has: what it is, and how it looks."""

    value: float
    name: str
    css: str
    dash: str


def panel_lines(panel: Panel, runs: Mapping[str, RunResult], colours: Mapping[str, int] | None = None
                ) -> Iterator[Line]:
    """Lines of recorded runs, by label; `colours` are numbers of those of their controllers.

    The reference is drawn once, of the run that was recorded longest. Currents of one run have a colour each, those of
    several the colour of their run.
    """
    kind, of = panel
    having = [label for label, run in runs.items() if of in shown_by(run, kind)]
    if kind == "position" and having:
        longest = max(having, key=lambda label: float(runs[label].time[-1]))
        yield Line(longest, runs[longest].plan.axes[of].reference, "reference", "reference", "dot")
    for k, (label, run) in enumerate(runs.items()):
        css = f"run-{k % HUES if colours is None else colours[label]}"
        dash = DASHES[k % len(DASHES)]
        if label not in having:
            continue
        signals = needed_columns(run.plan, kind, of)
        if kind not in CURRENTS:
            yield Line(label, signals[0], label, css, dash)
            continue
        for s, signal in enumerate(signals):
            short = signal.rpartition(".")[2].removesuffix("_cmd")
            name = f"{short} {label}" if len(runs) > 1 else short
            if colours is None or len(runs) == 1:
                yield Line(label, signal, name, CURRENTS[kind][s % len(CURRENTS[kind])], dash)
            else:
                yield Line(label, signal, name, css, dash, thin=s > 0, of=label)


def panel_levels(panel: Panel, runs: Mapping[str, RunResult]) -> list[Level]:
    """Bands of settling, end stops and limits of currents, each once; of what not all runs have it is said whose."""
    scale = PANELS[panel.kind].scale
    whose: dict[Level, list[str]] = {}
    for label, run in runs.items():
        if panel.kind == "error" and panel.of in run.plan.axes:
            for band in run.plan.metrics.bands_of(run.plan.axes[panel.of]):
                whose.setdefault(Level(scale * band, "bands of settling", "reference", "dot"), []).append(label)
        for limit in limits(run.plan, run.parameters):
            for value in limit.values if (limit.kind, limit.of) == panel else ():
                whose.setdefault(Level(scale * value, limit.text, "limit", "dashdot"), []).append(label)
    return [level if len(labels) == len(runs) or level.css == "reference" else
            level._replace(name=f"{level.name} ({', '.join(labels)})") for level, labels in whose.items()]


class Limit(NamedTuple):
    """Levels (SI) that a panel marks: its kind, the axis or motor it shows, what they are in words, and where."""

    kind: str
    of: str
    text: str
    values: list[float]


def limits(plan: RunPlan, parameters: Mapping[str, float]) -> list[Limit]:
    """Limits by the parameters (SI) that a run started with; of FMUs with other names none."""
    drawn = []
    for name, axis in plan.axes.items():
        stop = axis.position.rpartition(".")[0] + ".stop."
        if stop + "lower" in parameters and stop + "upper" in parameters:
            drawn.append(Limit("position", name, "end stops", [parameters[stop + end] for end in ("lower", "upper")]))
    for name, motor in plan.motors.items():
        peak = parameters.get(motor.currents[0].rpartition(".")[0] + ".amplifier.peak") if motor.currents else None
        limit = parameters.get(motor.commands[0].partition(".")[0] + ".current_limit") if motor.commands else None
        if peak:
            drawn.append(Limit("currents", name, f"peak of the amplifiers, {peak:g} A", [-peak, peak]))
        if limit:   # 0 is none
            limit *= parameters.get(motor.commands[0].rpartition(".")[0] + ".limit_ratio", 1.0)
            drawn.append(Limit("commands", name, f"limit of the commands, {limit:g} A", [-limit, limit]))
    return drawn
