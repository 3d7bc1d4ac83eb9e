import math

import numpy as np
import pytest
from facts import require_facts
from hypothesis import assume, given
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from maglev.scenario.signals import Signal

SIGNAL = TypeAdapter(Signal)


def signal(**table):
    return SIGNAL.validate_python({"to": "controller.y.reference", **table})


def refusal(**table):
    with pytest.raises(ValidationError) as caught:
        signal(**table)
    return str(caught.value.errors()[0])


def rate(of, t):
    return float(of.rates_at(np.array([t]))[0])


def test_steps_hold_between_their_times():
    steps = signal(kind="steps", unit="mm", times=[0, 1, "6 s"], values=[25, 27, "2.3 cm"])
    assert [steps.value(t) for t in (-1.0, 0.0, 0.5, 1.0, 5.999, 6.0, 100.0)] == [
        0.025, 0.025, 0.025, 0.027, 0.027, 0.023, 0.023]
    assert rate(steps, 1.0) == 0.0


@given(st.integers(1, 200_000))
def test_no_step_is_missed_by_rounding(k):
    steps = signal(kind="steps", times=[0.0, k / 5000.0], values=[1.0, 2.0])
    assert steps.value(k * 0.2e-3) == 2.0
    assert steps.value((k - 1) * 0.2e-3) == 1.0


def test_constant():
    constant = signal(kind="constant", value="25 mm")
    assert (constant.value(3.0), rate(constant, 3.0)) == (0.025, 0.0)


def test_sinusoid_with_offset():
    sinusoid = signal(kind="sinusoids", offset="25 mm", terms=[{"amplitude": "5 mm", "omega": "1.5 pi rad/s"}])
    assert sinusoid.value(0.0) == 0.025
    assert sinusoid.value(1.0 / 3.0) == pytest.approx(0.030)
    assert rate(sinusoid, 0.0) == pytest.approx(0.005 * 1.5 * math.pi)


def test_ramp_starts_at_rest_and_ends_at_full_amplitude():
    terms = [{"amplitude": 1.0, "omega": 3.0, "phase": 1.0}]
    ramped = signal(kind="sinusoids", terms=terms, ramp=2.0)
    plain = signal(kind="sinusoids", terms=terms)
    assert (ramped.value(0.0), rate(ramped, 0.0)) == (0.0, 0.0)
    assert ramped.value(1.0) == pytest.approx(0.5 * plain.value(1.0))
    assert (ramped.value(2.0), rate(ramped, 2.0)) == (plain.value(2.0), rate(plain, 2.0))


terms_strategy = st.lists(st.fixed_dictionaries({
    "amplitude": st.floats(-1.0, 1.0), "omega": st.floats(0.0, 20.0), "phase": st.floats(-7.0, 7.0)}),
    min_size=1, max_size=4)


@given(terms_strategy, st.floats(-1.0, 1.0), st.floats(0.1, 5.0), st.floats(0.01, 10.0))
def test_rate_of_sinusoids_is_the_central_difference(terms, offset, ramp, t):
    sinusoids = signal(kind="sinusoids", offset=offset, terms=terms, ramp=ramp)
    half = 1e-4
    assume(abs(t - ramp) > half)   # the second derivative jumps at the end of the ramp, and the difference straddles it
    difference = (sinusoids.value(t + half) - sinusoids.value(t - half)) / (2.0 * half)
    assert rate(sinusoids, t) == pytest.approx(difference, rel=1e-3, abs=1e-2)


@pytest.fixture
def recorded(tmp_path):
    path = tmp_path / "recorded.csv"
    path.write_text("time, gap, speed\n0, 20, 0\n1, 22, 1\n3, 21, 0\n")
    return path


