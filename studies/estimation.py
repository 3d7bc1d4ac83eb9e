"""Estimation of one scale of Coulomb friction for all axes, from part of the evidence, and its test on the rest.

    python -m studies.estimation

Writes the table of docs/estimation.md, and the values assumed before, for scenarios to extend. `estimation.toml` lists
the scaled values and the evidence that chooses.
"""

import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from maglev.api.comparing import run_compared
from maglev.api.options import experiments_of
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.marked import markdown_table, write_part
from maglev.files.side_by_side import unwatched
from maglev.runs.chain import compared_with, needed, select
from maglev.runs.execution import RunResult
from maglev.runs.procedures import evaluate_all, judge_procedure
from maglev.runs.verdicts import ClaimResult, count_verdicts, judge_run, least_ratio, miss, ratio, sentences
from maglev.scenario.run_plan import RunPlan, StartValue

FILE = Path(__file__).with_name("estimation.toml")
DOCS = Path(__file__).parents[1] / "docs" / "estimation.md"
EFFECTS = Path(__file__).parents[1] / "scenarios" / "effects"
STAGES = ("2dof", "3dof")   # that the thesis has

SHARE = 0.05    # standard deviation of a number that a run should have, as a share of it
MARGIN = 0.1    # standard deviation of how far a limit or factor is missed, as a share of it

Defaults = Mapping[str, float]   # by `model.variable`, SI
Judged = tuple[str, ClaimResult]   # the run or procedure that a claim is about, and the claim with its verdict


@dataclass(frozen=True)
class Settings:
    """The whole study; see `estimation.toml`."""

    training: Sequence[str]   # runs whose sentences and bounds are for training; all others are held out
    largest_residual: float
    candidates: Sequence[float]
    assumed: Defaults   # what is scaled
    follows: Defaults   # what is scaled along where a scenario gives it at all
    ripple: Defaults    # what is tried next to the scale that is chosen


def read_settings(path: Path = FILE) -> Settings:
    """Read the settings; TypeError where a table lacks something or has too much."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    return Settings(**table.pop("scale"), **table)


def times(scale: float, values: Defaults) -> dict[str, float]:
    return {name: scale * value for name, value in values.items()}


@dataclass(frozen=True)
class WeightRow:
    """Verdict of the evidence on one scale of friction, with slot ripple or without."""

    scale: float
    ripple: bool
    training: Sequence[Judged]
    held_out: Sequence[Judged]


def with_defaults(plan: RunPlan, defaults: Defaults, following: Defaults) -> RunPlan:
    """Plan in which variables that it does not give start at other defaults; those that follow, only if it gives them.

    Both are by `model.variable`. A value of 0 is an effect that the scenario has turned off, and stays.
    """
    fmus = {}
    for name, fmu in plan.fmus.items():
        given = {*fmu.start, *fmu.start_from}
        start = {**of_model(defaults, fmu.model, absent=given), **fmu.start}
        start |= {variable: value for variable, value in of_model(following, fmu.model).items()
                  if variable in fmu.start and fmu.start[variable].value != 0}
        fmus[name] = fmu.model_copy(update={"start": start})
    return plan.model_copy(update={"fmus": fmus})


def of_model(values: Defaults, model: str | None, absent: Iterable[str] = ()) -> dict[str, StartValue]:
    """Values of one model's variables, without those that are named."""
    split = {key: key.partition(".") for key in values}
    return {variable: StartValue(values[key], None, repr(values[key])) for key, (own, _, variable) in split.items()
            if own == model and variable not in {*absent}}


def row(settings: Settings, scale: float, ripple: Defaults | None = None) -> WeightRow:
    """All the evidence at a scale of friction, with slot ripple if it is given."""
    plans = [plan for plan in select(None) if not plan.check_only]
    plans = [*plans, *compared_with(plans)]
    defaults = {**times(scale, settings.assumed), **(ripple or {})}
    experiments = [replace(experiment, plan=with_defaults(experiment.plan, defaults, times(scale, settings.follows)))
                   for experiment in experiments_of([*plans, *needed(plans)], {})]
    return split(settings, scale, ripple is not None, judge_claims(list(run_compared(experiments, unwatched).values())))


def judge_claims(results: Sequence[RunResult]) -> list[Judged]:
    """Verdicts on the claims about runs and procedures; other readings of an experiment are no further evidence."""
    metrics = {result.plan.name: result.metrics for result in results}
    return [*((run.plan.name, result) for run in results if not run.plan.another_reading
              for result in judge_run(run.plan.claims, run.metrics, metrics)),
            *((outcome.settings.name, result) for outcome in evaluate_all(results)
              for result in judge_procedure(outcome))]


