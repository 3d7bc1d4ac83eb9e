import math
from types import SimpleNamespace

import numpy as np
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

from maglev.files.errors import MeasurementError
from maglev.runs import measuring
from maglev.runs.measures import measures_of
from maglev.runs.measuring import CHUNK, added, run_metrics, step_samples
from maglev.runs.metrics import Effort, MotorCurrents, phase_resistances, winding_of
from maglev.scenario.loading import load_plan
from maglev.scenario.run_plan import Axis, MetricSettings, Motor, StartValue

TIME = np.arange(10001, dtype=float) * 1e-3


def plan(**changes):
    return SimpleNamespace(**{
        "axes": {"y": Axis(position="plant.y.position", reference="controller.y.reference")},
        "motors": {}, "stage": None, "stop_flag": None, "trip_flag": None, "events": [], "event_ends": [],
        "disturbances": [],
        "metrics": MetricSettings(bands=[1e-4, 1e-5]), **changes})


def step_at_1_s(start, target):
    return np.where(TIME >= 1.0, target, start)


def second_order(start, target, omega, zeta):
    """Response of omega²/(s² + 2 zeta omega s + omega²) to a step at 1 s."""
    t = np.maximum(TIME - 1.0, 0.0)
    damped = omega * math.sqrt(1.0 - zeta**2)
    rest = np.exp(-zeta * omega * t) * (np.cos(damped * t) + zeta * omega / damped * np.sin(damped * t))
    return target - (target - start) * rest


@given(st.floats(0.2, 0.8), st.floats(5.0, 20.0), st.sampled_from([(0.025, 0.027), (0.03, 0.01), (0.0, -0.015)]))
def test_second_order_step(zeta, omega, ends):
    start, target = ends
    metrics = run_metrics(plan(), TIME, {"plant.y.position": second_order(start, target, omega, zeta),
                                         "controller.y.reference": step_at_1_s(start, target)})
    (step,) = metrics.steps
    assert (step.axis, step.time, step.start, step.target) == ("y", 1.0, start, target)
    assert step.overshoot == pytest.approx(math.exp(-math.pi * zeta / math.sqrt(1.0 - zeta**2)), rel=5e-3)
    # The envelope of the error bounds the settling time from above, one half period less from below.
    for band, settling in step.settling_time.items():
        envelope = math.log(abs(target - start) / (band * math.sqrt(1.0 - zeta**2))) / (zeta * omega)
        half_period = math.pi / (omega * math.sqrt(1.0 - zeta**2))
        assert envelope - half_period - 2e-3 <= settling <= envelope + 2e-3
    assert not metrics.failed


def test_first_order_settles_when_it_says():
    position = 0.02 + 0.01 * (1.0 - np.exp(-5.0 * np.maximum(TIME - 1.0, 0.0)))
    metrics = run_metrics(plan(), TIME, {"plant.y.position": position,
                                         "controller.y.reference": step_at_1_s(0.02, 0.03)})
    (step,) = metrics.steps
    assert step.settling_time[1e-4] == pytest.approx(math.log(100.0) / 5.0, abs=1.5e-3)
    assert step.settling_time[1e-5] == pytest.approx(math.log(1000.0) / 5.0, abs=1.5e-3)
    assert step.overshoot == 0.0
    assert step.steady_state_error == pytest.approx(0.0, abs=1e-12)


@pytest.mark.parametrize(("errors", "settling"), [([2.0, -1.0, 1.5], math.inf), ([2.0, -1.5, 1.0], 1.0),
                                                  ([1.0, 1.0, 1.0], 0.0)])
def test_settling_time_of_the_last_sample_outside_is_infinite(errors, settling):
    columns = {"controller.y.reference": np.array([0.0, 8.0, 8.0, 8.0]),
               "plant.y.position": np.array([0.0, *(8.0 + error for error in errors)])}
    (step,) = run_metrics(plan(metrics=MetricSettings(bands=[1.0])), np.arange(4.0), columns).steps
    assert step.settling_time == {1.0: settling}


@given(st.integers(1, 3), st.integers(1, 4), st.integers(1, 40), st.booleans())
def test_sums_go_in_the_order_of_the_samples(columns, runs, samples, along):
    """However they lie in memory: of a column as of many, and of one that is continued."""
    values = np.random.default_rng(samples).normal(size=(samples, columns, runs)) * 1e3 + 1e-3
    expected = np.full((columns, runs), 0.1)
    for row in values:
        expected += row
    assert added(np.full((columns, runs), 0.1), np.asfortranarray(values) if along else values).tobytes() == \
        expected.tobytes()


