"""Metrics and verdicts as tables for the terminal and the text report."""

import math
from collections.abc import Sequence

from rich.markup import escape
from rich.table import Column, Table

from scenarios.metrics import Metrics
from scenarios.quantity import to_unit
from scenarios.scenario import Scenario
from scenarios.study import RunResult
from scenarios.verdicts import VERDICTS, ClaimResult, Judgements

COLOURS = {"reproduced": "green", "within 10 %": "yellow", "not reproduced": "red", "not testable": "dim",
           "not run": "magenta"}


def metric_tables(scenario: Scenario, metrics: Metrics) -> list[Table]:
    """Tables of the steps, the tracking errors and the currents, as far as the run has them."""
    tables = []
    if metrics.steps:
        bands = scenario.metrics.bands
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
        table = Table(title=f"Tracking error from t = {scenario.metrics.tracking_from:g} s on")
        for name in ("axis", "mean", "peak"):
            table.add_column(name, justify="right")
        for tracking in metrics.tracking:
            table.add_row(tracking.axis, length(tracking.mean), length(tracking.peak))
        tables.append(table)
    table = Table(title="Currents: largest absolute values")
    for name in ("motor", "phase current (A)", "command (A)"):
        table.add_column(name, justify="right")
    for motor in metrics.motors:
        names = scenario.motors[motor.motor]
        table.add_row(motor.motor, f"{motor.peak_current:.2f}" if names.currents else "not recorded",
                      f"{motor.peak_command:.2f}" if names.commands else "not recorded")
    tables.append(table)
    return tables


def claim_table(results: Sequence[ClaimResult]) -> Table:
    """Table of the thesis's claims with what was measured and the verdicts."""
    table = Table(title="Claims of the thesis")
    for name in ("claim", "source", "expected", "measured", "verdict"):
        table.add_column(name)
    for result in results:
        claim = result.claim
        note = f": {result.note}" if result.note else ""
        table.add_row(claim.text, claim.source, claim.criterion, result.measured_text,
                      f"[{COLOURS[result.verdict]}]{result.verdict}[/]{note}")
    return table


def study_table(results: Sequence[RunResult], verdicts: Judgements) -> Table:
    """Table of many runs: how each ended, and how many of its claims have which verdict."""
    table = Table(Column("run", no_wrap=True), "outcome",
                  *(Column(verdict.replace(" reproduced", "\nreproduced"), justify="right") for verdict in VERDICTS),
                  title="Verdicts on the claims")
    totals = dict.fromkeys(VERDICTS, 0)
    for result in results:
        name = result.scenario.name
        ended = short_outcome(result.metrics) if result.metrics is not None else f"did not complete: {result.failure}"
        counts = {verdict: sum(claim.verdict == verdict for claim in verdicts[name]) for verdict in VERDICTS}
        for verdict, count in counts.items():
            totals[verdict] += count
        cells = [f"[{COLOURS[verdict]}]{count}[/]" if count else "" for verdict, count in counts.items()]
        table.add_row(name, escape(ended), *(cells if verdicts[name] else ["no claims"]))
    table.add_section()
    table.add_row(f"{len(results)} runs", "", *(str(total) for total in totals.values()))
    return table


def claims_markdown(results: Sequence[RunResult], verdicts: Judgements) -> str:
    """Table of all claims in Markdown: run, claim, source, the thesis's value, ours, verdict."""
    lines = ["| run | claim | source | thesis value | here | verdict |", "|---|---|---|---|---|---|"]
    for result in results:
        for judged in verdicts[result.scenario.name]:
            claim = judged.claim
            verdict = f"**{judged.verdict}**: {judged.note}" if judged.note else judged.verdict
            cells = (f"`{result.scenario.name}`", claim.text, claim.source, claim.criterion, judged.measured_text,
                     verdict)
            lines.append("| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |")
    counted = [judged.verdict for run in verdicts.values() for judged in run]
    counts = ", ".join(f"{counted.count(verdict)} {verdict}" for verdict in VERDICTS if verdict in counted)
    return f"{len(counted)} claims on {len(results)} runs: {counts}.\n\n" + "\n".join(lines) + "\n"


def outcome(metrics: Metrics) -> str:
    """One line on whether the run held."""
    events = []
    if metrics.stop_contact is not None:
        events.append(f"an end stop was touched at {metrics.stop_contact:.3f} s")
    if metrics.tripped is not None:
        events.append(f"the controller tripped at {metrics.tripped:.3f} s")
    events += [f"largest error at the end {error}" for error in end_error(metrics)]
    return ("failed" if metrics.failed else "held") + ": " + ", ".join(events)


def short_outcome(metrics: Metrics) -> str:
    """The same in as few words as a table has room for: what made the run fail, or its error at the end."""
    events = [(time, words) for time, words in ((metrics.stop_contact, "stop"), (metrics.tripped, "trip"))
              if time is not None]
    first = [f"{words} at {time:.3f} s" for time, words in sorted(events)[:1]] or end_error(metrics)
    return ("failed" if metrics.failed else "held") + "".join(f", {event}" for event in first)


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
