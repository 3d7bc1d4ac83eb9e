"""Temporary folders of processes that were killed are removed by the next one, those of living processes never."""

import errno
import signal
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

import pytest
from facts import raises

from maglev.files.scratch import PREFIX, ScratchFolders, scratch
from maglev.files.session import SESSION
from maglev.files.whole_file import whole_files, write_whole

HELD = """
import sys
from maglev.files.scratch import scratch_folder
(scratch_folder(sys.argv[1]) / "unpacked").mkdir()
print("made", flush=True)
sys.stdin.read()
"""

# Another process takes a folder for one that was left if it looks between its making and its lock.
MANY = """
import sys
from maglev.files.scratch import scratch
from maglev.files.session import SESSION
for _ in range(300):
    with SESSION.anew(), scratch(sys.argv[1]) as folder:
        (folder / "file").write_text("mine")
        assert (folder / "file").read_text() == "mine"
"""


@pytest.fixture
def other(tmp_path: Path) -> Iterator[subprocess.Popen[str]]:
    """A process with a temporary folder, which lives until it is killed."""
    with subprocess.Popen([sys.executable, "-c", HELD, str(tmp_path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                          text=True) as process:
        assert process.stdout is not None
        assert process.stdout.readline() == "made\n"
        yield process
        process.kill()


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGHUP])
def test_a_killed_process_leaves_nothing_for_long(tmp_path: Path, other: subprocess.Popen[str], number: int) -> None:
    held, = tmp_path.iterdir()
    stranger = tmp_path / "maglev_of_somebody_else"
    stranger.mkdir()
    with scratch(str(tmp_path)) as folder:
        assert set(tmp_path.iterdir()) == {held, stranger, folder}
        assert (held / "unpacked").is_dir()
    other.send_signal(number)
    other.wait()
    assert held.is_dir()
    with SESSION.anew():   # as in the next process
        with scratch(str(tmp_path)) as folder:
            assert set(tmp_path.iterdir()) == {stranger, folder}
        assert list(tmp_path.iterdir()) == [stranger]
        assert not SESSION.get(ScratchFolders).locks


def test_keeps_a_persons_file_with_such_a_name(tmp_path: Path) -> None:
    """Such a folder can be seen by others, or has a name that is none of `mkdtemp`."""
    (tmp_path / f"{PREFIX}notes").mkdir(mode=0o700)
    (tmp_path / f"{PREFIX}abcdefgh").mkdir(mode=0o755)
    left = tmp_path / f"{PREFIX}abcd_123"
    left.mkdir(mode=0o700)
    with scratch(str(tmp_path)):
        assert not left.exists()
    assert {path.name for path in tmp_path.iterdir()} == {f"{PREFIX}notes", f"{PREFIX}abcdefgh"}


def test_a_link_in_the_place_of_a_folder_is_not_followed(tmp_path: Path) -> None:
    kept = tmp_path / "kept"
    kept.mkdir()
    (tmp_path / f"{PREFIX}x").symlink_to(kept)
    with scratch(str(tmp_path)):
        pass
    assert kept.is_dir()


@pytest.mark.usefixtures("slow")
def test_processes_that_look_all_the_time_take_nothing_from_each_other(tmp_path: Path) -> None:
    several = [subprocess.Popen([sys.executable, "-c", MANY, str(tmp_path)]) for _ in range(4)]
    assert [process.wait(timeout=120) for process in several] == [0, 0, 0, 0]
    assert list(tmp_path.iterdir()) == []


def test_a_build_that_was_killed_leaves_nothing_beside_the_files_of_the_next(tmp_path: Path,
                                                                             other: subprocess.Popen[str]) -> None:
    other.kill()
    other.wait()
    with whole_files(tmp_path) as unfinished:
        (unfinished / "Plant.fmu").touch()
    assert [path.name for path in tmp_path.iterdir()] == ["Plant.fmu"]


def test_a_file_whose_writer_was_killed_leaves_nothing_beside_the_next(tmp_path: Path,
                                                                       other: subprocess.Popen[str]) -> None:
    other.kill()
    other.wait()
    write_whole(tmp_path / "report.html", "all of it")
    assert [path.name for path in tmp_path.iterdir()] == ["report.html"]


def test_a_full_disk_names_the_full_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What the system says names none; a file that has a name keeps it."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    full = OSError(errno.ENOSPC, "No space left on device")
    with raises(OSError, tmp_path, "TMPDIR") as told, scratch():
        raise full
    assert (told.value.filename, told.value.errno) == (str(tmp_path), errno.ENOSPC)
    for place, error in ((str(tmp_path), full), (None, OSError(errno.ENOSPC, "full", "a.csv")), (None, OSError("x"))):
        with pytest.raises(OSError) as told, scratch(place):
            raise error
        assert told.value is error
