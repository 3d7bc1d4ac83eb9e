"""Maps of outcomes: every cell of a study in its place, and in a browser what became of it and how it is run again."""

import base64
import gzip
import json
import re
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pytest
from report_tab import DESKTOP, PHONE, Tab, violations, wait_until
from studied_grid import ABOUT

from maglev.pages.outcome_map import (
    ASTRAY,
    BROKEN,
    OUTCOMES,
    PASSES,
    STOPPED,
    TOUCHED,
    TRIPPED,
    Factor,
    map_of,
    outcomes_of,
)
from maglev.pages.sample_commands import command_of
from maglev.pages.study_page import study_page, write_maps

INF = float("inf")
SIDES = {"plant.a": [1.0, 2.0], "plant.b": [0.1 * k for k in range(12)], "plant.c": [-3.0, -1.0, 0.5, 2.0, 9.0, 10.0,
                                                                                     11.0, 12.0, 13.0]}
RAN = {**ABOUT, "design": {"kind": "grid"}, "targets": [*SIDES],
       "vary": [{"name": name, "set": [name]} for name in SIDES]}


def grid() -> tuple[pa.Table, dict[str, Any]]:
    """A grid of which the outcome follows from the values: a stop beyond a line that moves with a."""
    rows = [dict(zip(SIDES, values, strict=True)) for values in product(*SIDES.values())]
    passed = [row["plant.c"] < 4.0 * row["plant.a"] + 3.0 * row["plant.b"] for row in rows]
    made = pa.Table.from_pylist([{
        "sample": k, **row, "trip time": INF, "stop contact time": INF if passes else 0.1, "failed": float(not passes),
        "passed": passes, "ending": "completed" if passes else "failed: touched an end stop at 0.100 s",
        "failure": None} for k, (row, passes) in enumerate(zip(rows, passed, strict=True))],
        schema=pa.schema([("sample", pa.int64()), *((name, pa.float64()) for name in (
            *SIDES, "trip time", "stop contact time", "failed")), ("passed", pa.bool_()), ("ending", pa.string()),
            ("failure", pa.string())]))
    roles = dict.fromkeys(SIDES, b"varied") | dict.fromkeys(("trip time", "stop contact time", "failed"), b"metric")
    return made.cast(pa.schema([field.with_metadata({b"unit": b"", b"role": roles.get(field.name, b"")})
                                for field in made.schema])), RAN


@pytest.mark.parametrize(("passed", "early", "trip", "stop", "outcome"), [
    (True, False, INF, INF, PASSES), (True, False, INF, 0.1, TOUCHED), (False, False, INF, 0.1, STOPPED),
    (False, False, 0.1, 0.2, TRIPPED), (False, False, INF, INF, ASTRAY), (False, True, INF, INF, BROKEN)])
def test_the_first_cause_counts(passed: bool, early: bool, trip: float, stop: float, outcome: int) -> None:
    found = outcomes_of(pa.table({"passed": [passed], "failure": ["refused" if early else None], "trip time": [trip],
                                  "stop contact time": [stop]}))
    assert found.tolist() == [outcome]


def test_every_sample_is_in_its_cell() -> None:
    """The two with most values are the sides, whatever their order; of what has its values in disorder, too."""
    made, about = grid()
    found = map_of(made, about)
    assert found is not None
    assert [factor.name for factor in found.factors] == ["plant.b", "plant.c", "plant.a"]
    for row in made.to_pylist():
        at = {factor.name: factor.values.tolist().index(row[factor.name]) for factor in found.factors}
        expected = PASSES if row["passed"] else STOPPED
        assert found.cells[at["plant.a"], at["plant.b"], at["plant.c"]] == expected


def test_a_small_map_and_one_of_one_outcome_are_left_out() -> None:
    made, about = grid()
    one = made.filter(pa.compute.equal(made["plant.c"], -3.0))
    assert map_of(one, about) is None
    passing = made.set_column(made.schema.get_field_index("passed"), "passed", pa.array([True] * made.num_rows))
    assert map_of(passing.set_column(made.schema.get_field_index("stop contact time"), "stop contact time",
                                     pa.array([INF] * made.num_rows)), about) is None
    assert map_of(made, {**about, "design": {"kind": "sobol"}}) is None


def test_a_command_sets_what_all_samples_set_and_booleans() -> None:
    made, about = grid()
    found = map_of(made, {**about, "run": {**about["run"], "set": {"plant.a": 1.5, "plant.off": True, "plant.d": 7.0}}})
    assert found is not None
    assert found.command == f"{command_of(about, None)} --set plant.a=1.5 --set plant.off=true --set plant.d=7.0"
    off = Factor("plant.off", "", np.array([0.0, 1.0]), {"plant.off": np.array([False, True])})
    assert off.shown()["sets"] == {"plant.off": [False, True]}


def numbers(command: str) -> dict[str, float]:
    """What a command sets."""
    return {name: float(value) for name, value in re.findall(r"--set (\S+?)=(\S+)", command)}


