"""The stages that a process knows."""

from dataclasses import replace
from pathlib import Path

import pytest
from named_blocks import named_block

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.registry import STAGES, OwnStage, definitions
from maglev.descriptions.writer import page_texts
from maglev.linear.parameters import controllers, plants

MINE = replace(PACKAGED_STAGES["2dof"], name="mine")


def stage(folder: Path, mass: float) -> OwnStage:
    """A stage with its pages in a folder."""
    axis, *others = MINE.axes
    stage = replace(MINE, axes=(replace(axis, mass=mass), *others))
    for path, text in page_texts(stage).items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_text(text, encoding="utf-8")
    return OwnStage(stage, folder, folder / "mine.toml")


def test_from_the_first_to_the_last(tmp_path: Path) -> None:
    for folder, mass in (("first", 5.0), ("second", 6.0)):   # the second is instead of the first
        STAGES.add(stage(tmp_path / folder, mass))
        block = named_block("PlantMine")
        assert getattr(block, MINE.axis_names[0]).mass == mass
        assert [*STAGES.stages] == [*PACKAGED_STAGES, "mine"] and STAGES.own_of("StageMine") is STAGES.own["mine"]
        assert {*definitions(MINE)} <= {*STAGES.definitions()} and STAGES.systems()["StageMine"].name == "mine"
        assert "PlantMine" in plants() and "RegulatorMine" in controllers()
    STAGES.forget("mine", "mine", "2dof")
    assert STAGES.stages == PACKAGED_STAGES and STAGES.own_of("PlantMine") is None
    assert not {*definitions(MINE)} & {*STAGES.definitions(), *plants(), *controllers()}
    with pytest.raises(KeyError):
        STAGES.definition("PlantMine")
