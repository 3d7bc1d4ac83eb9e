"""Metrics and verdicts as tables for the terminal and the text report."""

import math

from rich.table import Table

from scenarios.claims import ClaimResult
from scenarios.metrics import Metrics
from scenarios.quantity import to_unit
from scenarios.scenario import Scenario

COLOURS = {"reproduced": "green", "within 10 %": "yellow", "not reproduced": "red", "not testable": "dim"}


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
        table.add_row(motor.motor, f"{motor.peak_current:.2f}", f"{motor.peak_command:.2f}")
    tables.append(table)
    return tables


def claim_table(results: list[ClaimResult]) -> Table:
    """Table of the thesis's claims with what was measured and the verdicts."""
    table = Table(title="Claims of the thesis")
    for name in ("claim", "source", "expected", "measured", "verdict"):
        table.add_column(name)
    for result in results:
        claim = result.claim
        note = ""
        if result.verdict == "not testable":
            note = f": {claim.not_testable}"
        elif result.verdict == "not reproduced" and claim.reason:
            note = f": {claim.reason}"
        table.add_row(claim.text, claim.source, claim.expectation if claim.metric else "", result.measured_text,
                      f"[{COLOURS[result.verdict]}]{result.verdict}[/]{note}")
    return table


def outcome(metrics: Metrics) -> str:
    """One line on whether the run held."""
    events = []
    if metrics.stop_contact is not None:
        events.append(f"an end stop was touched at {metrics.stop_contact:.3f} s")
    if metrics.tripped is not None:
        events.append(f"the controller tripped at {metrics.tripped:.3f} s")
    worst = max(metrics.end_errors.items(), key=lambda item: item[1], default=None)
    if worst is not None:
        events.append(f"largest error at the end {length(worst[1])} on {worst[0]}")
    return ("failed" if metrics.failed else "held") + ": " + ", ".join(events)


def seconds(time: float) -> str:
    """A settling time."""
    return "not settled" if math.isinf(time) else f"{time:.2f} s"


def length(value: float) -> str:
    """A length in mm, or µm if it is small."""
    return f"{to_unit(value, 'mm'):.3g} mm" if value >= 0.1e-3 else f"{to_unit(value, 'um'):.3g} µm"
