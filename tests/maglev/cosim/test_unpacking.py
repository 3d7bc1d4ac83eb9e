"""Where FMUs are unpacked, and what of them."""

import tempfile
from pathlib import Path

import pytest
from written_controllers import controller

import maglev
from maglev.cosim import fmu as module
from maglev.cosim.fmu import Fmu, read_description, runs_python, unpacking_folder
from maglev.errors import FmuError
from maglev_files.scratch import remove_scratch

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
    with Fmu("pd", path, read_description("pd", path)) as instance:
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


def test_where_no_folder_is_left_it_says_what_an_fmu_that_runs_python_needs(
        tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Others need nothing."""
    inside = tmp_path / "R&D"
    inside.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(inside))
    monkeypatch.setattr(module, "TEMPORARY", (str(tmp_path / "absent"),))
    with pytest.raises(FmuError, match="R&D: expected one that can be written to, with a path of ASCII letters"):
        unpacking_folder()
    folder = unpacking_folder(python=False)
    assert folder.parent == inside
    remove_scratch(folder)


@pytest.mark.usefixtures("slow")
def test_fmus_that_run_python_are_told_from_others(python_fmu: Path, tmp_path: Path) -> None:
    assert runs_python(python_fmu)
    assert not runs_python(tmp_path / "absent.fmu")
