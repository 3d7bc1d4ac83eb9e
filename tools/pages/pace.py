"""Measure how fast pages draw: the first picture, frames a second and longest task of the live page, a zoom step.

    python tools/pages/pace.py [--live results/live.html] [--report results/report.html] [--figure figure-5-21]

It needs a Chromium, Playwright, and the pages of `make pages`; what it prints is worth something on a quiet machine.
"""

import argparse
import shutil
import statistics
from pathlib import Path

from playwright.sync_api import Browser, CDPSession, Page, sync_playwright

SECONDS = 10
STEPS = 20   # of zooming
RUNS = {"as it opens": "", "another runs along": "#run=3dof-tracking-nonlinear&ghost=PID3DOF",
           "5-DOF, from the sides": "#run=5dof-setpoints&view=sides"}

WATCH = """() => { window.longest = 0; new PerformanceObserver((list) => {
    for (const { duration } of list.getEntries()) window.longest = Math.max(window.longest, duration);
}).observe({ type: "longtask" }); }"""
COUNT = "[maglevLive.frames, performance.now(), maglevLive.frame?.time ?? 0]"


def opened(browser: Browser, url: str) -> tuple[Page, CDPSession]:
    """A page in a tab of its own, and what tells its costs."""
    page = browser.new_context(offline=True, viewport={"width": 1440, "height": 900}).new_page()
    page.goto(url)
    page.wait_for_timeout(2500)
    return page, page.context.new_cdp_session(page)


def spent(session: CDPSession) -> float:
    """Processor time (s) of the page's thread so far."""
    metrics = session.send("Performance.getMetrics")["metrics"]
    return next(float(metric["value"]) for metric in metrics if metric["name"] == "TaskDuration")


def first_picture(browser: Browser, path: Path, drawn: str) -> None:
    """Processor time of the page's thread until its first picture, opened again."""
    page, session = opened(browser, path.resolve().as_uri())
    session.send("Performance.enable", {"timeDomain": "threadTicks"})
    costs = []
    for _ in range(5):
        page.goto("about:blank")
        before = spent(session)
        page.goto(path.resolve().as_uri(), wait_until="commit")
        while not page.evaluate(f"Boolean({drawn})"):
            page.wait_for_timeout(10)
        costs.append(spent(session) - before)
    print(f"first picture of {path.name}: {1e3 * statistics.median(costs):.0f} ms")
    page.context.close()


def live_pace(browser: Browser, path: Path) -> None:
    """Frames a second, speed and longest task (over 50 ms are counted) at 1×, also with a slower processor."""
    for name, fragment in RUNS.items():
        page, session = opened(browser, path.resolve().as_uri() + fragment)
        for slower in (1, 4):
            session.send("Emulation.setCPUThrottlingRate", {"rate": slower})
            page.wait_for_timeout(1000)
            page.evaluate(WATCH)
            first = page.evaluate(COUNT)
            page.wait_for_timeout(1e3 * SECONDS)
            last = page.evaluate(COUNT)
            longest, seconds = page.evaluate("window.longest"), 1e-3 * (last[1] - first[1])
            print(f"{name:22} processor 1/{slower}: {(last[0] - first[0]) / seconds:5.1f} frames/s, "
                  f"{(last[2] - first[2]) / seconds:5.2f} × real time, longest task "
                  + (f"{longest:.0f} ms" if longest else "below 50 ms"))
        page.context.close()


def zoom(browser: Browser, path: Path, figure: str) -> None:
    """Processor time of the page's thread for a step of zooming: scripts, style, layout, and painting."""
    page, session = opened(browser, path.resolve().as_uri())
    page.evaluate("document.getElementById('player-play')?.textContent === 'Pause' && "
                  "document.getElementById('player-play').click()")
    page.evaluate("(id) => document.getElementById(id).scrollIntoView()", figure)
    drawn = "(id) => maglevReport.plots[id]?.places.every((place) => place.querySelector('.panel-plot')) ?? false"
    while not page.evaluate(drawn, figure):
        page.wait_for_timeout(50)
    page.wait_for_timeout(1000)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})

    costs: dict[str, list[float]] = {"step": [], "nothing": []}
    for step in range(STEPS):
        for what, factor in (("step", 0.5 if step % 2 else 2.0), ("nothing", None)):
            before = spent(session)
            page.evaluate("([id, factor]) => { if (factor) change(maglevReport.plots[id], factor, 0); }",
                          [figure, factor])
            page.evaluate("(id) => maglevReport.plots[id].drawn", figure)
            page.evaluate("() => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))")
            costs[what].append(1e3 * (spent(session) - before))
    cost = statistics.median(costs["step"]) - statistics.median(costs["nothing"])
    panels = page.evaluate("(id) => maglevReport.plots[id].panels.length", figure)
    print(f"a step of zooming in {figure} ({panels} panels): {cost:.0f} ms")
    page.context.close()


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--live", type=Path, default=Path("results/live.html"))
    parser.add_argument("--report", type=Path, default=Path("results/report.html"))
    parser.add_argument("--figure", default="figure-5-21")
    arguments = parser.parse_args()
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        first_picture(browser, arguments.live, "window.maglevLive?.frames")
        first_picture(browser, arguments.report, "window.maglevReport?.views || document.querySelector('.panel-plot')")
        live_pace(browser, arguments.live)
        zoom(browser, arguments.report, arguments.figure)
        browser.close()


if __name__ == "__main__":
    main()
