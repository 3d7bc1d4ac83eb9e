"""Where FMUs are unpacked, and what of them."""

import stat
import tempfile
import zipfile
from pathlib import Path

import pytest
from facts import raises
from written_controllers import controller

import maglev
from maglev.cosim import fmu as module
from maglev.cosim.fmu import HERE, Fmu, read_description, runs_python, unpack, unpacking_folder
from maglev.files.errors import FmuError
from maglev.files.scratch import remove_scratch
from maglev.user.source import FmuFile

FOLDERS = ["o'brien", "Dropbox (ACME)", "R&D", "50 %", "a+b", "#1", "ünï", "a,b", "a;b", "x=1", "[a]", "a@b", "$(a)"]


@pytest.fixture(scope="module")
def python_fmu(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An FMU that runs Python."""
    path, = maglev.build(controller(tmp_path_factory.mktemp("pd")), fmus=tmp_path_factory.mktemp("fmus"))
    return path


def step_below(folder: Path, path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Where an FMU was unpacked that makes a step while temporary files are in a folder."""
    folder.mkdir(exist_ok=True)
    monkeypatch.setattr(tempfile, "tempdir", str(folder))
    with Fmu("pd", FmuFile(path), read_description("pd", path)) as instance:
        instance.initialise({}, 0.0, 1.0)
        instance.instance.doStep(0.0, 5e-4)
        return instance.folder.parent


@pytest.mark.usefixtures("slow")
def test_an_fmu_that_runs_python_loads_wherever_temporary_files_are(
        python_fmu: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    other = tmp_path / "other"
    other.mkdir()
    monkeypatch.setattr(module, "TEMPORARY", (str(tmp_path / "absent"), str(other)))
    for name in FOLDERS:
        assert step_below(tmp_path / name, python_fmu, monkeypatch) == other, name
    assert step_below(tmp_path / "a -._~Z9", python_fmu, monkeypatch) == tmp_path / "a -._~Z9"


def test_without_a_folder_names_the_needs_of_fmus_that_run_python(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Others need nothing."""
    inside = tmp_path / "R&D"
    inside.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(inside))
    monkeypatch.setattr(module, "TEMPORARY", (str(tmp_path / "absent"),))
    with raises(FmuError, inside, "ASCII"):
        unpacking_folder()
    folder = unpacking_folder(python=False)
    assert folder.parent == inside
    remove_scratch(folder)


@pytest.mark.usefixtures("slow")
def test_fmus_that_run_python_are_told_from_others(python_fmu: Path, tmp_path: Path) -> None:
    assert runs_python(python_fmu)
    assert not runs_python(tmp_path / "absent.fmu")


LIBRARY = f"{HERE[0]}theirs.so"


def packed(folder: Path, links: dict[str, str]) -> Path:
    """An archive with a program and symbolic links, as `zip -y` writes them."""
    path = folder / "theirs.fmu"
    with zipfile.ZipFile(path, "w") as archive:
        for name, mode, text in ((LIBRARY, stat.S_IFREG | 0o644, "library"),
                                 ("resources/solver", stat.S_IFREG | 0o755, "#!/bin/sh\n"),
                                 *((name, stat.S_IFLNK | 0o777, target) for name, target in links.items())):
            entry = zipfile.ZipInfo(name)
            entry.external_attr = mode << 16
            archive.writestr(entry, text)
    return path


def test_links_and_programs_are_unpacked_as_such(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    folder.mkdir()
    links = {"resources/lib.so": f"../{LIBRARY}", "resources/again": "lib.so", "to": "resources"}
    unpack(packed(tmp_path, links), folder)
    assert (folder / "resources/again").read_text() == "library" and (folder / "to/again").is_symlink()
    assert (folder / "resources/solver").stat().st_mode & 0o111 == 0o111
    assert not (folder / LIBRARY).stat().st_mode & 0o111


@pytest.mark.parametrize("links", [
    {"resources/a": "/etc/passwd"}, {"resources/a": "../../secret"}, {"a": "a"},
    {"resources/deep/root": "../..", "resources/a": "deep/root/../secret"}])
def test_a_link_that_leads_out_of_the_folder_is_refused(tmp_path: Path, links: dict[str, str]) -> None:
    (tmp_path / "secret").write_text("secret")
    folder = tmp_path / "out"
    folder.mkdir()
    name, target = [*links.items()][-1]
    with raises(FmuError, repr(name), repr(target)):
        unpack(packed(tmp_path, links), folder)
