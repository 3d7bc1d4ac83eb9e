"""Pages under axe-core, at the size of a desktop and of a phone, light and dark: what it finds wrong for readers.

    python tools/pages/axe_check.py results/report.html results/live.html …

It needs a Chromium, Playwright, and axe-playwright-python, which brings axe-core; none of it becomes part of a page.
"""

import argparse
import shutil
import sys
from pathlib import Path
from typing import Any

import axe_playwright_python
from playwright.sync_api import Browser, sync_playwright

AXE = Path(axe_playwright_python.__file__).parent / "axe.min.js"
SIZES = {"desktop": (1280, 800), "phone": (390, 844)}
SETTLED = 2000   # ms that a page has to draw
# The rules of WCAG 2.1, levels A and AA, and the best practices; colours of what is drawn on a canvas are not seen.
RUN = "async () => (await axe.run(document, { resultTypes: ['violations'] })).violations"


def violations(browser: Browser, page: Path, axe: str, size: str, scheme: Any) -> list[str]:
    """What axe-core finds on a page: rule, what is wrong, and the first elements."""
    width, height = SIZES[size]
    context = browser.new_context(offline=True, viewport={"width": width, "height": height}, color_scheme=scheme,
                                  is_mobile=size == "phone", has_touch=size == "phone", reduced_motion="reduce")
    tab = context.new_page()
    tab.goto(page.resolve().as_uri())
    tab.wait_for_timeout(SETTLED)
    tab.evaluate(axe)
    found = tab.evaluate(RUN)
    context.close()
    return [f"{each['id']}: {each['help']}: {len(each['nodes'])} times, such as "
            + "; ".join(" ".join(map(str, node["target"])) for node in each["nodes"][:3])
            + f" ({each['nodes'][0].get('failureSummary', '').splitlines()[-1].strip()})" for each in found]


def main() -> None:
    """Check the pages of the command line; exit code 1 if something is wrong."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("pages", nargs="+", type=Path)
    pages = parser.parse_args().pages
    wrong = 0
    axe = AXE.read_text(encoding="utf-8")
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"), args=["--no-sandbox"])
        for page in pages:
            for size in SIZES:
                for scheme in ("light", "dark"):
                    found = violations(browser, page, axe, size, scheme)
                    print(f"{page.name}, {size}, {scheme}: {len(found)} violations")
                    print("".join(f"    {each}\n" for each in found), end="")
                    wrong += len(found)
        browser.close()
    sys.exit(wrong > 0)


if __name__ == "__main__":
    main()
