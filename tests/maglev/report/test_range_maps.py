"""Maps of the operating range on the page: every cell as the data have it, of the stages that the report is about."""

import re
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from report_runs import packaged, page_of, recorded
from report_tab import Tab

from maglev.maps.operating_range import OUTCOMES, Map, RigMaps, read_maps, shares
from maglev.maps.rows import Origin
from maglev.maps.tolerances import QUESTIONS, read_tolerances
from maglev.report.outcome_maps import RANGE, TOLERANCES, section
from maglev.report.page import write_report

STAGES = ("2dof", "3dof", "5dof")
LARGEST = 25_000   # bytes: the report of all runs has to stay below 4 MB


def drawn(path: str, shape: tuple[int, int]) -> np.ndarray:
    """How often a path runs through each cell."""
    runs = re.findall(r"M([\d.]+) ([\d.]+)h(\d+)", path)
    assert "".join(f"M{x} {y}h{length}" for x, y, length in runs) == path
    count = np.zeros(shape, dtype=int)
    for x, y, length in runs:
        count[int(y), int(float(x)):int(float(x)) + max(int(length), 1)] += 1   # a dot has no length
    return count


def pictures(text: str, stage: str) -> list[ElementTree.Element]:
    """Maps of a stage in the order of the page; the section is also well-formed XML."""
    article, = [each for each in ElementTree.fromstring(text).iter("article") if each.get("data-rig") == stage]
    return [svg for svg in article.iter("svg") if svg.get("role") == "img"]


def of_every_outcome() -> RigMaps:
    """Maps of one law in which every outcome occurs, in a grid that is not square."""
    ends = np.arange(12).reshape(3, 4, 1, 1) % len(OUTCOMES) * np.ones(3, dtype=int)
    ends[0, 0, 0, 2] = 5
    return RigMaps({"a < b": Map(np.array([1e-3, 2e-3, 3e-3]), np.array([1e-3, 2e-3, 3e-3, 4e-3]), np.array([0.0]),
                                 np.array([0.9, 1.0, 1.1]), ends)}, Origin("0.0", None, {}))


