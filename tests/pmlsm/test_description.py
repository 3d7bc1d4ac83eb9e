"""A description as the text that FMUs carry."""

from collections.abc import Callable
from dataclasses import replace
from math import nextafter, pi

import pytest

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.registry import definitions
from maglev.language.sources import carried_modules
from pmlsm.description_text import from_text, to_text
from pmlsm.stage_description import MotorKind, StageDescription

KIND = MotorKind({"pole_pitch": 0.048, "field.B3": -1e-300}, 1.3, 0.9, 1.1, 0.8, 0.7)


def unlike(stage: StageDescription) -> StageDescription:
    """A stage with a motor of another kind, and numbers that a shorter text would not give back."""
    first, *others = stage.motors
    return replace(stage, motors=(replace(first, kind=KIND), *others), sample_time=nextafter(1e-3, 1.0), height=-0.0,
                   title="µ \"quoted\" \\ and 'more'\u2028", sources={"axes": "pages 3 to 5"}, modulation=1.0 / pi)


@pytest.mark.parametrize("name", PACKAGED_STAGES)
@pytest.mark.parametrize("changed", [lambda stage: stage, unlike])
def test_text_gives_the_description_back_exactly(
        name: str, changed: Callable[[StageDescription], StageDescription]) -> None:
    stage = changed(PACKAGED_STAGES[name])
    assert repr(from_text(to_text(stage))) == repr(stage)


@pytest.mark.parametrize("name", PACKAGED_STAGES)
def test_definition_that_an_fmu_carries_has_the_description_as_data(name: str) -> None:
    stage = unlike(PACKAGED_STAGES[name])
    for made in definitions(stage).values():
        carried: dict[str, object] = {}
        exec(made.text(), carried)
        assert repr(carried["STAGE"]) == repr(stage)
        break


def test_reading_a_description_takes_nothing_but_the_standard_library_and_the_motor() -> None:
    modules = carried_modules("pmlsm.description_text", ("pmlsm", "maglev"))
    assert {*modules} == {
        "pmlsm.description_text", "pmlsm.stage_description", "pmlsm.motor_geometry", "pmlsm.magnet_field"}
