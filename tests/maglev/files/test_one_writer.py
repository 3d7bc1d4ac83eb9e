"""One writer at a time, and files that belong together."""

import errno
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from maglev.files.cache import FILES, digest_at, record_conflict
from maglev.files.one_writer import Busy, NoLock, only_writer
from maglev.files.whole_file import write_whole

HOLDER = """
import sys, time
sys.path[:] = {path!r}
from pathlib import Path
from maglev.files.one_writer import only_writer
with only_writer(Path({lock!r})):
    print("locked", flush=True)
    time.sleep(600.0)
"""


def test_another_process_is_kept_out_until_the_first_ends_however_it_does(tmp_path: Path) -> None:
    lock = tmp_path / "new" / ".lock"
    holder = subprocess.Popen([sys.executable, "-c", HOLDER.format(path=sys.path, lock=str(lock))],
                              stdout=subprocess.PIPE, text=True)
    assert holder.stdout is not None
    assert holder.stdout.readline() == "locked\n"
    with pytest.raises(Busy), only_writer(lock):
        pass
    with only_writer(lock.with_name(".other")):
        pass
    holder.kill()
    holder.communicate()
    with only_writer(lock), pytest.raises(Busy), only_writer(lock):
        pass
    assert list(lock.parent.iterdir()) == []


def test_who_waits_goes_after_the_other(tmp_path: Path) -> None:
    order: list[str] = []
    waiting = threading.Event()

    def second() -> None:
        waiting.set()
        with only_writer(tmp_path / ".lock", wait=60.0):
            order.append("second")

    thread = threading.Thread(target=second)
    with only_writer(tmp_path / ".lock"):
        thread.start()
        assert waiting.wait(60.0)
        thread.join(0.05)
        order.append("first")
    thread.join(60.0)
    assert order == ["first", "second"]


def test_an_error_of_the_block_is_not_taken_for_a_lock(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(BlockingIOError) as raised, only_writer(tmp_path / ".lock"):
        raise OSError(errno.EAGAIN, "of the block")
    assert not isinstance(raised.value, Busy | NoLock)

    def without_locks(*_: object) -> None:
        raise OSError(errno.ENOLCK, "no locks")

    monkeypatch.setattr("maglev.files.one_writer.lock", without_locks)
    with pytest.raises(NoLock), only_writer(tmp_path / ".lock"):
        pass


def test_a_folder_that_takes_no_lock_takes_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def read_only(*_: object) -> None:
        raise PermissionError(errno.EACCES, "Permission denied", str(tmp_path / ".lock"))

    monkeypatch.setattr("maglev.files.one_writer.Path.open", read_only)
    with pytest.raises(PermissionError) as raised, only_writer(tmp_path / ".lock"):
        pass
    assert raised.value.filename == str(tmp_path)


@pytest.mark.parametrize(("record", "own"), [
    ("{}", True), ("[]", True), ("no JSON", True), ('{"files": 3}', True), ('{"files": {"other.csv": "0"}}', True),
    ('{"files": {"run.csv": "0"}}', False), ('{"files": {"run.csv": 3}}', False),
    ('{"files": {"run.csv": null}}', False)])
def test_a_record_that_says_nothing_of_a_file_refuses_none(tmp_path: Path, record: str, own: bool) -> None:
    path = tmp_path / "run.csv"
    assert record_conflict(path) == ""
    path.write_text("a,b\n1,2\n", encoding="utf-8")
    (tmp_path / "run.json").write_text(record, encoding="utf-8")
    assert (record_conflict(path) == "") is own


def test_a_file_is_known_by_every_byte(tmp_path: Path) -> None:
    import json

    path = tmp_path / "run.csv"
    write_whole(path, "a,b\n1,2\n")
    write_whole(tmp_path / "run.json", json.dumps({FILES: {path.name: digest_at(path)}}))
    assert record_conflict(path) == ""
    for text in ("a,b\n1,3\n", "a,b\n1,2\n3,4\n", "a,b\n1,2", ""):
        write_whole(path, text)
        assert "does not belong to run.json next to it" in record_conflict(path)
