"""What a process that is not trusted says: values come through as they are, and nothing in a line is executed."""

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

from maglev.cosim.isolated_run import Wired, Work
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import CsvError, MaglevError, QuantityError, ScenarioError
from maglev.files.json_lines import line_of, value_of
from maglev.files.worker_process import Said, said_in
from pmlsm.motor_geometry import MotorGeometry

LEAVES = (st.none() | st.booleans() | st.integers() | st.floats() | st.text() | st.binary() |
          st.complex_numbers() | st.builds(Path, st.sampled_from(["a/b", "/c d", "ü"])))
VALUES = st.recursive(LEAVES, lambda inner: st.lists(inner) | st.tuples(inner, inner) |
                      st.dictionaries(st.text() | st.integers(), inner) | st.builds(Work, st.text(), st.text()))


def same(one: Any, other: Any) -> bool:
    """Whether two values are of the same type and, NaN or not, the same."""
    if type(one) is not type(other):
        return False
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    if isinstance(one, dict):
        return same(list(one.items()), list(other.items()))
    if isinstance(one, complex):
        return same([one.real, one.imag], [other.real, other.imag])
    if isinstance(one, float) and math.isnan(one):
        return math.isnan(other)
    return bool(one == other)


@given(VALUES)
def test_values_come_through(value: Any) -> None:
    line = line_of(value)
    assert line.endswith(b"\n") and b"\n" not in line[:-1]
    assert same(value_of(line), value)


@pytest.mark.parametrize("array", [np.arange(6.0).reshape(2, 3), np.array([1 + 2j, np.nan]), np.zeros((0, 4)),
                                   np.array(True), np.arange(3, dtype=np.uint8), np.arange(8.0)[::2]])
def test_arrays_come_through(array: Any) -> None:
    found = value_of(line_of(array))
    assert (found.dtype, found.shape, found.tobytes()) == (array.dtype, array.shape, array.tobytes())
    found[...] = 0   # it can be written to


@pytest.mark.parametrize("name", PACKAGED_STAGES)
def test_stages_and_parts_come_through(name: str) -> None:
    assert value_of(line_of(PACKAGED_STAGES[name])) == PACKAGED_STAGES[name]
    motor = MotorGeometry()
    motor.pole_pitch = 0.05
    assert value_of(line_of(motor)).electrical_angle(0.01) == motor.electrical_angle(0.01)


@pytest.mark.parametrize(("error", "kind"), [
    (ScenarioError("a key"), ScenarioError), (QuantityError("2 kilo"), QuantityError),
    (CsvError(Path("a.csv"), "no header"), MaglevError), (ZeroDivisionError("by zero"), RuntimeError),
    (FileNotFoundError(2, "No such file", "a.csv"), FileNotFoundError), (OSError("full"), OSError)])
def test_errors_keep_their_words(error: Exception, kind: type) -> None:
    error.add_note("a traceback")
    found = value_of(line_of(error))
    assert type(found) is kind
    assert str(found) == str(error) or isinstance(error, OSError)
    assert str(error).rpartition("] ")[2] in str(found)
    assert vars(found)["__notes__"] == ["a traceback"]


class Evil:
    """What would end this process where it is unpickled."""

    def __reduce__(self) -> Any:
        return __import__("os")._exit, (7,)


NOTHING_OF_OURS = [
    b"a line of my log\n", b"\n", b"7\n", b"{}\n", b'{"own": 7}\n', b'{"own": ["os", "stat_result", {}]}\n',
    b'{"own": ["maglev.files.worker_process", "WorkerProcess", {}]}\n',
    b'{"own": ["maglev.files.worker_process", "subprocess", {}]}\n',
    b'{"own": ["maglev.files.worker_process", "Path", {}]}\n',
    b'{"own": ["maglev.files.worker_process", "Said", {"kind": 1}]}\n',
    b'{"own": ["maglev.descriptions.packaged", "__name__", {}]}\n', b'{"own": ["maglev.nowhere", "Said", {}]}\n',
    b'{"array": ["O", [1], {"bytes": "AAAAAAAAAAA="}]}\n', b'{"array": ["<f8", [9], {"bytes": "AAAA"}]}\n',
    line_of(Said("interrupt", "gone")),
    b'{"own": ["maglev.files.worker_process", "Said", {"kind": "end", "what": 1}]}\n',
    *(b'{"own": ["maglev.cosim.isolated_run", "Stepped", {"done": %s, "steps": 3}]}\n' % done
      for done in (b'"1"', b"null", b"true", b"1.5", b"[]", b"1" * 30, b"1" * 5000)),
    b'{"own": ["maglev.cosim.isolated_run", "Stepped", {"done": 1}]}\n',
    b'{"own": ["maglev.cosim.isolated_run", "Wired", '
    b'{"initial": [], "phases": [1], "final": [], "columns": []}]}\n',
    b'{"complex": [%s, 0]}\n' % (b"1" * 400),
    b'{"error": ["Interrupted", ["now"], []]}\n', b'{"error": ["signal", ["now"], []]}\n', b'{"two": 1, "keys": 2}\n',
    b"[" * 100000 + b"\n", pickle.dumps(Evil()), b"\xff\xfe\n"]


@pytest.mark.parametrize("line", NOTHING_OF_OURS, ids=range(len(NOTHING_OF_OURS)))
def test_refuses_bytes_that_are_not_a_report(line: bytes) -> None:
    with pytest.raises(ValueError):
        said_in(line)


@given(st.binary())
def test_noise_is_refused(line: bytes) -> None:
    with pytest.raises(ValueError):
        said_in(line)


def test_a_value_that_has_no_plain_form_is_a_bug_where_it_is_said() -> None:
    with raises(TypeError, "Evil"):
        line_of(Said("result", Evil()))


def test_reports_come_through() -> None:
    wired = Wired([Work("a", "fmi2GetReal")], [[Work("b", "fmi2DoStep")]], [], [["a.x", "a.y"]])
    assert said_in(line_of(Said("report", wired))) == Said("report", wired)
