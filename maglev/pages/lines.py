"""Lines and levels of a panel of runs, the same in pages and in pictures, with their looks."""

from collections.abc import Iterator, Mapping
from typing import NamedTuple

from maglev.pages.figures import Panel, needed_columns, run_colours, shown_by
from maglev.pages.panels import PANELS
from maglev.runs.execution import RunResult
from maglev.scenario.run_plan import RunPlan

DASHES = ("solid", "dash", "dashdotdot", "long")   # of runs, in turn; references and limits have others
CURRENTS = {"commands": ("direct", "quadrature"), "currents": ("phase-0", "phase-1", "phase-2")}   # colours, in turn


class Line(NamedTuple):
    """A line of a panel: the run's label, the column, the name, and the look."""

    run: str
    signal: str               # column, or error of an axis
    name: str
    css: str                  # colour in the style sheet of all pages
    dash: str = "solid"
    thin: bool = False
    of: str | None = None     # its name in a legend of all panels, if it differs


class Level(NamedTuple):
    """A level across a panel, in the panel's unit: its name, and its look."""

    value: float
    name: str
    css: str
    dash: str


def panel_lines(panel: Panel, runs: Mapping[str, RunResult], colours: Mapping[str, int] | None = None
                ) -> Iterator[Line]:
    """Lines of recorded runs, by label, in the colours of their controllers; `colours` are those of more runs.

    The reference is drawn once, of the run that was recorded longest. Currents have a colour each or, of several runs
    in the same colours as other panels, that of their run.
    """
    kind, of = panel
    having = [label for label, run in runs.items() if of in shown_by(run, kind)]
    if kind == "position" and having:
        longest = max(having, key=lambda label: float(runs[label].time[-1]))
        yield Line(longest, runs[longest].plan.axes[of].reference, "reference", "reference", "dot")
    numbers = run_colours(runs) if colours is None else colours
    for k, (label, run) in enumerate(runs.items()):
        css = f"run-{numbers[label]}"
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
    """Return bands of settling, end stops and limits of currents, each once; with the run if not all runs have it."""
    whose: dict[Level, list[str]] = {}
    for label, run in runs.items():
        for level in levels_of(panel, run.plan, run.parameters):
            whose.setdefault(level, []).append(label)
    return [level if len(labels) == len(runs) or level.css == "reference" else
            level._replace(name=f"{level.name} ({', '.join(labels)})") for level, labels in whose.items()]


def levels_of(panel: Panel, plan: RunPlan, parameters: Mapping[str, float]) -> Iterator[Level]:
    """Levels of a run; limits by the parameters (SI) that it started with, of FMUs with other names none."""
    kind, of = panel
    axis, motor, scale = plan.axes.get(of), plan.motors.get(of), PANELS[kind].scale
    if kind == "error" and axis:
        for band in plan.metrics.bands_of(axis):
            yield Level(scale * band, "bands of settling", "reference", "dot")
    elif kind == "position" and axis:
        ends = [f"{axis.position.rpartition('.')[0]}.stop.{end}" for end in ("lower", "upper")]
        for end in ends if parameters.keys() >= {*ends} else ():
            yield Level(scale * parameters[end], "end stops", "limit", "dashdot")
    elif kind == "currents" and motor and motor.currents:
        peak = parameters.get(f"{motor.currents[0].rpartition('.')[0]}.amplifier.peak", 0.0)
        yield from around(f"peak of the amplifiers, {peak:g} A", scale * peak)
    elif kind == "commands" and motor and motor.commands:
        limit = parameters.get(f"{motor.commands[0].partition('.')[0]}.current_limit", 0.0) * parameters.get(
            f"{motor.commands[0].rpartition('.')[0]}.limit_ratio", 1.0)
        yield from around(f"limit of the commands, {limit:g} A", scale * limit)


def around(name: str, limit: float) -> list[Level]:
    """A limit to both sides of zero; none where it is 0."""
    return [Level(sign * limit, name, "limit", "dashdot") for sign in (-1.0, 1.0)] if limit else []
