"""Pages of every kind, as they are seen: three widths, light and dark."""

import shutil
from pathlib import Path

import pytest
from report_runs import packaged, recorded
from report_tab import CONTRAST, Tab, wait_until

from maglev.comparison.files import rows_of
from maglev.comparison.page import comparison_page
from maglev.live.page import live_page
from maglev.pages.shell import INDEX, publish

WIDTHS = (1440, 820, 390)   # px
PLOTTED = "document.querySelector('.plot').scrollIntoView() || document.querySelector('.panel-plot') !== null"

# What is wider than the window, whether the head covers what follows, and what its own box or the window cuts off.
LOOK = """() => {
  const [head, main] = ["header", "main"].map((name) => document.querySelector(name).getBoundingClientRect());
  const within = (element, holds) => element
    && (holds(getComputedStyle(element)) || within(element.parentElement, holds));
  const seen = (element) => element.checkVisibility() && element.clientWidth > 1 && !element.closest("svg, select")
    && !within(element, ({ clipPath }) => clipPath === "inset(50%)");   // what screen readers read
  const cuts = (element) => {
    const { overflowX, textOverflow } = getComputedStyle(element);      // dots say that there is more
    return ["hidden", "clip"].includes(overflowX) && textOverflow !== "ellipsis"
      && element.scrollWidth > element.clientWidth + 1;
  };
  const beyond = (element) => element.getBoundingClientRect().right > innerWidth + 1
    && !within(element, ({ overflowX }) => ["auto", "scroll"].includes(overflowX));
  const all = [...document.body.querySelectorAll("*")]
    .filter((element) => (beyond(element) || cuts(element)) && seen(element));
  return { wide: document.documentElement.scrollWidth - innerWidth, covered: head.bottom > main.top + 1,
    cut: all.map((element) => element.outerHTML.slice(0, 80)) };
}"""


@pytest.fixture(scope="module")
def pages(report: Path, wasm_fmus: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Folder with a page of each kind that has plots, and the index that they make."""
    folder = tmp_path_factory.mktemp("pages")
    shutil.copy(report, folder)
    runs = {name: recorded(packaged(f"2dof-step-4-{name}")) for name in ("linear", "nonlinear")}
    publish(folder / "live.html", live_page(wasm_fmus, [packaged("2dof-setpoints")]))
    publish(folder / "compare.html", comparison_page("2dof-step-4", "Two laws", runs, rows_of(runs)))
    return folder


@pytest.mark.parametrize(("name", "drawn"), [
    ("report.html", PLOTTED), ("compare.html", PLOTTED), ("live.html", "maglevLive.frames > 5"), (INDEX, "true")],
    ids=["report", "compare", "live", "index"])
def test_nothing_is_cut_or_covered(browser, pages: Path, name: str, drawn: str) -> None:  # type: ignore[no-untyped-def]
    tab = Tab(browser, pages / name)
    wait_until(tab.page, drawn)
    for width in WIDTHS:
        tab.page.set_viewport_size({"width": width, "height": 900})
        assert tab.evaluate(LOOK) == {"wide": 0, "covered": False, "cut": []}, width
    for scheme in ("light", "dark"):
        tab.page.emulate_media(color_scheme=scheme)
        seen = tab.evaluate(CONTRAST, "h1")
        assert seen["ratio"] >= 7 and (seen["paper"] < 0.1) == (scheme == "dark")
    problems = tab.problems + tab.evaluate("window.maglevReport?.errors ?? window.maglevLive?.problems ?? []")
    tab.context.close()
    assert problems == []
