"""The plots of the report in a browser."""

import csv
from itertools import pairwise
from xml.etree.ElementTree import fromstring as parse_svg

import numpy as np
import pytest
from report_outcomes import HOSTILE
from report_runs import SPEED
from report_tab import DESKTOP, PHONE, Tab, wait_until


def test_every_figure_is_drawn(desktop):
    desktop.evaluate("maglevReport.drawAll()")
    plots = desktop.evaluate("""[...document.querySelectorAll("[data-figure]")].map((plot) => ({
        id: plot.dataset.figure, pictures: plot.querySelectorAll(".panel-plot").length,
        lines: [...plot.querySelectorAll(".line")].map((line) => line.getAttribute("d").length),
        panels: maglevReport.plots[plot.dataset.figure].panels.map(({ lines }) => lines.length) }))""")
    assert len(plots) > 40
    for plot in plots:
        assert plot["pictures"] == len(plot["panels"]) > 0, plot
        assert len(plot["lines"]) == sum(plot["panels"]) > 0, plot
        assert min(plot["panels"]) > 0, plot
        assert min(plot["lines"]) > 10, plot


def panels_of(tab, figure: str) -> list[dict]:
    """What the panels of a figure show: titles, lines, levels, ranges, instants."""
    tab.evaluate("maglevReport.drawAll()")
    return tab.evaluate("""(id) => maglevReport.plots[id].panels.map(({ lines, ...panel }) => ({ ...panel,
        lines: lines.map(({ x, y, ...line }) => ({ ...line, x: Array.from(x), y: Array.from(y) })) }))""", figure)


def test_a_figure_overlays_its_runs_and_has_units(desktop):
    panels = panels_of(desktop, "figure-4-25")
    assert [panel["title"] for panel in panels] == ["gap v (mm)", "h (mm)"]
    assert [panel["xTitle"] for panel in panels] == ["time (s)"] * 2
    for panel in panels:
        assert [line["name"] for line in panel["lines"]] == ["reference", "nonlinear", "linear"]
        np.testing.assert_allclose([line["y"][-1] for line in panel["lines"]], [26.0, 25.0, 25.0], atol=1e-3)   # mm
        (stop,) = panel["instants"]
        assert stop["x"] == 0.25   # s
        assert stop["name"] == "linear touched an end stop at 0.250 s"


def lines_of(tab, figure: str) -> list[list[str]]:
    """Names of the lines that each panel of a figure shows now."""
    wait_until(tab.page, f"maglevReport.plots['{figure}']?.places.every((place) => place.querySelector('.panel-plot'))")
    return tab.evaluate(f"maglevReport.plots['{figure}'].panels.map(({{ lines }}) => lines.map(({{ name }}) => name))")


@pytest.mark.parametrize("viewport", [DESKTOP, PHONE])
def test_a_switch_shows_the_motion_without_friction_and_what_claims_come_to(browser, report, viewport):
    tab = Tab(browser, report, viewport)
    switch = tab.page.locator('[data-switch="figure-5-20"]')
    told = "[...document.querySelectorAll('#figure-5-20 details.what-if')].map(({ open }) => open)"
    switch.scroll_into_view_if_needed()
    position, *_ = lines_of(tab, "figure-5-20")
    assert position == ["reference", "nonlinear"]
    assert set(tab.evaluate(told)) == {False}
    switch.click()
    assert switch.get_attribute("aria-pressed") == "true"
    wait_until(tab.page, "maglevReport.plots['figure-5-20']?.panels[0].lines.length === 3")
    position, *_ = lines_of(tab, "figure-5-20")
    assert position == ["reference", "nonlinear", "without friction"]
    assert set(tab.evaluate(told)) == {True}
    switch.click()
    wait_until(tab.page, "maglevReport.plots['figure-5-20']?.panels[0].lines.length === 2")
    assert set(tab.evaluate(told)) == {False}
    tab.close()


def test_a_claim_of_the_table_leads_to_its_curves_without_friction(browser, report):
    tab = Tab(browser, report)
    tab.page.locator("#run-3dof-setpoints details.what-if summary").first.click()
    tab.page.locator("#run-3dof-setpoints details.what-if a").first.click()
    assert tab.evaluate("location.hash") == "#figure-5-20"
    wait_until(tab.page, "maglevReport.plots['figure-5-20']?.panels[0].lines.length === 3")
    tab.close()


