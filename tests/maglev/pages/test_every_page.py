"""Pages of every kind, as they are seen: three widths, light and dark, on paper, under a finger, by axe-core."""

import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
import pytest
from report_runs import packaged, recorded
from report_tab import ALONE, CONTRAST, DESKTOP, LANDSCAPE, PHONE, SHIFTS, SMALL, WIDE, Tab, violations, wait_until
from studied_grid import broken_at

from maglev.files.text_columns import unbroken
from maglev.pages.comparison_files import compared_rows, comparison_page
from maglev.pages.live_page import live_page
from maglev.pages.shell import HEAD, INDEX, colour, publish
from maglev.pages.study_page import study_page

if TYPE_CHECKING:
    from playwright.sync_api import ViewportSize

WIDTHS = (1440, 820, 390)   # px
PLOTTED = "document.querySelector('.plot').scrollIntoView() || document.querySelector('.panel-plot') !== null"
RUNS = "maglevLive.frames > 5"
MANY = ("#figures figure:nth-of-type(n+4)", "table.claims > tbody:nth-of-type(n+4)", "#assumptions dl")   # of a kind

GOOD = {"wide": 0, "covered": False, "cut": [], "over": []}
# Buttons have changed their colour.
CALM = "Promise.allSettled(document.getAnimations().map(({ finished }) => finished)).then(() => null)"
# What is wider than the window, whether the head covers what follows, what its own box or the window cuts off, and
# which texts in the window lie over each other.
LOOK = """() => {
  const [head, main] = ["header", "main"].map((name) => document.querySelector(name).getBoundingClientRect());
  const within = (element, holds) => element
    && (holds(getComputedStyle(element)) || within(element.parentElement, holds));
  const seen = (element) => element.checkVisibility({ visibilityProperty: true }) && element.clientWidth > 1
    && !element.closest("svg, select")
    && !within(element, ({ clipPath }) => clipPath === "inset(50%)");   // what screen readers read
  const cuts = (element) => {
    const { overflowX, textOverflow } = getComputedStyle(element);      // dots say that there is more
    return ["hidden", "clip"].includes(overflowX) && textOverflow !== "ellipsis"
      && element.scrollWidth > element.clientWidth + 1;
  };
  const beyond = (element) => element.getBoundingClientRect().right > innerWidth + 1
    && !within(element, ({ overflowX }) => ["auto", "scroll"].includes(overflowX));
  const all = [...document.body.querySelectorAll("*")]
    .filter((element) => (beyond(element) || cuts(element)) && seen(element));
  const scrolls = (element) => (!element ? null : getComputedStyle(element).overflowY === "visible"
    ? scrolls(element.parentElement) : element.getBoundingClientRect());
  const texts = [], walk = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT), range = new Range();
  const above = ({ position, clipPath }) => ["absolute", "sticky"].includes(position) || clipPath === "inset(50%)";
  while (walk.nextNode()) {
    const element = walk.currentNode.parentElement, words = walk.currentNode.data.trim();
    if (!words || element.closest("script, style, select, textarea, noscript")) continue;
    range.selectNodeContents(walk.currentNode);
    const boxes = [...range.getClientRects()].filter(({ bottom, top }) => bottom > 0 && top < innerHeight);
    if (!boxes.length || !element.checkVisibility({ visibilityProperty: true }) || within(element, above)) continue;
    const room = scrolls(element);   // what is scrolled out of it is not seen
    for (const { left, right, top, bottom } of boxes) {
      if (!room || (top >= room.top - 1 && bottom <= room.bottom + 1)) texts.push({ left, right, top, bottom, words });
    }
  }
  const over = texts.filter((a, i) => texts.some((b, k) => k < i && a.left + 2 < b.right && b.left + 2 < a.right
    && a.top + 5 < b.bottom && b.top + 5 < a.bottom)).map(({ words }) => words);
  return { wide: document.documentElement.scrollWidth - innerWidth, covered: head.bottom > main.top + 1,
    cut: all.map((element) => element.outerHTML.slice(0, 80)), over };
}"""


