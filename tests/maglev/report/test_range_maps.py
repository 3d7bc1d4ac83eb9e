"""Maps of the operating range on the page: every cell as the data have it, of the stages that the report is about."""

import base64
import gzip
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from report_runs import packaged, page_of, recorded
from report_tab import Tab, wait_until

from maglev.maps.operating_range import OUTCOMES, Map, RigMaps, read_maps
from maglev.maps.rows import Origin
from maglev.maps.tolerances import QUESTIONS, read_tolerances
from maglev.report.outcome_maps import MARKED, RANGE, TOLERANCES, maps_data, of_rigs, section
from maglev.report.page import json_in_html, write_report

STAGES = ("2dof", "3dof", "5dof")
LARGEST = 25_000   # bytes: the report of all runs has to stay below 4 MB


def of_every_outcome() -> RigMaps:
    """Maps of one law in which every outcome occurs, in a grid that is not square."""
    ends = np.arange(12).reshape(3, 4, 1, 1) % len(OUTCOMES) * np.ones(3, dtype=int)
    ends[0, 0, 0, 2] = 5
    return RigMaps({"a < b": Map(np.array([1e-3, 2e-3, 3e-3]), np.array([1e-3, 2e-3, 3e-3, 4e-3]), np.array([0.0]),
                                 np.array([0.9, 1.0, 1.1]), ends)}, Origin("0.0", None, {}))


def cells_of(each: dict[str, Any], law: str) -> np.ndarray:
    """Outcomes that the page has of a law, shape (layers, down, along)."""
    data, = (found["packed"] for found in each["laws"] if found["name"] == law)
    shape = [len(each["factors"][k]["values"]) for k in (2, 0, 1)]
    return np.frombuffer(gzip.decompress(base64.b64decode(data)), np.uint8).reshape(shape)


@pytest.mark.parametrize("stage", [*STAGES, "4dof"])
def test_the_page_has_every_cell_as_the_data_have_it(stage: str) -> None:
    maps = {**read_maps(), "4dof": of_every_outcome()}[stage]
    each, = maps_data(RANGE, stage, maps).values()
    assert [law["name"] for law in each["laws"]] == [*maps.laws]
    assert each["outcomes"] == [*OUTCOMES, "settles only with the constants as they are"]
    assert len({*each["looks"]}) == len(each["outcomes"]) and each["looks"][-1] == MARKED
    for law, found in maps.laws.items():
        wanted = np.where(found.fragile, len(OUTCOMES), found.nominal)   # (down, along, steps)
        assert cells_of(each, law).tolist() == np.moveaxis(wanted, 2, 0).tolist()
    down, along, layers = each["factors"]
    assert [down["name"], along["name"], down["unit"]] == ["initial gap", "target gap", "mm"]
    assert down["values"] == [f"{1e3 * gap:g}" for gap in next(iter(maps.laws.values())).initial]
    assert layers["values"][0].startswith("No ")


@pytest.mark.parametrize("stage", STAGES)
def test_the_page_has_every_cell_of_tolerances_as_the_data_have_it(stage: str) -> None:
    maps = read_tolerances()[stage]
    for question, each in zip(QUESTIONS, maps_data(TOLERANCES, stage, maps).values(), strict=True):
        for law, found in maps.maps[question.name].items():
            assert cells_of(each, law).tolist() == found.tolist()
        assert each["factors"][1]["values"][1:] == [f"{value:g}" for value in question.along.values[1:]]
        assert all(heading.startswith(f"{question.down.name.capitalize()} and {question.along.name}")
                   for heading in each["factors"][2]["values"])


def test_the_page_tells_outcomes_apart_without_colour_and_hides_the_other_stage(browser, tmp_path: Path) -> None:
    results = [recorded(packaged(name)) for name in ("2dof-setpoints", "3dof-setpoints")]
    write_report(tmp_path / "report.html", results, {})
    tab = Tab(browser, tmp_path / "report.html")
    wait_until(tab.page, "document.querySelectorAll('article .maps canvas').length === 7 + 2 * 7")
    inks = tab.evaluate("""LOOKS.map(([, ink]) =>
        [...Array(24 * 24).keys()].map((k) => ink(k % 24, Math.floor(k / 24))).join())""")
    by_colour = tab.evaluate("LOOKS.map(([name]) => name)")
    assert len({*zip(by_colour, inks, strict=True)}) == len(inks) == 8
    assert len({ink for ink, name in zip(inks, by_colour, strict=True) if name != "text"}) == 7
    maps = tab.page.locator("#operating-range .maps canvas:visible")
    assert maps.count() == 7
    boxes = [each.bounding_box() for each in maps.all()]
    assert all(box and box["width"] > 100 and box["height"] > 100 for box in boxes)
    maps.first.focus()
    tab.page.keyboard.press("ArrowRight")
    said = tab.page.locator("#operating-range .place").first.text_content() or ""
    assert said.startswith("initial gap ") and "nonlinear " in said and tab.page.locator("article code").count() == 0
    tab.page.select_option("#index-rig", "2dof")
    assert maps.count() == 3
    assert tab.page.locator("#tolerances .maps canvas:visible").count() == 2 * 3
    tab.close()


def test_a_report_shows_the_stages_that_it_has_runs_of() -> None:
    page = page_of([recorded(packaged("3dof-setpoints"))])
    assert "range-3dof" in page.attributes("id")
    assert "range-2dof" not in page.attributes("id")
    assert "0.1 mm of its reference" in page.with_id("operating-range").text
    assert "#operating-range" in page.attributes("href")


def test_the_section_is_absent_without_data_of_the_stage() -> None:
    assert section(RANGE, of_rigs(RANGE, ["4dof"])) == section(TOLERANCES, of_rigs(TOLERANCES, [""])) == ""
    page = page_of([])
    assert not {"operating-range", "tolerances"} & {*page.attributes("id")}
    assert "#operating-range" not in page.attributes("href")


def test_the_maps_say_what_they_rest_on() -> None:
    text = " ".join(section(RANGE, of_rigs(RANGE, STAGES)).split())
    for maps in read_maps().values():
        commit = f" ({maps.origin.commit})" if maps.origin.commit else ""   # they may be flown from a tree without git
        assert f"Maglev FMUs {maps.origin.version}{commit}" in text
    assert "not of this report's runs" in text
    assert "<code>python -m studies.operating_range</code>" in text
    assert "times 0.95, 1 and 1.05," in text


def test_the_maps_take_few_bytes() -> None:
    for kind in (RANGE, TOLERANCES):
        data = [maps_data(kind, rig, maps) for rig, maps in of_rigs(kind, STAGES).items()]
        assert len(json_in_html(data)) + len(section(kind, of_rigs(kind, STAGES))) < LARGEST