def test_a_chart_of_a_procedure_has_its_curves_without_friction_too(desktop):
    chart = desktop.evaluate("Object.keys(maglevReport.figures).find((id) => maglevReport.figures[id].chart"
                             " && maglevReport.figures[id].without)")
    before = panels_of(desktop, chart)
    desktop.evaluate("(id) => document.querySelector(`[data-switch='${id}']`).click()", chart)
    wait_until(desktop.page, f"maglevReport.plots['{chart}']?.panels[0].lines.length > {len(before[0]['lines'])}")
    for panel, old in zip(panels_of(desktop, chart), before, strict=True):
        names = [line["name"] for line in old["lines"]]
        assert [line["name"] for line in panel["lines"]] == [*names, *(f"{name}, without friction" for name in names)]
    desktop.evaluate("(id) => document.querySelector(`[data-switch='${id}']`).click()", chart)
    wait_until(desktop.page, f"maglevReport.plots['{chart}']?.panels[0].lines.length === {len(before[0]['lines'])}")


def test_a_line_is_drawn_where_its_values_are(desktop):
    """Of 21 to 26 mm in 0.5 s, by the labels of the axes."""
    desktop.evaluate("maglevReport.drawAll()")
    seen = desktop.evaluate("""(() => {
        const picture = document.querySelector('[data-figure="figure-4-25"] .panel-plot');
        const box = picture.querySelector('.line[data-name="reference"]').getBoundingClientRect();
        const labels = [...picture.querySelectorAll("text")].map((text) => ({ text: text.textContent,
          anchor: text.getAttribute("text-anchor"), box: text.getBoundingClientRect() }));
        return { box, labels };
    })()""")
    up = {float(label["text"]): label["box"]["y"] + label["box"]["height"] / 2
          for label in seen["labels"] if label["anchor"] == "end"}
    (low, low_px), (high, high_px) = min(up.items()), max(up.items())
    assert low_px < high_px, "an air gap grows downwards"
    at = [low + (high - low) * (px - low_px) / (high_px - low_px)
          for px in (seen["box"]["y"], seen["box"]["y"] + seen["box"]["height"])]
    np.testing.assert_allclose(at, [21.0, 26.0], atol=0.15)


def test_limits_of_a_run_are_drawn_where_they_are(desktop):
    """Only those that the run started with, and of the figure's panel."""
    (gap, _, _) = panels_of(desktop, "figure-4-18")
    assert [(level["value"], level["name"]) for level in gap["levels"]] == [(18.0, "end stops"), (31.0, "end stops")]
    commands, currents = panels_of(desktop, "figure-4-20")
    assert [level["value"] for level in commands["levels"]] == [-1.5, 1.5]
    assert {level["name"] for level in currents["levels"]} == {"peak of the amplifiers, 2.5 A"}
    drawn = desktop.page.locator('[data-figure="figure-4-20"] .level')
    assert drawn.count() == 4


def test_a_chart_has_lines_marks_and_units(desktop):
    (panel,) = panels_of(desktop, "figure-4-9-2dof-thrust")
    assert [line["name"] for line in panel["lines"]] == ["parabola fit", "estimator"]
    assert [line["marked"] for line in panel["lines"]] == [False, True]
    assert [line["css"] for line in panel["lines"]] == ["run-0", "run-1"]
    assert [panel["xTitle"], panel["title"]] == ["air gap (mm)", "L (m/(s² A))"]
    assert panel["lines"][0]["y"] == [0.333333, 0.25, 0.125]


def test_a_chart_has_panels_below_each_other_and_shows_labels_as_they_are(desktop):
    desktop.evaluate("maglevReport.drawAll()")
    plot = desktop.page.locator('[data-figure="figure-4-10-2dof-thrust"]')
    tops = [picture.bounding_box()["y"] for picture in plot.locator(".panel-plot").all()]
    assert len(tops) == 2
    assert tops[0] < tops[1]
    assert plot.locator(".legend button").all_text_contents() == [HOSTILE, "estimator"] * 2
    assert plot.locator("a[href], script").count() == 0


def test_a_band_goes_about_its_line_as_far_as_it_has_an_end(desktop):
    """From 10 to 15 mm; at 20 mm the margin is infinite."""
    desktop.evaluate("maglevReport.drawAll()")
    panel = desktop.page.locator('[data-figure="figure-4-10-2dof-thrust"] .panel-plot').first
    (band,) = panel.locator(".band").all()
    line = panel.locator('.line').first.get_attribute("d")
    corners = [tuple(map(float, point.split())) for point in band.get_attribute("d").strip("MZ").split("L")]
    points = [tuple(map(float, point.split())) for point in line.strip("M").split("L")]
    assert [x for x, _ in corners] == [points[0][0], points[1][0], points[1][0], points[0][0]]
    assert 0.5 * (corners[0][1] + corners[3][1]) == pytest.approx(points[0][1], abs=0.2)
    assert (corners[3][1] - corners[0][1]) / (corners[2][1] - corners[1][1]) == pytest.approx(1.5, rel=0.05)