@pytest.fixture(scope="module")
def pages(report: Path, wasm_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a page of each kind, and the index that they make."""
    folder = tmp_path_factory.mktemp("pages")
    shutil.copy(report, folder)
    runs = {name: recorded(packaged(f"2dof-step-4-{name}"), rms_errors={"v": error, "h": error})
            for name, error in (("linear", 2e-5), ("nonlinear", 1e-5))}
    publish(folder / "live.html", live_page(wasm_fmus, [packaged("3dof-setpoints-improved")]))
    publish(folder / "compare.html", comparison_page("2dof-step-4", "Two laws", runs, compared_rows(runs)))
    publish(folder / "study.html", study_page(*broken_at()))
    return folder


@pytest.mark.thorough
def test_nothing_is_cut_or_covered_in_the_report_of_every_run(browser, whole_report: Path) -> None:
    test_nothing_is_cut_or_covered_and_all_can_be_read(browser, whole_report.parent, "report.html", PLOTTED)


@pytest.mark.parametrize(("name", "drawn"), [
    ("report.html", PLOTTED), ("compare.html", PLOTTED), ("study.html", "true"), ("live.html", RUNS),
    (INDEX, "true")], ids=["report", "compare", "study", "live", "index"])
def test_nothing_is_cut_or_covered_and_all_can_be_read(browser, pages: Path, name: str, drawn: str) -> None:
    tab = Tab(browser, pages / name, reduced_motion="reduce" if name == "report.html" else "no-preference")
    wait_until(tab.page, drawn)
    for width in WIDTHS:
        tab.page.set_viewport_size({"width": width, "height": 900})
        for _ in range(100):   # until what is drawn is drawn again
            found = tab.evaluate(LOOK)
            if found == GOOD:
                break
            tab.page.wait_for_timeout(50)
        assert found == GOOD, width
    wrong: list[str] = []
    for scheme in ("light", "dark"):
        tab.page.emulate_media(color_scheme=scheme)
        seen = tab.evaluate(CONTRAST, "h1")
        assert seen["ratio"] >= 7 and (seen["paper"] < 0.1) == (scheme == "dark")
        tab.evaluate(CALM)
        wrong += violations(tab.page, MANY)   # of a phone
    problems = tab.problems + tab.evaluate("window.maglevReport?.errors ?? window.maglevLive?.problems ?? []")
    tab.context.close()
    assert (problems, wrong) == ([], [])


@pytest.mark.few(8)
@pytest.mark.parametrize("size", [WIDE, PHONE, LANDSCAPE], ids=["desktop", "phone", "landscape"])
@pytest.mark.parametrize("name", ["report.html", "compare.html", "study.html", "live.html", INDEX])
def test_nothing_moves_by_itself_and_a_finger_hits_what_it_means(browser, pages: Path, name: str,
                                                                 size: "ViewportSize") -> None:
    for attempt in range(3):   # a machine with other work paints a page of which it has not all
        tab = Tab(browser, pages / name, size)
        wait_until(tab.page, RUNS if name == "live.html" else "document.readyState === 'complete'")
        tab.page.wait_for_timeout(1000)   # what is drawn first is drawn
        shifts = tab.evaluate(SHIFTS)
        if sum(value for value, *_ in shifts) < 0.05:
            break
        assert attempt < 2, shifts
        tab.context.close()
    if size is not WIDE:
        assert tab.evaluate("matchMedia('(pointer: coarse)').matches")
        tab.evaluate("document.querySelectorAll('details').forEach((each) => { each.open = true; })")
        assert tab.evaluate(SMALL) == []
        assert tab.evaluate("document.documentElement.scrollWidth - innerWidth") <= 0
    tab.context.close()


def test_ways_to_other_pages_are_one_line_on_a_phone(browser, pages: Path) -> None:
    tab = Tab(browser, pages / "study.html", PHONE)
    assert tab.page.locator(".shell > *").count() == 5
    assert tab.evaluate("document.querySelector('.shell').clientHeight") < 60
    tab.close()


def test_every_page_says_what_it_is(pages: Path) -> None:
    for path in pages.glob("*.html"):
        head = path.read_text(encoding="utf-8")[:HEAD]
        about, title, said = (re.findall(rf'<meta {key} content="([^"]*)">', head) for key in (
            'name="description"', 'property="og:title"', 'property="og:description"'))
        assert len(about) == 1 and about == said and len(about[0]) > 20 and not re.search("[<>]", about[0])
        assert re.findall("<title>(.*)</title>", head) == title
        assert head.count('<link rel="icon" href="data:image/svg+xml,%3Csvg') == 1
    assert "nonlinear is better" in (pages / "compare.html").read_text(encoding="utf-8")[:HEAD]


def test_a_phone_shows_the_table_of_a_comparison_whole(browser, tmp_path: Path) -> None:
    """Three controllers and by how much the best one is ahead, a line each: no name breaks within a word."""
    runs = {label: recorded(packaged("3dof-setpoints"), rms_errors={"y": error, "x": error, "z": 5e-6})
            for label, error in (("Regulator3DOF", 5.2e-6), ("LinearRegulator3DOF", 31e-6), ("PID3DOF", 22e-6))}
    publish(tmp_path / "compare.html", comparison_page("3dof-setpoints", "Three laws", runs, compared_rows(runs)))
    tab = Tab(browser, tmp_path / "compare.html", PHONE)
    lines = tab.evaluate("""[...document.querySelector(".values tbody tr").cells].slice(1).map((cell) =>
        [cell.dataset.label, cell.innerText.replace("\\u00a0", " "), cell.clientWidth < cell.scrollWidth,
         cell.clientHeight < 30])""")
    empty = tab.evaluate("[...document.querySelectorAll('.values td:empty')].map((cell) => cell.checkVisibility())")
    assert empty and not any(empty), "where none is the best, no line says by how much"
    tab.close()
    assert lines == [["Regulator3DOF", "5.2 µm ★", False, True], ["LinearRegulator3DOF", "31 µm", False, True],
                     ["PID3DOF", "22 µm", False, True], ["the next is", "4.2 times", False, True]]


def test_a_comparison_begins_with_its_verdict_and_its_sections_have_one_legend(browser, pages: Path) -> None:
    """Then the table, next to it the stages moving in one picture, and plots: a run has one colour and one dash."""
    tab = Tab(browser, pages / "compare.html", reduced_motion="reduce")
    tab.evaluate("maglevReport.drawAll()")
    wait_until(tab.page, "maglevReport.views && Object.keys(maglevReport.plots).length === 4")
    h1, message, table, stage, plot = (tab.page.locator(part).first.bounding_box() for part in (
        "h1", ".message", "table", "#player-stage", ".panel-plot"))
    assert h1 and message and table and stage and plot
    assert h1["y"] < message["y"] < stage["y"] < table["y"] < plot["y"]
    assert table["x"] + table["width"] < stage["x"] and stage["y"] + stage["height"] < DESKTOP["height"]
    assert tab.page.inner_text(".message") == unbroken(
        "nonlinear is better in 2 of 2 rows about axes (most in rms error of v, 10 µm against 20 µm).")
    assert [legend.locator("button").all_text_contents() for legend in tab.page.locator("[data-legend]").all()] == 2 * [
        ["linear", "nonlinear"]]
    assert tab.page.locator(".panel .legend button").count() == 0
    looks, legend = tab.evaluate("""(() => {
        const look = ({ style }) => `${style.stroke}; ${style.strokeDasharray.replaceAll("px", "")}`;
        const lines = (name) => [...document.querySelectorAll(".line")]
            .filter(({ dataset }) => dataset.name.split(" ").at(-1) === name);
        return [["linear", "nonlinear"].map((name) => [...new Set(lines(name).map(look))]),
            [...document.querySelectorAll("#legend button path")].map((path) => [look(path)])];
    })()""")
    assert looks == [["var(--run-2); none"], ["var(--run-0); 7, 4"]] == legend
    drawn = tab.evaluate("maglevReport.views.drawn.map(({ name, colour }) => [name, colour])")
    assert drawn == [["linear", colour("run-2")], ["nonlinear", colour("run-0")]]
    tab.page.locator("#legend button").first.click()
    gone = """[...document.querySelectorAll(".line")].filter(({ dataset }) => / ?linear$/.test(dataset.name)
        && !dataset.name.endsWith("nonlinear")).length"""
    wait_until(tab.page, f"{gone} === 0")
    tab.close()


def test_a_comparison_on_paper_has_its_plots_and_no_buttons(browser, pages: Path) -> None:
    """By the browser's menu, before anything was scrolled to."""
    tab = Tab(browser, pages / "compare.html")
    tab.evaluate("""() => addEventListener("beforeprint", () => {
        window.paper = [...document.querySelectorAll("figure")]
            .map((figure) => figure.querySelectorAll(".panel-plot .line").length);
        window.widest = Math.max(...[...document.querySelectorAll(".panel-plot")]
            .map((picture) => picture.viewBox.baseVal.width)); })""")
    wait_until(tab.page, "Object.keys(maglevReport.ready).length === 2")
    printed = tab.page.pdf()
    assert min(tab.evaluate("window.paper")) > 0
    assert tab.evaluate("window.widest") < 182 / 25.4 * 96 + 10, "wider ones shrink, and their letters with them"
    assert 2 <= printed.count(b"/Type /Page\n") <= 8
    tab.page.emulate_media(media="print")
    assert not any(button.is_visible() for button in tab.page.locator("button:not(.legend button)").all())
    assert tab.evaluate("getComputedStyle(document.querySelector('.panel')).breakInside") == "avoid"
    tab.close()


@pytest.mark.parametrize(("name", "drawn"), [("live.html", RUNS), ("compare.html", "!!maglevReport.views")])
def test_a_picture_is_printed_in_colours_of_paper(browser, pages: Path, name: str, drawn: str) -> None:
    """Of a reader of dark screens, too."""
    tab = Tab(browser, pages / name)
    tab.page.emulate_media(color_scheme="dark")
    wait_until(tab.page, drawn)
    tab.evaluate("""() => {
        window.bright = () => { const canvas = document.querySelector("canvas"), { width, height } = canvas;
            const { data } = canvas.getContext("2d").getImageData(0, 0, width, height);
            return data.reduce((sum, value) => sum + value, 0) / data.length; };
        addEventListener("beforeprint", () => { window.printed = bright(); }); }""")
    dark = tab.evaluate("bright()")
    pages_printed = tab.page.pdf(format="A4").count(b"/Type /Page\n")
    assert name != "live.html" or pages_printed <= 2, "none is blank"
    assert tab.evaluate("printed") > 1.1 * dark
    assert tab.evaluate("bright()") == pytest.approx(dark, rel=0.05), "and afterwards as before"
    tab.context.close()
    assert not [each for each in tab.problems if "willReadFrequently" not in each]   # the test reads them


@pytest.mark.parametrize("name", ["report.html", "compare.html", "study.html"])
def test_no_heading_is_the_last_of_a_printed_page(browser, pages: Path, name: str) -> None:
    tab = Tab(browser, pages / name)
    tab.page.emulate_media(media="print")
    assert [tab.evaluate(ALONE, height) for height in (269, 260, 251)] == [[], [], []]
    tab.close()


def test_bounds_of_figures_line_up_with_other_claims_on_paper(browser, pages: Path) -> None:
    """What is measured and the verdict stand where their heads do."""
    tab = Tab(browser, pages / "report.html")
    tab.page.emulate_media(media="print")
    tab.evaluate("document.querySelectorAll('.bounds details').forEach((each) => { each.open = true; })")
    heads = tab.evaluate("[...document.querySelectorAll('table.claims > thead th')].slice(3)"
                         ".map((head) => head.getBoundingClientRect().left)")
    rows = tab.evaluate("""[...document.querySelectorAll(".bounds table tr")].map(({ cells }) =>
        [...cells].slice(2).map((cell) => cell.getBoundingClientRect().left))""")
    assert rows
    np.testing.assert_allclose(rows, np.broadcast_to(heads, (len(rows), 2)), atol=3.0)   # px
    tab.close()


@pytest.fixture
def phone_live(browser, pages: Path) -> Iterator[Tab]:
    tab = Tab(browser, pages / "live.html", PHONE)
    wait_until(tab.page, RUNS)
    yield tab
    problems = tab.problems + tab.evaluate("maglevLive.problems")
    tab.context.close()
    assert problems == []


def swipe(tab: Tab, x: float, y: float, dx: float, dy: float) -> None:
    """A finger goes from a place of the window on (px)."""
    touches = tab.context.new_cdp_session(tab.page)
    for kind, part in (("touchStart", 0.0), *(("touchMove", 0.1 * k) for k in range(1, 11))):
        point = {"x": x + part * dx, "y": y + part * dy}
        touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [point]})
        tab.page.wait_for_timeout(15)
    touches.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})


