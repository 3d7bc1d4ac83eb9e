"""Metrics and verdicts as tables for the terminal and the text report."""

import math
from collections.abc import Callable, Sequence
from io import StringIO

from rich.console import Console
from rich.markup import escape
from rich.table import Column, Table
from rich.text import Text

from maglev.experiment.execution import RunResult
from maglev.experiment.provenance import Provenance
from maglev.judging.metrics import Metrics
from maglev.judging.verdicts import (
    OF_BOUNDS,
    VERDICTS,
    ClaimResult,
    Judgements,
    Verdict,
    bounds,
    bounds_met,
    count_verdicts,
    sentences,
    those_that_count,
)
from maglev.procedures.outcome import Outcome
from maglev.report.status import events, is_listed, modification, run_status, troubles
from maglev.schema.run_plan import RunPlan
from maglev.units import to_unit

REPORT_WIDTH = 120   # characters

COLOURS: dict[Verdict, str] = {"reproduced": "green", "within 10 %": "yellow", "not reproduced": "red",
                               "not testable": "dim", "not run": "magenta",
                               "modified run": "cyan", "met": "green", "not met": "red"}


def show(console: Console, result: RunResult, verdicts: Sequence[ClaimResult]) -> None:
    """Print what was measured on a run, and the claims with their verdicts."""
    plan = result.plan
    console.print(heading(plan.name, plan.title))
    if result.metrics is None:
        console.print(Text(", ".join(run_status(result))))
        return
    if result.provenance is not None:
        console.print(Text(origin(result.provenance), style="dim"))
    for table in metric_tables(plan, result.metrics):
        console.print(table)
    for of_claims in claim_tables(verdicts):
        console.print(of_claims)
    console.print(outcome(result, result.metrics))


def text_of(result: RunResult, verdicts: Sequence[ClaimResult]) -> str:
    """What `show` prints, as text."""
    return as_text(lambda console: show(console, result, verdicts))


def as_text(show: Callable[[Console], None]) -> str:
    """What a function prints on a console."""
    text = StringIO()
    show(Console(file=text, width=REPORT_WIDTH))
    return text.getvalue()


def origin(provenance: Provenance) -> str:
    """Version, kinds of the FMUs and what differs from the plan, in a line."""
    commit = f" ({provenance.commit})" if provenance.commit else ""
    kinds = ", ".join(f"{fmu.name}: {fmu.kind} {fmu.model}" for fmu in provenance.fmus)
    modified = f"; modified: {', '.join(provenance.differences)}" if provenance.modified else ""
    return f"Maglev FMUs {provenance.version}{commit}; {kinds}{modified}"


def heading(name: str, title: str) -> Text:
    """First line about a run or a procedure."""
    return Text.assemble((name, "bold"), f": {title}")


def metric_tables(plan: RunPlan, metrics: Metrics) -> list[Table]:
    """Tables of the steps, the tracking errors and the currents, as far as the run has them."""
    tables = []
    if metrics.steps:
        bands = plan.metrics.bands
        table = Table(title="Steps: time from the step to the last error beyond a band")
        for name in ("t (s)", "axis", "step (mm)", *(f"settled to {length(band)}" for band in bands),
                     "overshoot", "steady-state error"):
            table.add_column(name, justify="right")
        for step in metrics.steps:
            table.add_row(f"{step.time:g}", step.axis,
                          f"{to_unit(step.start, 'mm'):g} → {to_unit(step.target, 'mm'):g}",
                          *(seconds(step.settling[band]) for band in bands),
                          f"{100.0 * step.overshoot:.1f} %", length(step.steady_state_error))
        tables.append(table)
    if metrics.tracking:
        table = Table(title=f"Tracking error from t = {plan.metrics.tracking_from:g} s on")
        for name in ("axis", "mean", "peak"):
            table.add_column(name, justify="right")
        for tracking in metrics.tracking:
            table.add_row(tracking.axis, length(tracking.mean), length(tracking.peak))
        tables.append(table)
    if not metrics.motors:
        return tables
    table = Table(title="Currents: largest absolute values")
    for name in ("motor", "phase current (A)", "command (A)"):
        table.add_column(name, justify="right")
    for motor in metrics.motors:
        names = plan.motors[motor.motor]
        table.add_row(motor.motor, f"{motor.peak_current:.2f}" if names.currents else "not recorded",
                      f"{motor.peak_command:.2f}" if names.commands else "not recorded")
    tables.append(table)
    return tables


def claim_tables(results: Sequence[ClaimResult]) -> list[Table | str]:
    """Tables of the thesis's claims in words and, apart, of the bounds of its figures; words where there are none."""
    tables: list[Table | str] = [claim_table("Claims of the thesis", sentences(results)) if sentences(results)
                                 else "no claims"]
    if bounds(results):
        met = f": {bounds_met(results)} met" if bounds_met(results) else ""
        tables.append(claim_table(f"Bounds by the axes of figures{met}", bounds(results)))
    return tables


def claim_table(title: str, results: Sequence[ClaimResult]) -> Table:
    """Table of claims with what was measured and the verdicts."""
    table = Table(title=title)
    for name in ("claim", "source", "expected", "measured", "verdict"):
        table.add_column(name)
    for result in results:
        claim = result.claim
        note = f": {result.note}" if result.note else ""
        table.add_row(*map(Text, (claim.text, claim.source, claim.criterion, result.measured_text)),
                      Text.assemble((result.verdict, COLOURS[result.verdict]), note))
    return table


