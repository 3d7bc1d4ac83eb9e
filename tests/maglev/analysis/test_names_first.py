"""Names that a plant or a controller of ours does not have are refused before an FMU is built or a loop runs."""

from pathlib import Path
from typing import Any, Literal

import pytest
from facts import raises

import maglev
from maglev.files.errors import LinearModelError
from maglev.linear.loop import linearise_loop, openings_of
from maglev.linear.parameters import plants

AT = {"y": "25 mm"}


@pytest.fixture
def _nothing_is_built(monkeypatch: pytest.MonkeyPatch) -> None:
    def build(*_: Any) -> Path:
        raise AssertionError("built before the names were looked at")

    monkeypatch.setattr("maglev.analysis.pair.fmus_named", build)


@pytest.mark.usefixtures("_nothing_is_built")
@pytest.mark.parametrize(("call", "facts"), [
    (lambda: maglev.linearise_numerically("Plant3DOF", "mine.py", AT, openings=["alpha.q"]), ["'alpha.q'"]),
    (lambda: maglev.linearise_numerically("plant.fmu", "PID3DOF", {"v": "25 mm"}), ["'v'"]),
    (lambda: maglev.linearise_numerically("Plant3DOF", "mine.py", AT, plant_parameters={"y.mas": 1}),
     ["Plant3DOF", "'y.mas'", "'y.mass'"]),
    (lambda: maglev.linearise_numerically("Plant3DOF", "PID3DOF", AT, controller_parameters={"gain": 1}),
     ["PID3DOF", "'gain'"]),
    (lambda: maglev.frequency_response("Plant3DOF", "mine.py", AT, ["q"]), ["'q'", "y.measured"]),
    (lambda: maglev.frequency_response("Plant3DOF", "mine.py", AT, ["alpha.i_a"]), ["'alpha.i_a'", "y.measured"])])
def test_wrong_names_are_refused_first(call: Any, facts: list[str]) -> None:
    with raises(LinearModelError, *facts):
        call()


@pytest.mark.parametrize(("stage", "at", "measurement"), [
    ("2DOF", {"v": "20 mm"}, None), ("3DOF", AT, "Measurement3DOF"), ("5DOF", AT, None)])
def test_openings_follow_from_the_stage(stage: str, at: dict[str, str], measurement: str | None) -> None:
    loop = linearise_loop(f"Plant{stage}", f"Regulator{stage}", at, measurement=measurement)
    currents: Literal["dq", "phases"] = "dq" if measurement is None else "phases"
    assert set(openings_of(plants()[f"Plant{stage}"], currents)) == set(loop.openings)