def test_chunks_do_not_matter(monkeypatch):
    """A window, an event and a flag that several have a part of, and one that begins with a chunk."""
    rng, reference = np.random.default_rng(2), step_at_1_s(0.02, 0.022)
    noise = {name: rng.normal(size=len(TIME)) for name in ("i_a", "i_d")}
    pushed = plan(motors={"alpha": SimpleNamespace(currents=["i_a"], commands=["i_d"])}, trip_flag="tripped",
                  events=[SimpleNamespace(name="push", time=3.7)], event_ends=[8.1],
                  metrics=MetricSettings(bands=[1e-3], tracking_from=2.5))
    columns = hold(**noise, tripped=(TIME >= 6.2).astype(float), **{
        "controller.y.reference": reference, "plant.y.position": reference + 1e-3 * rng.normal(size=len(TIME))})
    found = set()
    for chunk in (CHUNK, 1, 377, 1000, len(TIME) + 1):
        monkeypatch.setattr(measuring, "CHUNK", chunk)
        found.add(repr(run_metrics(pushed, TIME, columns, {"alpha": 2.0})))
    assert len(found) == 1


def test_window_ends_at_the_next_step_of_any_axis():
    axes = {axis: Axis(position=f"{axis}.p", reference=f"{axis}.r") for axis in ("y", "x")}
    columns = {"y.r": np.where(TIME >= 1.0, 2e-3, 0.0), "x.r": np.where(TIME >= 4.0, 3e-3, 0.0)}
    columns["y.p"] = np.where((TIME >= 2.0) & (TIME < 4.0), 2e-3, 0.0)   # leaves its reference when x steps
    columns["x.p"] = np.where(TIME >= 5.0, 3e-3, 0.0)
    y, x = run_metrics(plan(axes=axes), TIME, columns).steps
    assert (y.axis, y.time, x.axis, x.time) == ("y", 1.0, "x", 4.0)
    assert y.settling_time[1e-4] == pytest.approx(0.999)
    assert y.steady_state_error == 0.0
    assert x.settling_time[1e-4] == pytest.approx(0.999)


def test_a_rotation_has_bands_and_a_limit_of_its_own():
    axes = {"y": Axis(position="y.p", reference="y.r"), "roll": Axis(position="p", reference="r", rotation=True)}
    columns = {"y.r": step_at_1_s(0.0, 1e-3), "y.p": np.where(TIME >= 2.0, 1e-3, 0.0),
               "r": step_at_1_s(0.0, 10e-3), "p": np.where(TIME >= 3.0, 6e-3, 0.0)}
    settings = MetricSettings.model_validate(
        {"bands": ["0.1 mm"], "tilt_bands": ["5 mrad", "1 mrad"], "fail_tilt": "3.9 mrad"})
    tilted = plan(axes=axes, metrics=settings)
    metrics = run_metrics(tilted, TIME, columns)
    assert [dict(step.settling_time) for step in metrics.steps] == [
        {1e-4: pytest.approx(0.999)}, {5e-3: pytest.approx(1.999), 1e-3: math.inf}]
    assert not metrics.failed and metrics.lost == (1.0,)
    assert [*metrics.ended_off] == ["roll"]
    further = MetricSettings.model_validate({"fail_tilt": "4.1 mrad"})
    assert run_metrics(plan(axes=axes, metrics=further), TIME, columns).ended_off == {}
    assert {(each.quantity, each.of, each.unit) for each in measures_of(tilted, metrics)} >= {
        ("settling time to 5 mrad", "roll", "s"), ("settling time to 0.1 mm", "y", "s"), ("end error", "roll", "rad")}


def test_a_moving_reference_has_no_steps():
    assert step_samples(np.sin(TIME)) == []
    assert step_samples(np.array([0.0, 1.0])) == [1]
    assert step_samples(np.array([0.0, 0.0, 1.0, 1.0, 0.0])) == [2, 4]
    assert step_samples(np.array([0.0, 1.0, 2.0, 2.0])) == []
    assert step_samples(np.array([0.0, 0.0, 1.0, 2.0, 2.0])) == []


def test_a_step_at_the_first_sample_begins_where_the_run_does():
    reference = np.where(TIME < 5.0, 1e-3, 2e-3)
    reference[0] = 0.0
    metrics = run_metrics(plan(), TIME, hold(**{"controller.y.reference": reference}))
    assert [(step.start, step.target) for step in metrics.steps] == [(0.0, 1e-3), (1e-3, 2e-3)]


