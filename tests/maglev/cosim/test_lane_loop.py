"""Runs side by side have the bits of recorded runs, and what happens in one lane leaves the others alone."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from recorded_metrics import require_as_recorded

from maglev.cosim import lane_loop
from maglev.cosim.lane_loop import DONE, LEVEL_3, NARROW, REFUSED, WIDER, Taken, Vectors, widest
from maglev.cosim.master import Observer
from maglev.many.repeated_run import Changes, RepeatedRun
from maglev.runs.measuring import Found, Measuring
from maglev.runs.preparation import Experiment, prepare
from maglev.scenario.loading import load_plan

# Runs, and what is varied in them: lanes differ in masses, gains, friction that is off in one, where they begin and go,
# limits, and errors that trip one of them.
RUNS: dict[str, list[dict[str, float]]] = {
    "2dof-laws-nonlinear": [
        {"plant.v.mass": mass, "plant.h.friction.coulomb": friction, "controller.trip_error": trip,
         "reference.h.amplitude": 1.0 + 0.1 * friction}
        for mass, friction, trip in ((4.35, 0.0, 0.1), (5.0, 1.0, 1.0e-4), (9.0, 2.0, 2.0e-3), (4.0, 0.5, 0.1),
                                     (4.2, 0.0, 0.02))],
    "3dof-laws-nonlinear": [
        {"plant.y.mass": mass, "controller.current_limit": limit, "plant.x.position_start": start}
        for mass, limit, start in ((6.9, 4.0, 0.0), (8.0, 0.5, 0.01), (6.0, 3.0, -0.01), (7.1, 1.0e-3, 0.0))],
    "5dof-laws-nonlinear": [{"plant.y.mass": mass, "controller.current_limit": limit}
                            for mass, limit in ((18.0, 4.0), (20.0, 0.5), (22.0, 4.0))],
}
STATUS = "2dof-laws-nonlinear"


def experiment_of(run: str, folder: Path) -> Experiment:
    return prepare(load_plan(run), folder, {}, {})


def positions(experiment: Experiment) -> list[str]:
    return [axis.position for axis in experiment.plan.axes.values()]


@pytest.mark.parametrize("run", [pytest.param(run, marks=pytest.mark.thorough) if "5dof" in run else run
                                 for run in RUNS])
def test_lanes_have_the_bits_of_recorded_runs(run: str, native_fmus: Path) -> None:
    """The last lanes have none where there are fewer runs than lanes."""
    experiment = experiment_of(run, native_fmus)
    require_as_recorded(experiment, RUNS[run], positions(experiment), 10)


# Values of one run: of every kind of target, some refused, some that make it trip, run away or touch a stop.
ANY_RUN = st.fixed_dictionaries({
    "plant.y.mass": st.sampled_from((6.9, 8.0, 0.01, 1.0e3, -1.0)), "controller.antiwindup": st.booleans(),
    "plant.x.locked": st.booleans(), "plant.alpha.phase_a.open": st.booleans(),
    "controller.trip_error": st.floats(1.0e-4, 0.1), "plant.x.position_start": st.floats(-0.03, 0.03),
    "controller.current_limit": st.floats(0.1, 6.0), "reference.y.amplitude": st.floats(0.5, 3.0)})


@given(st.lists(ANY_RUN, min_size=6, max_size=6))
@settings(max_examples=5, derandomize=True, deadline=None, database=None, phases=[Phase.generate],
          suppress_health_check=list(HealthCheck))
def test_random_runs_have_the_same_bits_in_lanes(native_fmus: Path, runs: list[Changes]) -> None:
    experiment = experiment_of("3dof-laws-nonlinear", native_fmus)
    require_as_recorded(experiment, runs, positions(experiment), 10)


@pytest.mark.parametrize("width", [2, *(pytest.param(width, marks=pytest.mark.thorough) for width in (1, 4, 8))])
def test_width_does_not_matter(width: int, native_fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lane_loop, "widest", lambda: Vectors(width, "baseline", frozenset()))
    require_as_recorded(experiment_of(STATUS, native_fmus), RUNS[STATUS][:3])


def test_widest_vectors_are_those_of_the_processor() -> None:
    assert widest(frozenset()) is NARROW
    assert widest(LEVEL_3) == (4, "x86_64_v3", LEVEL_3)
    assert widest(LEVEL_3 - {"avx2"}) is NARROW
    assert widest(LEVEL_3 | {"avx512f", "avx512bw", "avx512cd", "avx512dq", "avx512vl", "sse2"}).width == 8
    assert widest().needed <= lane_loop.processor_flags()


def test_a_library_for_other_vectors_is_never_loaded(native_fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One that lies in the cache, kept by a processor with wider vectors, is not found by one that has none."""
    experiment, (changes, *_) = experiment_of(STATUS, native_fmus), RUNS[STATUS]
    kept: dict[tuple[str, str], bytes] = {}
    monkeypatch.setattr(lane_loop, "kept", lambda place, name: kept.get((place, name)))
    monkeypatch.setattr(lane_loop, "keep_here", lambda place, name, content: kept.setdefault((place, name), content))
    monkeypatch.setattr(lane_loop, "library", lambda _sources, _name, host: host.flags)
    monkeypatch.setattr(lane_loop, "LaneLoop", lambda made, *_: made)
    with RepeatedRun(experiment, measuring=Measuring(experiment.plan, experiment.times)) as repeated:
        for vectors in (*WIDER, NARROW):
            monkeypatch.setattr(lane_loop, "widest", lambda vectors=vectors: vectors)
            repeated.widen(changes)
            assert repeated.loop is None
            repeated.widen(changes, build=True)
            flags: Any = repeated.loop
            assert f"-mcpu={vectors.processor}" in flags