def test_absolute_errors_are_on_a_logarithmic_axis(desktop):
    panels = panels_of(desktop, "figure-4-29")
    assert [panel["logarithmic"] for panel in panels] == ["mm", "mm"]
    np.testing.assert_allclose(panels[0]["lines"][0]["y"], 1.0, atol=1e-3)   # mm
    texts = desktop.page.locator('[data-figure="figure-4-29"] .panel-plot').first.locator("text").all_text_contents()
    assert "1 mm" in texts


def picture_of(tab, figure: str):
    """First panel of a figure, in view."""
    tab.evaluate("maglevReport.drawAll()")
    picture = tab.page.locator(f'[data-figure="{figure}"] .panel-plot').first
    picture.scroll_into_view_if_needed()
    return picture


def shown_range(tab, figure: str) -> list[list[float]]:
    return tab.evaluate("(id) => maglevReport.plots[id].views.map(({ low, high }) => [low, high])", figure)


def test_dragging_zooms_all_panels_and_a_double_click_shows_all(desktop):
    figure = "figure-4-18"
    box = picture_of(desktop, figure).bounding_box()
    (before, *_) = shown_range(desktop, figure)
    mouse, middle = desktop.page.mouse, box["y"] + box["height"] / 2
    mouse.move(box["x"] + 0.4 * box["width"], middle)
    mouse.down()
    mouse.move(box["x"] + 0.6 * box["width"], middle, steps=3)
    mouse.up()
    zoomed = shown_range(desktop, figure)
    assert zoomed == [zoomed[0]] * 3
    assert zoomed[0][1] - zoomed[0][0] == pytest.approx(0.2 * box["width"] / (box["width"] - 74) * 0.5, rel=0.05)
    picture_of(desktop, figure).dblclick(position={"x": 300, "y": 80})
    assert shown_range(desktop, figure) == [before] * 3


def test_buttons_zoom_move_and_show_all(desktop):
    figure = "figure-4-19"
    picture_of(desktop, figure)
    tools = desktop.page.locator(f'[data-figure="{figure}"] .tools')
    for label, wanted in (("zoom in", [0.125, 0.375]), ("to the right", [0.1875, 0.4375]),
                          ("to the left", [0.125, 0.375]), ("zoom out", [0.0, 0.5]), ("zoom in", [0.125, 0.375]),
                          ("show all", [0.0, 0.5])):
        tools.get_by_role("button", name=label, exact=True).click()
        np.testing.assert_allclose(shown_range(desktop, figure)[0], wanted, atol=1e-9)


def test_pointing_at_a_plot_tells_the_values(desktop):
    picture = picture_of(desktop, "figure-4-18")
    picture.hover(position={"x": 400, "y": 60})
    readout = desktop.page.locator('[data-figure="figure-4-18"] .readout').first
    texts = readout.locator("div").all_text_contents()
    time = float(texts[0].removeprefix("time (s): "))
    reference, position = (float(text.split(": ")[1].split(" ")[0]) for text in texts[1:])
    assert reference == pytest.approx(21.0 + 1e3 * SPEED * time, abs=2e-3)
    assert position == pytest.approx(20.0 + 1e3 * SPEED * time, abs=2e-3)
    assert texts[1].endswith(" mm") and "±" not in texts[1], "a reference is exact"
    assert "± 0.001 mm" in texts[2]
    box, below = readout.bounding_box(), picture.bounding_box()
    assert box["y"] + box["height"] <= below["y"] + 8, "it covers no curve"   # px above the frame
    everywhere = desktop.page.locator('[data-figure="figure-4-18"] .readout')
    assert [each.locator("div").first.text_content() for each in everywhere.all()] == [texts[0]] * 3
    desktop.page.mouse.move(0, 0)
    assert not readout.is_visible()


