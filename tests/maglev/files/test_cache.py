"""What is kept where nothing can be written."""

from pathlib import Path

import pytest

from maglev.files import cache
from maglev.files.session import SESSION


def test_without_a_writable_cache_files_stay_in_this_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As under a home folder / of a user without one."""
    (tmp_path / "file").touch()
    monkeypatch.setenv(cache.PLACE, str(tmp_path / "file" / "cache"))
    with pytest.raises(NotADirectoryError):
        cache.keep("loops/1", "loop.so", b"code")
    assert cache.kept("loops/1", "loop.so") is None
    with SESSION.anew():
        entry = cache.keep_here("loops/1", "loop.so", b"code")
        assert entry.intact and entry.path.read_bytes() == b"code" and entry.path.name == "loop.so"
        assert cache.kept("loops/1", "loop.so") == entry
    assert not entry.path.parent.exists()
    assert cache.kept("loops/1", "loop.so") is None


def test_files_are_kept_in_the_cache_if_it_can_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(cache.PLACE, str(tmp_path))
    entry = cache.keep_here("loops/1", "loop.so", b"code")
    assert tmp_path in entry.path.parents and cache.kept("loops/1", "loop.so") == entry