STAGE = """(({ left, right, top, bottom }) => [left, right, top, bottom])
    (document.getElementById("stage").getBoundingClientRect())"""
LABEL = """(({ left, top }) => [left + maglevLive.hint.x, top + maglevLive.hint.y])
    (document.getElementById("stage").getBoundingClientRect())"""


def test_a_finger_turns_the_view_or_scrolls(phone_live: Tab) -> None:
    """Off the platform: sideways it turns the view, upwards it scrolls the page under the picture, which stays."""
    tab, page = phone_live, phone_live.page
    left, _, top, _ = tab.evaluate(STAGE)
    yaw = tab.evaluate("maglevLive.orbit.yaw")
    swipe(tab, left + 12, top + 14, 120.0, 4.0)
    turned = tab.evaluate("maglevLive.orbit.yaw")
    assert tab.evaluate("scrollY") == 0 and abs(turned - yaw) > 20.0
    swipe(tab, left + 12, top + 200, 0.0, -150.0)
    wait_until(page, "scrollY > 60")
    assert not page.is_visible("#released") and abs(tab.evaluate("maglevLive.orbit.yaw") - turned) < 3.0
    assert tab.evaluate(STAGE)[2] >= 0.0


def test_from_above_a_finger_moves_in_the_plane(phone_live: Tab) -> None:
    tab, page = phone_live, phone_live.page
    for view in ("sides", "space", "above"):
        page.select_option("#view", view)
        wait_until(page, f"maglevLive.shot === null && Math.abs(maglevLive.orbit.pitch - SHOTS.{view}.pitch) < 1")
    assert "view=above" in tab.evaluate("location.hash")
    place = "['x', 'y', 'z'].map((axis) => maglevLive.history.last().axes[axis].reference)"
    # The run's own references move until the finger is there; by the label it takes the platform at once.
    tab.evaluate(f"""document.getElementById("stage")
        .addEventListener("pointerdown", () => {{ window.before = {place}; }})""")
    x, y = tab.evaluate(LABEL)
    swipe(tab, x, y, 12.0, -6.0)
    wait_until(page, f"{place}[0] !== before[0]")
    wait_until(page, "Object.keys(maglevLive.leads).length === 0")
    wait_until(page, f"maglevLive.frame.time > {tab.evaluate('maglevLive.frame.time') + 0.1}")
    moved = 1e3 * (np.array(tab.evaluate(place)) - tab.evaluate("before")) * tab.evaluate(
        "maglevLive.views.space.camera.scale")
    assert moved == pytest.approx([12.0, 0.0, 6.0], abs=2.0)
    assert tab.evaluate("scrollY") == 0


