"""What the live page says is so: what differs from the plan, whose controller runs, why the platform has fallen."""

from pathlib import Path

from live_homes import HOMES
from report_tab import WIDE, Tab, wait_until


def test_what_is_said_of_settings_controllers_and_a_fall(browser, page: Path) -> None:
    tab = Tab(browser, page, WIDE, f"#run={HOMES[0]}")
    wait_until(tab.page, "maglevLive.frames > 3")
    tab.evaluate("change({ 'plant.alpha.amplifier.peak': 7.5 })")
    assert tab.page.locator(".settings li").inner_text() == "plant.alpha.amplifier.peak = 7.5 undo"
    tab.page.click(".settings button")
    assert tab.page.locator(".settings li").count() == 0
    tab.page.click("#run-law")
    wait_until(tab.page, "maglevLive.state.controller === 'own:law'")
    for controller, whose in (("Regulator3DOF", "The nonlinear"), ("own:law", "Your")):
        tab.page.select_option("#controller", controller)
        assert tab.page.inner_text("#status") == f"{whose} controller takes over, from where the stage is."
    tab.evaluate("asPlanned()")   # out of the experiment, which would tell it
    wait_until(tab.page, "maglevLive.frame.time > 0.2 && maglevLive.story === null")
    tab.evaluate("change(Object.fromEntries(offNames().map((name) => [name, true])))")
    wait_until(tab.page, "maglevLive.frame.flags.stop")
    said = tab.page.inner_text("#status")
    problems = tab.problems + tab.evaluate("maglevLive.problems")
    tab.context.close()
    assert said.endswith(" stop: the amplifiers are off.") and " A" not in said
    assert problems == []
