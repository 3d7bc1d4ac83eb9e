"""The report in a browser without network; skipped where playwright or a Chromium is missing."""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from report_outcomes import HOSTILE, chart, outcome
from report_runs import SPEED, all_recorded, failed, judged, packaged, recorded

from maglev.judging.verdicts import VERDICTS
from maglev.report.claim_table import LOOKS
from maglev.report.page import write_report

CANDIDATES = ("chromium", "chromium-browser", "google-chrome")
LIGHT, DARK = "light", "dark"
VERDICT_STYLES = [f".verdict.{look.css}" for look in LOOKS.values()]
DESKTOP, PHONE = {"width": 1280, "height": 900}, {"width": 390, "height": 800}

# Contrast ratio of an element's text to the page's background, as WCAG defines it.
CONTRAST = """(selector) => {
  const luminance = (colour) => colour.match(/[0-9.]+/g).slice(0, 3).map((part) => part / 255)
    .map((part) => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4)
    .reduce((sum, part, k) => sum + part * [0.2126, 0.7152, 0.0722][k], 0);
  const text = luminance(getComputedStyle(document.querySelector(selector)).color);
  const paper = luminance(getComputedStyle(document.body).backgroundColor);
  return { paper, ratio: (Math.max(text, paper) + 0.05) / (Math.min(text, paper) + 0.05) };
}"""


@pytest.fixture(scope="module")
def browser(slow: None):
    """A Chromium."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    path = next(filter(None, [os.environ.get("CHROMIUM"), *map(shutil.which, CANDIDATES)]), None)
    if path is None:
        pytest.skip(f"no Chromium: none of {', '.join(CANDIDATES)} is on the PATH, and CHROMIUM is not set")
    with api.sync_playwright() as playwright:
        chromium = playwright.chromium.launch(executable_path=path, args=["--no-sandbox"])
        yield chromium
        chromium.close()


@pytest.fixture(scope="module")
def report(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Report of every packaged run, one of them failed."""
    path = tmp_path_factory.mktemp("report") / "report.html"
    results = [result for result in all_recorded() if result.plan.name != "2dof-step-3-linear"]
    results = [recorded(packaged("2dof-step-4-linear"), stop_contact=0.25)
               if result.plan.name == "2dof-step-4-linear" else result for result in results]
    results.append(failed(packaged("2dof-step-3-linear"), "plant: the step at 2 s failed"))
    judgements = {result.plan.name: [judged(verdict, reason="friction is assumed") for verdict in VERDICTS]
                  for result in results}
    outcomes = [outcome(charts=(chart(), chart("4.10", HOSTILE, panels=2)), notes=(HOSTILE,), claims=())]
    write_report(path, results, judgements, outcomes)
    return path


class Tab:
    """The report in a browser; collects what goes wrong and what is requested."""

    def __init__(self, browser, report: Path, viewport=DESKTOP) -> None:
        self.url = report.as_uri()
        self.problems: list[str] = []
        self.requests: list[str] = []
        self.context = browser.new_context(offline=True, viewport=viewport, color_scheme=LIGHT,
                                           has_touch=viewport is PHONE, is_mobile=viewport is PHONE)
        self.page = self.context.new_page()
        self.page.on("console", lambda message: self.problems.append(f"{message.type}: {message.text}"))
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(self.url)

    def evaluate(self, script: str, argument=None):
        return self.page.evaluate(script, argument)

    def close(self) -> None:
        """Close, and check that all went well and nothing was requested but the page."""
        problems = self.problems + self.evaluate("maglevReport.errors")
        self.context.close()
        assert problems == []
        assert {url for url in self.requests if not url.startswith(("blob:", "data:"))} == {self.url}


@pytest.fixture(scope="module")
def desktop(browser, report) -> Iterator[Tab]:
    tab = Tab(browser, report)
    yield tab
    tab.close()


@pytest.fixture
def phone(browser, report) -> Iterator[Tab]:
    tab = Tab(browser, report, PHONE)
    yield tab
    tab.close()


def test_every_figure_is_drawn(desktop):
    desktop.evaluate("maglevReport.drawAll()")
    plots = desktop.evaluate("""[...document.querySelectorAll("[data-figure]")].map((plot) => ({
        id: plot.dataset.figure, pictures: plot.querySelectorAll("svg.main-svg").length,
        lines: plot.querySelectorAll(".scatterlayer .trace").length,
        points: (plot.data ?? []).map((line) => line.x.length) }))""")
    assert len(plots) > 40
    for plot in plots:
        assert plot["pictures"] > 0, plot
        assert plot["lines"] == len(plot["points"]) > 0, plot
        assert min(plot["points"]) > 1, plot