def test_csv_is_linear_between_rows_and_held_beyond(recorded):
    gap = signal(kind="csv", file=str(recorded), column="gap", unit="mm")
    assert [gap.value(t) for t in (-1.0, 0.0, 1.0, 3.0, 9.0)] == [0.020, 0.020, 0.022, 0.021, 0.021]
    assert gap.value(0.5) == pytest.approx(0.021)
    assert [rate(gap, t) for t in (-1.0, 3.0, 9.0)] == [0.0, 0.0, 0.0]
    assert rate(gap, 0.0) == pytest.approx(0.002)
    assert rate(gap, 2.0) == pytest.approx(-0.0005)


@given(st.floats(0.01, 0.99))
def test_rate_of_csv_is_the_central_difference(tmp_path_factory, t):
    path = tmp_path_factory.mktemp("csv") / "line.csv"
    path.write_text("t,y\n0,1\n1,3\n")
    line = signal(kind="csv", file=str(path), column="y")
    assert rate(line, t) == pytest.approx((line.value(t + 1e-3) - line.value(t - 1e-3)) / 2e-3)


@pytest.mark.parametrize(("text", "words"), [
    ("time,gap\n0,1\n0,2\n", ["row 3", "time 0.0", "more than 0.0"]),
    ("time,gap\n1,1\n0,2\n", ["row 3", "more than 1.0"]),
    ("time,gap\n0,nan\n", ["row 2", "gap", "nan", "finite"]),
    ("time,gap\n0,\n", ["row 2", "gap", "finite"]),
    ("time,gap\n0\n", ["row 2 has 1 value, expected 2", "gap is missing"]),
    ("time,gap\n", ["expected rows of numbers"]),
    ("time,gaps\n0,1\n", ["column", "'gap'", "nearest is 'gaps'"])])
def test_bad_csv_is_refused(tmp_path, text, words):
    path = tmp_path / "bad.csv"
    path.write_text(text)
    message = refusal(kind="csv", file=str(path), column="gap")
    assert all(word in message for word in words)


def test_missing_csv_names_the_nearest_file(recorded):
    message = refusal(kind="csv", file=str(recorded.with_name("recorder.csv")), column="gap")
    assert "No such file" in message
    assert "nearest is 'recorded.csv'" in message


@pytest.mark.parametrize(("table", "words"), [
    ({"times": [0, 2, 1], "values": [1, 2, 3]}, ["'times', 2", "1.0", "ascending"]),
    ({"times": [0, 0], "values": [1, 2]}, ["'times', 1", "ascending"]),
    ({"times": [0, 1], "values": [1]}, ["values", "[1.0]", "as many as times, 2, got 1"]),
    ({"times": [], "values": []}, ["times", "at least 1"]),
    ({"times": [0, math.nan], "values": [1, 2]}, ["times", "nan", "finite"]),
    ({"times": ["1 mm"], "values": [1]}, ["times", "1 mm", "in s"]),
    ({"times": [0], "values": 1}, ["values", "list"]),
    ({"times": [0], "values": ["1 kg"], "unit": "mm"}, ["1 kg", "in mm"]),
    ({"times": [0, 1], "values": ["1 mm", "1 kg"]}, ["1 kg", "in m"]),
    ({"times": [0], "values": [1], "unit": "mmm"}, ["unit", "mmm", "nearest is 'mm'"])])
def test_bad_steps_are_refused(table, words):
    message = refusal(kind="steps", **table)
    assert all(word in message for word in words)


@pytest.mark.parametrize(("table", "words"), [
    ({"terms": [{"amplitude": "1 kg", "omega": 1}], "unit": "mm"}, ["(0, 'amplitude')", "1 kg", "in mm"]),
    ({"terms": [{"amplitude": 1, "omega": "1 Hz"}]}, ["omega", "1 Hz", "rad/s"]),
    ({"terms": [{"omega": 1}]}, ["amplitude", "required"]),
    ({"terms": [3]}, ["terms"]),
    ({"terms": 3}, ["terms", "list"]),
    ({"terms": []}, ["terms", "at least 1"]),
    ({"terms": [{"amplitude": 1, "omega": 1}], "ramp": -1}, ["ramp", "greater than or equal to 0"])])