def test_tracking():
    reference = np.sin(TIME)
    error = np.where(TIME < 3.0, 0.5, 0.0) + 0.1 * np.sign(np.sin(20.0 * TIME))
    settings = MetricSettings(tracking_from=5.0, fail_error=1.0)
    (tracking,) = run_metrics(plan(metrics=settings), TIME, {
        "plant.y.position": reference + error, "controller.y.reference": reference}).tracking
    assert tracking.mean_tracking_error == pytest.approx(0.1, rel=1e-2)
    assert tracking.peak_tracking_error == pytest.approx(0.1)
    assert tracking.tracking_transient == pytest.approx(2.999)


def test_tracking_from_beyond_the_end_is_refused():
    settings = MetricSettings(tracking_from=11.0, fail_error=1.0)
    with raises(MeasurementError, "10.0 s", "tracking_from", "11.0 s"):
        run_metrics(plan(metrics=settings), TIME, hold())


def hold(**changes):
    return {"plant.y.position": np.zeros_like(TIME), "controller.y.reference": np.zeros_like(TIME), **changes}


def test_currents_are_absolute():
    motors = {"alpha": SimpleNamespace(currents=["i_a", "i_b"], commands=["i_d"])}
    metrics = run_metrics(plan(motors=motors), TIME, hold(
        i_a=np.full_like(TIME, 1.0), i_b=np.where(TIME > 5.0, -3.0, 0.0), i_d=np.full_like(TIME, -2.0)))
    (motor,) = metrics.motors
    assert (motor.motor, motor.peak_current, motor.peak_command, motor.mean_command) == ("alpha", 3.0, 2.0, 2.0)
    assert motor.mean_current == pytest.approx(1.5, abs=1e-3)


def test_of_a_motor_without_currents_or_commands_there_is_nothing():
    motors = {name: SimpleNamespace(currents=currents, commands=commands) for name, currents, commands in (
        ("alpha", ["i"], []), ("beta", [], ["u"]), ("gamma", [], []))}
    pushed = plan(motors=motors, events=[SimpleNamespace(name="all", time=0.0)], event_ends=[10.0])
    columns = hold(i=np.full_like(TIME, -2.0), u=np.ones_like(TIME))

    def efforts(samples, **changes):
        return run_metrics(pushed, TIME[:samples], {name: values[:samples] for name, values in {
            **columns, **changes}.items()}, dict.fromkeys(motors, 1.0)).events[0].efforts

    one, _, nothing = efforts(len(TIME))
    assert (one.rms_current, one.command_noise) == (2.0, 0.0)
    assert one.ohmic_loss == pytest.approx(4.0 * TIME[-1])
    assert nothing == Effort("gamma", 0.0, 0.0, 0.0)
    assert efforts(2, u=np.array([1.0, 3.0]))[1].command_noise == pytest.approx(math.sqrt(2.0))
    assert efforts(1)[0].ohmic_loss == 0.0
    assert run_metrics(pushed, TIME, columns).motors[2] == MotorCurrents("gamma", 0.0, 0.0, 0.0, 0.0)


def test_failure():
    flags = {"stop_flag": "at_stop", "trip_flag": "tripped"}
    never = np.zeros(len(TIME), dtype=np.int32)
    late = (TIME >= 7.0).astype(np.int32)
    quiet = run_metrics(plan(**flags), TIME, hold(at_stop=never, tripped=never))
    assert (quiet.stop_contact, quiet.tripped, quiet.failed) == (None, None, False)
    stopped = run_metrics(plan(**flags), TIME, hold(at_stop=late, tripped=never))
    assert (stopped.stop_contact, stopped.tripped, stopped.failed) == (7.0, None, True)
    tripped = run_metrics(plan(**flags), TIME, hold(at_stop=never, tripped=late))
    assert (tripped.stop_contact, tripped.tripped, tripped.failed) == (None, 7.0, True)
    lost = run_metrics(plan(), TIME, hold(**{"plant.y.position": np.full_like(TIME, -1.1e-3)}))
    assert (lost.failed, lost.ended_off) == (False, {"y": pytest.approx(1.1e-3)})


