"""Descriptions of stages of one's own: data sheets, fields, poles, and how mistakes in them are refused."""

import re
import warnings
from dataclasses import replace
from functools import cache
from math import exp, sqrt
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest
from facts import raises
from hypothesis import given, settings
from hypothesis import strategies as st
from named_blocks import named_block

from maglev.descriptions.data_sheet import Field, Winding, field_geometry, formulas
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import MaglevError, StageError
from maglev.linear.design import regulator_polynomial
from maglev.scenario.layers import PACKAGED as SCENARIOS
from maglev.scenario.layers import merged, read_layers
from maglev.user.gain_design import OMEGA0, held, stiffness
from maglev.user.new_stage import new_stage
from maglev.user.reading import read_own
from maglev.user.scenario_loop import loop_table
from pmlsm.motor_geometry import MotorGeometry

WINDING = Winding(turns=900.0, pole_pairs=3.0, magnets=4.0, magnet_width=28.58e-3, length=50e-3, coercivity=875.4e3)


def changed(path: Path, like: str, *changes: tuple[str, str]) -> Path:
    """Description that begins like a stage's, with other texts instead of some."""
    new_stage(path, like)
    text = path.read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("like", PACKAGED_STAGES)
def test_a_new_stage_is_the_one_that_it_is_like(tmp_path: Path, like: str) -> None:
    """Its data sheet is turned back into the constants that it was written from; z of the 3-DOF stage has x's motor."""
    stage, own = PACKAGED_STAGES[like], read_own(changed(tmp_path / "own.toml", like))
    first = stage.horizontal[0].name
    assert own.plant.thrust[first] == pytest.approx(stage.plant.thrust[first], rel=1e-3)
    for name in ("attraction", "coils", "iron"):
        assert getattr(own.plant, name) == pytest.approx(getattr(stage.plant, name), rel=1e-3)
    gaps = np.linspace(0.008, 0.04, 50)
    fields = [[each.motor().field.value(gap) for gap in gaps] for each in (own, stage)]
    assert fields[0] == pytest.approx(fields[1], rel=5e-3)
    assert (own.axis_names, own.motor_names, own.sharing) == (stage.axis_names, stage.motor_names, stage.sharing)
    assert own.motors == stage.motors
    for name in ("height", "motor_stop", "sample_time", "modulation", "resolution"):
        assert getattr(own, name) == getattr(stage, name)
    for name in ("mass", "start", "stop", "rotation", "bias", "friction", "ripple", "roughness", "mode"):
        assert [getattr(axis, name) for axis in own.axes] == [getattr(axis, name) for axis in stage.axes]


def test_one_line_makes_the_guides_of_an_axis_rough(tmp_path: Path) -> None:
    from maglev.user.adoption import know_stage

    stop = "stop = { lower = -0.07"   # in the table of h
    end = f"correlation = 0.002 }}   # m/s², m; of the guides, random along the way\n{stop}"
    know_stage(changed(tmp_path / "rough.toml", "2dof", (f"rms = 0.0, {end}", f"rms = 0.3 }}\n{stop}")))
    stage = named_block("PlantRough")
    assert stage.start() == 0
    assert (stage.v.roughness.rms, stage.h.roughness.rms, stage.h.roughness.correlation) == (0.0, 0.3, 2e-3)
    assert stage.h.roughness.acceleration(0.01) != stage.h.roughness.acceleration(0.0)


def test_what_a_data_sheet_says_is_what_the_stage_does(tmp_path: Path) -> None:
    """Forces of the block, not of the formulas: N/A, N, per peak; and per rms they are as many times smaller."""
    from maglev.user.adoption import know_stage

    for name, currents, factor in (("peaks", "peak", 1.0), ("effective", "rms", 1.0 / sqrt(2.0))):
        know_stage(changed(tmp_path / f"{name}.toml", "2dof", ('currents = "peak"', f'currents = "{currents}"'),
                      ("force_constant = 10.65 ", "force_constant = 30.0 "),
                      ("attraction = 38.95 ", "attraction = 50.0 "),
                      ("attraction_gap = 0.02 ", "attraction_gap = 0.022 ")))
        stage = named_block(f"Plant{name.capitalize()}")
        stage.start()
        stage.attraction_modulation = stage.h.bias = stage.v.bias = 0.0
        stage.h.begin()
        stage.v.begin()
        stage.motor.i_q = 1.0
        stage.add_slope(0.0, 0.0)
        assert stage.h.acceleration * 1.594 == pytest.approx(-30.0 * factor)
        stage.motor.i_q, stage.v.position = 0.0, 0.022
        stage.add_slope(0.0, 0.0)
        assert (9.81 - stage.v.acceleration) * 4.35 == pytest.approx(50.0)