def test_a_figure_overlays_its_runs_and_has_units(desktop):
    desktop.evaluate("maglevReport.drawAll()")
    plot = desktop.evaluate("""(() => {
        const { data, layout } = document.querySelector('[data-figure="figure-4-25"]');
        return { names: data.map((line) => line.name), last: data.map((line) => line.y.at(-1)),
                 titles: [layout.yaxis.title.text, layout.yaxis2.title.text], shapes: layout.shapes.map((s) => s.x0) };
    })()""")
    assert plot["names"] == ["reference", "nonlinear", "linear"] * 2
    assert plot["titles"] == ["v (mm)", "h (mm)"]
    np.testing.assert_allclose(plot["last"], [26.0, 25.0, 25.0] * 2, atol=1e-3)   # mm
    assert plot["shapes"] == [0.25]   # s, the end stop


def test_a_chart_has_lines_marks_and_units(desktop):
    desktop.evaluate("maglevReport.drawAll()")
    plot = desktop.evaluate("""(() => {
        const { data, layout } = document.querySelector('[data-figure="figure-4-9-2dof-thrust"]');
        return { names: data.map((curve) => curve.name), modes: data.map((curve) => curve.mode),
                 colours: data.map((curve) => curve.line.color), y: data[0].y,
                 wanted: [colour("series-0"), colour("series-1")],
                 titles: [layout.xaxis.title.text, layout.yaxis.title.text] };
    })()""")
    assert plot["names"] == ["parabola fit", "estimator"]
    assert plot["modes"] == ["lines", "markers"]
    assert plot["colours"] == plot["wanted"]
    assert plot["titles"] == ["air gap (mm)", "L (m/(s² A))"]
    assert plot["y"] == [0.333333, 0.25, 0.125]


def test_a_chart_has_panels_below_each_other_and_shows_labels_as_they_are(desktop):
    desktop.evaluate("maglevReport.drawAll()")
    plot = desktop.evaluate("""(() => {
        const plot = document.querySelector('[data-figure="figure-4-10-2dof-thrust"]');
        return { axes: plot.data.map((curve) => [curve.xaxis, curve.yaxis]), upper: plot.layout.yaxis.domain,
                 lower: plot.layout.yaxis2.domain, links: plot.querySelectorAll("a[href]").length,
                 titles: [...plot.querySelectorAll(".g-xtitle text, .g-x2title text")].map((text) => text.textContent),
                 legend: [...plot.querySelectorAll(".legendtext")].map((text) => text.textContent) };
    })()""")
    assert plot["axes"] == [["x", "y"]] * 2 + [["x2", "y2"]] * 2
    assert plot["lower"][1] < plot["upper"][0]
    assert plot["titles"] == ["air gap (mm)"] * 2
    # A label is in the legend once.
    assert plot["legend"] == [HOSTILE, "estimator"]
    assert plot["links"] == 0


def test_absolute_errors_are_on_a_logarithmic_axis(desktop):
    desktop.evaluate("maglevReport.drawAll()")
    plot = desktop.evaluate("""(() => {
        const { data, layout } = document.querySelector('[data-figure="figure-4-29"]');
        return { types: [layout.yaxis.type, layout.yaxis2.type], y: data[0].y };
    })()""")
    assert plot["types"] == ["log", "log"]
    np.testing.assert_allclose(plot["y"], 1.0, atol=1e-3)   # mm


def wait_until(page, condition: str) -> None:
    """Wait for a condition; the page's policy forbids playwright's own way."""
    for _ in range(200):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(50)
    pytest.fail(f"still not so: {condition}")


def choose(page, run: str) -> None:
    """Choose a run of the moving picture, and wait until it is shown."""
    page.select_option("#player-run", run)
    wait_until(page, "document.querySelector('#player-time').max === '0.5'")


def reading(page, label: str) -> str:
    """A number below the moving picture."""
    return page.locator(".readings div", has=page.get_by_text(label, exact=True)).locator("dd").inner_text()


def mover(page) -> list[float]:
    """Place of the mover in the picture, px."""
    return page.evaluate("""(() => {
        const { e, f } = document.querySelector("#player-views svg g").transform.baseVal.consolidate().matrix;
        return [e, f];
    })()""")


