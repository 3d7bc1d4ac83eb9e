"""The estimated constants of a run as values and as a table beside the thesis's."""

from collections.abc import Sequence

from maglev.experiment.execution import RunResult
from maglev.procedures.outcome import Found, ValueTable
from maglev.procedures.rig_data import estimate, estimators
from maglev.schema.procedure import ProcedureSettings


def constant_values(result: RunResult, constants: Sequence[str]) -> list[Found]:
    """What claims may be about."""
    return [Found("constant", value, constant=name, epsilon=epsilon) for epsilon in estimators(result)
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
