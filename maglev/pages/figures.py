"""The figures of the page: which runs they show in which panels, and the signals that this needs."""

import re
import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.registry import known_stages
from maglev.pages.live_content import LAW_COLOURS, LAWS
from maglev.pages.panels import PANELS, panel_kinds
from maglev.pages.status import shown_until
from maglev.runs.execution import RunResult
from maglev.scenario.run_plan import Axis, RunPlan
from maglev.scenario.toml_table import Seconds, Table

EVERY = "*"
COARSER = 10.0   # times as large a tolerance
COLOURS = 7   # of runs

# The main runs, those that are also shown as a moving picture.
MOVING = ("3dof-setpoints-improved", "3dof-step-3-antiwindup-linear", "3dof-tracking-nonlinear",
          "2dof-setpoints", "2dof-tracking-nonlinear", "2dof-step-4-linear",
          "5dof-setpoints")


class Panel(NamedTuple):
    """One panel: its kind, and the axis, the motor ("*" for all) or the output of a user's own that it shows."""

    kind: str
    of: str


class Figure(Table):
    """A figure of the file, or a figure of a run that the file does not mention."""

    number: str | None = None                      # in the thesis
    variant: str | None = None                     # what sets it apart from another figure of the same number
    caption: str
    runs: dict[str, str] = Field(min_length=1)     # label in the legend by name of the run
    panels: list[str] = Field(min_length=1)        # kind and axis or motor, such as "error y", "position *"
    until: Seconds | None = None                   # end of the time that is shown at first; None for all

    @field_validator("panels")
    @classmethod
    def known_kinds(cls, panels: list[str]) -> list[str]:
        for text in panels:
            kind, _, of = text.partition(" ")
            if kind not in PANELS or not of:
                raise ValueError(f"{text!r} is no panel, expected {', '.join(PANELS)} and an axis, a motor, a column "
                                 "or *")
        return panels

    @property
    def id(self) -> str:
        parts = [self.number, self.variant] if self.number else ["run", next(iter(self.runs))]
        return anchor("figure", *(part for part in parts if part))


class Shown(NamedTuple):
    """A figure that has data: its runs among the results, also those that failed, and the panels that they fill."""

    figure: Figure
    runs: list[RunResult]
    panels: list[Panel]
    id: str                                    # its anchor in the page
    number: str | None                         # in the thesis
    title: str
    caption: str
    colours: Mapping[str, int] | None = None   # by name of the run, where a legend of all plots names the runs

    @property
    def names(self) -> list[str]:
        """Return the names that claims about the figure can have: its runs, and the procedures that these belong to."""
        procedures = [run.plan.procedure.name for run in self.runs if run.plan.procedure is not None]
        return list(dict.fromkeys([*(run.plan.name for run in self.runs), *procedures]))

    @property
    def recorded(self) -> list[RunResult]:
        """Runs that can be drawn."""
        return [run for run in self.runs if len(run.time)]

    def has(self, run: str) -> bool:
        return any(result.plan.name == run for result in self.runs)


def read_figures() -> list[Figure]:
    text = (Path(__file__).parent / "report/plots/figures.toml").read_text(encoding="utf-8")
    return [Figure.model_validate(table) for table in tomllib.loads(text)["figures"]]


def shown_figures(figures: Iterable[Figure], results: Sequence[RunResult]) -> list[Shown]:
    """Return figures with at least one recorded run; then one for every other recorded run, with all its panels.

    Runs of a procedure, many and short, get none of their own: the procedure has its charts.
    """
    own = [f"{kind} {EVERY}" for kind in panel_kinds("column")]
    shown = list(with_data(figures, results, own))
    every_panel = [f"{kind} {EVERY}" for kind in panel_kinds("axis", "motor")]
    others = [Figure(caption=result.plan.title, runs={result.plan.name: "simulated"}, panels=every_panel,
                     until=shown_until([(result.metrics, float(result.time[-1]) if len(result.time) else 0.0)]))
              for result in results
              if result.plan.procedure is None and not any(figure.has(result.plan.name) for figure in shown)]
    return shown + list(with_data(others, results, own))


def with_data(figures: Iterable[Figure], results: Sequence[RunResult], more: Sequence[str] = ()) -> Iterator[Shown]:
    """Figures that have something to draw, in their panels and in more of them."""
    by_name = {result.plan.name: result for result in results}
    for figure in figures:
        runs = [by_name[run] for run in figure.runs if run in by_name]
        panels = list(dict.fromkeys(panel for text in [*figure.panels, *more] for panel in expand(text, runs)))
        if panels:
            heading = f"Figure {figure.number}" if figure.number else f"Run {next(iter(figure.runs))}"
            title = f"{heading}: {figure.variant}" if figure.variant else heading
            yield Shown(figure, runs, panels, figure.id, figure.number, title, figure.caption)


def expand(text: str, runs: Iterable[RunResult]) -> Iterator[Panel]:
    """Panels that a text such as "error *" means, as far as the runs have what they show."""
    kind, _, of = text.partition(" ")
    for result in runs:
        recorded = recorded_columns(result)
        for name in shown_by(result, kind):
            if of in (name, EVERY) and any(column in recorded for column in needed_columns(result.plan, kind, name)):
                yield Panel(kind, name)


