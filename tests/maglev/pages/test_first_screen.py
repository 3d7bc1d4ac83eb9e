"""The moving picture, and how the report looks in a browser: on a phone, in dark, in numbers of px."""

import numpy as np
import pytest
from report_runs import SPEED, packaged
from report_tab import CONTRAST, DARK, DESKTOP, LIGHT, PHONE, Tab, wait_until

from maglev.pages.claim_table import LOOKS

# Every tenth figure, also one of a procedure: to draw all takes long, and they are alike.
DRAW_SOME = """Promise.all(Object.keys(maglevReport.figures).filter((id, k) => k % 10 === 0).map(draw))"""
VERDICT_STYLES = [f".verdict.{css}" for css, _ in LOOKS.values()]


def choose(page, run: str) -> None:
    """Choose a run of the moving picture, and wait until it is shown."""
    page.select_option("#player-run", run)
    wait_until(page, f"maglevReport.views?.space.run === report.moving['{run}'].stage")


def row(page):
    """What the moving picture shows of the first run: axes and motors, SI."""
    return page.evaluate("maglevReport.views.drawn[0].row")


def mover(page) -> list[float]:
    """Place of the mover, px: across in space, and down next to its gap."""
    return page.evaluate("""(() => {
        const { space, gap, drawn: [{ row }] } = maglevReport.views;
        return [boxIn(space, row, "position")[0], gap.y(1e3 * row.axes[space.run.vertical].position)];
    })()""")


def test_scrubbing_shows_the_values_at_that_time(desktop):
    choose(desktop.page, "3dof-setpoints-improved")
    desktop.page.locator("#player-time").fill("0")
    along, gap = mover(desktop.page)
    desktop.page.locator("#player-time").fill("0.25")
    assert desktop.page.locator("#player-clock").text_content() == "0.25 s"
    shown = row(desktop.page)
    assert shown["axes"]["y"]["position"] == pytest.approx(20e-3 + SPEED * 0.25, abs=2e-6)
    assert shown["axes"]["y"]["reference"] == pytest.approx(21e-3 + SPEED * 0.25, abs=2e-6)
    # Sinusoids of 1 Hz, those of the phases after the two commands.
    for motor in ("alpha", "beta"):
        wanted = [np.sin(2.0 * np.pi * (0.25 + k / 3.0)) for k in range(*phases_of(motor))]
        assert shown["motors"][motor]["phases"] == pytest.approx(wanted, abs=0.03)
    later_along, later_gap = mover(desktop.page)
    assert later_along > along
    assert later_gap > gap   # a larger gap is lower in the picture


def phases_of(motor: str) -> tuple[int, int]:
    """Numbers of the phases among a motor's recorded signals."""
    first = len(packaged("3dof-setpoints-improved").motors[motor].commands)
    return first, first + 3


def test_a_mover_that_tilts_turns_as_the_gaps_at_its_ends_say(desktop):
    """With pitch the gap grows along x, with roll it shrinks along z; in space tilts are five times as large."""
    choose(desktop.page, "5dof-setpoints")
    desktop.page.locator("#player-time").fill("0")
    slopes = desktop.evaluate("""(() => {
        const { space, drawn: [{ row }] } = maglevReport.views, moved = motionOf(space.run, row, "position");
        return [[100, 0, 0], [0, 0, 100]].map((point) => (moved(point)[1] - moved([0, 0, 0])[1]) / 100 / TILT);
    })()""")
    assert slopes == pytest.approx([20e-3, -20e-3], rel=1e-2)   # of 20 mrad each


def test_the_mover_hangs_below_the_stator_by_the_gap(desktop):
    choose(desktop.page, "2dof-setpoints")
    desktop.page.locator("#player-time").fill("0")
    below, beside = desktop.evaluate("""(() => {
        const { space, gap, drawn: [{ row }] } = maglevReport.views;
        const stator = Math.max(...space.bodies.stators.map(({ high }) => high[1]));
        return [motionOf(space.run, row, "position")([0, 0, 0])[1] - stator, (gap.y(20) - gap.y(0)) / gap.scale];
    })()""")
    assert (below, beside) == (pytest.approx(20.0), pytest.approx(20.0))   # mm


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


def test_nothing_is_wider_than_a_phone(phone):
    phone.evaluate(DRAW_SOME)
    wait_until(phone.page, "maglevReport.views")
    width, available = phone.evaluate("[document.documentElement.scrollWidth, document.documentElement.clientWidth]")
    assert width <= available == PHONE["width"]
    too_wide = phone.evaluate("""[...document.querySelectorAll("main *")]
        .filter((part) => !part.closest(".wide, .plot, thead"))
        .filter((part) => part.getBoundingClientRect().right > document.documentElement.clientWidth + 1)
        .map((part) => part.outerHTML.slice(0, 80))""")
    assert too_wide == []


def test_text_and_plots_are_readable_in_both_schemes(desktop):
    page = desktop.page
    desktop.evaluate(DRAW_SOME)
    try:
        for scheme in (DARK, LIGHT):
            page.emulate_media(color_scheme=scheme)
            for selector in ("body", "a", ".reason", ".status", ".legend span", "#index a span", *VERDICT_STYLES):
                seen = page.evaluate(CONTRAST, selector)
                assert (seen["paper"] < 0.05) == (scheme == DARK)
                assert seen["ratio"] > 4.5, (scheme, selector)
    finally:
        page.emulate_media(color_scheme=LIGHT)


@pytest.mark.parametrize("viewport", [DESKTOP, PHONE], ids=["desktop", "phone"])
def test_the_first_screen_has_the_message_and_the_moving_stage(browser, report, viewport):
    tab = Tab(browser, report, viewport)
    message, stage = (tab.page.locator(part).first for part in (".message", "#player-stage"))
    wait_until(tab.page, "maglevReport.views")
    box, below = message.bounding_box(), stage.bounding_box()
    assert box is not None and box["y"] + box["height"] < viewport["height"]
    assert below is not None and below["y"] < viewport["height"]
    wait_until(tab.page, "Number(document.querySelector('#player-time').value) > 0.1")
    later = mover(tab.page)
    tab.page.locator("#player-time").fill("0")
    assert mover(tab.page) != later
    tab.close()


def test_nothing_moves_for_who_wants_no_motion(browser, report):
    tab = Tab(browser, report, reduced_motion="reduce")
    wait_until(tab.page, "document.querySelector('#player-time').max === '0.5'")
    tab.page.wait_for_timeout(200)
    assert tab.page.input_value("#player-time") == "0"
    assert tab.page.locator("#player-play").inner_text() == "Play"
    tab.close()


def test_without_scripts_the_claims_are_there_and_a_notice(browser, report):
    context = browser.new_context(offline=True, java_script_enabled=False)
    page = context.new_page()
    page.goto(report.as_uri())
    notice = page.locator("noscript p")
    assert "need JavaScript" in notice.text_content()
    assert notice.bounding_box()["y"] < 100
    assert page.locator("table.claims tr[data-verdict]").first.is_visible()
    context.close()
