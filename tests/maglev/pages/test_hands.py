"""The live page of all its runs: each has the bits of the native FMUs, and what hands and fingers do shows."""

from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from live_homes import HOMES
from report_tab import PHONE, WIDE, Tab, wait_until

from maglev import build, new_controller
from maglev.pages.live_content import live_runs
from maglev.pages.live_page import live_page, worker_text
from maglev.pages.shell import packed_text
from maglev.runs.preparation import prepare

pytestmark = pytest.mark.thorough

POSITION = "maglevLive.history.last().axes"
UNFOLD = "for (const details of document.querySelectorAll('.panel details')) details.open = true"
STAY = "for (const axis of maglevLive.run.axes) nudge(axis, 0)"   # also when the run's next step is due
# Gaps less their references (m) of the rows from one on.
ERRORS = """(first) => Array.from({ length: maglevLive.history.count - first }, (_, k) =>
    maglevLive.history.at(first + k, columnOf.position(0)) - maglevLive.history.at(first + k, columnOf.reference(0)))"""
# The worker of the page with all runs also tells the positions of a run at every communication point until a time (s).
WORKER = """HANDLERS.stepped = ({ run, until, model = runs[run].fmus.controller.model, settings = {} }) => {
    const checked = new Simulation(library, runs[run], model, settings), positions = [];
    for (let k = 0; k <= Math.round(until / checked.run.step); k++) {
        if (k) checked.step();
        positions.push(...checked.run.axes.map((_, i) => checked.motion.values[2 * i]));
    }
    postMessage({ type: "stepped", positions });
};
"""
HEARD = """() => {
    SHAPES.stepped = { positions: Array.isArray };
    RECEIVED.stepped = ({ positions }) => { window.stepped = positions; };
}"""
MIDDLE = """(() => { const box = document.getElementById("stage").getBoundingClientRect();
    const [left, top, width, height] = boxIn(maglevLive.views.space, maglevLive.history.last(), "position");
    return [box.left + left + width / 2, box.top + top + height / 2]; })()"""


