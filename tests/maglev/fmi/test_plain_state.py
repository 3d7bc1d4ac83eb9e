"""State of a user's object: comes through JSON as it is, and nothing that stands there is executed."""

import json
import pickle
import random
import sys
from collections import deque
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

from maglev.fmi.plain_state import NotPlain, read_state, written_state
from maglev.fmi.slave import Refused
from maglev.fmi.user_slave import WrittenSlave

LEAVES = (st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text() | st.binary() |
          st.complex_numbers(allow_nan=False))
KEYS = st.integers() | st.text() | st.tuples(st.integers(), st.text())
VALUES = st.recursive(LEAVES, lambda inner: st.lists(inner) | st.tuples(inner, inner) | st.dictionaries(KEYS, inner) |
                      st.sets(KEYS) | st.frozensets(KEYS) | st.lists(inner).map(lambda made: deque(made, 9)))
HERE = Path(__file__).parent


class Mode(Enum):
    OFF = 0
    ON = 1


class Ring:
    """A part of a user's object."""

    def __init__(self, values: list[float]) -> None:
        self.values = values
        self.owner: Any = self
        self.mode = Mode.ON


def through(value: Any) -> Any:
    """The value after it was text."""
    return read_state(json.loads(json.dumps(written_state((value,), "value"))), HERE)[0]


@given(VALUES)
def test_values_come_through(value: Any) -> None:
    assert through(value) == value and type(through(value)) is type(value)


def test_objects_come_through_once_each() -> None:
    values = [1.0, float("inf")]
    ring, values_again, mode = through([Ring(values), values, Mode.OFF])
    assert type(ring) is Ring and ring.owner is ring and ring.values is values_again
    assert (values_again, ring.mode, mode) == (values, Mode.ON, Mode.OFF)


def test_generators_and_arrays_come_through() -> None:
    generator = random.Random(3)
    generator.random()
    again = through(generator)
    assert [again.random() for _ in range(3)] == [generator.random() for _ in range(3)]
    array = np.arange(6.0).reshape(2, 3)[:, ::2]
    found = through({"array": array, "number": np.float32(0.1)})
    assert found["array"].tobytes() == array.tobytes() and found["array"].shape == (2, 2)
    found["array"][0, 0] = 9.0
    assert type(found["number"]) is np.float32 and found["number"] == np.float32(0.1)


@pytest.mark.parametrize("value", [print, sys, Ring, np.array([None]), pickle.Pickler, iter([])], ids=range(6))
def test_names_what_has_no_plain_form(value: Any) -> None:
    with raises(NotPlain, "vars(self)['held']"):
        written_state(({"held": value},), "vars(self)")


@pytest.mark.parametrize("objects", [
    [["own", "subprocess", "Popen", []]], [["own", "maglev.fmi.slave", "BlockSlave", []]],
    [["own", __name__, "Path", []]], [["own", __name__, "through", []]], [["own", __name__, "a.b", []]],
    [["array", "|O8", [1], "AAAAAAAAAAA="]], [["array", "<f8", [9], "AAAA"]], [["eval", "1"]], [["list", 7]], [7], 7,
    [["list", [{"object": 5}]]], [["list", [{"enum": ["os", "environ", "PATH"]}]]], [["list", [[1]]]]], ids=range(14))
def test_refuses_text_that_no_state_has(objects: Any) -> None:
    with pytest.raises(NotPlain):
        read_state({"value": {"tuple": [{"object": 0}]}, "objects": objects}, HERE)


class Part:
    """A part of a slave."""


class Evil:
    """What would end this process where it is unpickled."""

    def __reduce__(self) -> Any:
        return __import__("os")._exit, (7,)


def slave() -> Any:
    """A slave with a user's object, without the binary around it."""
    made = object.__new__(WrittenSlave)
    made.written, made.state_slots, made.setters = Ring, [], {}
    made.phase, made.stale = "after the initialization", False
    made.next_time, made.stop_time = 0.0, 1.0
    made.block = Part()
    made.block.law, made.block.clock = Ring([1.0]), Part()
    return made


def test_a_slave_takes_its_own_state_and_no_other() -> None:
    one, other = slave(), slave()
    one.block.law.values.append(2.0)
    text = one._fmu_state_to_bytes(one._get_fmu_state())
    other._set_fmu_state(other._fmu_state_from_bytes(text))
    assert other.block.law.values == [1.0, 2.0] and other.block.law.owner is not one.block.law
    for forged in (pickle.dumps(Evil()), b"\xff", b"[]", text.replace(b'"Ring"', b'"Popen"'),
                   text.replace(b'"block"', b'"bloc"'), text.replace(b"after the init", b"before the init")):
        with pytest.raises(Refused):
            other._set_fmu_state(other._fmu_state_from_bytes(forged))
        assert other.block.law.values == [1.0, 2.0]
