"""The stages that a process knows."""

from dataclasses import replace
from pathlib import Path

import pytest
from named_blocks import named_block

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.registry import OwnStage, definitions, known_stages
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
    stages = known_stages()
    for folder, mass in (("first", 5.0), ("second", 6.0)):   # the second is instead of the first
        stages.add(stage(tmp_path / folder, mass))
        block = named_block("PlantMine")
        assert getattr(block, MINE.axis_names[0]).mass == mass
        assert [*stages.stages] == [*PACKAGED_STAGES, "mine"] and stages.own_of("StageMine") is stages.own["mine"]
        assert {*definitions(MINE)} <= {*stages.definitions()} and stages.systems()["StageMine"].name == "mine"
        assert "PlantMine" in plants() and "RegulatorMine" in controllers()
    stages.forget("mine", "mine", "2dof")
    assert stages.stages == PACKAGED_STAGES and stages.own_of("PlantMine") is None
    assert not {*definitions(MINE)} & {*stages.definitions(), *plants(), *controllers()}
    with pytest.raises(KeyError):
        stages.definition("PlantMine")
