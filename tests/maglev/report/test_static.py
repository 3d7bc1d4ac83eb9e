"""Pictures for browsers without JavaScript."""

from dataclasses import replace
from xml.etree.ElementTree import fromstring as parse_svg

import numpy as np
import pytest
from report_runs import SPEED, packaged, recorded
from report_tab import DESKTOP, PHONE

from maglev.report.plots.data import run_data
from maglev.report.plots.figures import read_figures, shown_figures
from maglev.report.plots.picture import figure_of
from maglev.report.plots.static import (
    HEIGHT,
    LEFT,
    TOP,
    WIDTH,
    Line,
    PanelPicture,
    labels,
    panel_picture,
    static_picture,
)
from maglev.schema.run_plan import Event


def points(path: str) -> np.ndarray:
    """Points of a path, px, shape (n, 2)."""
    start, _, steps = path.removeprefix("M").partition("l")
    return np.cumsum([[float(part) for part in start.split()],
                      *np.array(steps.split(), dtype=float).reshape(-1, 2)], axis=0)


def test_a_line_is_where_its_values_are():
    """By the labels of the axes: a straight line from 20 mm on with the speed of the run."""
    run = recorded(packaged("2dof-setpoints"))
    shown, = (each for each in shown_figures(read_figures(), [run]) if each.id == "figure-4-18")
    pictures = [parse_svg(text) for text in static_picture(shown).split("\n")]
    assert len(pictures) == len(shown.panels)
    up = {float((text.text or "").replace("−", "-")): float(text.get("y", "")) - 4
          for text in pictures[0].findall("text") if text.get("class") == "end"}
    (low, low_px), *_, (high, high_px) = sorted(up.items())
    reference, position = (points(path.get("d", "")) for path in pictures[0].findall("path") if path.get("style"))
    values = [low + (high - low) * (each[:, 1] - low_px) / (high_px - low_px) for each in (position, reference)]
    per_px = (high - low) / abs(high_px - low_px)
    for found, start in zip(values, (20.0, 21.0), strict=True):
        np.testing.assert_allclose(found[[0, -1]], [start, start + 1e3 * SPEED * 0.5], atol=1.1 * per_px)
    assert position[[0, -1], 0].tolist() == [LEFT, LEFT + WIDTH]


def test_few_points_keep_the_extremes_and_what_has_no_value_is_left_out():
    time = np.linspace(0.0, 1.0, 10001)
    values = np.sin(2.0 * np.pi * time)
    values[[100, 200]] = np.nan, np.inf
    picture = parse_svg(panel_picture(PanelPicture("x (mm)", "time (s)", [Line("a & b", "run-0", time, values)])))
    line, = (points(path.get("d", "")) for path in picture.findall("path") if path.get("style"))
    assert 20 < len(line) < 200
    assert line[:, 1].min() == pytest.approx(TOP + HEIGHT * 0.05 / 1.1, abs=1.0)
    assert line[:, 1].max() == pytest.approx(TOP + HEIGHT * 1.05 / 1.1, abs=1.0)
    expected = TOP + HEIGHT * (1.1 - np.sin(2.0 * np.pi * (line[:, 0] - LEFT) / WIDTH)) / 2.2
    assert np.abs(line[:, 1] - expected).max() < 2.0   # px
    assert panel_picture(PanelPicture("x (mm)", "time (s)", [Line("a", "run-0", time[:3], np.full(3, np.nan))])) == ""


def test_windows_of_events_are_drawn_in_every_picture():
    pytest.importorskip("matplotlib")
    run = recorded(packaged("2dof-setpoints"))
    events = [Event(name="push", time=0.1, end=0.3), Event(name="other", time=0.4)]
    run = replace(run, plan=run.plan.model_copy(update={"events": events}))
    assert [each[:2] for each in run_data(run, [], 1000, ())["windows"]] == [("push", 0.1), ("other", 0.4)]
    shown, = (each for each in shown_figures(read_figures(), [run]) if each.id == "figure-4-18")
    picture = parse_svg(static_picture(shown).split("\n")[0])
    bands = [path.get("d", "") for path in picture.findall("path") if path.get("class") == "window"]
    assert [(band.split(" ")[0], band.split("H")[1].split("v")[0]) for band in bands] == [
        (f"M{LEFT + WIDTH * start:.0f}", f"{LEFT + WIDTH * end:.0f}") for start, end in ((0.2, 0.6), (0.8, 1.0))]
    assert [text.text for text in picture.findall("text") if text.get("class") == "window-name"] == ["push", "other"]
    figure = figure_of(run)
    assert [[note.get_text() for note in panel.texts] for panel in figure.axes[:3]] == [["push", "other"]] * 2 + [[]]
    assert all(len(panel.patches) == 2 for panel in figure.axes)


@pytest.mark.parametrize(("low", "high"), [(0.0, 26.0), (-1.3, 1.3), (20.01, 20.02), (1e5, 3e5), (-3e-7, 1e-7)])
def test_labels_are_round_and_few(low, high):
    found = labels(low, high, False)
    assert 2 <= len(found) <= 6
    for value, text in found:
        assert low - 1e-9 * (high - low) <= value <= high + 1e-9 * (high - low)
        assert float(text.replace("−", "-")) == pytest.approx(value, abs=1e-6 * (high - low))


@pytest.mark.parametrize("viewport", [DESKTOP, PHONE])
def test_without_javascript_there_are_pictures_tables_and_the_notice(browser, report, viewport):
    context = browser.new_context(offline=True, viewport=viewport, java_script_enabled=False)
    page = context.new_page()
    page.goto(report.as_uri())
    figures = page.locator("figure[id]").all()
    drawn = [figure.locator("svg.still").count() for figure in figures]
    assert len(figures) > 40
    assert min(drawn) > 0
    for part in ("noscript .status", "table.claims tbody tr", "svg.still"):
        assert page.locator(part).first.is_visible(), part
    for part in (".plot", "#moving", ".search", ".filter"):
        assert not page.locator(part).first.is_visible(), part
    box = page.locator("svg.still").first.bounding_box()
    assert 0 < box["width"] <= viewport["width"]
    context.close()


def test_a_browser_with_javascript_makes_no_pictures_of_them(desktop):
    assert desktop.evaluate("document.querySelectorAll('.still').length") == 0
