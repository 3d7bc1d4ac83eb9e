"""FMUs of others whose model descriptions mislead, and files that are not there: one line each."""

import re
import zipfile
from pathlib import Path

import fmpy
import pytest
from facts import raises

from maglev.cosim.fmu import Fmu, flaw_note, read_description, unpack
from maglev.descriptions.own_fmus import definition
from maglev.files.errors import FmuError
from maglev.fmi.model_description import model_description
from maglev.user.source import FmuFile


def described(folder: Path, old: str, new: str) -> Path:
    """Write an archive with the model description of a plant, changed in every place with a text."""
    text = model_description(definition("Plant2DOF"), "{0}", "0", 0).decode()
    assert re.search(old, text)
    path = folder / "theirs.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", re.sub(old, new, text))
    return path


@pytest.mark.parametrize("identifier", ["../../evil", "/evil", "..", "a/b", "a b", ""])
def test_a_library_outside_the_archive_is_not_loaded(tmp_path: Path, identifier: str) -> None:
    path = described(tmp_path, 'modelIdentifier="[^"]*"', f'modelIdentifier="{identifier}"')
    with raises(FmuError, path, "modelIdentifier", repr(identifier)):
        read_description("plant", path)


@pytest.mark.parametrize(("libraries", "named"), [
    (["windows9/Plant2DOF.dll", "of_mine/", "of_mine/Plant2DOF.so", "of_mine/b.so"], "of_mine, windows9"),
    ([], "no platform")])
def test_a_binary_for_other_machines(tmp_path: Path, libraries: list[str], named: str) -> None:
    path = described(tmp_path, "Plant2DOF", "Plant2DOF")
    with zipfile.ZipFile(path, "a") as archive:
        for library in libraries:
            archive.writestr(f"binaries/{library}", "")
    with raises(FmuError, path, named, fmpy.platform):
        Fmu("plant", FmuFile(path), read_description("plant", path))


@pytest.mark.parametrize("name", ["resources\\a.txt", "/etc/a.txt", "C:a.txt"])
def test_a_path_that_fmi_does_not_have(tmp_path: Path, name: str) -> None:
    path = described(tmp_path, "Plant2DOF", "Plant2DOF")
    with zipfile.ZipFile(path, "a") as archive:
        archive.writestr(name, "")
    with raises(FmuError, path, repr(name)):
        Fmu("plant", FmuFile(path), read_description("plant", path))


def test_nothing_is_unpacked_outside(tmp_path: Path) -> None:
    path, folder = tmp_path / "theirs.fmu", tmp_path / "out"
    with zipfile.ZipFile(path, "w") as archive:
        for name in ("../a.txt", "resources/../../b.txt", f"binaries/{fmpy.platform}/c.so"):
            archive.writestr(name, "")
    folder.mkdir()
    unpack(path, folder)
    assert {file for file in tmp_path.rglob("*") if file.is_file() and folder not in file.parents} == {path}


UNITS = {
    "a thousand": ('factor="1000"', "factor", "1000", "1"), "none": ('factor="0"', "factor", "0", "1"),
    "no number": ('factor="NaN"', "factor", "nan", "1"), "another zero": ('offset="273.15"', "offset", "273.15", "0"),
    "an area": ('factor="1" m="2"', "m", "2", "1"), "another dimension": ('s="1"', "s", "1", "0")}


@pytest.mark.parametrize("case", UNITS)
def test_a_unit_that_is_not_what_its_name_says(tmp_path: Path, case: str) -> None:
    attributes, *facts = UNITS[case]
    new = attributes if ' m="' in attributes else f'm="1" {attributes}'
    path = described(tmp_path, r'(<Unit name="m">\s*<BaseUnit) m="1"', rf"\1 {new}")
    with raises(FmuError, path, "'m'", *facts):
        read_description("plant", path)


@pytest.mark.parametrize("base", ['m="1" factor="0.001"', 'm="1" factor="1e-3" offset="0"'])
def test_a_unit_that_is(tmp_path: Path, base: str) -> None:
    path = described(tmp_path, '(<UnitDefinitions>)', rf'\1<Unit name="mm"><BaseUnit {base}/></Unit>')
    assert len(read_description("plant", path).unitDefinitions) > 1


def test_the_other_kind_is_there(tmp_path: Path) -> None:
    """Whoever has built one kind only forgets, or adds, --kind native."""
    for folder in ("native", "clocked"):
        (tmp_path / folder).mkdir()
    python, native, clocked = (tmp_path / folder / "Plant2DOF.fmu" for folder in ("", "native", "clocked"))
    for missing, there, *facts in ((python, native, "kind", "native"), (native, python, "kind"),
                                   (clocked, native, "kind", "native"), (python, clocked, "fmus", clocked.parent)):
        there.touch()
        with raises(FmuError, missing, there, *facts):
            read_description("plant", missing)
        there.unlink()


FLAWS = {
    "a unit 1": ((r'unit="m"', 'unit="1"'), 'The unit "1" of variable '),
    "an empty unit": ((r'unit="m"', 'unit=""'), 'The unit "" of variable '),
    "a unit without a definition, but with one to show": (
        (r'unit="m"', 'unit="rpm"'), 'The unit "rpm" of variable '),
    "a date that is none": ((r'generationDateAndTime="[^"]*"', 'generationDateAndTime="1 May"'),
                            "attribute 'generationDateAndTime': '1 May' is not a valid value")}


@pytest.mark.parametrize("case", FLAWS)
def test_a_small_flaw_of_a_description_is_said_and_does_no_harm(tmp_path: Path, case: str) -> None:
    """As OpenModelica, MapleSim and Hopsan write it."""
    change, said = FLAWS[case]
    path = described(tmp_path, *change)
    assert "v.position" in {variable.name for variable in read_description("plant", path).modelVariables}
    note = flaw_note(path)
    assert note.startswith("its model description is flawed: ") and said in note
    assert "\n" not in note


@pytest.mark.parametrize("change", [('name="h.position"', 'name="v.position"'), ("causality=", "cause=")])
def test_a_flaw_that_does_harm_is_refused_with_small_ones_beside_it(tmp_path: Path, change: tuple[str, str]) -> None:
    path = described(tmp_path, *change)
    with zipfile.ZipFile(path) as archive:
        text = archive.read("modelDescription.xml").decode()
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("modelDescription.xml", text.replace('unit="m"', 'unit="1"'))
    with raises(FmuError, path):
        read_description("plant", path)
