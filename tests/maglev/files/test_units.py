import math

import numpy as np
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

from maglev.files.errors import QuantityError, ScenarioError
from maglev.files.fmi_units import exponents
from maglev.files.units import UNITS, number_or_text, parse_quantity, positive_time, read_quantity, to_unit


@pytest.mark.parametrize(("text", "value"), [
    ("25 mm", 0.025), ("10 um", 1e-5), ("10 µm", 1e-5), ("10 \u03bcm", 1e-5), ("2 kg", 2.0), ("30 %", 0.3),
    ("-4 A", -4.0), ("1.5 s", 1.5), ("0.2 ms", 0.0002), ("24.5mm", 0.0245), ("+1e-3 m", 0.001), (" .5 kN/m ", 500.0),
    ("1.5 pi rad/s", 1.5 * math.pi), ("2π rad", 2.0 * math.pi), ("100 N.s/m", 100.0)])
def test_text_is_the_number_on_paper(text, value):
    assert parse_quantity(text) == value


def test_plain_numbers_are_si_or_in_the_given_unit():
    assert parse_quantity(25) == 25.0
    assert parse_quantity(24.5, "mm") == 0.0245
    assert [parse_quantity(number) for number in (np.int64(25), np.float32(0.5), np.array(3))] == [25.0, 0.5, 3.0]
    assert parse_quantity("2 cm", "mm") == 0.02


def test_unit_as_written():
    assert read_quantity("2 kg").unit == "kg"
    assert read_quantity(2).unit is None


@given(st.floats(-1e6, 1e6), st.sampled_from(sorted(UNITS)))
def test_there_and_back(value, unit):
    assert to_unit(parse_quantity(value, unit), unit) == pytest.approx(value, rel=1e-14, abs=1e-300)


@pytest.mark.parametrize(("value", "facts"), [
    ("25 mn", ["25 mn", "'mn'", "'mN'"]),
    ("25", ["'25'", "unit"]),
    ("fast", ["'fast'", "25 mm"]),
    (math.nan, ["nan", "finite"]),
    (math.inf, ["inf", "finite"]),
    ("1e999 m", ["1e999 m", "finite"]),
    (True, ["True", "number"]),
    (None, ["None", "number"])])
def test_refusals_name_value_and_expectation(value, facts):
    with raises(QuantityError, *facts):
        parse_quantity(value)


@pytest.mark.parametrize(("text", "facts"), [
    ("4kilo", ["'kilo'", "'kg'"]), ("4 kilometers", ["'kilometers'", "'km'"]), ("2 Millimetre", ["'mm'"]),
    ("3 KG", ["'kg'"]), ("1 /s", ["'1/s'"]), ("off", ["'25 mm'", "true", "false"]), ("2 xyz", ["'xyz'", "'kg'"]),
    ("5,0", ["'5,0'", "'5.0'"]), ("5,25 mm", ["'5.25 mm'"]), ("3..5", ["'3..5'", "one number"]),
    ("3-5", ["one number"]), ("1:30", ["one number"]), ("1/2 m", ["one number"]), ("1'000", ["one number"])])
def test_names_the_unit_that_may_be_meant(text, facts):
    with raises(QuantityError, *facts):
        parse_quantity(text)


@pytest.mark.parametrize(("text", "unit", "value"), [
    ("2 mV.s/rad", "V.s/rad", 0.002), ("40 1/s3", "1/s3", 40.0), ("9.81 m/s²", "m/s2", 9.81), ("3 N m/A", "Wb", 3.0),
    ("1 kV/(mm.s)", "V/(m.s)", 1e6), ("5 g.cm2", "kg.m2", 5e-7), ("4 V/A", "ohm", 4.0), ("12 mH", "V.s/A", 0.012),
    ("2 J", "N.m", 2.0), ("60 rpm", "rad/s", 2.0 * math.pi), ("1 s^-2", "1/s2", 1.0), ("7 mΩ", "Ohm", 0.007)])
def test_composed_units_are_made_of_the_table(text, unit, value):
    assert parse_quantity(text, unit) == pytest.approx(value, rel=1e-15)
    assert to_unit(parse_quantity(text, unit), text.partition(" ")[2]) == pytest.approx(float(text.split()[0]))


@pytest.mark.parametrize(("text", "unit"), [
    ("2 Hz", "1/s"), ("2 Hz", "rad/s"), ("2 1/s", "rad/s"), ("2 V/rpm", "V.s"), ("1 m/s/s", "m/s"), ("2 N.m", "N/m")])
def test_distinguishes_similar_symbols(text, unit):
    with raises(QuantityError, text, unit):
        parse_quantity(text, unit)


def test_every_symbol_is_an_si_unit_of_its_own_exponents():
    """Of the SI brochure, table 4: V = W/A, Ohm = V/A, H = Wb/A, T = Wb/m2, F = C/V, J = N m, Pa = N/m2, S = 1/Ohm."""
    for derived in ("V = W/A", "Ohm = V/A", "H = Wb/A", "T = Wb/m2", "F = C/V", "J = N.m", "Pa = N/m2", "S = 1/Ohm",
                    "W = J/s", "Wb = V.s", "C = A.s", "N = kg.m/s2"):
        one, other = derived.split(" = ")
        assert exponents(one) == exponents(other)


def test_other_dimension_is_refused():
    with raises(QuantityError, "2 kg", "kg", "m"):
        parse_quantity("2 kg", "m")


@pytest.mark.parametrize(("text", "unit", "value"), [
    ("3 kg*m/s^2", "N", 3.0), ("3 N m", "J", 3.0), ("4 N·m", "J", 4.0), ("3 m**2", "m2", 3.0)])
def test_units_are_spelled_in_many_ways(text, unit, value):
    assert parse_quantity(text, unit) == value


@pytest.mark.parametrize(("text", "unit"), [("2 Hz", "rad/s"), ("2 rad/s", "Hz"), ("5 Hz/s", "rad/s2")])
def test_cycles_are_no_radians(text, unit):
    with raises(QuantityError, text, text[2:], unit):
        parse_quantity(text, unit)


def test_a_time_of_an_option():
    assert [positive_time(value, ScenarioError, "timeout") for value in (5, "5", "5 ms", "2 min")] == [5, 5, 5e-3, 120]
    for value, *facts in (0.0, "0 s"), ("-1 s", "0 s"), ("5 mm", "'5 mm'", "s"):
        with raises(ScenarioError, "timeout", *facts):
            positive_time(value, ScenarioError, "timeout")


def test_conversion_to_an_unknown_unit_names_value_and_nearest():
    with raises(QuantityError, "0.025", "'mmm'", "'mm'"):
        to_unit(0.025, "mmm")


def test_infinite_settling_time_converts():
    assert to_unit(math.inf, "ms") == math.inf


@pytest.mark.parametrize(("text", "value"), [("−4 A", -4.0), ("1e−3 m", 1e-3), ("3 m.s−1", 3.0)])
def test_a_minus_sign_is_one(text: str, value: float) -> None:
    """As typeset pages have it, U+2212, and what is copied from them."""
    assert parse_quantity(text) == value
    assert number_or_text(text.split()[0]) == value
