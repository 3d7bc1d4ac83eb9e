"""Maps of the operating range on the page: every cell as the data have it, of the stages that the report is about."""

import base64
import gzip
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from report_runs import packaged, page_of, recorded
from report_tab import Tab, wait_until

from maglev.pages import report_page
from maglev.pages.figures import stage_name
from maglev.pages.grids import Grid, Origin, StageGrids, read_grids
from maglev.pages.operating_range import OUTCOMES, SETTLED
from maglev.pages.outcome_maps import MARKED, RANGE, TOLERANCES, map_data, maps_section, of_stages
from maglev.pages.report_page import json_in_html, write_report
from maglev.pages.tolerances import QUESTIONS
from maglev.scenario.layers import packaged_runs

STAGES = ("2dof", "3dof", "5dof")
LARGEST = 25_000   # bytes: the report of all runs has to stay below 4 MB


def of_every_outcome() -> StageGrids:
    """Maps of one law in which every outcome occurs, in a grid that is not square."""
    ends = np.tile(np.arange(12, dtype=np.uint8).reshape(3, 4) % len(OUTCOMES), (1, 3, 1, 1))
    ends[0, 2, 0, 0] = 5
    varied = {"tilt": [0.0], "constants": [0.9, 1.0, 1.1], "initial gap": [1e-3, 2e-3, 3e-3],
              "target gap": [1e-3, 2e-3, 3e-3, 4e-3]}
    return StageGrids({"moves": Grid({name: np.array(values) for name, values in varied.items()}, {"a < b": ends})},
                    Origin("0.0", None, {}))


def cells_of(each: dict[str, Any], law: str) -> np.ndarray:
    """Outcomes that the page has of a law, shape (layers, down, along)."""
    data, = (found["packed"] for found in each["laws"] if found["name"] == law)
    shape = [len(each["factors"][k]["values"]) for k in (2, 0, 1)]
    return np.frombuffer(gzip.decompress(base64.b64decode(data)), np.uint8).reshape(shape)


@pytest.mark.parametrize("stage", [*STAGES, "4dof"])
def test_the_page_has_every_cell_as_the_data_have_it(stage: str) -> None:
    found = {**read_grids(RANGE.file), "4dof": of_every_outcome()}[stage]
    each, = map_data(RANGE, stage, found).values()
    grid, = found.grids.values()
    assert [law["name"] for law in each["laws"]] == [*grid.laws]
    assert each["outcomes"] == [*OUTCOMES, "settles only with the constants as they are"]
    assert len({*each["looks"]}) == len(each["outcomes"]) and each["looks"][-1] == MARKED
    as_they_are = grid.varied["constants"].tolist().index(1.0)
    for law, ends in grid.laws.items():   # (steps, constants, down, along)
        fragile = (ends[:, as_they_are] == SETTLED) & (ends != SETTLED).any(axis=1)
        assert cells_of(each, law).tolist() == np.where(fragile, len(OUTCOMES), ends[:, as_they_are]).tolist()
    down, along, layers = each["factors"]
    assert [down["name"], along["name"], down["unit"]] == ["initial gap", "target gap", "mm"]
    assert down["values"] == [f"{1e3 * gap:g}" for gap in grid.varied["initial gap"]]
    assert layers["values"][0].startswith("No ")


@pytest.mark.parametrize("stage", STAGES)
def test_the_page_has_every_cell_of_tolerances_as_the_data_have_it(stage: str) -> None:
    found = read_grids(TOLERANCES.file)[stage]
    for question, each in zip(QUESTIONS, map_data(TOLERANCES, stage, found).values(), strict=True):
        for law, ends in found.grids[question.name].laws.items():
            assert cells_of(each, law).tolist() == ends.tolist()
        assert each["factors"][1]["values"][1:] == [f"{value:g}" for value in question.along.values[1:]]
        assert all(heading.startswith(f"{question.down.name.capitalize()} and {question.along.name}")
                   for heading in each["factors"][2]["values"])


def test_the_page_tells_outcomes_apart_without_colour_and_hides_the_other_stage(
        browser, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(report_page, "mapped_stages", lambda results: {result.plan.stage.name for result in results})
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
    tab.page.select_option("#index-stage", "2dof")
    assert maps.count() == 3
    assert tab.page.locator("#tolerances .maps canvas:visible").count() == 2 * 3
    tab.close()


def test_a_report_shows_the_stages_that_it_has_most_runs_of(monkeypatch: pytest.MonkeyPatch) -> None:
    run = recorded(packaged("3dof-setpoints"))
    every: Any = [SimpleNamespace(plan=SimpleNamespace(name=name, stage=SimpleNamespace(name=stage_name(name))))
             for name in packaged_runs()]
    assert report_page.mapped_stages([run]) == set()
    assert report_page.mapped_stages(every) >= {*STAGES}
    assert "#operating-range" not in page_of([run]).attributes("href")
    monkeypatch.setattr(report_page, "mapped_stages", lambda _: {"3dof"})
    page = page_of([run])
    assert "range-3dof" in page.attributes("id")
    assert "range-2dof" not in page.attributes("id")
    assert "0.1 mm of its reference" in page.with_id("operating-range").text
    assert "#operating-range" in page.attributes("href")


def test_the_section_is_absent_without_data_of_the_stage() -> None:
    assert maps_section(RANGE, of_stages(RANGE, ["4dof"])) == maps_section(TOLERANCES,
                                                                           of_stages(TOLERANCES, [""])) == ""
    page = page_of([])
    assert not {"operating-range", "tolerances"} & {*page.attributes("id")}
    assert "#operating-range" not in page.attributes("href")


def test_the_maps_say_what_they_rest_on() -> None:
    text = " ".join(maps_section(RANGE, of_stages(RANGE, STAGES)).split())
    for found in read_grids(RANGE.file).values():
        commit = f" ({found.origin.commit})" if found.origin.commit else ""   # a tree without git has none
        assert f"Maglev FMUs {found.origin.version}{commit}" in text
    assert "not of this report's runs" in text
    assert "<code>python -m studies.operating_range</code>" in text
    assert "times 0.95, 1 and 1.05," in text


def test_the_maps_take_few_bytes() -> None:
    for kind in (RANGE, TOLERANCES):
        data = [map_data(kind, stage, found) for stage, found in of_stages(kind, STAGES).items()]
        assert len(json_in_html(data)) + len(maps_section(kind, of_stages(kind, STAGES))) < LARGEST
