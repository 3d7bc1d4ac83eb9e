"""The live page in the hand and in a frame: the stage is seen whole, and nothing scrolls inside another page."""

from pathlib import Path

import pytest
from live_homes import HOMES
from report_tab import LANDSCAPE, PHONE, Tab, wait_until

RUNS = "maglevLive.frames > 5"
# px by which platform and stators are inside the picture of the stage in space, and the picture inside the window.
ROOM = """(() => {
    const { space } = maglevLive.views, row = maglevLive.history.last();
    const boxes = [boxIn(space, row, "position"), boxIn(space, row, "reference")];
    const inside = boxes.flatMap(([left, top, width, height]) => [left - space.left, top - space.top,
        space.left + space.width - left - width, space.top + space.height - top - height]);
    const { top, left, right, bottom } = document.getElementById("stage").getBoundingClientRect();
    return { platform: Math.min(...inside), picture: Math.min(top, left, innerWidth - right, innerHeight - bottom) };
})()"""
# What of a frame's page cannot be seen without scrolling, and texts that are cut.
UNSEEN = """() => [...document.querySelectorAll("#what, #moment, #stage, button")]
    .filter((element) => element.checkVisibility()).filter((element) => {
        const { top, bottom, left, right } = element.getBoundingClientRect();
        return top < 0 || left < 0 || bottom > innerHeight || right > innerWidth
            || element.scrollHeight > element.clientHeight + 1;
    }).map(({ id, textContent }) => id || textContent)"""


@pytest.mark.few(3)
@pytest.mark.parametrize("size", [PHONE, LANDSCAPE], ids=["portrait", "landscape"])
@pytest.mark.parametrize("run", HOMES)
def test_a_phone_shows_the_stage_whole_either_way(browser, page: Path, run: str, size) -> None:
    tab = Tab(browser, page, size, f"#run={run}")
    wait_until(tab.page, RUNS)
    room = tab.evaluate(ROOM)
    assert room["platform"] >= 0.0 and room["picture"] >= 0.0
    assert tab.page.locator("details[open]").count() == 0, "what if and what goes wrong are folded"
    assert tab.evaluate("document.documentElement.scrollHeight") < 2900
    tab.context.close()


@pytest.mark.parametrize(("width", "height"), [(740, 544), (350, 832)], ids=["desktop", "phone"])
def test_in_a_frame_the_stage_is_alone_and_nothing_scrolls(browser, page: Path, tmp_path: Path, width: int,
                                                           height: int) -> None:
    """As the site has it: experiments, what came of one, and the stage; all of it is seen."""
    around = tmp_path / "around.html"
    around.write_text(f'<iframe src="{page.as_uri()}" style="width: {width}px; height: {height}px"></iframe>',
                      encoding="utf-8")
    context = browser.new_context(offline=True, viewport={"width": 1000, "height": 900})
    tab = context.new_page()
    tab.goto(around.as_uri())
    frame = tab.frames[1]
    wait_until(frame, "typeof maglevLive === 'object' && maglevLive.frames > 5")
    frame.click("text=Controller off")
    wait_until(frame, "document.getElementById('moment').textContent")
    assert frame.inner_text("#moment").startswith("Without current it hit its ")
    assert frame.evaluate(UNSEEN) == []
    assert frame.evaluate("document.documentElement.scrollHeight <= innerHeight")
    assert frame.evaluate("document.getElementById('stage').clientHeight") > 250
    assert not any(frame.is_visible(part) for part in ("h1", "#beat", ".panel", "#strips"))
    problems = frame.evaluate("maglevLive.problems")
    context.close()
    assert problems == []