@pytest.mark.parametrize("stage", [*STAGES, "4dof"])
def test_every_cell_is_drawn_as_the_data_have_it(stage: str) -> None:
    rigs = {**read_maps(), "4dof": of_every_outcome()}
    maps = rigs[stage]
    flown = [(law, found, step) for step in range(len(next(iter(maps.laws.values())).steps))
             for law, found in maps.laws.items()]
    for (law, found, step), svg in zip(flown, pictures(section(RANGE, [stage], rigs), stage), strict=True):
        nominal = found.nominal[::-1, :, step]   # the largest initial gap is on top
        paths = {path.get("class"): drawn(path.get("d") or "", nominal.shape) for path in svg.iter("path")}
        dots = paths.pop("dot", np.zeros(nominal.shape, dtype=int))
        assert dots.tolist() == found.fragile[::-1, :, step].astype(int).tolist()
        assert paths.keys() == {f"o{outcome}" for outcome in np.unique(nominal)}
        for outcome in np.unique(nominal):
            assert paths[f"o{outcome}"].tolist() == (nominal == outcome).astype(int).tolist()
        title = svg.findtext("title") or ""
        assert title.startswith(f"{law}. ")
        for name, share in zip(OUTCOMES, shares(found)[step][1], strict=True):
            assert (f" {name} {100 * share:.0f} %" in title) == (share > 0)
        gaps = [f"{1e3 * gaps[k]:g}" for gaps in (found.target, found.initial) for k in (0, len(gaps) // 2, -1)]
        assert [text.text for text in svg.iter("text")] == [*gaps, "target gap, mm", "initial gap, mm"]


@pytest.mark.parametrize("stage", STAGES)
def test_every_cell_of_a_map_of_tolerances_is_drawn_as_the_data_have_it(stage: str) -> None:
    maps = read_tolerances()[stage]
    flown = [(law, question, found[step]) for question in QUESTIONS for step in range(len(maps.sizes))
             for law, found in maps.maps[question.name].items()]
    for (law, question, found), svg in zip(flown, pictures(section(TOLERANCES, [stage]), stage), strict=True):
        paths = {path.get("class"): drawn(path.get("d") or "", found.shape) for path in svg.iter("path")}
        assert paths.keys() == {TOLERANCES.looks[outcome] for outcome in np.unique(found)}
        for outcome in np.unique(found):   # the harmless row is the lowest
            assert paths[TOLERANCES.looks[outcome]][::-1].tolist() == (found == outcome).astype(int).tolist()
        assert (svg.findtext("title") or "").startswith(
            f"{law}. {question.down.name.capitalize()} and {question.along.name}")
        texts = [text.text for text in svg.iter("text")]
        assert texts[1:len(question.along.values)] == [f"{value:g}" for value in question.along.values[1:]]


def test_the_legend_tells_every_outcome_that_occurs() -> None:
    text = section(RANGE, ["4dof"], {"4dof": of_every_outcome()})
    legend, = [each for each in ElementTree.fromstring(text).iter("ul") if each.get("class") == "range-legend"]
    assert ["".join(item.itertext()).strip() for item in legend] == [
        *OUTCOMES, "settles only with the constants as they are"]


def test_the_page_tells_outcomes_apart_without_colour_and_hides_the_other_stage(browser, tmp_path: Path) -> None:
    results = [recorded(packaged(name)) for name in ("2dof-setpoints", "3dof-setpoints")]
    write_report(tmp_path / "report.html", results, {})
    tab = Tab(browser, tmp_path / "report.html")
    looks = tab.evaluate("""(count) => [...Array(count).keys()].map((outcome) => {
        const path = document.querySelector(".range path").cloneNode();
        path.setAttribute("class", `o${outcome}`);
        document.querySelector(".range g").append(path);
        const { stroke, strokeWidth, strokeDasharray } = getComputedStyle(path);
        return [stroke !== "none" && strokeWidth, strokeDasharray];
    })""", len(OUTCOMES))
    assert len({tuple(look) for look in looks}) == len(OUTCOMES)
    assert all(width for width, _ in looks)
    maps = tab.page.locator("#operating-range .range svg:visible")
    assert maps.count() == 14
    boxes = [each.bounding_box() for each in maps.all()]
    assert all(box and box["width"] > 100 and box["height"] > 100 for box in boxes)
    tolerances = tab.page.locator("#tolerances .range svg:visible")
    assert tolerances.count() == 4 * 7
    labels = tab.evaluate("""() => [...document.querySelectorAll("#tolerances .range svg")].flatMap((svg) => {
        const boxes = [...svg.querySelectorAll("text")].map((text) => text.getBoundingClientRect());
        return boxes.filter((a, i) => boxes.some((b, k) => k < i && a.left < b.right && b.left < a.right
            && a.top + 3 < b.bottom && b.top + 3 < a.bottom)).length;
    })""")
    assert not any(labels), "labels of a map cover each other"
    tab.page.select_option("#index-rig", "2dof")
    assert maps.count() == 6
    assert tolerances.count() == 4 * 3
    tab.close()


def test_a_report_shows_the_stages_that_it_has_runs_of() -> None:
    page = page_of([recorded(packaged("3dof-setpoints"))])
    assert "range-3dof" in page.attributes("id")
    assert "range-2dof" not in page.attributes("id")
    assert "0.1 mm of its reference" in page.with_id("operating-range").text
    assert "#operating-range" in page.attributes("href")


def test_the_section_is_absent_without_data_of_the_stage() -> None:
    assert section(RANGE, ["3dof"], {"2dof": read_maps()["2dof"]}) == ""
    assert section(RANGE, [""]) == section(TOLERANCES, [""]) == ""
    page = page_of([])
    assert not {"operating-range", "tolerances"} & {*page.attributes("id")}
    assert "#operating-range" not in page.attributes("href")


def test_the_maps_say_what_they_rest_on() -> None:
    text = " ".join(section(RANGE, STAGES).split())
    for maps in read_maps().values():
        commit = f" ({maps.origin.commit})" if maps.origin.commit else ""   # they may be flown from a tree without git
        assert f"Maglev FMUs {maps.origin.version}{commit}" in text
    assert "not of this report's runs" in text
    assert "<code>python -m studies.operating_range</code>" in text
    assert "times 0.95, 1 and 1.05," in text


def test_the_maps_take_few_bytes() -> None:
    assert len(section(RANGE, STAGES).encode()) < LARGEST
    assert len(section(TOLERANCES, STAGES).encode()) < 2 * LARGEST
