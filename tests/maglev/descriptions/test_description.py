"""Descriptions of stages: what they may say, and how a mistake in one is refused."""

from pathlib import Path

import pytest
from facts import raises

from maglev.descriptions.description_file import PACKAGED, read_stage
from maglev.files.errors import StageError

TEXT = (PACKAGED / "3dof.toml").read_text(encoding="utf-8")


@pytest.mark.parametrize(("old", "new", "facts"), [
    ('mass = "6.9 kg"', 'mass = "6.9 m"', ["axes.y.mass", "'6.9 m'", "kg"]),
    ('mass = "6.9 kg"', 'mass = nan', ["axes.y.mass", "nan"]), ('mass = "6.9 kg"', '', ["axes.y.mass", "missing"]),
    ('drives = "z"', 'drives = "w"', ["motors.beta.drives", "'w'", "x, z"]),
    ('drives = "z"', 'drives = "x"', ["axes.z", "no motor"]),
    ('start = "25 mm"', 'start = "5 mm"', ["axes.y.start", "0.005 m", "0.0185", "0.032 m"]),
    ("pid = [-7.0, -10.0, 42.0]", "pid = [-7.0]", ["axes.y.design.pid", "[-7.0]", "3 numbers"]),
    ("thrust = { x = 0.6135, z = 0.8224 }\nattraction = 334.52", "thrust = { x = 0.6135 }\nattraction = 334.52",
     ["plant.thrust", "x", "x, z"]),
    ("antiwindup = true", 'antiwindup = "yes"', ["design.antiwindup", "'yes'", "true", "false"]),
    ('name = "3dof"', 'name = "3 dof"', ["name", "'3 dof'", "_"]),
    ("[design]", "[geometry]\npole_pich = 0.06\n\n[design]", ["geometry.pole_pich", "'pole_pitch'"]),
    ("[design]", "[geometry]\nslot_pitch = 0\n\n[design]", ["geometry.slot_pitch", "0 m", "0.0001", "1 m"]),
    ("[design]", '[geometry]\npole_pitch = "57 g"\n\n[design]', ["geometry.pole_pitch", "'57 g'", "m"]),
    ("sharing = 2", "sharing = 1.5", ["sharing", "1.5", "whole number"]),
    ('spacing = "1 mm"', 'spacing = "2 mm"', ["design.table", "0.018", "0.046 m", "0.008", "0.04 m"]),
    ("[plant]", '[motor_stop]\nlower = "18 mm"\nupper = "32 mm"\n\n[plant]', ["motor_stop"]),
    *(("[motors.beta]", f"[motors.{name}]", [f"motors.{name}", f"'{name}'"])
      for name in ("gamma", "lambda", "double", "z", "time")),
    ('title = "3-DOF stage"', "title = 'the \"fast\" stage'", ["title", "'the \"fast\" stage'", '"', "\\", "/*", "*/"]),
    ('equation = "(5.3)"', 'equation = """(5.3)\nimport os"""', ["equation", "'(5.3)\\nimport os'", "one line"]),
    ("[axes.y]", "[axes.Y]", ["axes", "'Y'", "lower-case"])])
def test_a_mistake_is_refused_in_one_line(tmp_path: Path, old: str, new: str, facts: list[str]) -> None:
    assert old in TEXT
    path = tmp_path / "mine.toml"
    path.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    with raises(StageError, path, *facts):
        read_stage(path)


def test_a_platform_that_tilts_has_no_gain_schedule(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text((PACKAGED / "5dof.toml").read_text(encoding="utf-8") + "\n[design.schedule]\n"
                    "bounds = [0.026, 0.024, 0.022]\nsetpoints = [0.027, 0.025, 0.023, 0.021]\n", encoding="utf-8")
    with raises(StageError, path, "design.schedule"):
        read_stage(path)


def test_every_value_has_a_source() -> None:
    """Of those that do not name one, it is an assumption."""
    stage = read_stage(PACKAGED / "3dof.toml")
    assert stage.source("axes.y.mass") == "stated, Table 5.1"
    assert stage.source("axes.y.friction.coulomb").startswith("estimated")
    assert stage.source("axes.y.friction.viscous") == "assumed"
    assert stage.source("motors.alpha.amplifier.peak") == stage.source("motors.alpha.amplifier")


@pytest.mark.parametrize(("start", "end", "facts"), [
    ("[motor_stop]", "# Half", ["motor_stop", "missing"]), ("[axes.pitch]", "# Stops", ["axes", "y, x, z, roll"]),
    ('stop = { lower = "-62', "\n", ["axes.x.stop", "missing"])])
def test_what_a_platform_that_tilts_needs(tmp_path: Path, start: str, end: str, facts: list[str]) -> None:
    """Without one of its parts, which reaches from its start to an end."""
    text = (PACKAGED / "5dof.toml").read_text(encoding="utf-8")
    before, _, rest = text.partition(start)
    path = tmp_path / "mine.toml"
    path.write_text(before + end + rest.partition(end)[2], encoding="utf-8")
    with raises(StageError, path, *facts):
        read_stage(path)
