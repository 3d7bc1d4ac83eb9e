"""Data of a run for the procedures: stage, estimators, recorded columns, and constants as values and a table."""

from collections.abc import Mapping, Sequence
from typing import TypeVar

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError, nearest
from maglev.files.units import to_unit
from maglev.identification.regressors import EstimatedStage
from maglev.identification.regressors import estimated_stage as described
from maglev.identification.settings import EPSILON
from maglev.runs.execution import RunResult
from maglev.runs.procedure_outcome import ProcedureValue, ValueTable
from maglev.scenario.procedure import ProcedureSettings
from maglev.scenario.run_plan import RunPlan

T = TypeVar("T")

Runs = Mapping[str, RunResult]   # runs that completed, by name


def stage_of(plan: RunPlan) -> EstimatedStage:
    """The stage of a scenario as the estimators see it; ScenarioError if it is of none."""
    if plan.stage is None:
        raise ScenarioError(f"{plan.source}: expected an FMU or the air gap of a stage, by which a procedure knows it")
    return described(plan.stage)


def estimators(result: RunResult, parameter: str = "epsilon") -> dict[float, str]:
    """Estimators of a run by their ε (s) or another parameter, ascending; ScenarioError if two have the same."""
    names: dict[float, str] = {}
    for name in result.plan.fmus:
        value = result.parameters.get(f"{name}.{parameter}")
        if value is None:
            continue
        if value in names:
            raise ScenarioError(f"{names[value]} and {name} of {result.plan.name} both have {parameter} = "
                                f"{value:g}, expected estimators that differ in it")
        names[value] = name
    return dict(sorted(names.items()))


def estimate(result: RunResult, constants: Sequence[str], epsilon: float = EPSILON) -> dict[str, float]:
    """Constants that the estimator with an ε (s) has at the end of a run; ScenarioError if there is none."""
    name = at_epsilon(estimators(result), epsilon)
    return {constant: entry(result.ends, f"{name}.{constant}", result) for constant in constants}


def at_epsilon(by_epsilon: Mapping[float, T], epsilon: float = EPSILON) -> T:
    """Return the entry for an ε (s), by default the thesis's ε for the later procedures; ScenarioError if there is
    none.
    """
    if epsilon not in by_epsilon:
        raise ScenarioError(f"no estimator has epsilon = {epsilon:g} s, expected one next to "
                            f"{', '.join(f'{known:g} s' for known in by_epsilon) or 'none'}")
    return by_epsilon[epsilon]


def entry(table: Mapping[str, T], name: str, result: RunResult) -> T:
    """Return the entry of a run's table under a name; ScenarioError if there is none."""
    if name not in table:
        raise ScenarioError(f"{result.plan.name} has no {name}, {nearest(name, table)}")
    return table[name]


def column(result: RunResult, name: str) -> Array:
    """A column, such as "plant.v.encoder"; ScenarioError if it was not recorded."""
    return np.asarray(entry(result.columns, name, result), dtype=np.float64)


def positions_of(result: RunResult, stage: EstimatedStage) -> Array:
    """Positions by the encoders, shape (n, axes); where the platform tilts, y and tilts by the gaps at the motors."""
    return np.stack([position_of(result, stage, axis) for axis in stage.axes], axis=1)


def position_of(result: RunResult, stage: EstimatedStage, axis: str) -> Array:
    """Position of one axis by the encoders that show it."""
    described = stage.described
    shares = zip(described.encoders, stage.places.measuring(described)[stage.axes.index(axis)], strict=True)
    return np.asarray(sum(share * column(result, f"plant.{name}") for name, share in shares if share))


def millimetres(length: float) -> str:
    return f"{to_unit(length, 'mm'):.4g}"


def constants_of(settings: ProcedureSettings, result: RunResult, constants: Sequence[str]
                 ) -> tuple[list[ProcedureValue], ValueTable]:
    """Constants with each ε, for claims; and in a table, with those of the thesis and those the plant was run with."""
    found = {epsilon: estimate(result, constants, epsilon) for epsilon in estimators(result)}
    values = [ProcedureValue("constant", value, constant=name, epsilon=epsilon)
              for epsilon, by_name in found.items() for name, value in by_name.items()]
    plant = [result.parameters.get(f"plant.{name}") for name in constants]
    header, columns = ["constant", "of the plant"], [constants, ["" if of is None else f"{of:.5g}" for of in plant]]
    for epsilon, by_name in found.items():
        header.append(f"ε = {epsilon:g}")
        columns.append([f"{value:.5g}" for value in by_name.values()])
        if printed := settings.printed_at(epsilon):
            header.append("thesis")
            columns.append([f"{printed[name]:.5g}" if name in printed else "" for name in constants])
    title = f"Table {settings.table}: constants by the estimator" if settings.table else "Constants by the estimator"
    return values, ValueTable(title, tuple(header), tuple(zip(*columns, strict=True)))
