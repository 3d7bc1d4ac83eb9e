"""The page of speed by version: it is what the history gives, and a benchmark adds to the file of its commit."""

import json
from pathlib import Path

import pytest

from benchmarks import speed_history
from benchmarks.speed_history import Measured, history, record, speed_page

DOCS = Path(__file__).parents[2] / "docs"


def test_page_is_of_the_history() -> None:
    written = (DOCS / "speed.md").read_text(encoding="utf-8")
    assert written == speed_page(history()), "`python benchmarks/speed_history.py`"


def test_cells_are_of_the_commits_that_have_them() -> None:
    entries = [Measured("aaaaaaa", "2026-01-01", "0.1", {speed_history.WHOLE: {"in memory": 3.0}}),
               Measured("bbbbbbb", "2026-01-02", "0.1", {speed_history.STEP: {"x": 1.5}}),
               Measured("ccccccc", "2026-01-03", "0.2", {speed_history.WHOLE: {"in memory": 2.0}})]
    assert f"| in memory: {speed_history.WHOLE} | 2.00 |  | 3.00 |" in speed_page(entries)


def test_ratios_are_added_to_the_file_of_the_commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speed_history, "FOLDER", tmp_path)
    monkeypatch.setattr(speed_history, "head", lambda: ("abcdef0", "2026-01-01T00:00:00+00:00"))
    record(speed_history.STEP, {"one": 1.234, "two": 2.0})
    record(speed_history.STEP, {"two": 3.0})
    file, = tmp_path.iterdir()
    found = json.loads(file.read_text(encoding="utf-8"))
    assert found["commit"] == file.stem == "abcdef0"
    assert found["ratios"] == {speed_history.STEP: {"one": 1.23, "two": 3.0}}
