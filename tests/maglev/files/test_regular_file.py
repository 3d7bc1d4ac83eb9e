"""A named pipe instead of a file: it is named at once, where nobody would ever write into it or read it."""

import errno
import os
import shutil
import signal
import socket
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
from facts import raises, require_facts

from maglev.cosim.fmu import checked_description, read_description
from maglev.files import whole_file
from maglev.files.cache import digest_at, keep, kept, record_conflict
from maglev.files.copies import ORIGIN, original
from maglev.files.errors import MaglevError, in_one_line
from maglev.files.regular_file import regular
from maglev.files.table import read_table
from maglev.files.toml_file import read_toml
from maglev.identification.model_file import model_settings
from maglev.many.dataset import read_dataset
from maglev.pages.shell import has_own_index, pages_in
from maglev.runs.baseline_file import read_digests
from maglev.runs.carried_experiments import carried_experiments
from maglev.runs.starts import read_parameters
from maglev.scenario.loading import load_plan
from maglev.user.source import PythonFile

pytestmark = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="there are no named pipes")


@pytest.fixture(autouse=True)
def limit() -> Iterator[None]:
    """A test that waits for the other end of a pipe fails."""
    def fail(_number: int, _frame: object) -> None:
        raise AssertionError("it waits")

    before = signal.signal(signal.SIGALRM, fail)
    signal.alarm(30)
    yield
    signal.alarm(0)
    signal.signal(signal.SIGALRM, before)


def pipe(folder: Path, name: str) -> Path:
    os.mkfifo(folder / name)
    return folder / name


READERS: dict[str, tuple[str, Callable[[Path], Any]]] = {
    "TOML": ("a.toml", read_toml), "scenario": ("a.toml", load_plan), "CSV": ("a.csv", read_table),
    "parameters": ("a.ssv", lambda path: read_parameters(path, "", [])),
    "digests": ("digests.txt", lambda path: read_digests(path.parent)), "model": ("a.toml", model_settings),
    "FMU": ("a.fmu", lambda path: read_description("plant", path)),
    "description": ("a.fmu", lambda path: checked_description(f"{path}", path)),
    "experiments": ("a.fmu", carried_experiments), "controller": ("a.py", lambda path: PythonFile(path).load()),
    "dataset": ("a.parquet", read_dataset)}


@pytest.mark.parametrize("reader", READERS)
def test_readers_name_a_pipe(reader: str, tmp_path: Path) -> None:
    name, read = READERS[reader]
    path = pipe(tmp_path, name)
    with pytest.raises((MaglevError, OSError)) as failure:
        read(path)
    require_facts(in_one_line(failure.value), path, "named pipe")


def test_a_device_and_a_socket_are_named(tmp_path: Path) -> None:
    with raises(OSError, "'/dev/zero'", "device"):
        regular(Path("/dev/zero"))
    with socket.socket(socket.AF_UNIX) as server, raises(OSError, tmp_path / "s", "socket"):
        server.bind(str(tmp_path / "s"))
        regular(tmp_path / "s")
    assert [regular(path) for path in (tmp_path, tmp_path / "none")] == [tmp_path, tmp_path / "none"]


def test_leaves_other_files_of_the_folder_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A page, an index, the record of a run, an entry of the cache, the origin of copies."""
    for name in ("other.html", "index.html", "run.json", ORIGIN):
        pipe(tmp_path, name)
    assert list(pages_in(tmp_path)) == [] and not has_own_index(tmp_path)
    (tmp_path / "run.csv").write_text("time,a\n0,0\n")
    assert record_conflict(tmp_path / "run.csv") == ""
    assert original(tmp_path / "run.csv") == tmp_path / "run.csv"
    monkeypatch.setenv("MAGLEV_CACHE", str(tmp_path / "cache"))
    entry = keep("fmus/key", "a.fmu", b"content")
    entry.path.unlink()
    os.mkfifo(entry.path, 0o600)
    assert digest_at(entry.path) == "" and kept("fmus/key", "a.fmu") is None
    assert keep("fmus/key", "a.fmu", b"content") == kept("fmus/key", "a.fmu")
    shutil.rmtree(tmp_path / "cache")


def test_a_pipe_that_nobody_reads_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(whole_file, "PATIENCE", 0.1)
    path = pipe(tmp_path, "check.xml")
    with raises(OSError, path, "named pipe") as failure:
        whole_file.write_whole(path, "text")
    assert (failure.value.errno, failure.value.filename) == (errno.ENXIO, str(path))
