"""The live page in Chromium beyond its tests: every run against the native FMUs, and what hands do to a flight.

    python tools/pages/live_check.py [--fmus fmus]

It needs a Chromium, Playwright, and the FMUs of `maglev build --kind native --target host` and `--target wasm`.
"""

import argparse
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np
from playwright.sync_api import Browser, Page, sync_playwright

from maglev import build, new_controller
from maglev.experiment.preparation import prepare
from maglev.live.content import live_runs
from maglev.live.page import write_live
from maglev.schema.run_plan import RunPlan

POSITION = "maglevLive.history.last().axes"
UNFOLD = "for (const details of document.querySelectorAll('.panel details')) details.open = true"


class Problem(Exception):
    """Something that is not as it should be."""


def require(good: bool, what: str) -> None:
    """Refuse what is not as it should be; an assert would go with -O."""
    if not good:
        raise Problem(what)


def wait_until(page: Page, condition: str, most: float = 20.0) -> None:
    """Wait for a condition; the page's policy forbids Playwright's own way."""
    end = time.monotonic() + most
    while not page.evaluate(condition):
        require(time.monotonic() < end, f"still not so after {most} s: {condition}")
        page.wait_for_timeout(50)


class Tab:
    """The page in a browser of its own; what goes wrong in it is kept."""

    def __init__(self, browser: Browser, url: str, phone: bool = False):
        width, height = (390, 844) if phone else (1440, 900)
        self.context = browser.new_context(offline=True, viewport={"width": width, "height": height}, is_mobile=phone,
                                           has_touch=phone)
        self.page = self.context.new_page()
        self.problems: list[str] = []
        self.page.on("console", lambda message: self.problems.append(message.text))
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.goto(url)
        wait_until(self.page, "maglevLive.frames > 5 || maglevLive.problems.length")

    def close(self) -> None:
        """Close, and refuse what went wrong."""
        problems = self.problems + self.page.evaluate("maglevLive.problems")
        self.context.close()
        require(not problems, "; ".join(problems))


def compare_runs(browser: Browser, url: str, fmus: Path) -> None:
    """Every run of the page against the native FMUs under the master: the same bits."""
    tab = Tab(browser, url)
    tab.page.click("#play")   # the flight that is shown rests meanwhile
    took = steps = seconds = 0.0
    rows = []
    for plan in live_runs():
        there = native(plan, fmus)
        tab.page.evaluate(f"post({{ type: 'flown', run: '{plan.name}', until: {plan.stop_time}, "
                          "settings: {} })")
        wait_until(tab.page, f"maglevLive.flown['{plan.name}'] !== undefined", 60.0)
        flown = tab.page.evaluate(f"(({{ positions, took }}) => [Array.from(positions), took])"
                                  f"(maglevLive.flown['{plan.name}'])")
        here = np.array(flown[0]).reshape(there.shape)
        difference = np.abs(here - there).max(axis=1)
        rows.append((plan.name, difference.max(), np.argmax(difference > 0.0) if difference.any() else -1))
        took += flown[1]
        steps += plan.steps
        seconds += plan.stop_time
    tab.close()
    for name, most, first in sorted(rows, key=lambda row: row[1], reverse=True):
        print(f"  {name:45} {most:8.1e} m, first at step {first}")
    equal = sum(most == 0.0 for _, most, _ in rows)
    print(f"{len(rows)} runs, {seconds:.0f} s: {equal} equal, largest difference "
          f"{max(most for _, most, _ in rows):.1e} m; "
          f"{1e3 * took / steps:.1f} µs a step of plant and controller, {seconds / (1e-3 * took):.0f} times real time")
    require(equal == len(rows), "a run has other bits than the FMUs")


def native(plan: RunPlan, fmus: Path) -> np.ndarray:
    """Positions, shape (points, axes), in the order of the page."""
    columns = prepare(plan, fmus / "native", {}, {}).run(None).columns
    assert plan.rig is not None
    return np.stack([columns[f"plant.{axis}.position"] for axis in plan.rig.axis_names], axis=1)


