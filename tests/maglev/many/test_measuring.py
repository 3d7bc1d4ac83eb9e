"""Metrics of runs that are not recorded: bit for bit `run_metrics` of the recordings that calls of the FMUs give."""

import math
from ctypes import c_int64
from pathlib import Path

import numpy as np
import pytest
from facts import raises
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from written_controllers import controller
from written_controllers import trial as trial_file

import maglev
from maglev.cosim import Order
from maglev.many.repeated_run import Changes, RepeatedRun
from maglev.many.study_columns import named_values
from maglev.runs.endings import ending, endings
from maglev.runs.measuring import Found, Measuring, run_metrics
from maglev.runs.metrics import phase_resistances
from maglev.runs.preparation import Experiment, prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.layers import packaged_runs
from maglev.scenario.loading import load_plan
from maglev.user.blocks import built_blocks
from maglev.user.source import FmuFile

LIMITS = '''class Limits:
    """Of a part that others share."""

    def __init__(self) -> None:
        self.reached = False


'''


def trial_of(experiment: Experiment, kept: tuple[str, ...] = (), every: int = 1,
              ended: c_int64 | None = None) -> RepeatedRun:
    """A run with the loop for it, compiled now."""
    found = RepeatedRun(experiment, None, Measuring(experiment.plan, experiment.times, kept, every), ended)
    found.load(build=True)
    assert found.loop is not None
    return found


def require_same(trial: RepeatedRun, changes: Changes) -> None:
    """The same metrics, and the same of what is kept, of both ways."""
    measured, = trial.measure([changes])
    assert isinstance(measured, Found)
    meter, state, rows = measured
    plan = trial.experiment.plan
    time, columns = trial.run(changes)
    whole, many = run_metrics(plan, time, columns, phase_resistances(plan)(changes)), meter.metrics([state])
    assert endings(plan, many) == [ending(plan, whole)]
    expected, found = named_values(plan, whole), named_values(plan, many)
    assert list(found) == list(expected)
    for name, (value, unit) in expected.items():
        # As text, a NaN is itself; of a number, text is shortest, and so exact.
        assert [repr(float(each)) for each in found[name][0]] == [repr(float(value))] and found[name][1] == unit, name
    assert trial.measuring is not None
    for i, name in enumerate(trial.measuring.kept):
        assert rows[:, i].tobytes() == columns[name][::trial.measuring.every].astype(np.float64).tobytes()


def experiment_of(fmus: Path, name: str, stop_time: float | None = None, order: Order = "sequential") -> Experiment:
    plan = load_plan(name)
    if stop_time is not None:
        plan = plan.model_copy(update={"stop_time": stop_time, "events": [
            each for each in plan.events if each.time < stop_time]})
    return prepare(plan, fmus, {}, {}, {"order": order})


@pytest.mark.few(5)
@pytest.mark.parametrize(("name", "stop_time", "order"), [
    ("2dof-equilibrium-excitation", 0.5, "sequential"),   # several FMUs of one model
    ("2dof-faults-lost", None, "sequential"), ("3dof-setpoints-improved", 7.0, "jacobi"),
    ("3dof-push", None, "sequential"), ("2dof-effects-heat", None, "sequential"),
    ("2dof-tracking-pid", None, "sequential"), ("2dof-laws-nonlinear", None, "sequential"),   # steps and a push
    ("3dof-measurement-jitter", 1.5, "sequential"), ("5dof-setpoints", 1.5, "sequential"),
    ("2dof-step-4-linear", None, "sequential")])
def test_metrics_are_those_of_the_recording(native_fmus: Path, name: str, stop_time: float | None,
                                            order: Order) -> None:
    experiment = experiment_of(native_fmus, name, stop_time, order)
    kept = [name for axis in experiment.plan.axes.values() for name in (axis.position, axis.reference)]
    with trial_of(experiment, tuple(kept), 7) as trial:
        require_same(trial, {})
        require_same(trial, {})   # nothing is left of the one before


@pytest.mark.thorough
@pytest.mark.parametrize("name", list(packaged_runs()))
def test_metrics_of_every_run(native_fmus: Path, name: str) -> None:
    """With the FMUs' own values where a run takes some from another."""
    experiment = experiment_of(native_fmus, name)
    with trial_of(experiment) as trial:
        if trial.measure([{}])[0] is not None:   # else it shows a refusal
            require_same(trial, {})


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(mass=st.floats(3.0, 6.0), amplitude=st.floats(-0.03, 0.03), start=st.floats(0.012, 0.026),
       limit=st.floats(0.5, 9.0), friction=st.floats(0.0, 3.0))