def split(settings: Settings, scale: float, ripple: bool, judged: Sequence[Judged]) -> WeightRow:
    return WeightRow(scale, ripple, [claim for claim in judged if claim[0] in settings.training],
                     [claim for claim in judged if claim[0] not in settings.training])


def best_scale(rows: Sequence[WeightRow]) -> float:
    """The scale that reproduces most of the sentences for training; of equal ones the first."""
    return max(rows, key=lambda row: counts(row.training)[0][0]).scale


def counts(judged: Iterable[Judged]) -> tuple[tuple[int, int, int], tuple[int, int]]:
    """Verdicts on sentences (reproduced, within 10 %, not reproduced) and on bounds (met, not met)."""
    results = [result for _, result in judged]
    words, axes = count_verdicts(sentences(results)), count_verdicts(results)
    return ((words["reproduced"], words["within 10 %"], words["no difference"] + words["not reproduced"]),
            (axes["met"], axes["not met"]))


def residual(result: ClaimResult, largest: float) -> float:
    """Return how far a claim is missed, in standard deviations, at most `largest`; 0 if it is met or not testable.

    "about" a figure: half of its last digit or 5 %, the larger one, is one standard deviation. A limit or a factor:
    10 % of it, on the wrong side. A bound by an axis: the distance of its ticks. A yes or no,
    or an axis that never settles: 1.
    """
    claim, measured = result.claim, result.measured
    if claim.quantity is None or (result.verdict in ("reproduced", "met") and claim.relation != "about"):
        return 0.0
    if measured is None:
        return largest   # the run failed
    if isinstance(claim.target, tuple):
        low, high = claim.target
        missed = max(low - measured, measured - high, 0.0) / (high - low)
    elif result.against is not None:
        missed = miss(claim, ratio(float(measured), result.against), least_ratio(claim)) / (MARGIN * claim.factor)
    elif claim.relation == "is":
        missed = 1.0
    else:
        target = float(claim.target or 0.0)
        missed = miss(claim, float(measured), target) / (MARGIN * abs(target))
        if claim.relation == "about":
            last = math.floor(math.log10(abs(target))) - (claim.digits or 1) + 1 if target else -math.inf   # digit
            missed = (float(measured) - target) / max(SHARE * abs(target), 0.5 * 10.0**last)
    # An event that never happens has no distance: whether a mover comes to rest in a band of 10 µm is decided by the
    # last bits.
    return largest * math.tanh(missed / largest) if math.isfinite(missed) else math.copysign(1.0, missed)


def table_of(settings: Settings, rows: Sequence[WeightRow]) -> str:
    """Verdicts and misfit, half the sum of squared residuals, at every scale; the one that training chooses is bold."""
    cells_of_rows = []
    best = best_scale([row for row in rows if not row.ripple])
    for row in rows:
        label = f"× {row.scale:g}" + (", slot ripple" if row.ripple else "")
        cells = [f"**{label}**" if row.scale == best and not row.ripple else label]
        for judged in (row.training, row.held_out):
            of_sentences, (met, missed) = counts(judged)
            misfit = 0.5 * sum(residual(result, settings.largest_residual) ** 2 for _, result in judged)
            cells += [" / ".join(map(str, of_sentences)), f"{met} of {met + missed}", f"{misfit:.1f}"]
        cells_of_rows.append(cells)
    heads = ("Coulomb friction", "training: sentences", "bounds", "misfit", "held out: sentences", "bounds", "misfit")
    return markdown_table(heads, cells_of_rows)


def as_assumed(name: str, settings: Settings) -> str:
    """TOML with the friction assumed before one scale of it was estimated, for scenarios to extend."""
    stage = PACKAGED_STAGES[name]
    lines = [f"# {stage.title}. Coulomb friction as it was assumed, before one scale of it was estimated "
             "(docs/estimation.md).", "# Made by `python -m studies.estimation`.", "", "[fmus.plant.start]"]
    lines += [f'"{variable}" = {value:.4g}' for model, _, variable, value in (
        (*variable.partition("."), value) for variable, value in settings.assumed.items())
        if model == f"Plant{stage.suffix}"]
    return "\n".join(lines) + "\n"


def main() -> None:
    """Run and judge all the evidence at every scale, and at the best with slot ripple; write what was found."""
    settings = read_settings()
    rows = [row(settings, scale) for scale in settings.candidates]
    table = table_of(settings, [*rows, row(settings, best_scale(rows), settings.ripple)])
    write_part(DOCS, "estimation", table)
    for name in STAGES:
        (EFFECTS / f"{name}-as-assumed.toml").write_text(as_assumed(name, settings), encoding="utf-8")


if __name__ == "__main__":
    main()