def hands(browser: Browser, url: str) -> None:
    """What people do: swap, fly along, drag, kick, set, copy; each must show in the flight."""
    tab = Tab(browser, url + "#run=3dof-setpoints-improved&speed=5")
    page = tab.page
    wait_until(page, "maglevLive.frame.time > 4")
    page.select_option("#speed", "1")
    # The stage is to stay where it is, also when the run's next step is due.
    page.evaluate("for (const axis of maglevLive.run.axes) nudge(axis, 0)")

    def excursion(act: Callable[[], object], seconds: float = 0.8) -> float:
        """Largest error of the gap (m) in the seconds after something is done."""
        before = page.evaluate("maglevLive.history.count")
        act()
        page.wait_for_timeout(1e3 * seconds)
        return float(page.evaluate(f"""(() => {{ const rows = maglevLive.history; let most = 0;
            for (let row = {before}; row < rows.count; row++) most = Math.max(most, Math.abs(
                rows.at(row, columnOf.position(0)) - rows.at(row, columnOf.reference(0)))); return most; }})()"""))

    for model in ("ScheduledRegulator3DOF", "PID3DOF", "LinearRegulator3DOF", "Regulator3DOF"):
        most = excursion(partial(page.select_option, "#controller", model))
        print(f"  swap to {model}: gap within {1e6 * most:.0f} µm")
        require(most < 1.5e-3 and not page.evaluate("maglevLive.frame.flags.stop"), f"{model} loses the stage")
    page.select_option("#ghost", "PID3DOF")
    wait_until(page, "maglevLive.ghost?.count > 50")
    page.focus("#stage")
    kicked = excursion(lambda: page.keyboard.press("j"))
    print(f"  kick of 0.41 N s: gap within {1e6 * kicked:.0f} µm")
    require(kicked > 50e-6, "a kick moves nothing")
    before = page.evaluate(f"{POSITION}.x.reference")
    for _ in range(4):
        page.keyboard.press("ArrowRight")
        page.wait_for_timeout(80)
    wait_until(page, f"Math.abs({POSITION}.x.reference - {before} - 4e-3) < 1e-6")
    page.evaluate("window.scrollTo(0, 0)")
    drag(page, 40.0)
    after = page.evaluate(f"{POSITION}.x.reference")
    require(abs(after - before) > 8e-3, f"dragging the reference moves it from {before} to {after} m")
    page.evaluate(UNFOLD)
    page.check("#drag-mover")
    page.evaluate("window.scrollTo(0, 0)")
    page.mouse.move(*middle(page))
    page.mouse.down()
    page.mouse.move(middle(page)[0] + 60, middle(page)[1])
    wait_until(page, f"Math.abs({POSITION}.x.force) > 5")
    page.mouse.up()
    wait_until(page, f"{POSITION}.x.force === 0")
    page.fill("#payload", "0.5")
    page.fill("#gains", "1.1")
    page.select_option("#parameter-name", "plant.y.position_start")
    page.fill("#parameter-value", "0.99")
    page.click(".parameter button")
    require("expected" in page.inner_text("#status") or "between" in page.inner_text("#status"), "a bad start is flown")
    page.fill("#parameter-value", "0.024")
    page.click(".parameter button")
    wait_until(page, "maglevLive.frame.time < 2")
    fragment = page.evaluate("location.hash")
    page.click("#copy-command")
    command = page.input_value("#copied")
    print(f"  {fragment}\n  {command}")
    require("plant.y.mass=7.4" in fragment and "--set plant.y.mass=7.4" in command, "settings are not in the address")
    tab.close()
    again = Tab(browser, url + fragment)
    require(again.page.evaluate("location.hash") == fragment, "the address does not come back")
    require(again.page.evaluate("valueOf('plant.y.mass')") == 7.4, "the address sets nothing")
    again.close()


