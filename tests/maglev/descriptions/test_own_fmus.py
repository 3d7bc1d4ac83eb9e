"""Which FMU files are the ones that this installation makes: by their content, whatever they say and are called."""

import re
import shutil
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

from maglev.descriptions.own_fmus import DEFINITIONS, built_here
from maglev.fmi import recognition
from maglev.language import sources
from maglev.language.sources import module_path
from maglev.scenario.catalogue import build

Contents = dict[str, bytes]

NAME = "Regulator3DOF"


@pytest.fixture(params=["python", "native"])
def ours(request: pytest.FixtureRequest, slow: None) -> Path:
    """An FMU of ours, of each kind."""
    folder: Path = request.getfixturevalue("fmus" if request.param == "python" else "native_fmus")
    return folder / f"{NAME}.fmu"


def changed(ours: Path, copy: Path, change: Callable[[Contents], None]) -> Path:
    """A copy of an FMU whose files a function has changed."""
    with zipfile.ZipFile(ours) as archive:
        contents = {name: archive.read(name) for name in archive.namelist()}
    change(contents)
    with zipfile.ZipFile(copy, "w") as archive:
        for name, data in contents.items():
            archive.writestr(name, data)
    return copy


def described(text: bytes, by: bytes) -> Callable[[Contents], None]:
    """Replace what the model description says."""
    def change(contents: Contents) -> None:
        now, times = re.subn(text, by, contents["modelDescription.xml"])
        assert times
        contents["modelDescription.xml"] = now
    return change


def every(ending: str, by: Callable[[bytes], bytes]) -> Callable[[Contents], None]:
    """Change every file with an ending."""
    def change(contents: Contents) -> None:
        found = [name for name in contents if name.endswith(ending)]
        contents.update({name: by(contents[name]) for name in found})
    return change


@pytest.mark.few(14)
@pytest.mark.parametrize("name", DEFINITIONS)
def test_a_built_fmu_is_recognised(fmus: Path, native_fmus: Path, name: str) -> None:
    assert built_here(fmus / f"{name}.fmu")
    assert built_here(native_fmus / f"{name}.fmu")


def test_name_and_place_of_the_file_do_not_matter(ours: Path, tmp_path: Path) -> None:
    assert built_here(Path(shutil.copy(ours, tmp_path / "another name.fmu")))
    assert built_here(changed(ours, tmp_path / "packed again.fmu", lambda contents: None))


@pytest.mark.usefixtures("slow")
def test_one_with_a_module_that_is_no_more_is_of_another_version(tmp_path: Path) -> None:
    path, = build([NAME], tmp_path)

    def change(contents: Contents) -> None:
        name, = (name for name in contents if name.endswith("/pmlsm/gap_functions.py"))
        contents[name.replace("gap_functions", "gaps_of_old")] = contents.pop(name)

    assert built_here(path)
    assert not built_here(changed(path, tmp_path / "old.fmu", change))


@pytest.mark.usefixtures("slow")
def test_the_date_does_not_matter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1000000000")
    path, = build([NAME], tmp_path)
    monkeypatch.delenv("SOURCE_DATE_EPOCH")
    assert built_here(path)


@pytest.mark.parametrize("change", [
    lambda contents: contents.update({f"binaries/linux64/{NAME}.so": b"\x7fELF, and it is not ours"}),
    every(".so", lambda library: library + b"\0"),
    described(rb'start="[^"]*"', b'start="1.0"'),
    described(rb'description="[^"]*"', b'description=""'),
    described(rb'guid="\{[^"]*\}"', b'guid="{00000000000000000000000000000000}"'),
    described(rb'generationDateAndTime="[^"]*"', b'generationDateAndTime="2026-99-01T00:00:00Z"'),
    described(rb'modelName="\w+"', b'modelName="PID3DOF"'),
    lambda contents: contents.update({"resources/sitecustomize.py": b"print('here')"}),
    lambda contents: contents.pop("modelDescription.xml"),
], ids=["another library", "a byte more", "start values", "description", "guid", "date", "model", "a file more",
        "no description"])
def test_a_changed_fmu_is_not_recognised(ours: Path, tmp_path: Path, change: Callable[[Contents], None]) -> None:
    """Also where the GUID stays what it was, and whatever tool it says."""
    assert not built_here(changed(ours, tmp_path / f"{NAME}.fmu", change))


def test_changed_code_is_not(fmus: Path, native_fmus: Path, tmp_path: Path) -> None:
    for folder, ending in ((fmus, "/regulator.py"), (fmus, "code/slave.py"), (fmus, "slavemodule.txt"),
                           (native_fmus, "/block.h"), (native_fmus, "/instance.h"), (native_fmus, "/model.c")):
        change = every(ending, lambda text: text + b"\n")
        assert not built_here(changed(folder / f"{NAME}.fmu", tmp_path / f"{NAME}.fmu", change)), ending


def test_one_of_other_sources_is_not(ours: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What an earlier version built, or a checkout before its last change."""
    now = tmp_path / "regulator.py"
    now.write_text(module_path("controller_fmu.regulator").read_text() + "# changed\n")
    for module in (recognition, sources):
        monkeypatch.setattr(module, "module_path",
                            lambda name: now if name == "controller_fmu.regulator" else module_path(name))
    assert not built_here(Path(shutil.copy(ours, tmp_path)))


def test_two_files_of_one_name_are_not(ours: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copy(ours, tmp_path))
    with zipfile.ZipFile(copy, "a") as archive, pytest.warns(UserWarning, match="Duplicate name"):
        archive.writestr("modelDescription.xml", archive.read("modelDescription.xml"))
    assert not built_here(copy)


def test_one_that_only_says_so_is_not(ours: Path, tmp_path: Path) -> None:
    """The model description is ours, byte for byte; nothing behind it is."""
    with zipfile.ZipFile(ours) as archive:
        description = archive.read("modelDescription.xml")
    with zipfile.ZipFile(tmp_path / f"{NAME}.fmu", "w") as archive:
        archive.writestr("modelDescription.xml", description)
        archive.writestr(f"binaries/linux64/{NAME}.so", b"\x7fELF")
    assert not built_here(tmp_path / f"{NAME}.fmu")


def test_a_file_that_is_not_an_fmu_is_not_recognised(tmp_path: Path) -> None:
    (tmp_path / "text.fmu").write_text("not an archive")
    (tmp_path / "folder.fmu").mkdir()
    (tmp_path / "half.fmu").write_bytes(b"PK\3\4" + bytes(100))
    with zipfile.ZipFile(tmp_path / "empty.fmu", "w"):
        pass
    for name in ("text", "folder", "half", "empty", "missing"):
        assert not built_here(tmp_path / f"{name}.fmu")


def test_a_file_that_is_replaced_is_looked_at_again(ours: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copy(ours, tmp_path))
    assert built_here(copy)
    other = changed(ours, tmp_path / "other", every(".so", lambda library: library + b"\0"))
    other.replace(copy)
    assert not built_here(copy)
