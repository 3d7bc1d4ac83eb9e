"""The page of speed by version: it is what the history gives, and a benchmark adds to the file of its commit."""

import json
from pathlib import Path
from xml.etree import ElementTree

import pytest

from benchmarks import speed_history
from benchmarks.speed_history import Measured, history, page, picture, record

DOCS = Path(__file__).parents[2] / "docs"


def test_page_and_picture_are_of_the_history() -> None:
    assert (DOCS / "speed.md").read_text(encoding="utf-8") == page(history()), "`python benchmarks/speed_history.py`"
    assert (DOCS / "speed.svg").read_text(encoding="utf-8") == picture(history())
    assert ElementTree.fromstring(picture(history())).get("viewBox")


def test_curves_and_cells_are_of_the_commits_that_have_them() -> None:
    entries = [Measured("aaaaaaa", "2026-01-01", "0.1", {speed_history.WHOLE: {"in memory": 3.0}}),
               Measured("bbbbbbb", "2026-01-02", "0.1", {speed_history.STEP: {"x": 1.5}}),
               Measured("ccccccc", "2026-01-03", "0.2", {speed_history.WHOLE: {"in memory": 2.0}})]
    assert f"| in memory: {speed_history.WHOLE} | 3.00 |  | 2.00 |" in page(entries)
    left, right, top = speed_history.LEFT, speed_history.LEFT + speed_history.PANEL, speed_history.TOP
    below = top + speed_history.HEIGHT + speed_history.TOP + 22   # the second panel
    assert (f'points="{left:.1f},{below:.1f} {right:.1f},{below + speed_history.HEIGHT / 2:.1f}"'
            in picture(entries))


def test_ratios_are_added_to_the_file_of_the_commit(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(speed_history, "FOLDER", tmp_path)
    monkeypatch.setattr(speed_history, "head", lambda: ("abcdef0", "2026-01-01T00:00:00+00:00"))
    record(speed_history.STEP, {"one": 1.234, "two": 2.0})
    record(speed_history.STEP, {"two": 3.0})
    file, = tmp_path.iterdir()
    found = json.loads(file.read_text(encoding="utf-8"))
    assert found["commit"] == file.stem == "abcdef0"
    assert found["ratios"] == {speed_history.STEP: {"one": 1.23, "two": 3.0}}


def test_curves_and_labels_stay_within_their_panel() -> None:
    """Also of ratios below 1 that all end near its foot."""
    entries = [Measured("aaaaaaa", "2026-01-01", "0.1", {speed_history.STEP: {"x": 4.5, "y": 4.0, "z": 1.2}}),
               Measured("bbbbbbb", "2026-01-02", "0.1", {speed_history.STEP: {"x": 0.8, "y": 0.84, "z": 0.74}})]
    foot = speed_history.TOP + speed_history.HEIGHT
    root = ElementTree.fromstring(picture(entries))
    space = "{http://www.w3.org/2000/svg}"
    points = [float(point.split(",")[1]) for curve in root.iter(f"{space}polyline")
              for point in curve.attrib["points"].split()]
    labels = [float(text.attrib["y"]) for text in root.iter(f"{space}text") if text.get("class", "").startswith("s")]
    assert min(points) >= speed_history.TOP and max(points) == foot
    assert len(labels) == 3 and max(labels) <= foot + 4
    assert min(b - a for a, b in zip(sorted(labels), sorted(labels)[1:], strict=False)) >= speed_history.LINE - 0.1
