"""Instances of FMI 3.0 FMUs by plain steps, with event mode and with a clock: their states, and many at a time."""

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from pathlib import Path

import pytest
from event_mode import Instance, unpacked

WAYS = {"steps": ("fmi3_fmus", "Plant3DOF"), "events": ("fmi3_fmus", "Regulator3DOF"),
        "clock": ("clocked_fmus", "Regulator3DOF")}


@pytest.fixture(params=WAYS)
def new(slow: None, request: pytest.FixtureRequest, tmp_path: Path) -> partial[Instance]:
    """Function that makes an instance of one library."""
    fmus, name = WAYS[request.param]
    return partial(Instance, unpacked(request.getfixturevalue(fmus) / f"{name}.fmu", tmp_path),
                   events=request.param != "steps")


def test_a_state_before_each_call(new: partial[Instance]) -> None:
    """A sample is due, its clock active, it is taken, between samples: restored there, and in another instance."""
    one, other = new().begin(), new(number=1).begin()
    one.run(0, 3)
    states, returned = [], []
    for call in one.calls(3):
        states.append((one.fmu.getFMUState(), one.state()))
        returned.append(call())
    later = one.run(4, 3)
    end = one.state()
    assert len({data for _, data in states}) == len(states)
    other.number = one.number
    for k, (state, data) in enumerate(states):
        one.fmu.setFMUState(state)
        other.fmu.setFMUState(other.fmu.deserializeFMUState(data))
        for each in (one, other):
            assert each.state() == data
            assert [call() for call in each.calls(3)[k:]] == returned[k:]
            assert each.run(4, 3) == later
            assert each.state() == end
    altered = data[:-1] + bytes([data[-1] ^ 1])
    assert "that this FMU has written" in one.refusal(lambda: one.fmu.deserializeFMUState(altered))


@pytest.mark.few(1)
def test_50_instances_in_four_threads(new: partial[Instance]) -> None:
    """Each does what it does alone; ctypes lets them run at the same time."""
    def simulated(one: Instance) -> tuple[list[object], bytes]:
        found = one.run(0, 40), one.state()
        one.fmu.freeInstance()
        return found

    expected = [simulated(new(number=k).begin()) for k in range(50)]
    many = [new(number=k).begin() for k in range(50)]
    assert len({one.fmu.dll._handle for one in many}) == 1, "expected instances of one library"
    with ThreadPoolExecutor(4) as pool:
        assert list(pool.map(simulated, many)) == expected
    assert len({state for _, state in expected}) == 50


def test_a_state_of_an_instance_of_the_other_sort_is_refused(fmi3_fmus: Path, tmp_path: Path) -> None:
    folder = unpacked(fmi3_fmus / "Regulator3DOF.fmu", tmp_path)
    plain, with_events = (Instance(folder, events=events).begin() for events in (False, True))
    for of, to, said in ((plain, with_events, "without event mode, expected one with it"),
                         (with_events, plain, "with event mode, expected one without it")):
        state, before = to.fmu.deserializeFMUState(of.state()), to.state()
        assert to.refusal(partial(to.fmu.setFMUState, state)) == f"state of an instance {said}"
        assert to.state() == before
