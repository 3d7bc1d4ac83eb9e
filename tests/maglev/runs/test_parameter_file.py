"""Parameter sets (SSV) of SSP tools as start values: converted by their units, or refused with file, name and value."""

from pathlib import Path
from xml.sax.saxutils import quoteattr

import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

from maglev.files.errors import ScenarioError
from maglev.files.fmi_units import BASE_UNITS
from maglev.files.units import UNITS, known_unit, parse_quantity
from maglev.fmi.parameter_set import SSC, SSV, Value, parameter_set, xml_file
from maglev.runs.starts import files_given, read_parameters

FMUS = ("controller", "plant")


def written(folder: Path, parameters: str, units: str = "", version: str = "1.0") -> Path:
    path = folder / "mine.ssv"
    path.write_text(f'<v:ParameterSet xmlns:v="{SSV}" xmlns:c="{SSC}" version="{version}" name="m">'
                    f"<v:Parameters>{parameters}</v:Parameters><v:Units>{units}</v:Units></v:ParameterSet>")
    return path


def one(kind: str, value: str, unit: str | None = None, name: str = "plant.y.mass") -> str:
    of = "" if unit is None else f" unit={quoteattr(unit)}"
    return f"<v:Parameter name={quoteattr(name)}><v:{kind} value={quoteattr(value)}{of}/></v:Parameter>"


def unit(name: str, **base: object) -> str:
    of = " ".join(f'{key}="{value}"' for key, value in base.items())
    return f"<c:Unit name={quoteattr(name)}><c:BaseUnit {of}/></c:Unit>"


def test_reads_the_files_that_maglev_writes(tmp_path: Path) -> None:
    values = [Value("y.mass", "Real", 0.1 + 0.2, "kg"), Value("C1", "Real", 14.2), Value("n", "Integer", 3),
              Value("antiwindup", "Boolean", True)]
    path = tmp_path / "a.ssv"
    path.write_bytes(xml_file(parameter_set("a", values)))
    found = read_parameters(path, "plant", FMUS)
    assert [(name, start.value) for name, start in found.items()] == [(f"plant.{v.name}", v.value) for v in values]
    assert [start.unit for start in found.values()] == ["kg", None, None, None]


@given(st.sampled_from(sorted(UNITS)), st.floats(-1e9, 1e9), st.booleans(), st.booleans())
def test_units_are_those_of_our_texts(tmp_path_factory: pytest.TempPathFactory, name: str, value: float, told: bool,
                                      angles: bool) -> None:
    """Whether the file declares them or not, and with the radian or without, as many tools leave it out."""
    known = known_unit(name)
    assert known is not None
    base = {key: power for key, power in known.dimension if key in BASE_UNITS and (angles or key != "rad")}
    path = written(tmp_path_factory.getbasetemp(), one("Real", repr(value), name),
                   unit(name, factor=repr(known.factor), **base) if told else "")
    start = read_parameters(path, "", FMUS)["plant.y.mass"]
    assert (start.value, start.unit) == (parse_quantity(f"{value!r} {name}"), known.si)


@pytest.mark.parametrize(("declared", "value", "si"), [
    (unit("lb", kg=1, factor=0.45359237), 4.5359237, "kg"), (unit("degF", K=1, factor=0.5, offset=255.0), 260.0, "K"),
    (unit("mm", kg=1, factor=2), 20.0, "kg"), (unit("odd", m=1, s=-2), 10.0, "m/s2")])
def test_a_unit_is_what_the_file_declares(tmp_path: Path, declared: str, value: float, si: str) -> None:
    name = declared.split('"')[1]
    start = read_parameters(written(tmp_path, one("Float64", "10", name), declared, "2.0"), "", FMUS)["plant.y.mass"]
    assert (start.value, start.unit) == (pytest.approx(value, rel=1e-15), si)


def test_a_unit_that_nobody_knows_yet_is_left_to_the_fmu(tmp_path: Path) -> None:
    start = read_parameters(written(tmp_path, one("Real", "10", "furlong")), "", FMUS)["plant.y.mass"]
    assert (start.value, start.unit, start.written) == (10.0, "furlong", "10 furlong")


@pytest.mark.parametrize(("parameters", "units", "facts"), [
    (one("Real", "nan"), "", ["plant.y.mass", "nan", "finite"]),
    (one("Real", "1e999", "kg"), "", ["plant.y.mass", "1e999 kg", "finite"]),
    (one("Real", "1 2 3"), "", ["plant.y.mass", "1 2 3"]), (one("Real", ""), "", ["plant.y.mass", "number"]),
    (one("Integer", "1.5"), "", ["plant.y.mass", "1.5", "whole"]),
    (one("Boolean", "7"), "", ["plant.y.mass", "7", "true", "false"]),
    (one("Binary", "00"), "", ["plant.y.mass", "00", "Binary", "Real, Integer, Boolean, String or Enumeration"]),
    (one("Real", "1", "q"), unit("q", factor=0), ["plant.y.mass", "q", "factor = 0"]),
    (one("Real", "1", "q"), unit("q", m="x"), ["plant.y.mass", "q", "m = x"]),
    (one("Real", "1", "q"), unit("q", m=0.5), ["plant.y.mass", "q", "m = 0.5"]),
    (one("Real", "1", "q"), unit("q", factor="inf"), ["plant.y.mass", "q", "factor = inf"]),
    ('<v:Parameter name="plant.y.mass"/>', "", ["plant.y.mass", "no value"]),
    (one("Real", "1") * 2, "", ["plant.y.mass", "twice"]),
    (one("Real", "1", name="y.mass"), "", ["y.mass", "y", "controller", "plant"]), ("", "", ["parameters"])])
def test_refusals(tmp_path: Path, parameters: str, units: str, facts: list[str]) -> None:
    path = written(tmp_path, parameters, units)
    with raises(ScenarioError, path, *facts):
        read_parameters(path, "", FMUS)


@pytest.mark.parametrize(("text", "facts"), [
    ("", ["line 1", "SSV"]), ("<a", ["line 1", "SSV"]), ("<a/>", ["'a'", "ssv:ParameterSet"])])
def test_refuses_files_that_are_not_parameter_sets(tmp_path: Path, text: str, facts: list[str]) -> None:
    path = tmp_path / "mine.ssv"
    path.write_text(text)
    with raises(ScenarioError, path, *facts):
        read_parameters(path, "", FMUS)
    with raises(ScenarioError, tmp_path / "min.ssv", "'mine.ssv'"):
        read_parameters(tmp_path / "min.ssv", "", FMUS)
    with raises(ScenarioError, tmp_path):
        read_parameters(tmp_path, "", FMUS)


def test_which_files_are_given(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a=b.ssv").touch()
    a, b = Path("a.ssv"), Path("b.ssv")
    assert files_given(None) == []
    assert files_given("a.ssv") == files_given(a) == [("", a)]
    assert files_given({"plant": a}) == files_given(["plant=a.ssv"]) == files_given("plant=a.ssv") == [("plant", a)]
    assert files_given(["plant=a.ssv", b]) == [("plant", a), ("", b)]
    assert files_given(["a=b.ssv", "../x=1/a.ssv"]) == [("", Path("a=b.ssv")), ("", Path("../x=1/a.ssv"))]