def test_a_page_of_another_stage_that_is_dropped_takes_the_place_of_what_runs(browser, pages: Path, wasm_fmus: Path,
                                                                               tmp_path: Path) -> None:
    other = tmp_path / "live-mine.html"
    other.write_text(live_page(wasm_fmus, [packaged("2dof-setpoints")]), encoding="utf-8")
    tab = Tab(browser, pages / "live.html")
    wait_until(tab.page, RUNS)
    tab.page.set_input_files("#own-files", pages / "compare.html")
    wait_until(tab.page, "document.getElementById('status').textContent.startsWith('compare.html: expected a page')")
    assert tab.evaluate("maglevLive.run.plant") == "Plant3DOF"
    tab.page.set_input_files("#own-files", other)
    wait_until(tab.page, "maglevLive.run.plant === 'Plant2DOF' && maglevLive.history?.count > 0")
    assert tab.evaluate("[...document.querySelectorAll('#run option')].map(({ value }) => value)") == ["2dof-setpoints"]
    assert tab.evaluate("[...document.querySelectorAll('#readings dt')].map((axis) => axis.textContent)") == ["v", "h"]
    wait_until(tab.page, "(({ position, reference }) => reference > 5e-3 && Math.abs(position - reference) < 1e-3)"
               "(maglevLive.history.last().axes.v)")   # how many frames come before it settles is the machine's
    assert "live-mine.html" in tab.page.inner_text("#status") and "run=2dof-setpoints" in tab.evaluate("location.hash")
    problems = tab.problems + tab.evaluate("maglevLive.problems")
    tab.context.close()
    assert problems == []


