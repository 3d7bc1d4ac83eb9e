"""The loop with a generator and a supervisor as Python files: the page shows what runs, and the push is waited out."""

import re
import tomllib
from pathlib import Path

import numpy as np
import pytest

import maglev

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples" / "wired_loop"


def test_the_page_has_the_scenario() -> None:
    page = (ROOT / "docs" / "scenarios.md").read_text(encoding="utf-8")
    block = re.search(r"((?:^    .*\n|^\n)+)", page[page.index("`examples/wired_loop` is"):], re.MULTILINE)
    assert block is not None
    shown = tomllib.loads(re.sub("^    ", "", block[1], flags=re.MULTILINE))
    file = tomllib.loads((FOLDER / "pushed.toml").read_text(encoding="utf-8"))
    for name in ("supervisor", "generator", "controller"):
        assert shown["fmus"][name] == file["fmus"][name]
    assert shown["variants"]["goes-on"]["fmus"] == file["variants"]["goes-on"]["fmus"]


def test_the_supervisor_has_the_generator_wait(fastest_fmus: Path, tmp_path: Path) -> None:
    runs = {}
    for name, source in (("waits", "supervisor.hold"), ("continues", "")):
        path = tmp_path / "pushed.toml"
        text = (FOLDER / "pushed.toml").read_text(encoding="utf-8").split("[variants.")[0]
        path.write_text(text.replace('hold = "supervisor.hold"', f'hold = "{source}"').replace(
                '"1.5 s"', '"0.8 s"\noutput_interval = "0.5 ms"'))
        for file in FOLDER.glob("*.py"):
            (tmp_path / file.name).write_text(file.read_text(encoding="utf-8"))
        runs[name] = maglev.run(path, fmus=fastest_fmus)
    waits, on = runs["waits"], runs["continues"]
    held = waits["supervisor.hold"][1:] != 0   # in the same step: the generator is stepped after it
    moved = np.diff(waits["generator.v.reference"])
    assert 0.01 < 0.5e-3 * held.sum() < 0.5
    assert np.all(moved[held] == 0.0)
    assert waits["generator.v.reference"][-1] == pytest.approx(22e-3) == on["generator.v.reference"][-1]
    # A minimum-jerk way of 0.4 s passes its middle after 0.2 s, later by as long as it was held before.
    middle = [run.time[np.argmax(run["generator.v.reference"] >= 21e-3)] for run in (on, waits)]
    assert middle[0] == pytest.approx(0.3, abs=1e-3)
    before = held[:np.argmax(waits["generator.v.reference"] >= 21e-3)].sum() * 0.5e-3
    assert middle[1] - middle[0] == pytest.approx(before, abs=1e-3)
