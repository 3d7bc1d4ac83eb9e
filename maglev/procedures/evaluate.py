"""From runs to the outcomes of the procedures that they belong to."""

from collections.abc import Callable, Collection, Sequence

from maglev.errors import MaglevError, in_one_line
from maglev.experiment.execution import RunResult
from maglev.procedures import cogging, complete_model, equilibrium, forgetting, parabolas
from maglev.procedures.outcome import Outcome
from maglev.procedures.rig_data import Runs
from maglev.schema.procedure import Kind, ProcedureSettings

EVALUATIONS: dict[Kind, Callable[[ProcedureSettings, Runs], Outcome]] = {
    "parabolas": parabolas.evaluate, "equilibrium": equilibrium.evaluate, "cogging": cogging.evaluate,
    "identification": complete_model.evaluate, "forgetting": forgetting.evaluate}


def evaluate_all(results: Sequence[RunResult], asked: Collection[str] | None = None) -> list[Outcome]:
    """Outcomes of the procedures that have runs among the results, in the order of their names.

    With `asked`, names of runs, only of those that have runs among these: what was run for other runs to start from
    does not make a procedure. What a procedure finds only with runs that failed or are not there is left out of its
    outcome.
    """
    completed = {result.plan.name: result for result in results if result.failure is None}
    procedures = {result.plan.procedure.name: result.plan.procedure for result in results
                  if result.plan.procedure is not None and (asked is None or result.plan.name in asked)}
    return [evaluate(settings, completed) for _, settings in sorted(procedures.items())]


def evaluate(settings: ProcedureSettings, runs: Runs) -> Outcome:
    """Outcome of one procedure; runs from which nothing can be found are a note, and the claims stay "not run"."""
    try:
        return EVALUATIONS[settings.kind](settings, runs)
    except MaglevError as error:
        return Outcome(settings, (), notes=(f"nothing was found: {in_one_line(error)}",))
