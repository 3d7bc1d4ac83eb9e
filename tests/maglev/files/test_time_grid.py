"""Whole steps are counted in one way, by the reader of a scenario, the master and whoever thins what was recorded."""

from fractions import Fraction
from pathlib import Path

import numpy as np
import pytest
from facts import raises
from hypothesis import example, given
from hypothesis import strategies as st
from tiny_study import SCENARIO

from maglev.cosim.master import Master
from maglev.files.errors import FmuError, QuantityError, ScenarioError
from maglev.files.time_grid import MOST_STEPS, whole_steps
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan

pytestmark = pytest.mark.quick

STEPS = st.sampled_from([1e-5, 2e-4, 3e-4, 5e-4, 1e-3, 0.1, 1.0 / 3.0, 7.0])


@given(step=STEPS, count=st.integers(1, 10**8))
@example(step=3e-4, count=10**8)   # 3e4 / 3e-4 is 100000000.00000001
def test_rounding_is_on_the_grid(step: float, count: int) -> None:
    """Of a multiple of the step as a person writes it, and as it is multiplied."""
    assert whole_steps(count * step, step) == count
    assert whole_steps(float(f"{count * step:.15g}"), step) == count


@given(step=STEPS, count=st.integers(1, 10**7), beside=st.floats(2e-6, 0.5))
def test_times_off_the_grid_are_not_on_it(step: float, count: int, beside: float) -> None:
    time = (count + beside) * step
    exact = Fraction(time) / Fraction(step)
    if abs(exact - round(exact)) > 1.5e-6:   # the sum may have rounded it away
        with raises(QuantityError, f"{step} s"):
            whole_steps(time, step)


@pytest.mark.parametrize("time", [0.0, 4e-5, MOST_STEPS * 1e-4 + 1.0])
def test_at_least_one_step_and_not_too_many(time: float) -> None:
    with raises(QuantityError, "0.0001 s"):
        whole_steps(time, 1e-4)


@given(time=st.one_of(st.floats(1e-4, 2e3), st.integers(1, 10**7).map(lambda n: n * 2e-4),
                      st.builds(lambda n, off: n * 2e-4 + off, st.integers(1, 10**7), st.floats(-1e-6, 1e-6))))
def test_the_file_is_refused_where_the_master_would_refuse(time: float) -> None:
    """As 1000.0000002 s with steps of 0.2 ms was, which one of them took."""
    with Master([], [], 2e-4) as master:
        try:
            steps = master.steps_to(time)
        except FmuError:
            steps = None
    plan = load_plan("3dof-setpoints")
    try:
        read = type(plan).model_validate({**table_of(), "stop_time": time, "step": 2e-4}).steps
    except ValueError:
        read = None
    assert read == steps
    if steps is not None:
        assert np.isclose(steps * 2e-4, time, rtol=1e-9, atol=1e-9)


def table_of() -> dict[str, object]:
    return {"name": "timed", "title": "of some length", "output_interval": 2e-4, "fmus": {"plant": {"file": "p.fmu"}}}


def test_a_file_is_named(tmp_path: Path) -> None:
    path = tmp_path / "long.toml"
    path.write_text(SCENARIO.replace('"0.2 s"', "1000.0000002"), encoding="utf-8")
    with raises(ScenarioError, path, "stop_time", "1000.0000002"):
        load_plan(path)
    path.write_text(SCENARIO, encoding="utf-8")
    with raises(ScenarioError, path, "stop_time", "0.2 s", "step", "0.0003"):
        prepare(load_plan(path), tmp_path, {}, {}, {"step": 3e-4})
