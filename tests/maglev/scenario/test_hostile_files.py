"""Files that were made to break a reader, or that broke on the way: one line each, and soon."""

from pathlib import Path

import pytest
from command_line import error_line, maglev
from facts import raises, require_facts

from maglev.files.errors import CsvError, IdentificationError, QuantityError, ScenarioError
from maglev.files.table import read_table
from maglev.files.units import parse_quantity
from maglev.identification.model_file import model_settings
from maglev.scenario.layers import DEEPEST
from maglev.scenario.loading import load_plan, load_plans

HEAD = 'extends = "loops/3dof.toml"\nname = "mine"\ntitle = "Mine"\nstop_time = "10 ms"\n'


def refused(path: Path, text: str) -> str:
    path.write_text(text, encoding="utf-8")
    with raises(ScenarioError) as refusal:
        load_plans(path)
    return str(refusal.value)


def test_a_loop_of_the_package_is_found_from_anywhere(tmp_path: Path) -> None:
    """The first example of the documentation; a file of the same name next to the scenario goes before it."""
    path = tmp_path / "mine.toml"
    path.write_text(HEAD, encoding="utf-8")
    assert load_plan(path).fmus["plant"].model == "Plant3DOF"
    (tmp_path / "loops").mkdir()
    (tmp_path / "loops" / "3dof.toml").write_text('step = 1.0\n[fmus.plant]\nmodel = "Plant2DOF"\n', encoding="utf-8")
    path.write_text(HEAD.replace("10 ms", "10 s"), encoding="utf-8")
    assert load_plan(path).fmus["plant"].model == "Plant2DOF"


def test_a_file_takes_the_place_of_a_model(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(HEAD + '[fmus.controller]\nfile = "theirs.fmu"\n', encoding="utf-8")
    controller = load_plan(path).fmus["controller"]
    assert (controller.model, controller.file) == (None, str(tmp_path / "theirs.fmu"))
    both = HEAD + '[fmus.controller]\nfile = "theirs.fmu"\nmodel = "Regulator3DOF"\n'
    require_facts(refused(path, both), "fmus.controller", "model", "file")


def test_byte_order_mark(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_text("\N{ZERO WIDTH NO-BREAK SPACE}" + HEAD, encoding="utf-8")
    assert load_plan(path).name == "mine"


def test_nesting(tmp_path: Path) -> None:
    require_facts(refused(tmp_path / "deep.toml", "a = " + 5000 * "[" + 5000 * "]"), "nested")


def test_a_long_chain_of_files(tmp_path: Path) -> None:
    for k in range(DEEPEST + 5):
        (tmp_path / f"{k}.toml").write_text(f'extends = "{k + 1}.toml"\n', encoding="utf-8")
    require_facts(refused(tmp_path / "mine.toml", 'extends = "0.toml"\n'), f"{DEEPEST} files")


def test_paths_that_meet_again(tmp_path: Path) -> None:
    """Diamonds of files: 2^22 paths."""
    for k in range(22):
        (tmp_path / f"{k}.toml").write_text(f'extends = ["{k + 1}.toml", "{k + 1}.toml"]\n', encoding="utf-8")
    (tmp_path / "22.toml").write_text("", encoding="utf-8")
    require_facts(refused(tmp_path / "mine.toml", 'extends = "0.toml"\n'), tmp_path / "14.toml", "extends", "300 files")


@pytest.mark.parametrize("name", ["../x", "/x", "", ".", "..", "a/b", "a b"])
def test_names_are_no_paths(tmp_path: Path, name: str) -> None:
    require_facts(refused(tmp_path / "mine.toml", HEAD.replace('"mine"', f'"{name}"')), "name", repr(name))
    require_facts(refused(tmp_path / "mine.toml", HEAD + f'[variants."/{name}"]\n'), "name", f"'mine-/{name}'")


@pytest.mark.parametrize("value", [10**400, -(10**400), float("nan"), float("inf")])
def test_numbers_beyond_floats(value: float) -> None:
    with raises(QuantityError, "finite"):
        parse_quantity(value, "m")


def test_huge_numbers_in_files(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    require_facts(refused(path, HEAD + f'[fmus.plant.start]\n"y.mass" = 1{400 * "0"}\n'), 'fmus.plant.start."y.mass"')
    require_facts(refused(path, HEAD + f'[fmus.plant.start]\n"y.mass" = 1{5000 * "0"}\n'), "TOML")


def test_no_bound_on_steps(fmus: Path, tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    require_facts(refused(path, HEAD.replace("10 ms", "10000000 s")), "stop_time", "5e+10", "0.0002 s", "1e+08")
    path.write_text(HEAD, encoding="utf-8")
    short = ("run", path, "--fmus", fmus, "--out", tmp_path)
    require_facts(error_line(maglev(*short, "--step", "1e-300")), "1e-300", "1e+08")
    path.write_text(HEAD.replace("10 ms", "2500 s"), encoding="utf-8")
    require_facts(error_line(maglev(*short)), "12500000", "0.0002 s", "4 GB")


@pytest.mark.parametrize("text",
                         ['stage = ["2dof"]\nC1 = 1\n', "stage = {a = 1}\nC1 = 1\n", 'stage = "4dof"\nC1 = 1\n'])
def test_a_table_where_text_is_expected(tmp_path: Path, text: str) -> None:
    path = tmp_path / "model.toml"
    path.write_text(text, encoding="utf-8")
    with raises(IdentificationError, path, "stage", "2dof", "3dof"):
        model_settings(path)


def test_a_field_that_is_too_long(tmp_path: Path) -> None:
    path = tmp_path / "long.csv"
    path.write_text(f"time,h\n0,{200_000 * 'x'}\n", encoding="utf-8")
    with raises(CsvError, path, 131072):
        read_table(path).column("h")


def test_keys_in_keys_in_keys(tmp_path: Path) -> None:
    """Python cannot write such a value as text."""
    require_facts(refused(tmp_path / "deep.toml", HEAD + f"[{'.'.join(3000 * ['a'])}]\nb = 1\n"), "nested")


@pytest.mark.parametrize("line", ['title = "\\u001B[2J"', 'description = "a\\u009Bb"', '"\\u202E" = 1',
                                  'figures = ["4.1", "\\u0007"]'])
def test_control_characters(tmp_path: Path, line: str) -> None:
    message = refused(tmp_path / "mine.toml", f"{line}\n{HEAD.replace('title', '# title')}")
    require_facts(message, "control characters")
    assert message.isprintable()


def test_lines_and_tabs_are_no_control_characters(tmp_path: Path) -> None:
    path = tmp_path / "mine.toml"
    path.write_bytes(b'description = """\r\n\tone\r\ntwo\xc2\xa0\xe2\x80\x89mm"""\r\n' + HEAD.encode())
    assert load_plan(path).description == "\tone\ntwo\N{NO-BREAK SPACE}\N{THIN SPACE}mm"
