"""Numbers in environment variables: what is none is refused in one line, what is empty counts as not set."""

import os
import subprocess
import sys

import pytest
from facts import raises

from maglev.files.environment import DATE, MOST_UNPACKED, NUMBERS, number_in


@pytest.mark.parametrize("variable", NUMBERS)
@pytest.mark.parametrize("text", ["1e9", "-1", " 1", "0x10", "9" * 5000, "٣", "²", "many"])
def test_refuses_a_value_that_is_not_whole(variable: str, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(variable, text)
    with raises(ValueError, variable, repr(text), NUMBERS[variable].what):
        number_in(variable)


@pytest.mark.parametrize("variable", NUMBERS)
def test_an_empty_one_is_the_default(variable: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(variable, "")
    assert number_in(variable) == NUMBERS[variable].default


@pytest.mark.parametrize("variable", NUMBERS)
def test_numbers_are_below_a_limit(variable: str, monkeypatch: pytest.MonkeyPatch) -> None:
    limit = NUMBERS[variable].limit
    for number in (0, limit - 1):
        monkeypatch.setenv(variable, str(number))
        assert number_in(variable) == number
    monkeypatch.setenv(variable, str(limit))
    with raises(ValueError, variable, repr(str(limit))):
        number_in(variable)


def linearised_with(**variables: str) -> subprocess.CompletedProcess[str]:
    """A command that imports SciPy, and with that a module of NumPy that makes a number of the date, empty or not."""
    return subprocess.run([sys.executable, "-m", "maglev", "linearise", "Plant2DOF", "--at", "v=20mm"], text=True,
                          capture_output=True, timeout=120.0, env={**os.environ, **variables}, check=False)


@pytest.mark.usefixtures("slow")
@pytest.mark.parametrize(("variable", "text"), [(MOST_UNPACKED, "1e9"), (DATE, "soon")])
def test_commands_say_it_in_one_line(variable: str, text: str) -> None:
    done = linearised_with(**{variable: text})
    assert (done.returncode, done.stdout, done.stderr) == (
        2, "", f"maglev: {variable} = {text!r}, expected {NUMBERS[variable].what}\n")


@pytest.mark.usefixtures("slow")
def test_commands_go_on_where_both_are_empty() -> None:
    done = linearised_with(**dict.fromkeys(NUMBERS, ""))
    assert (done.returncode, done.stderr) == (0, "")
    assert "v.position" in done.stdout