def test_what_a_worker_sends_is_heard_as_far_as_it_is_expected(browser, pages: Path) -> None:
    """A law can send its page anything: the page takes no text of it for its own, and no data of another shape."""
    tab = Tab(browser, pages / "live.html")
    wait_until(tab.page, RUNS)

    def said(message: str) -> str:
        tab.evaluate(f"say(''); own.present = true; worker.onmessage({{ data: {message} }})")
        return tab.page.inner_text("#status")

    for message in ("null", "'text'", "{ type: 'constructor' }", "{ type: 'refused', text: 5 }",
                    "{ type: 'frame', rows: [1] }", "{ type: 'frame', rows: new Float32Array(3), "
                    "ghostRows: new Float32Array(0), flags: {}, ghostFlags: null, pace: 1, time: 1 }",
                    "{ type: 'owned', model: 'own:x', about: { variables: [] } }"):
        assert said(message) == "", message
    assert said("{ type: 'not done', text: 'Your browser is out of date' }") == "law: Your browser is out of date"
    assert said("{ type: 'not done', text: 'Plant3DOF: no' }") == "Plant3DOF: no"
    # What is still on its way from the run before an experiment is none of it.
    assert tab.evaluate("""(() => {
        tellStory("weak");
        worker.onmessage({ data: { type: "frame", rows: new Float32Array(page.width), ghostRows: new Float32Array(0),
            flags: { stop: true }, ghostFlags: null, pace: 1, time: 9 } });
        return page.history; })()""") is None
    tab.context.close()