def test_a_lane_that_is_refused_leaves_the_others_alone(native_fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A mover that is far too light for a stiff stop is thrown out; another lane never begins."""
    experiment = experiment_of(STATUS, native_fmus)
    runs = [{"plant.v.mass": mass, "plant.v.stop.stiffness": stiffness, "plant.v.position_start": start}
            for mass, stiffness, start in ((4.35, 1.0e6, 0.02), (0.001, 1.0e8, 0.02), (30.0, 2.0e6, 0.02),
                                           (4.35, 1.0e6, 1.0), (5.0, 1.0e6, 0.021))]
    statuses: list[list[int]] = []
    fly = RepeatedRun.fly

    def watched(repeated: RepeatedRun, taken: Taken, of_meters: Any) -> Any:
        sizes = fly(repeated, taken, of_meters)
        statuses.append(taken.status[:sum(map(len, of_meters.values()))].tolist())
        return sizes

    monkeypatch.setattr(RepeatedRun, "fly", watched)
    require_as_recorded(experiment, runs)
    assert [status for each in statuses for status in each] == [DONE, REFUSED, DONE, DONE]


def test_nothing_else_of_a_beginning_may_differ(native_fmus: Path) -> None:
    """A run that differs in what the library has as common is not made by it."""
    experiment = experiment_of(STATUS, native_fmus)
    measuring = Measuring(experiment.plan, experiment.times)
    begins = {"plant.v.stop.stiffness": 1.0e6, "plant.v.position_start": 0.02}   # as above, so that the loop is there
    runs: list[Changes] = [{"plant.v.mass": 4.35, **begins},
                           {"plant.v.mass": 5.0, **begins, "controller.current_limit": 3.0}]
    with RepeatedRun(experiment, measuring=measuring) as repeated:
        repeated.widen(runs[0], build=True)
        found = repeated.measure(runs[:repeated.width])
        assert isinstance(found[0], Found)
        assert found[1] is None


ARENA = 10_000_000


def upwards_or_downwards(step: int) -> Callable[..., Any]:
    """Allocate rows one after the other, or each before the last."""
    arena, place = np.zeros(ARENA, np.uint8), [0 if step > 0 else ARENA]

    def allocate(_: object, shape: tuple[int, int], kind: type) -> Any:
        size = -(-shape[0] * shape[1] * np.dtype(kind).itemsize // 64) * 64
        first = place[0] if step > 0 else place[0] - size
        place[0] += step * size
        return arena[first:first + size].view(kind)[:shape[0] * shape[1]].reshape(shape)

    return allocate


def test_its_c_is_the_same_wherever_memory_lies(native_fmus: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The platform is fed by its controller and by signals: which is set first is no matter of addresses."""
    made_of: list[str] = []

    def key(*what: object) -> str:
        made_of.append(repr(what))
        return "none"

    monkeypatch.setattr(lane_loop, "key_of", key)
    experiment = experiment_of("3dof-push", native_fmus)
    for step in (1, -1):
        monkeypatch.setattr(Observer, "allocate", upwards_or_downwards(step))
        with RepeatedRun(experiment, measuring=Measuring(experiment.plan, experiment.times)) as repeated:
            repeated.widen({})
    assert made_of[0] == made_of[1]