def test_formulas_of_the_thesis_are_off_by_factors() -> None:
    """As the documentation says: of what was identified on the two stages."""
    thrust, attraction, coils, iron = formulas(WINDING, MotorGeometry())
    two, three = PACKAGED_STAGES["2dof"], PACKAGED_STAGES["3dof"]
    assert thrust / two.axes[1].mass / two.plant.thrust["h"] == pytest.approx(3.1, abs=0.05)
    assert thrust / three.axes[1].mass / three.plant.thrust["x"] == pytest.approx(10.8, abs=0.05)
    assert thrust / three.axes[2].mass / three.plant.thrust["z"] == pytest.approx(9.9, abs=0.05)
    for stage, factors in ((two, (0.66, 0.63, 14.0)), (three, (0.985, 1.41, 230.0))):
        found = [attraction / stage.plant.attraction, coils / stage.plant.coils, iron / stage.plant.iron]
        assert [each / stage.vertical.mass for each in found] == pytest.approx(factors, rel=0.03)


def test_what_a_data_sheet_leaves_out_is_of_the_right_size(tmp_path: Path) -> None:
    """Coils by virtual work and iron by the square of the sum of the fields, against what was identified."""
    for like, coils, iron in (("2dof", 0.83, 2.5), ("3dof", 0.58, 13.0)):
        path = changed(tmp_path / f"less{like}.toml", like)
        lines = [line for line in path.read_text(encoding="utf-8").split("\n")
                 if not line.startswith(("direct_constant", "iron_attraction"))]
        path.write_text("\n".join(lines), encoding="utf-8")
        own, stage = read_own(path), PACKAGED_STAGES[like]
        assert own.plant.coils / stage.plant.coils == pytest.approx(coils, rel=0.05)
        measured = own.plant.coils**2 / (4.0 * own.plant.attraction)
        assert own.plant.iron == pytest.approx(measured)
        square = stage.plant.coils**2 / (4.0 * stage.plant.attraction)
        assert square / stage.plant.iron == pytest.approx(iron, rel=0.05)


def test_an_exponential_field_is_met_by_its_polynomial() -> None:
    motor = replace(PACKAGED_STAGES["3dof"],
                    geometry=field_geometry("field", Field(5e-3, 30e-3, B0=0.4, decay=9e-3))).motor()
    for gap in np.linspace(5e-3, 30e-3, 23):
        assert motor.field.value(gap) == pytest.approx(0.4 * exp(-gap / 9e-3), rel=1e-6)


def test_a_table_of_a_field_is_met_by_its_polynomial() -> None:
    gaps = tuple(np.linspace(5e-3, 30e-3, 11))
    given = Field(5e-3, 30e-3, gaps=gaps, B=tuple(0.4 * exp(-gap / 9e-3 - (gap / 20e-3)**2) for gap in gaps))
    motor = replace(PACKAGED_STAGES["3dof"], geometry=field_geometry("field", given)).motor()
    for gap, value in zip(given.gaps, given.B, strict=True):
        assert motor.field.value(gap) == pytest.approx(value, rel=0.01)


def test_poles_become_gains(tmp_path: Path) -> None:
    own = read_own(changed(tmp_path / "own.toml", "3dof", ("# poles = [-90, [-4, 6], [-2, 2]]",
                                                           "poles = [-80, [-5, 7], [-3, 1]]")))
    wanted = np.poly([-80, -5 + 7j, -5 - 7j, -3 + 1j, -3 - 1j]).real
    assert regulator_polynomial(own.vertical.design.gains, OMEGA0) == pytest.approx(wanted)


@pytest.mark.parametrize(("old", "new", "facts"), [
    ("# poles = [-90, [-4, 6], [-2, 2]]", "poles = [-90, [-4, 6]]", ["axes.y.design.poles", "[-90, [-4, 6]]", "five"]),
    ("# poles = [-90, [-4, 6], [-2, 2]]", "poles = [-90, [-4, 6], [2, 2]]",
     ["axes.y.design.poles", "[-90, [-4, 6], [2, 2]]", "below 0"]),
    ('currents = "peak"', 'currents = "mean"', ["catalogue.currents", "'mean'", "'rms'", "'peak'"]),
    ("force_constant", "forceconstant", ["catalogue.forceconstant", "'force_constant'"]),
    ("force_constant = 2.313 ", 'force_constant = "2.3 N" ', ["catalogue.force_constant", "'2.3 N'", "N/A"]),
    ("force_constant = 2.313 ", "# ", ["catalogue.force_constant", "missing", "[catalogue.winding]"]),
    ("at = 0.025 ", "at = 0.06 ", ["catalogue.at", "60 mm", "8…40 mm"]),
    ("[catalogue]\n", "[plant]\n[catalogue]\n", ["plant", "[catalogue]"]),
    ("lower = 0.008\n", "lower = 0.004\n", ["field", "8 to 40 mm", "4 mm"]),
    ("0.26967", "2.6967", ["field", "degree 12", "8 mm", "1%"]),
    ("gaps = [", "B0 = 0.3\ndecay = 0.01\ngaps = [", ["field", "B0", "decay", "gaps", "B", "coefficients"])])
