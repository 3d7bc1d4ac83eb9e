"""Numbers in environment variables: what is none is refused in one line, what is empty counts as not set."""

import os
import subprocess
import sys

import pytest

from maglev_files.environment import DATE, MOST_UNPACKED, NUMBERS, number_in


@pytest.mark.parametrize("variable", NUMBERS)
@pytest.mark.parametrize("text", ["1e9", "-1", " 1", "0x10", "9" * 40, "٣", "many"])
def test_what_is_no_whole_number_is_refused(variable: str, text: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(variable, text)
    with pytest.raises(ValueError, match="expected (seconds|bytes)") as refusal:
        number_in(variable)
    assert f"{variable} = {text!r}" in str(refusal.value)


@pytest.mark.parametrize("variable", NUMBERS)
def test_an_empty_one_is_the_default(variable: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(variable, "")
    assert number_in(variable) == NUMBERS[variable].default


def maglev_with(**variables: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-m", "maglev", "list"], capture_output=True, text=True, timeout=120.0,
                          env={**os.environ, **variables}, check=False)


def test_commands_say_it_in_one_line() -> None:
    done = maglev_with(**{MOST_UNPACKED: "1e9"})
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert done.stderr.startswith(f"maglev: {MOST_UNPACKED} = '1e9', expected bytes")
    assert maglev_with(**{DATE: ""}).returncode == 0
