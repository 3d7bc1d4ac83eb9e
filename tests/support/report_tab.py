"""The report in a tab of a Chromium, and what tests ask it."""

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import pytest

if TYPE_CHECKING:   # what is missing on some machines, where the fixture of the browser skips
    from playwright.sync_api import Browser, Frame, Page, ViewportSize

LIGHT: Literal["light"] = "light"
DARK: Literal["dark"] = "dark"
DESKTOP: "ViewportSize" = {"width": 1280, "height": 900}
WIDE: "ViewportSize" = {"width": 1440, "height": 900}
PHONE: "ViewportSize" = {"width": 390, "height": 800}
LANDSCAPE: "ViewportSize" = {"width": 844, "height": 390}   # the same on its side

# Contrast ratio of an element's text to the page's background, as WCAG defines it.
CONTRAST = """(selector) => {
  const luminance = (colour) => colour.match(/[0-9.]+/g).slice(0, 3).map((part) => part / 255)
    .map((part) => part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4)
    .reduce((sum, part, k) => sum + part * [0.2126, 0.7152, 0.0722][k], 0);
  const text = luminance(getComputedStyle(document.querySelector(selector)).color);
  const paper = luminance(getComputedStyle(document.body).backgroundColor);
  return { paper, ratio: (Math.max(text, paper) + 0.05) / (Math.min(text, paper) + 0.05) };
}"""


# What has moved since the page was opened, without what the reader did: each time the share of the window, and what.
SHIFTS = """() => new Promise((done) => {
  const shifts = [];
  new PerformanceObserver((list) => {
    for (const { value, hadRecentInput, sources } of list.getEntries()) {
      if (hadRecentInput) continue;
      shifts.push([value, ...sources.map(({ node, previousRect, currentRect }) =>
        `${node?.outerHTML?.slice(0, 60) ?? node?.textContent}: ${previousRect.y} to ${currentRect.y}`)]);
    }
  }).observe({ type: "layout-shift", buffered: true });
  setTimeout(() => done(shifts), 300);
})"""

# What a finger is to hit that is less than 44 px high: a box is hit with its label, a link in a text as it can be.
SMALL = """() => [...document.querySelectorAll("button, select, input:not([type='file']), summary, nav a")]
  .filter((element) => element.checkVisibility({ visibilityProperty: true }))
  .map((element) => (element.type === "checkbox" ? element.closest("label") : element))
  .filter((element) => element.getBoundingClientRect().height < 43.9)
  .map((element) => element.outerHTML.slice(0, 80))"""


# What heads something and is the last of a page: pages are columns as large as paper (mm).
ALONE = """(height) => {
  document.querySelectorAll("details").forEach((each) => { each.open = true; });
  Object.assign(document.documentElement.style, { columns: "182mm", columnFill: "auto", height: `${height}mm` });
  const seen = (element) => element.getClientRects().length > 0;
  const next = (element) => {
    const after = element.nextElementSibling ?? element.parentElement;
    return !after || (after === element.nextElementSibling && seen(after)) ? after : next(after);
  };
  const first = (element) => { const child = [...element.children].find(seen); return child ? first(child) : element; };
  return [...document.querySelectorAll("h2, h3, figcaption, tr.run, summary, dt, thead")]
    .filter((head) => seen(head) && next(head))
    .filter((head) => first(next(head)).getClientRects()[0].left > [...head.getClientRects()].at(-1).right)
    .map((head) => head.textContent.trim().slice(0, 60));
}"""


def violations(page: "Page", left_out: Sequence[str] = (), rules: Sequence[str] = ()) -> list[str]:
    """What axe-core finds on a page as it is seen now, by its rules of WCAG 2.1, A and AA, and best practices.

    Elements by whose like enough is looked at are left out, and rules that ask for what is not ours.
    """
    package = pytest.importorskip("axe_playwright_python", reason="axe-playwright-python is not installed")
    page.evaluate((Path(package.__file__).parent / "axe.min.js").read_text(encoding="utf-8"))
    found = page.evaluate("""async ([names, rules]) => {
        const exclude = names.filter((name) => document.querySelector(name)).map((name) => [name]);
        return (await axe.run({ include: [["html"]], exclude }, { resultTypes: ["violations"],
            rules: Object.fromEntries(rules.map((rule) => [rule, { enabled: false }])) })).violations;
    }""", [[*left_out], [*rules]])
    return [f"{each['id']}: {each['help']}: {each['nodes'][0]['html'][:100]}" for each in found]


class Tab:
    """The report in a browser; collects what goes wrong and what is requested."""

    def __init__(self, browser: "Browser", report: Path, viewport: "ViewportSize" = DESKTOP, fragment: str = "",
                 **options: Any) -> None:
        self.url = report.as_uri()
        self.problems: list[str] = []
        self.requests: list[str] = []
        touch = viewport in (PHONE, LANDSCAPE)
        self.context = browser.new_context(offline=True, viewport=viewport, color_scheme=LIGHT,
                                           has_touch=touch, is_mobile=touch, **options)
        self.page = self.context.new_page()
        self.page.on("console", lambda message: self.problems.append(f"{message.type}: {message.text}"))
        self.page.on("pageerror", lambda error: self.problems.append(str(error)))
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.goto(self.url + fragment)

    def evaluate(self, script: str, argument: Any = None) -> Any:
        return self.page.evaluate(script, argument)

    def close(self) -> None:
        """Close, and check that all went well and nothing was requested but the page."""
        problems = self.problems + self.evaluate("maglevReport.errors")
        self.context.close()
        assert problems == []
        assert {url for url in self.requests if not url.startswith(("blob:", "data:"))} == {self.url}


def wait_until(page: "Page | Frame", condition: str) -> None:
    """Wait for a condition, on a loaded machine up to four minutes; the page's policy forbids playwright's own way."""
    for _ in range(4800):
        if page.evaluate(condition):
            return
        page.wait_for_timeout(50)
    pytest.fail(f"still not so: {condition}")
