"""What the procedures need of a run: its rig, estimators, recorded columns, and the constants as values and a table."""

from collections.abc import Iterable, Mapping, Sequence
from typing import TypeVar

import numpy as np

from maglev.arrays import Array
from maglev.errors import ScenarioError, nearest
from maglev.experiment.execution import RunResult
from maglev.identification.rigs import Rig
from maglev.identification.rigs import rig_of as described
from maglev.procedures.outcome import ProcedureValue, ValueTable
from maglev.schema.judged.procedure import ProcedureSettings
from maglev.schema.run_plan import RunPlan
from maglev.units import to_unit

T = TypeVar("T")

Runs = Mapping[str, RunResult]   # runs that completed, by name

EPSILON = 0.01   # s, of the estimates that the thesis goes on with


def rig_of(plan: RunPlan) -> Rig:
    """The rig of a scenario as the estimators see it; ScenarioError if it is of none."""
    if plan.rig is None:
        raise ScenarioError(f"{plan.path}: expected an FMU or the air gap of a stage, by which a procedure knows it")
    return described(plan.rig)


def estimators(result: RunResult) -> dict[float, str]:
    """Estimators of a run by their ε (s), ascending; ScenarioError if two have the same."""
    return estimators_by(result, "epsilon")


def estimators_by(result: RunResult, parameter: str) -> dict[float, str]:
    """Estimators of a run by a parameter of theirs, ascending; ScenarioError if two have the same."""
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


def estimate(result: RunResult, epsilon: float, constants: Sequence[str]) -> dict[str, float]:
    """Constants that the estimator with an ε (s) has at the end of a run; ScenarioError if there is none."""
    by_epsilon = estimators(result)
    if epsilon not in by_epsilon:
        raise no_such_epsilon(epsilon, by_epsilon)
    name = by_epsilon[epsilon]
    return {constant: entry(result.ends, f"{name}.{constant}", result) for constant in constants}


def no_such_epsilon(epsilon: float, epsilons: Iterable[float]) -> ScenarioError:
    """Refusal of a run without an estimator of an ε (s)."""
    return ScenarioError(f"no estimator has epsilon = {epsilon:g} s, expected one beside "
                         f"{', '.join(f'{known:g} s' for known in epsilons) or 'none'}")


def entry(table: Mapping[str, T], name: str, result: RunResult) -> T:
    """What a table of a run has under a name; ScenarioError if it has nothing."""
    if name not in table:
        raise ScenarioError(f"{result.plan.name} has no {name}, nearest is {nearest(name, table)}")
    return table[name]


def column(result: RunResult, name: str) -> Array:
    """A column, such as "plant.v.encoder"; ScenarioError if it was not recorded."""
    return np.asarray(entry(result.columns, name, result), dtype=np.float64)


def plant_column(result: RunResult, name: str) -> Array:
    """A column of the plant, such as "v.encoder"; ScenarioError if it was not recorded."""
    return column(result, f"plant.{name}")


def measured_positions(result: RunResult, rig: Rig) -> Array:
    """Positions by the encoders, shape (n, axes); where the platform tilts, y and tilts by the gaps at the motors."""
    return np.stack([measured_position(result, rig, axis) for axis in rig.axes], axis=1)


def measured_position(result: RunResult, rig: Rig, axis: str) -> Array:
    """Position of one axis by the encoders that show it."""
    described = rig.described
    shares = zip(described.encoders, rig.places.measuring(described)[rig.axes.index(axis)], strict=True)
    return np.asarray(sum(share * plant_column(result, name) for name, share in shares if share))


def millimetres(length: float) -> str:
    return f"{to_unit(length, 'mm'):.4g}"


def mm(lengths: Array) -> list[float]:
    return [to_unit(length, "mm") for length in lengths.tolist()]


def constant_values(result: RunResult, constants: Sequence[str]) -> list[ProcedureValue]:
    """What claims may be about."""
    return [ProcedureValue("constant", value, constant=name, epsilon=epsilon) for epsilon in estimators(result)
            for name, value in estimate(result, epsilon, constants).items()]


def constant_table(settings: ProcedureSettings, result: RunResult, constants: Sequence[str]) -> ValueTable:
    """Constants with each ε: here, and as the thesis printed them; and what the plant was run with."""
    epsilons = list(estimators(result))
    printed = {epsilon: settings.printed_at(epsilon) for epsilon in epsilons}
    header = ["constant", "of the plant"]
    for epsilon in epsilons:
        header += [f"ε = {epsilon:g}", *(["thesis"] if printed[epsilon] else [])]
    rows = []
    for name in constants:
        true = result.parameters.get(f"plant.{name}")
        row = [name, "" if true is None else f"{true:.5g}"]
        for epsilon in epsilons:
            row.append(f"{estimate(result, epsilon, [name])[name]:.5g}")
            if printed[epsilon]:
                row.append(f"{printed[epsilon][name]:.5g}" if name in printed[epsilon] else "")
        rows.append(tuple(row))
    title = f"Table {settings.table}: constants by the estimator" if settings.table else "Constants by the estimator"
    return ValueTable(title, tuple(header), tuple(rows))