def test_events_of_known_signals():
    """An exponential return, three phases of a motor that turns, and commands that are noise on a ramp, and a sine."""
    event = SimpleNamespace(name="push", time=3.0)
    last = SimpleNamespace(name="rest", time=7.0)
    t = TIME - 3.0
    phases = {f"i_{k}": 2.0 * np.cos(2.0 * math.pi * (5.0 * TIME + k / 3.0)) for k in range(3)}
    noise = np.random.default_rng(5).normal(0.0, 0.3, len(TIME)) + 0.1 * TIME
    motors = {"alpha": SimpleNamespace(currents=[*phases], commands=["noise"]),
              "beta": SimpleNamespace(currents=[], commands=["sine"])}
    error = np.where((t >= 0.0) & (TIME < 7.0), -4e-3 * np.exp(-2.0 * t), 5e-6)
    pushed = plan(motors=motors, events=[event, last], event_ends=[7.0, 10.0])
    metrics = run_metrics(pushed, TIME, hold(**phases, noise=noise, sine=3.0 * np.sin(200.0 * TIME), **{
        "plant.y.position": error}), {"alpha": 7.0})
    first, second = metrics.events
    assert (first.time, first.end, second.end) == (3.0, TIME[6999], 10.0), "the sample at 7 s belongs to the next event"
    (y,), (alpha, beta) = first.deviations, first.efforts
    assert y.peak_deviation == pytest.approx(4e-3)
    assert y.recovery_time[1e-4] == pytest.approx(math.log(40.0) / 2.0, abs=1e-3)
    assert y.recovery_time[1e-5] == pytest.approx(math.log(400.0) / 2.0, abs=1e-3)
    assert y.integral_absolute_error == pytest.approx(2e-3 * (1.0 - math.exp(-2.0 * 3.999)), rel=1e-5)
    assert alpha.rms_current == pytest.approx(2.0 / math.sqrt(2.0))
    assert alpha.ohmic_loss == pytest.approx(7.0 * 1.5 * 2.0**2 * 3.999)
    assert alpha.command_noise == pytest.approx(0.3, rel=0.03)
    assert beta.command_noise == pytest.approx(3.0 * math.sin(200.0 * 1e-3 / 2.0), rel=1e-2)
    (after,) = second.deviations
    assert (after.peak_deviation, after.recovery_time[1e-5]) == (5e-6, 0.0)
    found = {(each.quantity, each.of, each.time): each for each in measures_of(pushed, metrics)}
    assert found["integral absolute error", "y", 3.0].text == "2 mm·s"
    assert found["ohmic loss", "alpha", 3.0].event == "push" and ("rms current", "beta", 3.0) not in found


def test_a_loss_is_that_of_a_warm_winding_and_absent_where_no_resistance_is_known():
    """1 A in 2 ohm for 10 s; copper that is 100 K warmer has 39.3 % more (assumed by the plant's winding)."""
    motors = {"alpha": Motor(currents=["plant.alpha.phase_a.current"])}
    pushed = plan(motors=motors, events=[SimpleNamespace(name="push", time=0.0)], event_ends=[10.0])
    columns = hold(**{"plant.alpha.phase_a.current": np.ones_like(TIME)})
    warm = columns | {f"{winding_of(motors['alpha'])}.rise": np.full_like(TIME, 100.0)}
    losses = [run_metrics(pushed, TIME, each, {"alpha": 2.0}).events[0].efforts[0].ohmic_loss
              for each in (columns, warm)]
    assert losses == pytest.approx([20.0, 27.86])
    assert "ohmic loss" not in {each.quantity for each in measures_of(pushed, run_metrics(pushed, TIME, columns))}


def test_resistances_are_those_of_the_sample_the_run_or_the_description():
    run = load_plan("3dof-push")
    assert run.stage is not None
    described = {motor.name: motor.winding.resistance for motor in run.stage.motors}
    assert phase_resistances(run)({}) == described
    run.fmus["plant"].start["alpha.winding.resistance"] = StartValue(4.0, "Ohm", "4 Ohm")
    assert phase_resistances(run)({}) == described | {"alpha": 4.0}
    assert phase_resistances(run)({"plant.alpha.winding.resistance": 5.0}) == described | {"alpha": 5.0}


def test_who_is_not_back_at_the_end_of_the_window_is_not_back():
    event = SimpleNamespace(name="push", time=3.0)
    columns = hold(**{"plant.y.position": np.where((TIME >= 3.0) & (TIME < 5.0), 1e-3, 0.0)})
    (early,) = run_metrics(plan(events=[event], event_ends=[4.0]), TIME, columns).events
    assert early.deviations[0].recovery_time == {1e-4: math.inf, 1e-5: math.inf}
    with raises(MeasurementError, "2.0 s", "'push'", "3.0 s"):
        run_metrics(plan(events=[event], event_ends=[4.0]), TIME[:2001],
                    {name: values[:2001] for name, values in columns.items()})


