"""What a hand does to the live page: it leads the platform; what it writes stays; refusals stand at their fields."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest
from live_homes import HOMES
from report_tab import PHONE, WIDE, Tab, wait_until

MIDDLE = """(() => { const box = document.getElementById("stage").getBoundingClientRect();
    const [left, top, width, height] = boxIn(maglevLive.views.space, maglevLive.history.last(), "position");
    return [box.left + left + width / 2, box.top + top + height / 2]; })()"""
LABEL = """(() => { const { x, y, half } = maglevLive.hint;
    const box = document.getElementById("stage").getBoundingClientRect();
    return [box.left + x - half + 4, box.top + y]; })()"""
STAY = "for (const axis of maglevLive.run.axes) nudge(axis, 0)"   # also when the run's first step is due
REFERENCE = "maglevLive.history.last().axes[vertical()].reference"
# A swipe is faster than a press, however slow the machine is.
FAST = """() => { window.slowly = setTimeout;
    window.setTimeout = (act, time) => slowly(act, time === PRESS ? 1e6 : time); }"""
CURRENT = """Math.abs(carryingCurrent(maglevLive.run,
    atGap(maglevLive.run, maglevLive.history.last(), {gap}), valueOf))"""


@pytest.fixture
def tab(browser, page: Path, request: pytest.FixtureRequest) -> Iterator[Tab]:
    found = Tab(browser, page, request.param, f"#run={HOMES[0]}", reduced_motion="reduce")   # it waits at its start
    wait_until(found.page, "maglevLive.frames > 0 && maglevLive.hint")
    found.evaluate(STAY)
    found.evaluate("play(true)")
    yield found
    problems = found.problems + found.evaluate("maglevLive.problems")
    found.context.close()
    assert problems == []


@pytest.mark.parametrize("tab", [WIDE], ids=[""], indirect=True)
@pytest.mark.parametrize("by", [45, -45])
def test_a_drag_by_the_label_leads_the_platform_to_where_it_can_be_held(tab: Tab, by: int) -> None:
    """45 px are more than there is to either stop: it continues slowly, and stays where 85 % of the current hold it."""
    mouse, (x, y) = tab.page.mouse, tab.evaluate(LABEL)
    before, begun = tab.evaluate(REFERENCE), tab.evaluate("maglevLive.history.last().time")
    mouse.move(x, y)
    mouse.down()
    mouse.move(x, y + by)
    wait_until(tab.page, "document.getElementById('flags').textContent.includes('no farther: it could not be held')")
    mouse.up()
    wait_until(tab.page, "Object.keys(maglevLive.leads).length === 0")
    there, time = tab.evaluate(REFERENCE), tab.evaluate("maglevLive.history.last().time")
    assert (there - before) * by > 0
    assert abs(there - before) / (time - begun) <= 0.0201   # m/s
    low, high = tab.evaluate("endsOf(maglevLive.run, vertical(), valueOf)")
    assert low + 1.49e-3 < there < high - 1.49e-3
    assert tab.evaluate(CURRENT.format(gap=there)) <= 0.85 * 4.0 + 0.01   # A
    wait_until(tab.page, f"maglevLive.frame.time > {time} + 1")
    assert not tab.evaluate("maglevLive.frame.flags.stop") and tab.evaluate("maglevLive.hits") == []


@pytest.mark.parametrize("tab", [PHONE], ids=[""], indirect=True)
def test_on_a_phone_a_swipe_scrolls_and_a_long_press_takes_the_platform(tab: Tab) -> None:
    touches = tab.context.new_cdp_session(tab.page)

    def touch(kind: str, *point: float) -> None:
        points = [dict(zip("xy", point, strict=True))] if point else []
        touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": points})
        tab.page.wait_for_timeout(16)

    assert tab.evaluate("document.querySelector('.canvas').offsetHeight <= innerHeight / 2")
    x, y = tab.evaluate(MIDDLE)
    tab.evaluate(FAST)
    touch("touchStart", x, y)
    for k in range(1, 13):
        touch("touchMove", x, y - 10 * k)
    touch("touchEnd")
    tab.evaluate("() => { window.setTimeout = slowly; }")
    wait_until(tab.page, "scrollY > 50")
    assert tab.evaluate("maglevLive.leads") == {}
    tab.evaluate("scrollTo(0, 0)")
    x, y = tab.evaluate(MIDDLE)
    before = tab.evaluate("maglevLive.history.last().axes.x.reference")
    touch("touchStart", x, y)
    wait_until(tab.page, "maglevLive.drag !== null")
    for k in range(1, 9):
        touch("touchMove", x + 5 * k, y)
    wait_until(tab.page, f"Math.abs(maglevLive.history.last().axes.x.reference - {before}) > 5e-3")
    touch("touchEnd")
    assert tab.evaluate("scrollY") == 0


@pytest.mark.parametrize("tab", [WIDE], ids=[""], indirect=True)
def test_what_is_written_outlives_the_page_and_is_not_replaced_unasked(tab: Tab) -> None:
    wait_until(tab.page, "editor.view !== null")
    tab.page.click(".cm-content")
    tab.page.keyboard.press("Control+Home")
    tab.page.keyboard.type("// mine")
    asked: list[str] = []

    def refuse(dialog: Any) -> None:
        asked.append(dialog.message)
        dialog.dismiss()

    tab.page.once("dialog", refuse)
    tab.page.select_option("#starter", "sliding")
    assert asked == ["Replace what is written by the starter sliding mode?"]
    assert tab.evaluate("lawText()").startswith("// mine") and tab.page.input_value("#starter") == "pid"
    tab.page.reload()
    wait_until(tab.page, "maglevLive.frames > 0")
    assert tab.evaluate("lawText()").startswith("// mine")
    tab.page.once("dialog", lambda dialog: dialog.accept())
    tab.page.select_option("#starter", "sliding")
    assert "sliding mode" in tab.evaluate("lawText()") and "// mine" not in tab.evaluate("lawText()")
    tab.page.reload()
    wait_until(tab.page, "maglevLive.frames > 0")
    assert "// mine" not in tab.evaluate("lawText()")


@pytest.mark.parametrize("tab", [WIDE], ids=[""], indirect=True)
def test_a_refusal_stands_at_its_field_and_a_link_tells_what_it_lacks(tab: Tab) -> None:
    tab.evaluate("for (const details of document.querySelectorAll('.panel details')) details.open = true")
    tab.page.select_option("#parameter-name", "plant.y.mass")
    tab.page.fill("#parameter-value", "-4")
    tab.page.click(".parameter button")
    assert tab.page.inner_text("#parameter-wrong").startswith("plant.y.mass = -4, expected a number from ")
    assert tab.page.get_attribute("#parameter-value", "aria-invalid") == "true"
    tab.page.fill("#parameter-value", "7")
    tab.page.click(".parameter button")
    assert tab.page.inner_text("#parameter-wrong") == ""
    tab.evaluate("location.hash = 'run=nothing&speed=3'")
    wait_until(tab.page, "document.getElementById('status').textContent.startsWith('Ignored in this link: ')")
    said = tab.page.inner_text("#status")
    assert "run = nothing: there is no such run here" in said and "speed = 3, expected one of " in said
