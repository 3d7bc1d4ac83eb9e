"""The estimated constants of a run as values and as a table beside the thesis's."""

from collections.abc import Sequence

from scenarios.procedures.outcome import Found, ValueTable
from scenarios.procedures.rig_data import estimate, estimators
from scenarios.procedures.settings import ProcedureSettings
from scenarios.study import RunResult


def constant_values(result: RunResult, constants: Sequence[str]) -> list[Found]:
    """What claims may be about."""
    return [Found("constant", value, constant=name, epsilon=epsilon) for epsilon in estimators(result)
            for name, value in estimate(result, epsilon, constants).items()]


def constant_table(settings: ProcedureSettings, result: RunResult, constants: Sequence[str]) -> ValueTable:
    """Constants with each ε: here, and as the thesis printed them; and what the plant was run with."""
    epsilons = list(estimators(result))
    header = ["constant", "of the plant"]
    for k, epsilon in enumerate(epsilons):
        printed = k < min((len(row) for row in settings.printed.values()), default=0)
        header += [f"ε = {epsilon:g}", *(["thesis"] if printed else [])]
    rows = []
    for name in constants:
        true = result.parameters.get(f"plant.{name}")
        row = [name, "" if true is None else f"{true:.5g}"]
        for k, epsilon in enumerate(epsilons):
            row.append(f"{estimate(result, epsilon, [name])[name]:.5g}")
            if "thesis" in header:
                row.append(f"{settings.printed[name][k]:.5g}" if name in settings.printed else "")
        rows.append(tuple(row))
    number = f"Table {settings.table}: " if settings.table else ""
    return ValueTable(f"{number}constants by the estimator", tuple(header), tuple(rows))
