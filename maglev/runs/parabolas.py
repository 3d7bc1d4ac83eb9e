"""Procedure 1: the thrust L at held air gaps, by parabola fit and by the estimator (sections 4.4.1, 5.4.1)."""

import math
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError
from maglev.identification.regressors import EstimatedStage, fitted_parabola, row_of, thrust_of_parabola, thrust_shape
from maglev.identification.settings import EPSILON
from maglev.runs.execution import RunResult
from maglev.runs.procedure_data import Runs, at_epsilon, column, entry, estimators, millimetres, positions_of, stage_of
from maglev.runs.procedure_outcome import Chart, Curve, Outcome, Panel, ProcedureValue, ValueTable
from maglev.scenario.loading import load_plans
from maglev.scenario.procedure import ProcedureSettings

FEWEST = 4    # rows that make a parabola
POINTS = 25   # marked on a recorded parabola


class Thrust(NamedTuple):
    """L of one axis in one run, m/(s² A): by parabola fit, and by the estimators by their ε (s)."""

    run: RunResult
    axis: str
    gap: float       # m
    alone: bool      # whether the other axes were held
    time: Array      # s, shape (n,), of the stroke
    position: Array  # m, shape (n,)
    by_parabola: float
    by_estimator: dict[float, float]

    @property
    def estimated(self) -> float:
        """L by the estimator with the ε that the thesis continues with; ScenarioError if there is none."""
        return at_epsilon(self.by_estimator)


def measured_thrust(result: RunResult, stage: EstimatedStage) -> list[Thrust]:
    """Thrust of every axis that moves in a run."""
    positions = dict(zip(stage.axes, positions_of(result, stage).T, strict=True))
    gap = float(positions[stage.axes[0]].mean())
    shape = float(thrust_shape(stage, np.array([gap]))[0])
    start = entry(result.plan.fmus, "plant", result).start
    axes = [axis.name for axis in stage.described.horizontal
            if f"{axis.name}.locked" not in start or not start[f"{axis.name}.locked"].value]
    if not axes:
        return []
    end = min(stroke_rows(positions[axis]) for axis in axes)
    if end < FEWEST:
        raise ScenarioError(f"{result.plan.name}: {end} rows of a parabola, expected {FEWEST} or more")
    time = result.time[:end]
    thrusts = []
    for axis in axes:
        constant = row_of(stage, axis).constants[0]
        # The first row has the values before the first command.
        currents = [column(result, f"plant.{motor.name}.i_q") for motor in stage.described.motors_of(axis)]
        i_q = float(np.mean(currents, axis=0)[1:end].mean())
        position = positions[axis][:end]
        by_parabola = thrust_of_parabola(stage, axis, time, position, i_q)
        by_estimator = {epsilon: shape * float(column(result, f"{name}.{constant}")[end - 1])
                        for epsilon, name in estimators(result).items()}
        thrusts.append(Thrust(result, axis, gap, len(axes) == 1, time, position, by_parabola, by_estimator))
    return thrusts


def stroke_rows(position: Array) -> int:
    """Number of rows until an axis is as far on the other side as it began; behind that it may touch a stop."""
    there = np.flatnonzero(position * np.sign(position[0]) <= -abs(position[0]))
    return int(there[0]) + 1 if len(there) else len(position)


def all_thrusts(procedure: str, runs: Runs) -> list[Thrust]:
    """Thrusts of the runs of a procedure, by ascending air gap."""
    mine = [run for run in runs.values() if run.plan.procedure is not None
            and run.plan.procedure.name == procedure]
    thrusts = [thrust for run in mine for thrust in measured_thrust(run, stage_of(run.plan))]
    return sorted(thrusts, key=lambda thrust: thrust.gap)


def evaluate(settings: ProcedureSettings, runs: Runs) -> Outcome:
    thrusts = all_thrusts(settings.name, runs)
    if not thrusts:
        return Outcome(settings, ())
    stage = stage_of(thrusts[0].run.plan)
    held, together = ([thrust for thrust in thrusts if thrust.alone == alone] for alone in (True, False))
    alone = {axis: [thrust for thrust in held if thrust.axis == axis]
             for axis in dict.fromkeys(thrust.axis for thrust in held)}
    values = [value for thrust in held for value in thrust_values(thrust)]
    for axis, of_axis in alone.items():
        shapes = thrust_shape(stage, np.array([thrust.gap for thrust in of_axis]))
        average = np.mean(np.array([thrust.by_parabola for thrust in of_axis]) / shapes)
        values.append(ProcedureValue("average_constant", float(average), constant=row_of(stage, axis).constants[0],
                                     axis=axis))
    single = {(thrust.axis, millimetres(thrust.gap)): thrust for thrust in held}
    for thrust in together:
        other = single.get((thrust.axis, millimetres(thrust.gap)))
        if other is not None:
            share = relative_error(thrust.estimated, other.estimated)
            values.append(ProcedureValue("simultaneous_deviation", share, axis=thrust.axis, gap=thrust.gap))
    names = tuple(sorted({thrust.run.plan.name for thrust in thrusts}))
    planned = load_plans(thrusts[0].run.plan.source)
    notes = (f"this rests on {len(names)} of {len(planned)} runs",) if len(names) < len(planned) else ()
    return Outcome(settings, names, tuple(values),
                   tuple(thrust_table(axis, of_axis) for axis, of_axis in alone.items()),
                   tuple(charts(settings, alone, together)), notes)