@pytest.mark.parametrize(("viewport", "scheme"), [(DESKTOP, "light"), (PHONE, "dark")])
def test_a_place_says_what_became_of_it_and_how_it_is_run(browser, tmp_path: Path, viewport, scheme) -> None:
    made, about = grid()
    (tmp_path / "study.html").write_text(study_page(made, about), encoding="utf-8")
    tab = Tab(browser, tmp_path / "study.html", viewport)
    tab.page.emulate_media(color_scheme=scheme)
    wait_until(tab.page, "document.querySelector('.maps figcaption')?.textContent")
    assert "samples that pass" not in tab.evaluate("document.getElementById('metric')?.textContent ?? ''"), "seen once"
    tab.page.select_option(".layer", index=1)
    wait_until(tab.page, "/^plant.a 2: .* of the map$/.test(document.querySelector('.maps figcaption').textContent)")
    below, above = (tab.page.locator(f"#maps {part}").bounding_box() for part in (".maps", ".legend"))
    assert below is not None and above is not None and above["y"] + above["height"] <= below["y"], "looks come first"
    tab.page.locator(".maps canvas").scroll_into_view_if_needed()
    box = tab.page.locator(".maps canvas").bounding_box()
    assert box is not None
    row, column = 3, 6
    wide, tall = (box["width"] - 64) / 9, (box["height"] - 42) / 12   # as `MAP` has the room around
    place = box["x"] + 56 + wide * (column + 0.5), box["y"] + 6 + tall * (12 - row - 0.5)
    (tab.page.touchscreen.tap if viewport is PHONE else tab.page.mouse.click)(*place)
    sample = {"plant.a": 2.0, "plant.b": SIDES["plant.b"][row], "plant.c": SIDES["plant.c"][column]}
    said, expected = tab.page.inner_text("#maps code"), command_of(about, sample)
    assert said.split(" --set ")[0] == expected.split(" --set ")[0]
    assert numbers(said) == numbers(expected), "the same bits"
    assert tab.page.inner_text(".place") == f"plant.b 0.3, plant.c 11, plant.a 2: {OUTCOMES[STOPPED]}"
    tab.page.locator(".maps canvas").focus()
    tab.page.keyboard.press("ArrowLeft")
    assert OUTCOMES[STOPPED] in tab.page.inner_text(".place"), "10 is beyond 8.9"
    for _ in range(2):
        tab.page.keyboard.press("ArrowLeft")
    assert tab.page.inner_text(".place").endswith(f"plant.c 2, plant.a 2: {OUTCOMES[PASSES]}")
    whole = tab.evaluate("mapped.then(({ view }) => view.x[1] - view.x[0])")
    tab.page.click("[aria-label='zoom in']")
    assert tab.evaluate("mapped.then(({ view }) => view.x[1] - view.x[0])") < whole == 9
    tab.page.click("#maps >> text=all")
    assert tab.evaluate("mapped.then(({ view }) => view.x[1] - view.x[0])") == whole
    tab.page.click("text=Ranges as numbers")
    tab.page.locator("#ranges input").nth(2 * 2).fill("10")
    tab.page.keyboard.press("Tab")
    wait_until(tab.page, "document.querySelector('.maps figcaption').textContent.endsWith('in 13 % of what is kept')")
    assert tab.evaluate("document.documentElement.scrollWidth") == viewport["width"]
    assert violations(tab.page) == []
    tab.close()


def test_a_page_has_the_maps_of_laws_side_by_side(browser, tmp_path: Path) -> None:
    made, about = grid()
    found = map_of(made, about)
    assert found is not None
    words = ("lands", *OUTCOMES[1:])
    write_maps(tmp_path / "laws.html", "laws", "From where <each> lands.", [found, found], words)
    text = (tmp_path / "laws.html").read_text(encoding="utf-8")
    data = json.loads(re.search(r'id="data">(.*?)</script>', text).group(1))   # type: ignore[union-attr]
    cells = gzip.decompress(base64.b64decode(data["maps"]["laws"][1]["packed"]))
    assert [*cells] == found.cells.ravel().tolist()
    assert "From where &lt;each&gt; lands." in text
    tab = Tab(browser, tmp_path / "laws.html")
    wait_until(tab.page, "document.querySelectorAll('.maps figcaption').length === 2")
    share = 100 * np.mean(found.cells[0] == PASSES)
    wait_until(tab.page, f"document.querySelector('.maps figcaption').textContent.includes('lands in {share:.0f} %')")
    looks = tab.evaluate("""LOOKS.map(([name, ink]) =>
        [name, ...[...Array(24 * 24).keys()].map((k) => ink(k % 24, Math.floor(k / 24)))].join())""")
    assert len({*looks}) == len(looks) == len(OUTCOMES)
    assert len({look.partition(",")[2] for look in looks if not look.startswith("text")}) == 5, "also without colour"
    tab.close()