def test_scrubbing_shows_the_values_at_that_time(desktop):
    choose(desktop.page, "3dof-setpoints-improved")
    desktop.page.locator("#player-time").fill("0")
    along, gap = mover(desktop.page)
    desktop.page.locator("#player-time").fill("0.25")
    assert reading(desktop.page, "time") == "0.25 s"
    assert reading(desktop.page, "gap y") == f"{20.0 + 1e3 * SPEED * 0.25:.2f} mm"
    assert reading(desktop.page, "alpha i_d") == "1.00 A"
    later_along, later_gap = mover(desktop.page)
    assert later_along > along
    assert later_gap > gap   # a larger gap is lower in the picture
    assert desktop.page.locator("#player-views svg").count() == 2


def test_the_mover_hangs_below_the_stator_by_the_gap(desktop):
    choose(desktop.page, "2dof-setpoints")
    desktop.page.locator("#player-time").fill("0")
    stator = desktop.evaluate("""Math.max(...[...document.querySelectorAll("#player-views svg > rect")]
        .filter((part) => part.style.fill === "var(--iron)").map((part) => part.getBBox())
        .map((box) => box.y + box.height))""")
    assert mover(desktop.page)[1] - stator == pytest.approx(20.0 * desktop.evaluate("VIEW.up"))   # px


def test_playing_moves_the_picture_until_it_is_paused(desktop):
    page = desktop.page
    choose(page, "2dof-step-4-linear")
    page.select_option("#player-speed", "0.25")
    before = mover(page)
    page.click("#player-play")
    wait_until(page, "Number(document.querySelector('#player-time').value) > 0.05")
    page.click("#player-play")
    stopped = float(page.input_value("#player-time"))
    assert mover(page) != before
    page.wait_for_timeout(100)
    assert float(page.input_value("#player-time")) == stopped
    assert page.locator("#player-play").inner_text() == "Play"


def test_the_moving_picture_tells_when_the_stop_is_touched(desktop):
    choose(desktop.page, "2dof-step-4-linear")
    status = desktop.page.locator("#player .status")
    desktop.page.locator("#player-time").fill("0.24")
    assert status.inner_text() == ""
    desktop.page.locator("#player-time").fill("0.26")
    assert "touched an end stop at 0.250 s" in status.inner_text()


def test_the_filter_shows_one_verdict(desktop):
    page = desktop.page
    rows = page.locator("table.claims tr[data-verdict]:visible")
    everything = rows.count()
    page.get_by_role("button", name="not testable").click()
    assert 0 < rows.count() == everything // len(VERDICTS)
    assert set(rows.evaluate_all("(rows) => rows.map((row) => row.dataset.verdict)")) == {"not testable"}
    # A link to a claim that is hidden shows it.
    page.evaluate("location.hash = 'claim-2dof-setpoints-0'")
    wait_until(page, "!document.querySelector('.filter [aria-pressed=true]').dataset.verdict")
    assert rows.count() == everything


def test_nothing_is_wider_than_a_phone(phone):
    phone.evaluate("maglevReport.drawAll()")
    wait_until(phone.page, "document.querySelector('#player-views svg')")
    width, available = phone.evaluate("[document.documentElement.scrollWidth, document.documentElement.clientWidth]")
    assert width <= available == PHONE["width"]
    too_wide = phone.evaluate("""[...document.querySelectorAll("main *")]
        .filter((part) => !part.closest(".wide, .plot, thead"))
        .filter((part) => part.getBoundingClientRect().right > document.documentElement.clientWidth + 1)
        .map((part) => part.outerHTML.slice(0, 80))""")
    assert too_wide == []


def test_text_and_plots_are_readable_in_both_schemes(desktop):
    page = desktop.page
    desktop.evaluate("maglevReport.drawAll()")
    try:
        for scheme in (DARK, LIGHT):
            page.emulate_media(color_scheme=scheme)
            for selector in ("body", "a", ".reason", ".status", *VERDICT_STYLES):
                seen = page.evaluate(CONTRAST, selector)
                assert (seen["paper"] < 0.05) == (scheme == DARK)
                assert seen["ratio"] > 4.5, (scheme, selector)
            wait_until(page, """[...document.querySelectorAll("[data-figure]")]
                .every((plot) => plot.layout.paper_bgcolor === colour("paper"))""")
    finally:
        page.emulate_media(color_scheme=LIGHT)