def shown_by(result: RunResult, kind: str) -> list[str]:
    """Return the items that panels of a kind can show of a run: axes, motors, or columns unknown to this project's
    FMUs.
    """
    of, plan = PANELS[kind].of, result.plan
    return own_outputs(plan, result.columns) if of == "column" else [*(plan.axes if of == "axis" else plan.motors)]


def own_outputs(plan: RunPlan, columns: Mapping[str, NDArray[Any]]) -> list[str]:
    """Return the columns of numbers that no FMU of this project has: further outputs of a user's FMU."""
    stages = known_stages()
    known = {variable.name for name in stages.definitions() for variable in stages.definition(name).variables}
    driven = {signal.to for signal in plan.signals} | {axis.reference for axis in plan.axes.values()}
    return [name for name, values in columns.items()
            if name.partition(".")[2] not in known and name not in driven and values.dtype == np.float64]


def controller_of(run: RunResult) -> str:
    """Return the FMU of this project that controlled a run; empty for another controller."""
    if run.provenance is not None:
        return next((fmu.model for fmu in run.provenance.fmus if fmu.name == "controller" and fmu.built_here), "")
    return (run.plan.fmus["controller"].model or "") if "controller" in run.plan.fmus else ""


def law_of(run: RunResult) -> str:
    """Return the law of this project's controller of a run, such as "linear"; empty for another controller."""
    return LAWS.get(controller_of(run).removesuffix(run.plan.stage.suffix if run.plan.stage else ""), "")


def run_colours(runs: Mapping[str, RunResult]) -> dict[str, int]:
    """Return the number of each run's colour, by label: that of its controller in every page, or the next free one."""
    numbers: dict[str, int] = {}
    for label, run in runs.items():
        number = LAW_COLOURS.get(law_of(run), 1)
        if number not in numbers.values():
            numbers[label] = number
    free = [k for k in range(COLOURS) if k not in numbers.values()] or [0]
    others = [label for label in runs if label not in numbers]
    return numbers | {label: free[k % len(free)] for k, label in enumerate(others)}


def stage_name(name: str, plan: RunPlan | None = None) -> str:
    """Name of the stage that a run, or a procedure by its name, is about; empty if none."""
    stage = plan.stage if plan else next((stage for stage in PACKAGED_STAGES.values() if stage.name in name.lower()),
                                         None)
    return stage.name if stage else ""


def moving_runs(results: Iterable[RunResult]) -> list[RunResult]:
    """Return the runs that a page animates: the main ones or, without any of them, the first recorded one."""
    recorded = {run.plan.name: run for run in results if len(run.time) > 1}
    return [recorded[name] for name in MOVING if name in recorded] or [*recorded.values()][:1]


def anchor(*parts: str) -> str:
    return re.sub(r"[^A-Za-z0-9]+", "-", "-".join(parts))


def axis_of(runs: Iterable[RunResult], panel: Panel) -> tuple[str, bool]:
    """SI unit of the axis that a panel shows of runs, m if it shows none, and whether the axis is an air gap."""
    return next(((axis.unit, axis.vertical) for run in runs if PANELS[panel.kind].of == "axis"
                 for name, axis in run.plan.axes.items() if name == panel.of), ("m", False))


def error_of(axis: Axis) -> str:
    """Name of the column with the error of an axis; see `recorded_columns`."""
    return f"{axis.position} - {axis.reference}"


def recorded_columns(result: RunResult) -> dict[str, NDArray[Any]]:
    """Return the columns of a run, and the errors of its axes, shape (n,), SI.

    The errors are columns of their own because they have a finer scale than position and reference.
    """
    columns = result.columns
    errors = {error_of(axis): columns[axis.position] - columns[axis.reference]
              for axis in result.plan.axes.values() if axis.position in columns and axis.reference in columns}
    return {**columns, **errors}


def needed_columns(plan: RunPlan, kind: str, of: str) -> list[str]:
    if kind == "own":
        return [of]
    if kind == "commands":   # direct and quadrature, if a motor has such: the phases are shown as delivered
        commands = plan.motors[of].commands
        return [name for name in commands if "i_d" in name or "i_q" in name] or list(commands)
    if kind == "currents":
        return list(plan.motors[of].currents)
    axis = plan.axes[of]
    speed = "".join((*axis.position.rpartition(".")[:2], "velocity"))
    return {"speed": [speed], "error": [error_of(axis)], "position": [axis.position, axis.reference]}[kind]


def needed_tolerances(result: RunResult, shown: Iterable[Shown], kinds: Sequence[str],
                      moves: bool) -> dict[str, float]:
    """Tolerances by name of the columns that panels of some kinds draw of a run, and, if it `moves`, the picture.

    Columns of the picture alone are COARSER, because it has fewer px.
    """
    plan = result.plan
    drawn = {panel for figure in shown if figure.has(plan.name) for panel in figure.panels}
    moving = {Panel(kind, of) for kind in ("position", "currents") for of in shown_by(result, kind)} if moves else set()
    tolerances = {}
    for kind, of in sorted(panel for panel in drawn | moving if panel.kind in kinds):
        for name in needed_columns(plan, kind, of) if of in shown_by(result, kind) else ():
            tolerances[name] = PANELS[kind].tolerance * (1.0 if Panel(kind, of) in drawn else COARSER)
            if kind == "own":
                tolerances[name] = tolerances[name] * float(np.nanmax(np.abs(result.columns[of]), initial=0.0)) or 1.0
    return tolerances