def study_table(results: Sequence[RunResult], verdicts: Judgements, outcomes: Sequence[Outcome] = ()) -> Table:
    """Table of many runs and of procedures: how each ended, and how many of its claims have which verdict."""
    claims = those_that_count(judged for _, judged in in_order(results, verdicts, outcomes))
    totals = count_verdicts(sentences(claims))
    shown = [verdict for verdict in VERDICTS if verdict not in OF_BOUNDS and (totals[verdict] or
                                                                              verdict != "modified run")]
    table = Table(Column("run", no_wrap=True), "outcome",
                  *(Column(verdict.replace(" reproduced", "\nreproduced"), justify="right") for verdict in shown),
                  Column("bounds\nmet", justify="right"), title="Verdicts on the claims")
    for result in results:
        if is_listed(result, verdicts):
            table.add_row(escape(result.plan.name), escape(short_outcome(result)),
                          *counted_cells(verdicts[result.plan.name], shown))
    table.add_section()
    for found in outcomes:
        table.add_row(escape(found.settings.name), counted(found.values, "value"),
                      *counted_cells(verdicts[found.settings.name], shown))
    table.add_section()
    procedures = counted(outcomes, "procedure") if outcomes else ""
    table.add_row(f"{len(results)} runs", procedures, *(str(totals[verdict]) for verdict in shown), bounds_met(claims))
    return table


def in_order(results: Sequence[RunResult], verdicts: Judgements,
             outcomes: Sequence[Outcome]) -> list[tuple[str, ClaimResult]]:
    """All claims with the names of what they are about: the runs first, then the procedures."""
    names = [*(result.plan.name for result in results), *(found.settings.name for found in outcomes)]
    return [(name, judged) for name in names for judged in verdicts[name]]


def counted_cells(claims: Sequence[ClaimResult], shown: Sequence[Verdict]) -> list[str]:
    """Cells of the table of many runs: numbers of claims in words by the verdicts that are shown, and bounds met."""
    if not claims:
        return ["no claims"]
    counts = count_verdicts(sentences(claims))
    return [*(f"[{COLOURS[verdict]}]{counts[verdict]}[/]" if counts[verdict] else "" for verdict in shown),
            bounds_met(claims)]


def counted(items: Sequence[object], noun: str) -> str:
    """Number of items with the noun, such as "1 value"."""
    return f"{len(items)} {noun}" if len(items) == 1 else f"{len(items)} {noun}s"


def claims_markdown(results: Sequence[RunResult], verdicts: Judgements, outcomes: Sequence[Outcome] = ()) -> str:
    """Claims in words, and the bounds of figures, as tables in Markdown: where, what, thesis's value, ours, verdict."""
    claims = in_order(results, verdicts, outcomes)
    counting = those_that_count(judged for _, judged in claims)
    words = sentences(counting)
    counts = ", ".join(f"{count} {verdict}" for verdict, count in count_verdicts(words).items() if count)
    subjects = f"{len(results)} runs" + (f" and {counted(outcomes, 'procedure')}" if outcomes else "")
    modified = [f"- `{result.plan.name}` is a {modification(result)}\n" for result in results if result.modified]
    notice = "".join(modified) + "\nVerdicts on the thesis are for its own runs.\n\n" if modified else ""
    met = bounds_met(counting)
    text = (f"{len(words)} claims on {subjects}: {counts}." + (f" {met} figure bounds met." if met else "")
            + f"\n\n{notice}{markdown_table('claim', [row for row in claims if row[1].claim.figure is None])}")
    of_figures = [row for row in claims if row[1].claim.figure is not None]
    return text + (f"\n## Bounds by the axes of figures\n\n{markdown_table('bound', of_figures)}" if of_figures else "")


def markdown_table(noun: str, claims: Sequence[tuple[str, ClaimResult]]) -> str:
    """Claims of one kind with the names of what they are about, as a table in Markdown."""
    lines = [f"| run | {noun} | source | thesis value | here | verdict |", "|---|---|---|---|---|---|"]
    for name, judged in claims:
        claim = judged.claim
        verdict = f"**{judged.verdict}**: {judged.note}" if judged.note else judged.verdict
        cells = (f"`{name}`", claim.text, claim.source, claim.criterion, judged.measured_text, verdict)
        lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    return "\n".join(lines) + "\n"


def outcome(result: RunResult, metrics: Metrics) -> str:
    """One line on whether the run held, with everything that disturbed it and its error at the end."""
    words = [*troubles(result), *(f"largest error at the end {error}" for error in end_error(metrics))]
    return held(metrics) + (": " if words else "") + ", ".join(words)


def short_outcome(result: RunResult) -> str:
    """The same in as few words as a table has room for: what made the run fail, or its error at the end."""
    if result.metrics is None:
        return ", ".join(troubles(result))
    first = [f"{event.word} at {event.time:.3f} s" for event in events(result.metrics)[:1]]
    return ", ".join([held(result.metrics), *(first or end_error(result.metrics))])


def held(metrics: Metrics) -> str:
    """Whether the run held, in a word."""
    return "failed" if metrics.failed else "held"


def end_error(metrics: Metrics) -> list[str]:
    """The largest error at the end with its axis, if there are axes."""
    worst = max(metrics.end_errors.items(), key=lambda item: item[1], default=None)
    return [] if worst is None else [f"{length(worst[1])} on {worst[0]}"]


def seconds(time: float) -> str:
    """A settling time."""
    return "not settled" if math.isinf(time) else f"{time:.2f} s"


def length(value: float) -> str:
    """A length in mm, or µm if it is small."""
    return f"{to_unit(value, 'mm'):.3g} mm" if value >= 0.1e-3 else f"{to_unit(value, 'um'):.3g} µm"