def test_metrics_of_random_runs(random_trial: RepeatedRun, mass: float, amplitude: float, start: float,
                                   limit: float, friction: float) -> None:
    """Some settle, some hit a stop, some fall: also with other references, which move the windows of steps."""
    require_same(random_trial, {
        "plant.v.mass": mass, "reference.h.amplitude": 1.0 + 10.0 * amplitude, "plant.v.position_start": start,
        "controller.current_limit": limit, "plant.h.friction.coulomb": friction})


@pytest.fixture(scope="module")
def random_trial(native_fmus: Path) -> RepeatedRun:
    return trial_of(experiment_of(native_fmus, "2dof-setpoints", 7.0))


def test_what_is_refused_is_left_to_the_calls(native_fmus: Path) -> None:
    """Of a value that is none, and of a step that does not fit: they say what is wrong."""
    with trial_of(experiment_of(native_fmus, "2dof-setpoints", 1.5)) as trial:
        assert trial.measure([{"controller.sample_time": 0.7e-3}])[0] is None
        require_same(trial, {})
        trial.load().drive({"controller.v.reference": [math.nan] * len(trial.experiment.times)})
        assert trial.measure([{}])[0] is None


def test_nothing_of_a_run_that_trips_stays_for_the_next(native_fmus: Path) -> None:
    experiment = experiment_of(native_fmus, "3dof-laws-nonlinear")
    with trial_of(experiment) as trial, trial_of(experiment) as fresh:
        tripped, after, first = (*(trial.measure([changes])[0] for changes in ({"controller.current_limit": 0.5}, {})),
                                 fresh.measure([{}])[0])
        assert isinstance(tripped, Found) and isinstance(after, Found) and isinstance(first, Found)
        assert tripped.state["flag"].max() > 0.0 > first.state["flag"].max()
        assert [after.state[name].tobytes() for name in first.state] == [
            values.tobytes() for values in first.state.values()]


def test_it_ends_when_it_is_told_to(native_fmus: Path) -> None:
    ended = c_int64()
    with trial_of(experiment_of(native_fmus, "2dof-setpoints"), ended=ended) as trial:
        assert trial.measure([{}])[0] is not None
        ended.value = 1   # as another thread says it
        with pytest.raises(KeyboardInterrupt):
            trial.measure([{}])


def test_fmus_of_fmi_3_are_taken(fmi3_fmus: Path) -> None:
    with trial_of(experiment_of(fmi3_fmus, "3dof-setpoints-improved", 7.0), ("plant.at_stop",), 3) as trial:
        require_same(trial, {})
        require_same(trial, {"plant.y.mass": 9.0, "controller.current_limit": 3.0})


def test_a_part_that_two_have_is_refused(tmp_path: Path) -> None:
    """A copy of the one would have the other's."""
    changes = (("    def __init__(self) -> None:\n        self.last", "    def __init__(self, other: Limits) -> None:\n"
                "        self.other = other\n        self.last"), ("= Rate()\n        self.travel = Rate()", "= Rate("
               "self.limits)\n        self.travel = Rate(self.limits)"), ("        self.gap =", "        self.limits = "
               "Limits()\n        self.gap ="), ("class Rate:", f"{LIMITS}class Rate:"))
    with raises(maglev.BuildError, "self.gap.other", "self.limits"):
        maglev.build(controller(tmp_path, *changes), fmus=tmp_path, kind="native", target="host")


def test_translated_classes_are_taken(native_fmus: Path, tmp_path: Path) -> None:
    fmu, = maglev.build(controller(tmp_path), fmus=tmp_path, kind="native", target="host")
    experiment = prepare(load_plan(trial_file(tmp_path)), native_fmus, {"controller": Replacement(FmuFile(fmu))}, {})
    written = built_blocks(experiment.fmu_files)
    assert [*written] == ["controller"]
    measuring = Measuring(experiment.plan, experiment.times, ["plant.v.position"], 3)
    with RepeatedRun(experiment, None, measuring, written=written) as trial:
        trial.load(build=True)
        require_same(trial, {"plant.v.mass": 4.0})
        require_same(trial, {"plant.v.mass": 5.0})


def test_only_native_fmus_of_this_installation_are_taken(fmus: Path, clocked_fmus: Path) -> None:
    for folder in (fmus, clocked_fmus):
        experiment = experiment_of(folder, "3dof-setpoints", 1.5)
        with RepeatedRun(experiment, None, Measuring(experiment.plan, experiment.times)) as trial:
            trial.load(build=True)
            assert trial.loop is None
            assert trial.measure([{}])[0] is None