def tilting_hands(browser: Browser, url: str) -> None:
    """On a stage that tilts: references of the tilts, kicks in them, a payload that is not in the middle."""
    tab = Tab(browser, url + "#run=5dof-setpoints")
    page = tab.page
    page.evaluate(UNFOLD)
    for axis in ("roll", "pitch"):
        before = page.evaluate(f"{POSITION}.{axis}.position")
        page.evaluate(f"refer('{axis}', 5e-3)")
        wait_until(page, f"Math.abs({POSITION}.{axis}.position - 5e-3) < 0.1e-3")
        print(f"  {axis} from {1e3 * before:.3f} mrad to its reference of 5 mrad")
        page.click(f"#kicks button[aria-label^='Kick {axis} by 0']")
        wait_until(page, f"Math.abs({POSITION}.{axis}.position - 5e-3) > 0.5e-3")
        wait_until(page, f"Math.abs({POSITION}.{axis}.position - 5e-3) < 0.1e-3")
    page.fill("#payload", "0.5")
    page.fill("#payload-x", "50")
    wait_until(page, f"Math.abs({POSITION}.pitch.position - 5e-3) > 0.5e-3")
    wait_until(page, f"Math.abs({POSITION}.pitch.position - 5e-3) < 0.1e-3")
    fragment = page.evaluate("location.hash")
    require("plant.payload.mass=0.5" in fragment and "plant.payload.x=0.05" in fragment, fragment)
    require(not page.evaluate("maglevLive.frame.flags.stop"), "the payload puts the stage on its stops")
    tab.close()


def fingers(browser: Browser, url: str) -> None:
    """On a phone: a finger on the mover takes it as far as it cannot follow; what fell lifts off."""
    tab = Tab(browser, url + "#run=3dof-setpoints-improved", phone=True)
    page, touches = tab.page, tab.context.new_cdp_session(tab.page)
    x, y = middle(page)
    for kind, part in (("touchStart", 0.0), *(("touchMove", 0.1 * k) for k in range(1, 11))):
        point = {"x": x + 40 * part, "y": y + 8 * part}
        touches.send("Input.dispatchTouchEvent", {"type": kind, "touchPoints": [point]})
        page.wait_for_timeout(20)
    touches.send("Input.dispatchTouchEvent", {"type": "touchEnd", "touchPoints": []})
    require(page.evaluate("scrollY") == 0, "a finger on the mover scrolls the page")
    wait_until(page, "maglevLive.frame.flags.stop")
    said = page.inner_text("#status")
    print(f"  {said}")
    require("there are 4.0 A" in said, said)
    fell = page.evaluate("maglevLive.frame.time")
    page.tap("#lift")
    wait_until(page, f"maglevLive.frame.time > {fell + 0.5} && !maglevLive.frame.flags.stop")
    require(not page.locator("#lift").is_visible(), "what flies is offered to lift off")
    tab.close()


def faults(browser: Browser, url: str) -> None:
    """What goes wrong, by hand: each shows in the flight, and is gone when it is taken back."""
    tab = Tab(browser, url + "#run=5dof-setpoints")
    page = tab.page
    page.evaluate(UNFOLD)
    page.evaluate("for (const axis of maglevLive.run.axes) nudge(axis, 0)")

    def error(act: Callable[[], None], seconds: float = 1.0) -> float:
        """Largest deviation (m) of the gap from its mean in the seconds after something is done."""
        act()
        page.wait_for_timeout(200)
        before = page.evaluate("maglevLive.history.count")
        page.wait_for_timeout(1e3 * seconds)
        gaps = page.evaluate(f"Array.from({{ length: maglevLive.history.count - {before} }}, (_, k) => "
                             f"maglevLive.history.at({before} + k, columnOf.position(0)))")
        return float(np.ptp(gaps))

    quiet = error(lambda: None)
    for slider, value in (("noise", "100"), ("shake", "2")):
        felt = error(partial(page.fill, f"#{slider}", value))
        page.fill(f"#{slider}", "0")
        page.wait_for_timeout(1500)
        print(f"  {slider} {value}: the gap moves by {1e6 * felt:.0f} µm, {1e6 * quiet:.0f} µm without")
        require(felt > 2 * quiet and not page.evaluate("maglevLive.frame.flags.stop"), f"{slider}: {felt} m")
    require("measurement" not in page.evaluate("location.hash"), "what is taken back stays in the address")
    off = error(lambda: page.click("#blink"), 0.1)
    require(off > 2 * quiet, f"20 ms without current move the gap by {off} m")
    page.wait_for_timeout(1000)
    page.check("#switch-phase")
    wait_until(page, "maglevLive.history.last().motors[maglevLive.run.motors[0]].phases[1] === 0")
    require(page.evaluate("maglevLive.history.last().motors[maglevLive.run.motors[0]].phases[0]") != 0, "all are open")
    page.uncheck("#switch-phase")
    page.fill("#delay", "20")
    wait_until(page, "maglevLive.frame.flags.stop")
    print(f"  20 ms late: {page.inner_text('#status')}")
    page.click("#planned")
    wait_until(page, "maglevLive.frame.time > 1 && maglevLive.frame.time < 4 && !maglevLive.frame.flags.stop")
    require("measurement" not in page.evaluate("location.hash"), "as planned leaves a setting")
    tab.close()