def test_mistakes_are_refused_in_one_line(tmp_path: Path, old: str, new: str, facts: list[str]) -> None:
    path = changed(tmp_path / "own.toml", "3dof", (old, new))
    with raises(StageError, path, *facts):
        read_own(path)


def test_its_linear_model_has_its_own_geometry(tmp_path: Path) -> None:
    """Thrust per current and stiffness of a stage with another pole pitch, by differences of what a plant does."""
    from maglev.linear.linearise import linearise
    from maglev.user.adoption import know_stage

    know_stage(changed(tmp_path / "own.toml", "2dof", ("pole_pitch = 0.05715", "pole_pitch = 0.03")))
    model = linearise("PlantOwn", {"v": 0.02})
    plant = named_block("PlantOwn")
    plant.start()
    plant.encoder.resolution = 0.0

    def moved(gap: float, quadrature: float) -> tuple[float, float]:
        plant.v.begin()
        plant.h.begin()
        plant.v.position = gap
        plant.motor.i_d, plant.motor.i_q = model.equilibrium.i_d[0], quadrature
        plant.add_slope(0.0, 0.0)
        return float(plant.v.acceleration), float(plant.h.acceleration)

    by_current = (moved(0.02, 1.0)[1] - moved(0.02, -1.0)[1]) / 2.0
    by_gap = (moved(0.02 + 1e-6, 0.0)[0] - moved(0.02 - 1e-6, 0.0)[0]) / 2e-6
    assert model.A[model.states.index("h.velocity"), model.states.index("motor.i_q")] == pytest.approx(by_current)
    assert model.A[model.states.index("v.velocity"), 0] == pytest.approx(by_gap, rel=1e-6)


@pytest.mark.parametrize("name", PACKAGED_STAGES)
def test_the_loop_of_a_stage_is_that_of_ours(name: str) -> None:
    """Written from the description it equals the files of the scenarios, except for tolerances of checks."""
    loop = loop_table(PACKAGED_STAGES[name])
    packaged = merged(read_layers(SCENARIOS / "loops" / f"{name}.toml"))
    assert sorted(loop["connections"]) == sorted(packaged["connections"])
    for axis in loop["axes"].values():
        for key in ("vertical", "rotation"):
            if not axis[key]:
                del axis[key]
    assert loop["axes"] == packaged["axes"]
    assert loop["fmus"] == {each: {"model": packaged["fmus"][each]["model"]} for each in ("controller", "plant")}
    for key in ("stop_flag", "trip_flag", "motors"):
        assert loop[key] == packaged[key]


@pytest.mark.parametrize(("changes", "facts"), [
    ([("sharing = 1 ", "sharing = 2 ")], ["sharing", "2", "1"]),
    ([("[motor_stop]", "[estimator]")], ["estimator.lower", "'guess'"]),
    ([("z = 0.2", "z = 0.0"), ("z = -0.2", "z = 0.0")], ["motors", "alpha1", "z = 0 m", "one line"]),
    ([("rotation = true             # a tilt of the platform: rad, N m\nmeaning = \"tilt about z\"",
       "meaning = \"tilt about z\"")], ["axes", "y, x, z, roll, pitch"])])
def test_tilts_that_fit_nothing_are_refused(tmp_path: Path, changes: list[tuple[str, str]], facts: list[str]) -> None:
    with raises(StageError, tmp_path / "own.toml", *facts):
        read_own(changed(tmp_path / "own.toml", "5dof", *changes))


def test_a_tilt_is_left_as_fast_as_its_motors_have_it(tmp_path: Path) -> None:
    """The motors push the platform down with M y'' = k y, and over with I r'' = k Σ z²/n r."""
    own = read_own(changed(tmp_path / "own.toml", "5dof", ("mass = 0.2 ", "mass = 0.3 "), ("z = 0.2", "z = 0.25"),
                           ("z = -0.2", "z = -0.25")))
    ratio = sqrt(6.9 * (2.0 * 0.25**2 / 4.0) / 0.3)
    at = held(own, own.vertical.start)
    assert at is not None
    assert sqrt(stiffness(own, "roll", at) / stiffness(own, "y", at)) == pytest.approx(ratio)


