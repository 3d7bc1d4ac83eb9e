"""Metrics of runs that are not recorded: bit for bit `run_metrics` of the recordings that calls of the FMUs give."""

import math
from ctypes import c_int64
from pathlib import Path

import pytest
from facts import raises
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from recorded_metrics import measured, require_as_recorded, require_same
from written_controllers import controller
from written_controllers import trial as trial_file

import maglev
from maglev.cosim import Order
from maglev.cosim.lane_loop import MOST_LANES
from maglev.many.repeated_run import Changes, RepeatedRun
from maglev.runs.measuring import Found, Measuring
from maglev.runs.preparation import Experiment, prepare
from maglev.runs.replacement import Replacement
from maglev.scenario.layers import packaged_runs
from maglev.scenario.loading import load_plan
from maglev.user.blocks import built_blocks
from maglev.user.source import FmuFile

# Values of 2dof-setpoints; all tests of it vary these, so that they share a loop.
VALUES: dict[str, float] = {"plant.v.mass": 4.35, "reference.h.amplitude": 1.0, "plant.v.position_start": 0.02,
                            "controller.current_limit": 4.0, "plant.h.friction.coulomb": 1.0}

LIMITS = '''class Limits:
    """Of a part that others share."""

    def __init__(self) -> None:
        self.reached = False


'''


def trial_of(experiment: Experiment, changes: Changes, ended: c_int64 | None = None) -> RepeatedRun:
    """Runs that differ in such changes, with the loop for them, compiled now."""
    found = RepeatedRun(experiment, None, Measuring(experiment.plan, experiment.times), ended)
    found.widen(changes, build=True)
    assert found.loop is not None
    return found


def experiment_of(fmus: Path, name: str, stop_time: float | None = None, order: Order = "sequential") -> Experiment:
    plan = load_plan(name)
    if stop_time is not None:
        plan = plan.model_copy(update={"stop_time": stop_time, "events": [
            each for each in plan.events if each.time < stop_time]})
    return prepare(plan, fmus, {}, {}, {"order": order})


@pytest.mark.few(2)
@pytest.mark.parametrize(("name", "stop_time", "order"), [
    ("2dof-equilibrium-excitation", 0.5, "sequential"),   # several FMUs of one model
    ("2dof-faults-lost", None, "sequential"), ("3dof-setpoints-improved", 7.0, "jacobi"),
    ("3dof-push", None, "sequential"), ("2dof-effects-heat", None, "sequential"),
    ("2dof-tracking-pid", None, "sequential"), ("3dof-measurement-jitter", 1.5, "sequential"),
    ("5dof-setpoints", 1.5, "sequential"), ("2dof-step-4-linear", None, "sequential")])
def test_metrics_are_those_of_the_recording(native_fmus: Path, name: str, stop_time: float | None,
                                            order: Order) -> None:
    experiment = experiment_of(native_fmus, name, stop_time, order)
    kept = [name for axis in experiment.plan.axes.values() for name in (axis.position, axis.reference)]
    many = MOST_LANES + 1   # the last one after the others: nothing is left of those before
    require_as_recorded(experiment, [{}] * many, kept, 7)


@pytest.mark.thorough
@pytest.mark.parametrize("name", list(packaged_runs()))
def test_metrics_of_every_run(native_fmus: Path, name: str) -> None:
    """With the FMUs' own values where a run takes some from another."""
    experiment = experiment_of(native_fmus, name)
    require_as_recorded(experiment, [{}])


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(mass=st.floats(3.0, 6.0), amplitude=st.floats(-0.03, 0.03), start=st.floats(0.012, 0.026),
       limit=st.floats(0.5, 9.0), friction=st.floats(0.0, 3.0))
def test_metrics_of_random_runs(random_trial: RepeatedRun, mass: float, amplitude: float, start: float,
                                   limit: float, friction: float) -> None:
    """Some settle, some hit a stop, some fall: also with other references, which move the windows of steps."""
    changes = dict(zip(VALUES, (mass, 1.0 + 10.0 * amplitude, start, limit, friction), strict=True))
    found, = random_trial.measure([changes])
    require_same(random_trial, changes, found)


@pytest.fixture(scope="module")
def random_trial(native_fmus: Path) -> RepeatedRun:
    return trial_of(experiment_of(native_fmus, "2dof-setpoints", 7.0), VALUES)


def test_what_is_refused_is_left_to_the_calls(native_fmus: Path) -> None:
    """Of a value that is none, and of a step that does not fit: they say what is wrong."""
    with trial_of(experiment_of(native_fmus, "2dof-setpoints", 1.5), VALUES) as trial:
        assert trial.measure([{"controller.sample_time": 0.7e-3}])[0] is None
        assert isinstance(trial.measure([VALUES])[0], Found)
        trial.load().drive({"controller.v.reference": [math.nan] * len(trial.experiment.times)})
        assert trial.measure([VALUES])[0] is None


def test_nothing_of_a_run_that_trips_stays_for_the_next(native_fmus: Path) -> None:
    experiment = experiment_of(native_fmus, "3dof-laws-nonlinear")
    changes: Changes = {"controller.current_limit": 0.5}
    with trial_of(experiment, changes) as trial, trial_of(experiment, changes) as fresh:
        tripped, after, first = (*(trial.measure([own])[0] for own in (changes, {})),
                                 fresh.measure([{}])[0])
        assert isinstance(tripped, Found) and isinstance(after, Found) and isinstance(first, Found)
        assert tripped.state["flag"].max() > 0.0 > first.state["flag"].max()
        assert [after.state[name].tobytes() for name in first.state] == [
            values.tobytes() for values in first.state.values()]


def test_it_ends_when_it_is_told_to(native_fmus: Path) -> None:
    ended = c_int64()
    with trial_of(experiment_of(native_fmus, "2dof-setpoints"), VALUES, ended) as trial:
        assert trial.measure([VALUES])[0] is not None
        ended.value = 1   # as another thread says it
        with pytest.raises(KeyboardInterrupt):
            trial.measure([VALUES])


def test_fmus_of_fmi_3_are_taken(fmi3_fmus: Path) -> None:
    require_as_recorded(experiment_of(fmi3_fmus, "3dof-setpoints-improved", 7.0), [
        {"plant.y.mass": 7.0, "controller.current_limit": 4.0},
        {"plant.y.mass": 9.0, "controller.current_limit": 3.0}], ["plant.at_stop"], 3)


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
    runs = [{"plant.v.mass": mass} for mass in (4.0, 5.0)]
    with RepeatedRun(experiment, None, measuring, written=written) as trial:
        trial.widen(runs[0], build=True)
        assert trial.loop is not None
        for changes, found in zip(runs, measured(trial, runs), strict=True):
            require_same(trial, changes, found, measuring.kept, measuring.every)


def test_only_native_fmus_of_this_installation_are_taken(fmus: Path, clocked_fmus: Path) -> None:
    for folder in (fmus, clocked_fmus):
        experiment = experiment_of(folder, "3dof-setpoints", 1.5)
        with RepeatedRun(experiment, None, Measuring(experiment.plan, experiment.times)) as trial:
            trial.widen({}, build=True)
            assert trial.loop is None
            assert trial.measure([{}])[0] is None
