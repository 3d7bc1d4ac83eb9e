"""What all refusals share: keys as TOML has them, in one line."""

import pickle
import tomllib
from copy import deepcopy
from pathlib import Path

import numpy as np
import pytest
from facts import raises
from hypothesis import given
from hypothesis import strategies as st

import maglev
from maglev.cosim.master import Recording, RunInterrupted
from maglev.files.errors import Interrupted, in_one_line, key_path, nearest, one_of

KEYS = st.text(st.characters(exclude_categories=["Cs"]))


@given(st.lists(KEYS, min_size=1, max_size=3))
def test_a_key_is_one_that_toml_reads(keys: list[str]) -> None:
    """Whatever is in it: line ends, quotes, what reorders a line."""
    path = key_path(keys)
    assert len(f"{path} ".splitlines()) == 1 and path.isprintable()
    found = tomllib.loads(f"{path} = 1")
    for key in keys:
        assert list(found) == [key]
        found = found[key]
    assert found == 1


def test_a_name_without_its_ending_is_nearest_to_that_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "3dof-mine.toml").touch()
    for read in (maglev.run, maglev.study, maglev.tune):
        with raises(maglev.ScenarioError, "'3dof-mine'", "'3dof-mine.toml'"):
            read("3dof-mine")
    with raises(maglev.StabilityError, "'3dof-mine.toml'"):
        maglev.region("3dof-mine", "x", "25 mm")
    with raises(maglev.ScenarioError, "3dof-mine", "'3dof-mine.toml'"):
        maglev.fmus(stage="3dof-mine")
    (tmp_path / "pd.py").touch()
    with raises(maglev.UnknownName, "controller", "pd", "'pd.py'"):
        maglev.run("3dof-setpoints", controller="pd")


@pytest.mark.parametrize(("name", "words"), [
    ("3dof-pid-lrge", "nearest is '3dof-pid-large'"), ("3DOF-PID-LARGE", "nearest is '3dof-pid-large'"),
    ("nope", "there are '3dof-pid-large', '2dof-setpoints', 'mass' and 1 other"), ("", "there are '3dof-pid-large', "),
])
def test_names_the_nearest_or_the_valid_names(name: str, words: str) -> None:
    assert nearest(name, ["3dof-pid-large", "2dof-setpoints", "mass", "bias"]).startswith(words)
    assert nearest(name, ["gap"]) == "there is 'gap'"
    assert nearest(name, []) == "there is none"


def test_one_of_says_what_is_nearest_where_something_is() -> None:
    assert one_of("xls", ["csv", "parquet"]) == "one of csv, parquet"
    assert one_of("cvs", ["csv", "parquet"]) == "one of csv, parquet; nearest is 'csv'"


def test_a_file_goes_before_what_the_system_says_of_it(tmp_path: Path) -> None:
    assert in_one_line(PermissionError(13, "Permission denied", "results")) == "results: Permission denied"
    assert in_one_line(OSError("no disk")) == "no disk"
    (tmp_path / "file").touch()
    with pytest.raises(FileExistsError) as refused:
        (tmp_path / "file").mkdir(exist_ok=True)
    assert in_one_line(refused.value) == f"{tmp_path}/file: File exists, expected a folder"


def test_keys_and_places() -> None:
    assert key_path(["signals", 0, "v.reference", "a\nb"]) == 'signals[0]."v.reference"."a\\nb"'


@given(st.text())
def test_one_line(text: str) -> None:
    assert len(f"{in_one_line(text)} ".splitlines()) == 1


RECORDING = Recording(np.zeros(1), {})


@pytest.mark.parametrize("error", [
    maglev.RunFailed("at t = 0 s", RECORDING), RunInterrupted("at t = 0 s", RECORDING, 15), Interrupted("ended", 15),
    maglev.BatchInterrupted("ended", maglev.Batch({}, {}, {}, {}, [], {}, np.zeros(0)), 15),
    maglev.CsvError(Path("run.csv"), "no numbers"), maglev.UnknownName("no column")],
    ids=lambda error: type(error).__name__)
def test_an_error_comes_over_from_another_process(error: BaseException) -> None:
    """As multiprocessing sends it: a Pool would wait for ever for one that cannot be made again."""
    for other in (pickle.loads(pickle.dumps(error)), deepcopy(error)):
        assert type(other) is type(error)
        assert str(other) == str(error)
        assert vars(other).keys() == vars(error).keys()
        assert getattr(other, "number", 15) == 15
