"""Constants that jump during a run: the estimates with and without forgetting, and the cost of forgetting.

The thesis leaves constants that change to future work, so nothing here is one of its claims.
"""

import numpy as np

from maglev.files.errors import ScenarioError
from maglev.runs.execution import RunResult
from maglev.runs.procedure_data import Runs, column, estimators
from maglev.runs.procedure_outcome import Chart, Curve, Outcome, Panel, ValueTable
from maglev.scenario.procedure import ProcedureSettings
from maglev.scenario.signals import Steps

BEFORE = 5.0     # s before the jump over which the scatter is taken
AFTER = 5.0      # s after the jump at which what is left of it is taken
POINTS = 400     # of a curve, at most


def jumps(result: RunResult) -> list[Steps]:
    """Signals of the scenario by which constants of the plant jump."""
    return [signal for signal in result.plan.signals
            if isinstance(signal, Steps) and signal.to.startswith("plant.C") and len(signal.values) > 1
            and result.time[0] < signal.times[-1] <= result.time[-1] - AFTER
            and 0.0 != signal.values[-2] != signal.values[-1]]


def evaluate(settings: ProcedureSettings, runs: Runs) -> Outcome:
    """Outcome on the run `jump`, if it completed."""
    result = runs.get(settings.runs["jump"])
    if result is None:
        return Outcome(settings, ())
    of_run = jumps(result)
    if not of_run:
        raise ScenarioError(f"{result.plan.name}: no constant of the plant jumps to another value {AFTER:g} s or "
                            "more before the end, expected a signal of kind steps to plant.C1 or another")
    by_forgetting = estimators(result, "forgetting")
    rows, panels = [], []
    kept = np.unique(np.linspace(0, len(result.time) - 1, POINTS).astype(int))
    for signal in of_run:
        constant, time, (before, after) = signal.to.removeprefix("plant."), signal.times[-1], signal.values[-2:]
        curves = []
        for forgetting, name in by_forgetting.items():
            path = column(result, f"{name}.{constant}")
            earlier = path[(result.time >= time - BEFORE) & (result.time < time)]
            later = float(path[np.searchsorted(result.time, time + AFTER) - 1])
            left = (later - after) / (before - after)
            rows.append((constant, f"{forgetting:g}", percent(earlier.mean() / before - 1.0),
                         percent(earlier.std() / before), percent(left)))
            curves.append(Curve(f"forgetting {forgetting:g} 1/s", result.time[kept], path[kept]))
        true = np.where(result.time[kept] < time, before, after)
        curves.append(Curve("of the plant", result.time[kept], true))
        panels.append(Panel("time (s)", constant, tuple(curves)))
    header = ("constant", "forgetting (1/s)", f"mean error, {BEFORE:g} s before", "scatter in this time",
              f"left of the jump {AFTER:g} s after")
    table = ValueTable("Constants that jump", header, tuple(rows))
    chart = Chart(None, "Constants of the plant that jump, and their estimates with several rates of forgetting.",
                  tuple(panels))
    return Outcome(settings, (result.plan.name,), tables=(table,), charts=(chart,))


def percent(share: float) -> str:
    """Return a share in percent, without a sign if it rounds to nothing."""
    return f"{100.0 * share:z.2f} %"