def test_keys_read_a_plot_and_zoom(desktop):
    """Arrows by a hundredth of what is shown, with shift by a tenth; what is drawn again keeps the focus."""
    figure = "figure-4-18"
    picture_of(desktop, figure)
    press = desktop.page.keyboard.press
    desktop.page.locator(f'[data-figure="{figure}"] .tools button').last.focus()
    press("Tab")
    press("Tab")   # past the names in the legend
    for _ in range(3):
        if desktop.evaluate("document.activeElement.matches('.panel-plot')"):
            break
        press("Tab")

    def said():
        return desktop.evaluate("document.activeElement.getAttribute('aria-valuetext')")

    assert said().startswith("time (s): 0.25; reference: ")
    for key, time in (("ArrowRight", "0.255"), ("Shift+ArrowRight", "0.305"), ("Home", "0"), ("End", "0.5")):
        press(key)
        assert said().split("; ")[0] == f"time (s): {time}"
    press("Home")
    press("+")
    np.testing.assert_allclose(shown_range(desktop, figure), [[0.0, 0.25]] * 3)
    desktop.evaluate("maglevReport.plots['figure-4-18'].drawn")
    press("0")
    np.testing.assert_allclose(shown_range(desktop, figure), [[0.0, 0.5]] * 3)
    assert desktop.page.locator(f'[data-figure="{figure}"] .readout:visible').count() == 3
    press("Escape")
    assert desktop.page.locator(f'[data-figure="{figure}"] .readout:visible').count() == 0


def test_names_of_windows_and_marks_leave_with_what_they_name(desktop):
    """In a view from 1 s to 3 s, 400 px wide, two windows are seen, and one has room for its name."""
    seen = desktop.evaluate("""(() => {
        const inner = svg("svg", {});
        const windows = [["before", 0, 0.9], ["push", 1.5, 2.5], ["a long name", 2.9, 3.5]]
            .map(([name, low, high]) => ({ name, low, high, css: "open" }));
        const names = drawWindows(inner, windows, scaleOf(1, 3, 0, 400, false), 400, 132);
        const numbers = (band) => ["x", "width"].map((key) => Number(band.getAttribute(key)));
        return { bands: [...inner.querySelectorAll("rect")].map(numbers),
                 names: names.map(({ text }) => text) };
    })()""")
    np.testing.assert_allclose(sorted(seen["bands"]), [[100, 200], [380, 20]])
    assert seen["names"] == ["push"]


def test_names_of_events_cover_nothing(desktop):
    """They stand above the frame of the first panel, one next to the other."""
    desktop.evaluate("maglevReport.drawAll()")
    plots = desktop.evaluate("""[...document.querySelectorAll("[data-figure]")].map((plot) => {
        const box = (element) => { const { left, right, top, bottom } = element.getBoundingClientRect();
            return { left, right, top, bottom }; };
        return { names: [...plot.querySelectorAll(".window-name")].map(box),
                 frames: [...plot.querySelectorAll(".panel-plot > rect")].map(box),
                 heads: [...plot.querySelectorAll(".panel-head")].map(box) }; })""")
    named = [plot for plot in plots if plot["names"]]
    assert named
    for plot in named:
        assert max(name["bottom"] for name in plot["names"]) <= plot["frames"][0]["top"] + 1.0
        assert min(name["top"] for name in plot["names"]) >= plot["heads"][0]["bottom"] - 1.0
        for left, right in pairwise(plot["names"]):
            assert left["right"] <= right["left"]


def test_a_name_in_the_legend_hides_its_line(desktop):
    picture_of(desktop, "figure-4-20")
    plot = desktop.page.locator('[data-figure="figure-4-20"]')
    button = plot.get_by_role("button", name="i_d", exact=True)
    lines = plot.locator('.line[data-name="i_d"]')
    for pressed, count in (("false", 0), ("true", 1)):
        button.click()
        assert button.get_attribute("aria-pressed") == pressed
        assert lines.count() == count


def test_a_plot_is_saved_with_its_colours_written_out(desktop):
    picture_of(desktop, "figure-4-20")
    text = desktop.evaluate("pictureText(maglevReport.plots['figure-4-20'])")
    assert "var(" not in text
    assert text.count('class="panel-plot"') == 2
    assert len(parse_svg(text).findall(".//*[@class='line']")) == 5


def readings(tab, figure: str) -> list[str]:
    """Texts of the readout of a figure's first panel, if it is seen."""
    readout = tab.page.locator(f'[data-figure="{figure}"] .readout').first
    return readout.locator("div").all_text_contents() if readout.is_visible() else []


def numbers(text: str) -> list[float]:
    """The value of a reading, and by how much it differs from the first cursor."""
    value, _, difference = text.split(": ")[1].partition(", Δ ")
    return [float(part.split(" ")[0].replace("−", "-")) for part in (value, difference) if part]


