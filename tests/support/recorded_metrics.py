"""Metrics of runs in lanes against those of the recordings that calls of the FMUs give, bit for bit."""

from collections.abc import Sequence

import numpy as np
import pytest

from maglev.files.errors import MaglevError
from maglev.many.repeated_run import Changes, RepeatedRun
from maglev.many.study_columns import named_values
from maglev.runs.endings import ending, endings
from maglev.runs.measuring import Found, Measuring, run_metrics
from maglev.runs.metrics import phase_resistances
from maglev.runs.preparation import Experiment

Results = list[Found | MaglevError | None]


def measured(trial: RepeatedRun, runs: Sequence[Changes]) -> Results:
    """Results of runs side by side, as many at a time as there are lanes."""
    found: Results = []
    for first in range(0, len(runs), trial.width):
        found += trial.measure(runs[first:first + trial.width])
    return found


def measured_in_lanes(experiment: Experiment, runs: Sequence[Changes], kept: Sequence[str], every: int) -> Results:
    """Results of runs in a loop that is compiled now, each with what it has to keep."""
    with RepeatedRun(experiment, None, Measuring(experiment.plan, experiment.times, kept, every)) as trial:
        trial.widen(runs[0], build=True)
        assert trial.loop is not None
        return measured(trial, runs)


def require_as_recorded(experiment: Experiment, runs: Sequence[Changes], kept: Sequence[str] = (),
                        every: int = 1) -> None:
    """Require of runs in lanes the metrics, what is kept, and the refusals of runs that are recorded."""
    found = measured_in_lanes(experiment, runs, kept, every)
    with RepeatedRun(experiment) as trial:
        for changes, result in zip(runs, found, strict=True):
            require_same(trial, changes, result, kept, every)


def require_same(trial: RepeatedRun, changes: Changes, result: Found | MaglevError | None, kept: Sequence[str] = (),
                 every: int = 1) -> None:
    """Require of one result what a recorded run with the same changes gives."""
    if not isinstance(result, Found):
        with pytest.raises(MaglevError) as refused:
            trial.run(changes)
        assert result is None or str(result) == str(refused.value)
        return
    meter, state, rows = result
    plan = trial.experiment.plan
    time, columns = trial.run(changes)
    whole, many = run_metrics(plan, time, columns, phase_resistances(plan)(changes)), meter.metrics([state])
    assert endings(plan, many) == [ending(plan, whole)]
    expected, of_lane = named_values(plan, whole), named_values(plan, many)
    assert list(of_lane) == list(expected)
    for name, (value, unit) in expected.items():
        (given,), own_unit = of_lane[name]
        # As text, a NaN is itself; of a number, text is shortest, and so exact.
        assert (repr(float(given)), own_unit) == (repr(float(value)), unit), name
    for i, name in enumerate(kept):
        assert rows[:, i].tobytes() == columns[name][::every].astype(np.float64).tobytes(), name