@pytest.mark.parametrize(("name", "like", "facts"), [
    *((name, "3dof", ["name", repr(name.removesuffix(".toml")), "lower-case"])
      for name in ("own.txt", "Own.toml", "own_2", "2nd.toml")), ("own.toml", "4dof", ["like", "4dof", "'5dof'"]),
    ("there.toml", "3dof", ["there.toml", "exists"]), ("no/own.toml", "3dof", ["no/own.toml", "folder"])])
def test_a_new_stage_overwrites_nothing(tmp_path: Path, name: str, like: str, facts: list[str]) -> None:
    (tmp_path / "there.toml").write_text("name = 1\n", encoding="utf-8")
    with raises(StageError, *facts):
        new_stage(tmp_path / name, like)
    assert [path.name for path in tmp_path.iterdir()] == ["there.toml"]


# Numbers of a description, and what no stage has in their place.
NUMBER = re.compile(r"(?<=[ \[=])-?\d+\.?\d*(?:e-?\d+)?(?=[ ,\]}\n])")
EXTREMES = ("1e-320", "5e-324", "1e-200", "1e200", "1.7e308", "0", "-0.0", "-1", "1e-12", "1e12", "nan", "inf", "-inf")
FIELDS = ("gaps", "B0 = 0.4\ndecay = 0.013", "coefficients = [0.1, -0.08, 0.03, -0.008]")


@cache
def description(like: str, optional: bool, field: str) -> str:
    """Text of a description, with its optional keys or without, and the field given in one of three ways."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "own.toml"
        new_stage(path, like)
        text = path.read_text(encoding="utf-8")
    if optional:
        text = re.sub(r"^# (?=\[?[a-z_.]+(?:\]| = ))", "", text, flags=re.MULTILINE)
    if field != "gaps":
        text = re.sub(r"(?<=\[field\]\n).*?(?=\n\n)", f"lower = 0.008\nupper = 0.04\n{field}", text, flags=re.DOTALL)
    return re.sub("#.*", "", text)


DESCRIBED = st.sampled_from([*PACKAGED_STAGES]), st.booleans(), st.sampled_from(FIELDS), st.data()


@pytest.mark.usefixtures("slow")
@settings(max_examples=75)
@given(*DESCRIBED)
def test_no_number_is_too_odd_to_be_refused(like: str, optional: bool, field: str, data: st.DataObject) -> None:
    """One number of a description is another one: it is a stage, or one line says why not, and nothing is printed."""
    read_with_another_number(like, optional, field, data)


@pytest.mark.thorough
@settings(max_examples=1000)
@given(*DESCRIBED)
def test_of_many_numbers_none_is_too_odd(like: str, optional: bool, field: str, data: st.DataObject) -> None:
    read_with_another_number(like, optional, field, data)


def read_with_another_number(like: str, optional: bool, field: str, data: st.DataObject) -> None:
    """Draw the place of a number and what stands there, and read the description; fails unless it says one line."""
    text = description(like, optional, field)
    place = data.draw(st.sampled_from([*NUMBER.finditer(text)]))
    text = f"{text[:place.start()]}{data.draw(st.sampled_from(EXTREMES))}{text[place.end():]}"
    with TemporaryDirectory() as folder, warnings.catch_warnings():
        warnings.simplefilter("error")
        path = Path(folder) / "own.toml"
        path.write_text(text, encoding="utf-8")
        try:
            read_own(path)
        except MaglevError as refusal:
            assert str(refusal).startswith(f"{path}: ") and "\n" not in str(refusal)


@pytest.mark.parametrize("like", PACKAGED_STAGES)
@pytest.mark.parametrize("optional", [False, True])
@pytest.mark.parametrize("field", FIELDS)
def test_the_descriptions_that_are_changed_are_stages(tmp_path: Path, like: str, optional: bool, field: str) -> None:
    path = tmp_path / "own.toml"
    path.write_text(description(like, optional, field), encoding="utf-8")
    assert read_own(path).axis_names == PACKAGED_STAGES[like].axis_names


def test_an_axis_may_begin_at_its_stop(tmp_path: Path) -> None:
    text = description("2dof", False, "gaps").replace("upper = 0.07 }", "upper = 5e-324 }")
    (tmp_path / "own.toml").write_text(text, encoding="utf-8")
    assert read_own(tmp_path / "own.toml").axis("h").design.gains[0] < 0.0


def test_a_field_of_nothing_is_refused(tmp_path: Path) -> None:
    text = description("3dof", False, "gaps").replace("B = [0.2", "B = [1e-320, 0.2")
    (tmp_path / "own.toml").write_text(text.replace("gaps = [", "gaps = [0.007, "))
    with raises(StageError, tmp_path / "own.toml", "field.B", "9.99988867e-321 T", "1e-09", "10 T"):
        read_own(tmp_path / "own.toml")