@pytest.fixture(scope="module")
def whole(wasm_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The page with all runs."""
    path = tmp_path_factory.mktemp("live") / "whole.html"
    text, packed = live_page(wasm_fmus, live_runs()), packed_text(worker_text().encode())
    assert packed in text
    path.write_text(text.replace(packed, packed_text((worker_text() + WORKER).encode())), encoding="utf-8")
    return path


@pytest.fixture
def tab(browser, whole: Path, request: pytest.FixtureRequest) -> Iterator[Tab]:
    """It in a window, with a run."""
    viewport, run = request.param
    found = Tab(browser, whole, viewport, f"#run={run}")
    wait_until(found.page, "maglevLive.frames > 5 || maglevLive.problems.length")
    found.evaluate(UNFOLD)
    found.evaluate(HEARD)
    yield found
    problems = found.problems + found.evaluate("maglevLive.problems")
    found.context.close()
    assert problems == []


def errors_after(tab: Tab, act: Callable[[], object], seconds: float) -> np.ndarray:
    """Errors of the gap (m), shape (n,), in the seconds after something is done."""
    before = tab.evaluate("maglevLive.history.count")
    act()
    rest(tab, seconds)
    return np.array(tab.evaluate(ERRORS, before))


def rest(tab: Tab, seconds: float) -> None:
    """Let the run go on by a time."""
    wait_until(tab.page, f"maglevLive.frame.time > {tab.evaluate('maglevLive.frame.time') + seconds}")


def positions(tab: Tab, run: str, until: float, settings: str = "{}", model: str | None = None) -> np.ndarray:
    """Positions of a run of the page, all axes at a point and then the next, with settings and a controller."""
    asked = "" if model is None else f"model: '{model}', "
    tab.evaluate(f"window.stepped = null; post({{ type: 'stepped', run: '{run}', until: {until}, {asked}"
                 f"settings: {settings} }})")
    wait_until(tab.page, "window.stepped !== null")
    return np.array(tab.evaluate("window.stepped"))


@pytest.mark.parametrize("tab", [(WIDE, "3dof-setpoints-improved")], ids=[""], indirect=True)
def test_every_run_has_the_bits_of_the_native_fmus(tab: Tab, native_fmus: Path) -> None:
    tab.page.click("#play")   # the run that is shown rests meanwhile
    for plan in live_runs():
        assert plan.stage is not None
        columns = prepare(plan, native_fmus, {}, {}).run().columns
        there = np.stack([columns[f"plant.{axis}.position"] for axis in plan.stage.axis_names], axis=1)
        assert np.array_equal(positions(tab, plan.name, plan.stop_time), there.ravel()), plan.name


@pytest.mark.parametrize("tab", [(WIDE, "3dof-setpoints-improved&speed=5")], ids=[""], indirect=True)
def test_the_page_shows_the_actions_of_hands(tab: Tab, browser, whole: Path) -> None:
    page = tab.page
    wait_until(page, "maglevLive.frame.time > 4")
    page.select_option("#speed", "1")
    tab.evaluate(STAY)
    for model in ("ScheduledRegulator3DOF", "PID3DOF", "LinearRegulator3DOF", "Regulator3DOF"):
        errors = errors_after(tab, partial(page.select_option, "#controller", model), 0.8)
        assert np.abs(errors).max() < 1.5e-3 and not tab.evaluate("maglevLive.frame.flags.stop"), model
    page.select_option("#ghost", "PID3DOF")
    wait_until(page, "maglevLive.ghost?.count > 50")
    page.focus("#stage")
    assert np.abs(errors_after(tab, lambda: page.keyboard.press("j"), 0.8)).max() > 50e-6, "a kick is felt"
    before = tab.evaluate(f"{POSITION}.x.reference")
    for step in (1e-3, 2e-3, 3e-3, 4e-3):   # each from where the last is seen to be
        page.keyboard.press("ArrowRight")
        wait_until(page, f"Math.abs({POSITION}.x.reference - {before} - {step}) < 1e-6")
    drag(tab, 40.0)
    page.mouse.up()
    wait_until(page, f"Math.abs({POSITION}.x.reference - {before}) > 8e-3")
    page.check("#drag-mover")
    drag(tab, 60.0)
    wait_until(page, f"Math.abs({POSITION}.x.force) > 5")
    page.mouse.up()
    wait_until(page, f"{POSITION}.x.force === 0")
    page.fill("#payload", "0.5")
    page.fill("#gains", "1.1")
    page.select_option("#parameter-name", "plant.y.position_start")
    page.fill("#parameter-value", "0.99")
    page.click(".parameter button")
    said = page.inner_text("#parameter-wrong") + page.inner_text("#status")
    assert any(word in said for word in ("expected", "between")), "a bad start is refused"
    page.fill("#parameter-value", "0.024")
    page.click(".parameter button")
    wait_until(page, "maglevLive.frame.time < 2")
    fragment = tab.evaluate("location.hash")
    page.click("#copy-command")
    assert "plant.y.mass=7.4" in fragment and "--set plant.y.mass=7.4" in page.input_value("#copied")
    again = Tab(browser, whole, WIDE, fragment)
    wait_until(again.page, "maglevLive.frames > 5")
    assert again.evaluate("[location.hash, valueOf('plant.y.mass')]") == [fragment, 7.4]
    assert again.problems == [] == again.evaluate("maglevLive.problems")
    again.context.close()


@pytest.mark.parametrize("tab", [(WIDE, "5dof-setpoints")], ids=[""], indirect=True)
def test_a_stage_that_tilts_follows_in_its_tilts(tab: Tab) -> None:
    page = tab.page
    for axis in ("roll", "pitch"):
        away = f"Math.abs({POSITION}.{axis}.position - 5e-3)"
        tab.evaluate(f"refer('{axis}', 5e-3)")
        wait_until(page, f"{away} < 0.1e-3")
        page.click(f"#kicks button[aria-label^='Kick {axis} by 0']")
        wait_until(page, f"{away} > 0.5e-3")
        wait_until(page, f"{away} < 0.1e-3")
    page.fill("#payload", "0.5")
    page.fill("#payload-x", "50")   # which is not in the middle
    wait_until(page, f"{away} > 0.5e-3")
    wait_until(page, f"{away} < 0.1e-3")
    fragment = tab.evaluate("location.hash")
    assert "plant.payload.mass=0.5" in fragment and "plant.payload.x=0.05" in fragment
    assert not tab.evaluate("maglevLive.frame.flags.stop")


@pytest.mark.parametrize("tab", [(PHONE, "3dof-setpoints-improved")], ids=[""], indirect=True)
def test_what_a_reference_has_brought_down_is_lifted_again(tab: Tab) -> None:
    page = tab.page
    tab.evaluate("refer(vertical(), 0.0305)")   # m, farther than the current carries it
    wait_until(page, "maglevLive.frame.flags.stop")
    assert "there are 4.0 A" in page.inner_text("#status")
    fell = tab.evaluate("maglevLive.frame.time")
    page.tap("#lift")
    wait_until(page, f"maglevLive.frame.time > {fell + 0.5} && !maglevLive.frame.flags.stop")
    page.wait_for_selector("#lift", state="hidden")


@pytest.mark.parametrize("tab", [(WIDE, "5dof-setpoints")], ids=[""], indirect=True)
def test_an_error_shows_until_its_cause_is_undone(tab: Tab) -> None:
    page = tab.page
    tab.evaluate(STAY)
    wait_until(page, "maglevLive.frame.time > 5")   # it rests

    def moves(act: Callable[[], object], seconds: float = 1.2) -> float:
        """How far the gap moves (m) in the seconds after something is done."""
        return float(np.ptp(errors_after(tab, act, seconds)))

    quiet = moves(lambda: None)
    for slider, value in (("noise", "100"), ("shake", "2")):
        assert moves(partial(page.fill, f"#{slider}", value)) > 2 * quiet, slider
        assert not tab.evaluate("maglevLive.frame.flags.stop")
        page.fill(f"#{slider}", "0")
        rest(tab, 1.5)
    assert "measurement" not in tab.evaluate("location.hash")
    assert moves(lambda: page.click("#blink"), 0.3) > 2 * quiet
    rest(tab, 1.0)
    page.check("#switch-phase")
    phases = "maglevLive.history.last().motors[maglevLive.run.motors[0]].phases"
    wait_until(page, f"{phases}[1] === 0")
    assert tab.evaluate(f"{phases}[0]") != 0
    page.uncheck("#switch-phase")
    page.fill("#delay", "20")
    wait_until(page, "maglevLive.frame.flags.stop")
    page.click("#planned")
    wait_until(page, "maglevLive.frame.time > 1 && maglevLive.frame.time < 4 && !maglevLive.frame.flags.stop")
    assert "measurement" not in tab.evaluate("location.hash")


@pytest.mark.parametrize(("tab", "run"), [((WIDE, name), name) for name in HOMES], ids=HOMES, indirect=["tab"])
def test_the_law_in_javascript_is_that_in_c(tab: Tab, run: str, tmp_path: Path) -> None:
    page = tab.page
    file = new_controller(tmp_path / "mine.py", stage=run.partition("-")[0])
    module = build([file], fmus=tmp_path, kind="native", target="wasm")[0]
    page.set_input_files("#own-files", [module, module.with_suffix(".xml")])
    wait_until(page, f"maglevLive.state.controller === 'own:{module.stem}'")
    tab.evaluate("setLawText(page.run.stage.law)")   # which is that of maglev new controller
    page.click("#run-law")
    wait_until(page, "maglevLive.state.controller === 'own:law'")
    ours, theirs = (positions(tab, run, 3.0, "{ 'plant.encoder.resolution': 0 }", model)
                    for model in ("own:law", f"own:{module.stem}"))
    assert np.abs(ours - theirs).max() < 1e-12 and np.ptp(ours) > 1e-3


def drag(tab: Tab, across: float) -> None:
    """Drag the mover that is drawn (px), and hold it."""
    tab.evaluate("window.scrollTo(0, 0)")
    x, y = tab.evaluate(MIDDLE)
    tab.page.mouse.move(x, y)
    tab.page.mouse.down()
    tab.page.mouse.move(x + across, y, steps=8)
    rest(tab, 0.2)