def own_controllers(browser: Browser, url: str, folder: Path) -> None:
    """The law in JavaScript against the C of the same one."""
    for rig in ("2dof", "3dof", "5dof"):
        run = next(plan.name for plan in live_runs() if plan.name.startswith(f"{rig}-setpoints"))
        file = new_controller(folder / f"mine{rig}.py", stage=rig)
        module = build([file], fmus=folder, kind="native", target="wasm")[0]
        tab = Tab(browser, f"{url}#run={run}")
        page = tab.page
        page.set_input_files("#own-files", [module, module.with_suffix(".xml")])
        wait_until(page, f"maglevLive.state.controller === 'own:{module.stem}'")
        page.select_option("#starter", "feedback")
        page.click("#run-law")
        wait_until(page, "maglevLive.state.controller === 'own:law'")
        flown = []
        for model in ("own:law", f"own:{module.stem}"):
            page.evaluate(f"delete maglevLive.flown['{run}']; post({{ type: 'flown', run: '{run}', until: 3, "
                          f"model: '{model}', settings: {{ 'plant.encoder.resolution': 0 }} }})")
            wait_until(page, f"maglevLive.flown['{run}']?.model === '{model}'", 60.0)
            flown.append(np.array(page.evaluate(f"Array.from(maglevLive.flown['{run}'].positions)")))
        most = np.abs(flown[0] - flown[1]).max()
        print(f"  {run}: law in JavaScript and in C differ by at most {most:.1e} m in 3 s")
        require(most < 1e-12 and np.ptp(flown[0]) > 1e-3, f"{run}: {most} m")
        tab.close()


def middle(page: Page) -> tuple[float, float]:
    """Where the first view's mover is on the screen."""
    return tuple(page.evaluate("""(() => { const box = document.getElementById("stage").getBoundingClientRect();
        const [left, top, width, height] = boxIn(maglevLive.views.space, maglevLive.history.last(), "position");
        return [box.left + left + width / 2, box.top + top + height / 2]; })()"""))


def drag(page: Page, across: float) -> None:
    """Drag on the stage (px)."""
    x, y = middle(page)
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + across, y, steps=8)
    page.wait_for_timeout(200)
    page.mouse.up()


def main() -> None:
    """Check everything; the exit code is 1 if something is not as it should be."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--fmus", type=Path, default=Path("fmus"))
    arguments = parser.parse_args()
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser", "google-chrome"))), None)
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        path = write_live(folder, fmus=arguments.fmus)
        print(f"page: {path.stat().st_size / 1000:.0f} kB")
        browser = playwright.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        try:
            compare_runs(browser, path.as_uri(), arguments.fmus)
            for check in (hands, tilting_hands, fingers, faults):
                check(browser, path.as_uri())
            own_controllers(browser, path.as_uri(), Path(folder))
        except Problem as problem:
            print(f"not as it should be: {problem}")
            sys.exit(1)
        browser.close()


if __name__ == "__main__":
    main()
