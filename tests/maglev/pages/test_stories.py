"""The experiments of the live page, each to its end in a Chromium: what they speak of is seen to move."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from live_homes import HOMES
from report_tab import PHONE, WIDE, Tab, wait_until

from maglev.linear.equilibrium import equilibrium

SEEN = {"desktop": (WIDE, 40.0), "phone": (PHONE, 24.0)}   # window, px that something moves by at least

# px that the mover of a run goes up and down in the close-up from the event on; its colour there, and that of its
# controller; px that the weight falls on the picture.
WAY = """(theirs) => {
    const { gap } = maglevLive.views, rows = theirs ? maglevLive.ghost : maglevLive.history, at = [];
    const column = columnOf.position(maglevLive.run.axes.indexOf(maglevLive.run.vertical));
    for (let row = rows.since(0.9); row < rows.count; row++) at.push(gap.y(1e3 * rows.at(row, column)));
    return Math.max(...at) - Math.min(...at);
}"""
DRAWN = """(theirs) => {
    const { gap } = maglevLive.views, canvas = document.getElementById("stage");
    const ratio = canvas.width / canvas.clientWidth;
    const row = (theirs ? maglevLive.ghost : maglevLive.history).last(), count = maglevLive.ghost ? 2 : 1;
    const [left] = columnOfMover(gap, theirs ? 1 : 0, count);
    const [x, y] = [left + 3, gap.y(faceOf(maglevLive.run, row)[0]) + BLOCK - 4].map((px) => Math.round(ratio * px));
    const spot = new OffscreenCanvas(1, 1).getContext("2d");
    spot.drawImage(canvas, x, y, 1, 1, 0, 0, 1, 1);
    const [red, green, blue] = spot.getImageData(0, 0, 1, 1).data;
    const said = maglevLive.colours[colourOf(maglevLive.run, maglevLive.state[theirs ? "ghost" : "controller"])];
    return [`#${[red, green, blue].map((part) => part.toString(16).padStart(2, "0")).join("")}`, said];
}"""
FALL = """(() => {
    const { space } = maglevLive.views, row = maglevLive.history.last(), { mass, height } = maglevLive.story.falls;
    const low = (above) => { const { low, high } = weightOf(space, { row, weight: { mass, above } });
        return space.camera.seen([(low[0] + high[0]) / 2, high[1], low[2]])[1]; };
    return low(0) - low(1e3 * height); })()"""


@pytest.fixture
def told(browser, page: Path, request: pytest.FixtureRequest) -> Iterator[Tab]:
    """An experiment of a stage at its end, in a window."""
    window, run, story = request.param
    tab = Tab(browser, page, SEEN[window][0], f"#run={run}&story={story}")
    wait_until(tab.page, "maglevLive.frame?.time > 0.2")
    if story != "weight":   # which is seen to fall
        tab.evaluate("post({ type: 'speed', value: 5 })")
    wait_until(tab.page, "document.getElementById('moment').textContent")
    tab.page.click("#play")
    tab.page.wait_for_timeout(100)
    yield tab
    problems = tab.problems + tab.evaluate("maglevLive.problems")
    tab.context.close()
    assert problems == []


CASES = [(window, run, story) for window in SEEN for run, story in (
    *((HOMES[0], story) for story in ("off", "weight", "pid", "weak")), (HOMES[1], "weight"), (HOMES[2], "off"))]


@pytest.mark.few(5)
@pytest.mark.parametrize("told", CASES, ids=map("-".join, CASES), indirect=True)
def test_what_an_experiment_speaks_of_is_seen_to_move(told: Tab, request: pytest.FixtureRequest) -> None:
    window, run, story = request.node.callspec.params["told"]
    least = SEEN[window][1]
    drawn, said = told.evaluate(DRAWN, False)
    assert drawn == said
    assert told.evaluate(WAY, False) > least
    if story == "pid":
        theirs, colour = told.evaluate(DRAWN, True)
        assert theirs == colour != said and told.evaluate(WAY, True) > least
        assert told.page.locator("#legend button").all_inner_texts() == ["reference", "nonlinear", "PID"]
        assert told.evaluate("plots.live.panels.map(({ title }) => title)")[-1] == "motor currents (A)"
    if story == "weight":
        assert told.evaluate(FALL) > least
        assert told.evaluate("weightNow(maglevLive.history.last().time)") == {
            "mass": pytest.approx(1.0), "x": 0.0, "z": 0.0, "above": 0.0}
        if run == HOMES[0]:
            before, after = (equilibrium("Plant3DOF", {"y": "25 mm"}, {"y.mass": mass}).i_d[0] for mass in (6.9, 7.9))
            assert f"from {-before:.1f} A to {-after:.1f} A" in told.page.inner_text("#moment")
    hits = [hit["name"] for hit in told.evaluate("maglevLive.hits")]
    assert hits == {"off": ["nonlinear"], "weak": ["nonlinear"], "pid": ["PID"], "weight": []}[story]


@pytest.mark.parametrize("told", [("desktop", HOMES[0], "weak")], ids=["weak"], indirect=True)
def test_what_fell_lifts_off_and_the_experiment_goes_on(told: Tab) -> None:
    fell = told.evaluate("maglevLive.frame.time")
    assert told.page.inner_text("#status") == "", "one line tells it, not two"
    moment = told.page.inner_text("#moment")
    peak = told.evaluate("valueOf('plant.alpha.amplifier.peak')")
    levels = told.evaluate("plots.live.panels.at(-1).levels.map(({ value }) => value)")
    assert levels == [-peak, peak], "and not the larger limit"
    assert 0.0 < peak < told.evaluate("valueOf('controller.current_limit')")
    told.page.click("#lift")
    wait_until(told.page, f"maglevLive.frame.time > {fell} + 0.4 && !maglevLive.frame.flags.stop")
    assert told.page.inner_text("#moment") == moment and "story=weak" in told.evaluate("location.hash")
    assert told.evaluate("maglevLive.history.at(0, 0)") == 0.0, "its plots go on"
    assert told.evaluate("maglevLive.hits") == []


def test_a_window_with_no_room_draws_nothing_and_breaks_nothing(browser, page: Path) -> None:
    tab = Tab(browser, page, {"width": 40, "height": 300})
    wait_until(tab.page, "maglevLive.frames > 3")
    problems = tab.problems + tab.evaluate("maglevLive.problems")
    tab.context.close()
    assert problems == []