def test_two_cursors_tell_differences(desktop):
    """A ramp by a known speed: the second cursor, fixed by a click, stays when the pointer is away."""
    figure = "figure-4-18"
    picture = picture_of(desktop, figure)
    picture.click(position={"x": 300, "y": 60})
    first = [numbers(text) for text in readings(desktop, figure)]
    assert [len(parts) for parts in first] == [1, 1, 1]
    picture.hover(position={"x": 500, "y": 60})
    picture.click(position={"x": 500, "y": 60})
    desktop.page.mouse.move(0, 0)
    texts = readings(desktop, figure)
    (time, since), (_, change), _ = map(numbers, texts)
    assert since == pytest.approx(time - first[0][0], abs=1e-4)
    assert 0.05 < since < 0.5
    assert change == pytest.approx(1e3 * SPEED * since, abs=2e-3)   # mm
    assert " mm, Δ " in texts[1]
    assert picture_of(desktop, figure).locator(".cursor").get_attribute("d").count("M") == 3
    for x in (500, 300):   # each is taken away by a click on it
        picture.click(position={"x": x, "y": 60})
    desktop.page.mouse.move(0, 0)
    assert readings(desktop, figure) == []


def test_a_tap_reads_a_plot(browser, report):
    """It stays, for a finger covers what it points at; a second one tells differences; one on a cursor removes it."""
    context = browser.new_context(viewport=PHONE, has_touch=True, offline=True)
    page = context.new_page()
    page.goto(report.as_uri())
    page.evaluate("maglevReport.drawAll()")
    picture = page.locator('[data-figure="figure-4-18"] .panel-plot').first
    readout = page.locator('[data-figure="figure-4-18"] .readout').first
    picture.scroll_into_view_if_needed()
    before = picture.bounding_box()
    picture.tap(position={"x": 150, "y": 60})
    assert readout.is_visible() and "Δ" not in readout.text_content()
    picture.tap(position={"x": 250, "y": 60})
    assert readout.text_content().count("Δ") == 3
    assert picture.bounding_box() == before, "nothing moves"
    picture.tap(position={"x": 250, "y": 60})
    picture.tap(position={"x": 150, "y": 60})
    assert not readout.is_visible()
    context.close()


def test_points_that_are_seen_are_saved(desktop):
    """Of a zoomed view, of lines that are not hidden, with units; the picture as large as drawn, at two dots a px."""
    figure = "figure-4-18"
    picture_of(desktop, figure)
    tools = desktop.page.locator(f'[data-figure="{figure}"] .tools')
    tools.get_by_role("button", name="zoom in", exact=True).click()
    with desktop.page.expect_download() as saved:
        tools.get_by_role("button", name="save the view as CSV").click()
    assert saved.value.suggested_filename == f"{figure}.csv"
    with saved.value.path().open(encoding="utf-8", newline="") as file:
        head, *rows = csv.reader(file)
    assert head == ["panel", "line", "x", "y"]
    times = np.array([float(row[2]) for row in rows])
    assert 0.125 <= times.min() < 0.13 and 0.37 < times.max() <= 0.375
    shown = [row for row in rows if row[0] == "gap v (mm) over time (s)" and row[1] == "reference"]
    x, y = np.array([row[2:] for row in shown], float).T
    np.testing.assert_allclose(y, 21.0 + 1e3 * SPEED * x, atol=2e-3)
    with desktop.page.expect_download() as saved:
        tools.get_by_role("button", name="save the view as PNG").click()
    png = saved.value.path().read_bytes()
    assert png[:8] == b"\x89PNG\r\n\x1a\n"
    width = desktop.evaluate("maglevReport.plots['figure-4-18'].handles[0].picture.viewBox.baseVal.width")
    assert int.from_bytes(png[16:20], "big") == 2 * width
    tools.get_by_role("button", name="show all", exact=True).click()


def test_no_text_of_saved_points_is_a_formula(desktop):
    saved = desktop.evaluate("""pointsText({ hidden: new Set(), views: [{ low: 0, high: 1 }], panels: [{
        title: "=1+1", xTitle: "t", lines: [{ name: '@SUM("A1")', x: [0, 1, 2], y: [5, null, 7] }] }] })""")
    assert [*csv.reader(saved.splitlines())][1:] == [["'=1+1 over t", "'@SUM(\"A1\")", "0", "5"]]
