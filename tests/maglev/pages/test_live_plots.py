"""Plots of the live page: what they read off is what ran; a hand holds them while the run goes on, and lets them go."""

import csv
import io
from pathlib import Path

import numpy as np
import pytest
from live_homes import HOMES
from report_tab import WIDE, Tab, wait_until

VIEW = "[plots.live.views[0].low, plots.live.views[0].high]"
# Time (s), position and reference (mm) of x in the rows that have run.
ROWS = """(() => { const { history, run } = maglevLive, i = run.axes.indexOf("x");
    return Array.from({ length: history.count - history.first }, (_, k) => [history.at(history.first + k, 0),
        1e3 * history.at(history.first + k, columnOf.position(i)),
        1e3 * history.at(history.first + k, columnOf.reference(i))]); })()"""
# Whether the last px before the end of what has run have ink on the canvas of a panel.
INK = """(p) => { const layer = plots.live.layers[p], { across } = plots.live.handles[p];
    const x = Math.floor(across.place(maglevLive.history.last().time) * layer.width / parseFloat(layer.style.width));
    const copy = new OffscreenCanvas(4, layer.height).getContext("2d");
    copy.drawImage(layer, Math.max(0, x - 6), 0, 4, layer.height, 0, 0, 4, layer.height);
    const { data } = copy.getImageData(0, 0, 4, layer.height);
    return !layer.hidden && data.some((part, k) => k % 4 === 3 && part > 0); }"""


def wait_for_ink(tab: Tab) -> None:
    """While a stage runs, a slow machine draws after the time that it has reached."""
    for p in range(5):
        wait_until(tab.page, f"({INK})({p})")


def test_plots_read_off_what_ran_are_held_and_go_on(browser, page: Path) -> None:
    tab = Tab(browser, page, WIDE, f"#run={HOMES[0]}&ghost=PID3DOF")
    wait_until(tab.page, "maglevLive.frame?.time > 2 && plots.live.rolling")
    wait_for_ink(tab)
    panel = tab.page.locator("#strips .panel-plot").nth(1)
    panel.scroll_into_view_if_needed()
    box = panel.bounding_box()
    assert box is not None
    tab.page.mouse.move(box["x"] + 62 + 0.16 * (box["width"] - 74), box["y"] + 30)
    here = tab.evaluate("plots.live.here")
    said = dict(part.rsplit(": ", 1) for part in tab.page.locator("#strips .readout").nth(1).inner_text().split("\n"))
    time, place, reference = np.array(tab.evaluate(ROWS)).T
    assert 1.0 < here < 2.0
    assert float(said["x nonlinear"].split(" ")[0].replace("−", "-")) == pytest.approx(
        np.interp(here, time, place), abs=2e-4)
    assert float(said["reference of x"].split(" ")[0]) == pytest.approx(np.interp(here, time, reference), abs=2e-4)
    tab.page.click(".tools button[title='zoom in']")
    held, now = tab.evaluate(VIEW), tab.evaluate("maglevLive.frame.time")
    assert held[1] - held[0] == pytest.approx(5.0, rel=1e-2)
    wait_until(tab.page, f"maglevLive.frame.time > {now} + 0.3")
    assert tab.evaluate(VIEW) == held and not tab.evaluate("plots.live.layers.some(({ hidden }) => !hidden)")
    assert tab.page.locator("#strips .panel-plot .line").count() == tab.evaluate(
        "plots.live.panels.flatMap(({ lines }) => lines).length")
    tab.page.click(".tools button[title='to the left']")
    rows = [*csv.DictReader(io.StringIO(tab.evaluate("pointsText(plots.live)")))]
    low, high = tab.evaluate(VIEW)
    assert low < held[0] and all(low <= float(row["x"]) <= high for row in rows)
    assert {"i_d alpha nonlinear", "i_d alpha PID"} <= {row["line"] for row in rows}
    tab.page.click(".tools button[title='follow what runs']")
    wait_until(tab.page, f"plots.live.rolling && plots.live.views[0].high > {held[1]}")
    wait_for_ink(tab)
    tab.page.click("#play")
    wait_until(tab.page, "!plots.live.rolling")
    panel.press("0")
    assert tab.evaluate(VIEW) == tab.evaluate("[plots.live.views[0].full.low, plots.live.views[0].full.high]")
    problems = tab.problems + tab.evaluate("maglevLive.problems")
    tab.context.close()
    assert problems == []
