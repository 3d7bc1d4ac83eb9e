"""The picture of the README: the live page in Chromium after some seconds.

    python tools/pages/live_picture.py [--page results/live.html] [--out docs/live.png]

It needs a Chromium, Playwright, Pillow, and the page that `maglev live` writes.
"""

import argparse
import io
import shutil
from pathlib import Path

import numpy as np
from PIL import Image
from playwright.sync_api import sync_playwright

RUN = "3dof-setpoints-improved"
UNTIL = 6.6               # s of the run: setpoints have just changed
SIZE = (1440, 1000)      # px of the page
COLOURS = 128             # of the file


def take_picture(page: Path) -> Image.Image:
    """The page in light colours, stopped at UNTIL."""
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium") or None,
                                             args=["--no-sandbox"])
        tab = browser.new_page(viewport={"width": SIZE[0], "height": SIZE[1]}, color_scheme="light")
        problems: list[str] = []
        tab.on("pageerror", lambda error: problems.append(str(error)))
        tab.goto(f"{page.resolve().as_uri()}#run={RUN}")
        # The page's policy forbids Playwright's own way of waiting.
        while tab.evaluate(f"maglevLive.problems.length === 0 && !(maglevLive.frame?.time > {UNTIL})"):
            tab.wait_for_timeout(20)
        tab.click("#play")
        tab.wait_for_timeout(300)
        problems += tab.evaluate("maglevLive.problems")
        if problems:
            raise SystemExit("; ".join(problems))
        return Image.open(io.BytesIO(tab.screenshot()))


def reduced(picture: Image.Image) -> Image.Image:
    """The picture in COLOURS: half are those of large areas, the others are spread over all, as thin lines need."""
    often = sorted(picture.getcolors(picture.width * picture.height) or [], reverse=True)[:COLOURS // 2]
    spread = picture.quantize(COLOURS // 2, Image.Quantize.MAXCOVERAGE, dither=Image.Dither.NONE).getpalette() or []
    palette = Image.new("P", (1, 1))
    palette.putpalette([*np.array([colour for _, colour in often]).ravel().tolist(), *spread])
    return picture.quantize(palette=palette, dither=Image.Dither.NONE)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--page", type=Path, default=Path("results/live.html"))
    parser.add_argument("--out", type=Path, default=Path("docs/live.png"))
    arguments = parser.parse_args()
    shown = reduced(take_picture(arguments.page).convert("RGB"))
    shown.save(arguments.out, optimize=True)
    print(f"{arguments.out}  {arguments.out.stat().st_size / 1e3:.0f} kB, {shown.width} × {shown.height}")


if __name__ == "__main__":
    main()