def test_bad_sinusoids_are_refused(table, words):
    message = refusal(kind="sinusoids", **table)
    assert all(word in message for word in words)


def table_signal(tmp_path, text, **table):
    path = tmp_path / "logged.csv"
    path.write_text(text, encoding="utf-8")
    return signal(kind="csv", file=str(path), column="gap", **table)


def test_units_of_the_header_go_before_those_of_the_signal(tmp_path):
    text = "time (ms);gap [mm]\n0;20,5\n500;21\n"
    for unit in (None, "mm", "m"):
        gap = table_signal(tmp_path, text, **({} if unit is None else {"unit": unit}))
        assert (gap.value(0.25), gap.unit) == (pytest.approx(0.02075), unit or "m")
    assert gap.used(0.5) == (f"{gap.file}: columns are separated by semicolons; numbers have decimal commas; "
                             "time (ms) is in ms; gap is in mm").replace("time (ms) is", "time is")
    counts = text.replace("[mm]", "[counts]")
    for content, table, *facts in (
            (text, {"unit": "kg"}, "gap [mm]", "mm"), (text, {"time_unit": "mm"}, "time (ms)", "mm", "s"),
            (text, {"time_unit": "sx"}, "time_unit", "'s'"), (counts, {}, "'counts'", "unit")):
        with pytest.raises(ValidationError) as caught:
            table_signal(tmp_path, content, **table)
        require_facts(caught.value.errors()[0], *facts)
    assert table_signal(tmp_path, counts, unit="um").value(0.0) == pytest.approx(20.5e-6)


@pytest.mark.parametrize(("rows", "table", "facts"), [
    ("0,20\n500,21\n1000,22\n", {}, ["10 s", "0 s", "500 s", "time_unit"]),
    ("0,20\n500,21\n1000,22\n", {"time_unit": "ms"}, []), ("0,20\n500,21\n1000,22\n", {"time_unit": "s"}, []),
    ("1700000000,20\n1700000001,21\n", {}, ["1.7e+09 s", "0 s", "10 s"]),
    ("1700000000,20\n1700000001,21\n", {"begin": 0}, []), ("100,20\n101,21\n", {}, ["100 s", "101 s"]),
    ("100,20\n101,21\n", {"begin": "-0.5 s"}, []), ("-3,20\n-1,21\n", {}, ["-3 s", "-1 s"]),
    ("-3,20\n0,21\n", {}, ["-3 s", "0 s"]), ("10,20\n11,21\n", {}, ["10 s", "11 s"]),
    ("0,20\n", {}, []), ("-1,20\n1,21\n", {}, []), ("2,20\n30,21\n", {}, [])])
def test_a_table_has_rows_in_the_run(tmp_path, rows, table, facts):
    """Otherwise the signal is one value for the whole run, and the recorded motion never happens."""
    found = table_signal(tmp_path, f"time,gap\n{rows}", **table).misfit(10.0)
    assert bool(found) == bool(facts)
    require_facts(found, *facts)


def test_a_table_begins_where_it_is_told_to(tmp_path):
    text = "time,gap\n2024-05-01T12:00:00,20\n2024-05-01T12:00:02,22\n"
    with pytest.raises(ValidationError) as caught:
        table_signal(tmp_path, text)
    require_facts(caught.value.errors()[0], "time", "time stamps")
    gap = table_signal(tmp_path, text, begin="1 s", unit="mm")
    assert [gap.value(t) for t in (0.5, 2.0, 9.0)] == [0.020, pytest.approx(0.021), 0.022]
    cut = table_signal(tmp_path, "time,gap\n100,20\n104,24\n", begin=-1)
    assert cut.used(2.0) == f"{cut.file}; rows from -1 s to 3 s, used from 0 s to 2 s"
