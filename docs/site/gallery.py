"""Fly the main runs and draw them for the gallery of the site: `python docs/site/gallery.py FOLDER FMUS`."""

import sys
from pathlib import Path

import maglev
from maglev.report.plots.figures import MOVING


def draw(folder: Path, fmus: Path, names: tuple[str, ...] = MOVING) -> list[Path]:
    """Write `NAME.png` for each run into a folder; returns the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    native = not any(fmus.glob("Plant?DOF.fmu"))
    written = []
    for name in names:
        written.append(folder / f"{name}.png")
        maglev.run(name, fmus=fmus, native=native).plot().savefig(written[-1], dpi=80)
    return written


if __name__ == "__main__":
    for path in draw(Path(sys.argv[1]), Path(sys.argv[2])):
        print(path)