@pytest.mark.parametrize("lost", [False, True])
def test_a_disturbance_ends_the_window_of_a_step(lost):
    """What the step did before is measured as if nothing came after, and a fall after it is not the step's."""
    settled = second_order(0.02, 0.022, 10.0, 0.5)
    reference = np.where(TIME >= 8.0, 0.025, step_at_1_s(0.02, 0.022))
    struck = np.where((TIME >= 6.0) & (TIME < 6.4), 0.03, settled)
    flag = ((TIME >= 6.1) & lost).astype(float)
    pushed = plan(stop_flag="at_stop", disturbances=[(0.5, "early"), (6.0, "push"), (6.4, "plant.y.force"),
                                                     (20.0, "never")])
    columns = {"plant.y.position": struck, "controller.y.reference": reference, "at_stop": flag}
    first, second = run_metrics(pushed, TIME, columns).steps
    (alone,) = run_metrics(plan(), TIME[:6000], {"plant.y.position": settled[:6000],
                                                 "controller.y.reference": reference[:6000]}).steps
    assert (first.settling_time, first.overshoot, first.steady_state_error) == (
        alone.settling_time, alone.overshoot, alone.steady_state_error)
    assert (first.end, first.cut_by, second.end, second.cut_by) == (6.0, "push", 10.0, "")
    assert run_metrics(pushed, TIME, columns).lost == (() if lost else (8.0,))   # it does not get there in time
    (whole, _) = run_metrics(plan(), TIME, columns).steps
    assert whole.settling_time[1e-4] == pytest.approx(5.4, abs=2e-3)
    assert (whole.end, whole.cut_by) == (8.0, "")


@pytest.mark.parametrize(("fallen", "lost"), [
    # Steps at 2, 4, 6 and 8 s; where the stage is on a stop.
    ([(3.0, 10.0)], (2.0,)),              # one fall, and it stays down
    ([(3.0, 3.5)], (2.0,)),               # it comes back before the next step
    ([(3.0, 5.0)], (2.0,)),               # it comes back during the next step, which found it fallen
    ([(3.0, 5.0), (6.5, 10.0)], (2.0, 6.0)),
    ([(2.5, 2.6), (4.5, 4.6)], (2.0, 4.0)),
    ([], ())])
def test_a_fall_counts_as_one_failure(fallen, lost):
    reference = 1e-3 * np.floor(TIME / 2.0 + 1e-9).clip(max=4)
    down = np.any([(start <= TIME) & (end >= TIME) for start, end in fallen] or [np.zeros_like(TIME)], axis=0)
    columns = hold(**{"plant.y.position": np.where(down, -0.01, reference), "controller.y.reference": reference})
    assert run_metrics(plan(stop_flag="at_stop"), TIME, {**columns, "at_stop": down.astype(float)}).lost == lost
    assert run_metrics(plan(), TIME, columns).lost == tuple(
        step for step in lost if any(start <= step + 2.0 - 1e-3 <= end for start, end in fallen)), "by its error alone"


@pytest.mark.parametrize(("columns", "facts"), [
    ({"plant.y.positio": TIME, "controller.y.reference": TIME}, ["'plant.y.position'", "'plant.y.positio'"]),
    (hold(**{"plant.y.position": TIME[:5]}), ["'plant.y.position'", "(5,)", "(10001,)"]),
    (hold(**{"plant.y.position": np.where(TIME == 2.0, np.nan, 0.0)}), ["'plant.y.position'", "finite", "2000"])])
def test_bad_columns_are_refused(columns, facts):
    with raises(MeasurementError, *facts):
        run_metrics(plan(), TIME, columns)


def test_no_samples_are_refused():
    with raises(MeasurementError, "time", "(0,)"):
        run_metrics(plan(), np.array([]), {})


@given(st.lists(st.floats(-1.0, 1.0), min_size=len(TIME) // 1000, max_size=len(TIME) // 1000))
def test_extremes_of_every_column_of_numbers(values):
    column = np.interp(TIME, np.linspace(0.0, 10.0, len(values)), values)
    columns = {"plant.y.position": column, "controller.y.reference": 0.5 * column, "flag": column > 0.0,
               "broken": np.where(TIME > 5.0, np.nan, column)}
    assert run_metrics(plan(), TIME, columns).extremes == {
        "plant.y.position": (min(column), max(column)),
        "controller.y.reference": (0.5 * min(column), 0.5 * max(column))}
