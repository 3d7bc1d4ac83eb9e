"""Pages of a stage: the equations that stand there are those of its blocks, for any number of motors and axes."""

import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from facts import raises

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.descriptions.writer import PAGES, written_page
from maglev.fmi.documentation import block_section, typeset
from pmlsm.stage_description import StageDescription, StageMotor
from pmlsm.velocity_rows import GRAVITY, normal_acceleration, thrust_term

AMPLIFIER = PACKAGED_STAGES["3dof"].motors[0].amplifier
MOTORS = tuple(StageMotor(name, drives, AMPLIFIER) for name,
               drives in (("left", "x"), ("right_2", "x"), ("alpha", "z")))
UNEVEN = replace(PACKAGED_STAGES["3dof"], name="uneven", title="R&D stage", sharing=3.0, motors=MOTORS, equation="",
                 sources={})
STAGES = pytest.mark.parametrize("stage", [*PACKAGED_STAGES.values(), UNEVEN], ids=lambda stage: stage.name)
STAGE, LINEARISATION, *_ = PAGES

F = {"f_1": 0.3, "f_2": 0.02, "f_3": 0.11, "f_4": 0.7}
SYMBOL = re.compile(r"[A-Za-z]_(?:\{[^{}]*(?:\{\w+\})?\}|\w)|G|\d+")


def currents(stage: StageDescription) -> dict[str, tuple[str, float]]:
    """TeX and value (A) of every current, by its name."""
    greek = ("alpha", "beta")
    subscripts = {motor: "" if len(stage.motors) == 1 else rf"\{motor}" if motor in greek
                  else rf",\mathrm{{{motor.replace('_', '')}}}" for motor in stage.motor_names}
    return {f"{motor}.i_{each}": (f"i_{{{each}{text}}}" if text else f"i_{each}", 0.3 + 0.7 * k + 0.2 * (each == "d"))
            for k, (motor, text) in enumerate(subscripts.items()) for each in ("q", "d")}


def value(tex: str, stage: StageDescription) -> float:
    """Right side of an equation without the disturbance Δ."""
    text = re.sub(r"\+ \\Delta_\S+", "", tex.partition(" = ")[2])
    known = {**F, "G": GRAVITY, **dict(currents(stage).values()),
             **{f"C_{constant.name[1:]}": constant.plant for constant in stage.constants}}
    numbers = SYMBOL.sub(lambda found: repr(known.get(found[0]) or float(found[0])), text.replace("^2", "**TWO"))
    return float(eval(re.sub(r"(?<=[\d)]) (?=[\d(])", "*", numbers), {"TWO": 2}))


@STAGES
def test_the_equations_are_those_of_the_parts(stage: StageDescription) -> None:
    vertical, *horizontal = re.findall(r"\\\[(.+)\\\]", written_page(STAGE, stage))
    attraction, coils, iron = (constant.plant for constant in stage.constants[-3:])
    i = {name: current for name, (_, current) in currents(stage).items()}
    direct = sum(current for name, current in i.items() if name.endswith("d"))
    # Normal accelerations of the parts are downwards and have the gravity in them.
    assert value(vertical, stage) == pytest.approx(normal_acceleration(
        stage.carrying * attraction, stage.sharing * coils, stage.sharing * iron, F["f_2"], F["f_3"], F["f_4"],
        direct, sum(current**2 for current in i.values())), rel=1e-12)
    assert len(horizontal) == len(stage.horizontal)
    for tex, axis, constant in zip(horizontal, stage.horizontal, stage.constants, strict=False):
        quadrature = sum(i[f"{motor.name}.i_q"] for motor in stage.motors_of(axis.name))
        assert value(tex, stage) == pytest.approx(
            thrust_term(stage.sharing * constant.plant, F["f_1"], quadrature), rel=1e-12)


@STAGES
@pytest.mark.parametrize("path", PAGES)
def test_pages_are_well_formed_with_every_equation_typeset(stage: StageDescription, path: str) -> None:
    page = typeset(written_page(path, stage))
    assert "\\" not in page and "()" not in page and "  " not in page.replace("\n", " ")
    ElementTree.fromstring(f"<body>{page}</body>")


def test_equal_currents_of_the_motors_of_an_axis() -> None:
    page = written_page(LINEARISATION, UNEVEN)
    assert r"\[i_{q,\mathrm{left}} = i_{q,\mathrm{right2}} = -\frac{v_x}{6 C_1 f_1}" in page
    assert r"(2 i_{q,\mathrm{left}}^2 + i_{q\alpha}^2 + 3 i_d^2) + 9 C_4 f_3 i_d - 9 C_3 f_2 = v_y" in page


def test_a_section_of_a_stage_of_the_users(tmp_path: Path) -> None:
    file = tmp_path / "plant_fmu" / "documentation" / "own.html"
    file.parent.mkdir(parents=True)
    file.write_text("<h2>Mine</h2>\n", encoding="utf-8")
    assert block_section([tmp_path], "plant_fmu", "own.html") == "<h2>Mine</h2>"
    assert block_section([tmp_path], "plant_fmu", "effects.html").startswith("<h2>")
    with raises(FileNotFoundError, "own.html"):
        block_section([], "plant_fmu", "own.html")