def relative_error(value: float, other: float) -> float:
    """Share by which a value differs from another."""
    return abs(value / other - 1.0) if other != 0.0 else math.inf


def thrust_values(thrust: Thrust) -> list[ProcedureValue]:
    return [ProcedureValue("thrust", thrust.by_parabola, axis=thrust.axis, gap=thrust.gap),
            *(ProcedureValue("estimated_thrust", by_estimator, axis=thrust.axis, epsilon=epsilon, gap=thrust.gap)
              for epsilon, by_estimator in thrust.by_estimator.items()),
            *(ProcedureValue("estimator_deviation", relative_error(by_estimator, thrust.by_parabola), axis=thrust.axis,
                             epsilon=epsilon, gap=thrust.gap) for epsilon, by_estimator in thrust.by_estimator.items())]


def thrust_table(axis: str, thrusts: Sequence[Thrust]) -> ValueTable:
    epsilons = list(thrusts[0].by_estimator)
    return ValueTable(
        f"Thrust of the {axis}-axis, m/(s²·A)",
        ("air gap (mm)", "parabola", *(f"NPFSI, ε = {epsilon:g}" for epsilon in epsilons)),
        tuple((millimetres(thrust.gap), f"{thrust.by_parabola:.4g}",
               *(f"{thrust.by_estimator[epsilon]:.4g}" for epsilon in epsilons)) for thrust in thrusts))


def charts(settings: ProcedureSettings, alone: Mapping[str, Sequence[Thrust]], together: Sequence[Thrust]
           ) -> list[Chart]:
    """The figures: motion and parabolas of each axis, L by every method, and L with all axes moving."""
    drawn, by_method, compared = [], [], []
    for axis, thrusts in alone.items():
        moved = [curve for thrust in thrusts[::2] for curve in motion(thrust)]   # the thesis draws every second air gap
        drawn.append(Chart(settings.figures.get(f"motion {axis}"), f"Displacement of the {axis}-axis under a constant "
                           "current at held air gaps, and the parabolas that were fitted to it.",
                           (Panel("time (s)", f"{axis} (mm)", tuple(moved)),)))
        titles = "air gap (mm)", f"L of {axis} (m/(s²·A))"
        by_method.append(Panel(*titles, (
            Curve("parabola", *over_gap(thrusts, [thrust.by_parabola for thrust in thrusts]), marked=True),
            *(Curve(f"NPFSI, ε = {epsilon:g}",
                    *over_gap(thrusts, [thrust.by_estimator[epsilon] for thrust in thrusts]))
              for epsilon in thrusts[0].by_estimator))))
        kinds = {"one axis": thrusts, "both axes": [thrust for thrust in together if thrust.axis == axis]}
        compared.append(Panel(*titles, tuple(Curve(label, *over_gap(some, [thrust.estimated for thrust in some]))
                                             for label, some in kinds.items())))
    drawn.append(Chart(settings.figures.get("thrust"), "Thrust over the air gap: by parabola fit, and by the estimator "
                       "with three values of ε.", tuple(by_method)))
    if together:
        drawn.append(Chart(settings.figures.get("simultaneous"), "Thrust over the air gap with one axis moving, and "
                           f"with both at once; by the estimator, ε = {EPSILON:g}.", tuple(compared)))
    return drawn


def motion(thrust: Thrust) -> list[Curve]:
    """Recorded displacement and fitted parabola of one run."""
    time, position = thrust.time, thrust.position
    start, acceleration = fitted_parabola(time, position)
    fitted = start + 0.5 * acceleration * time**2
    rows = np.unique(np.linspace(0, len(time) - 1, POINTS).astype(int))
    gap = f"{millimetres(thrust.gap)} mm"
    return [Curve(f"simulated, {gap}", time[rows], 1e3 * position[rows], marked=True, kin=gap),
            Curve(f"parabola, {gap}", time[rows], 1e3 * fitted[rows], kin=gap)]


def over_gap(thrusts: Sequence[Thrust], values: Sequence[float]) -> tuple[Array, Sequence[float]]:
    """Air gaps (mm) and values."""
    return 1e3 * np.array([thrust.gap for thrust in thrusts]), values
