"""What the examples do when they are executed: fly beside the thesis's regulator, print what was measured, draw it."""

import argparse
import warnings
from pathlib import Path

from PIL import Image  # matplotlib brings it

import maglev
from maglev.comparison.table import summary

SCENARIO = "3dof-setpoints-improved"
REGULATOR = "Regulator3DOF"


def fly(controller: type, file: str) -> None:
    """Fly the setpoints with a controller and with the thesis's regulator; write a picture named after the file."""
    name = Path(file).stem
    parser = argparse.ArgumentParser(prog=Path(file).name, description=f"{name} beside the thesis's regulator")
    parser.add_argument("--fmus", help="folder with FMUs, in place of those that are built for the run")
    parser.add_argument("--out", type=Path, default=Path("results"), help="folder for the picture")
    chosen = parser.parse_args()
    with warnings.catch_warnings():
        # Which gains and flags of the thesis's regulator a controller does not have needs no saying here.
        warnings.simplefilter("ignore")
        runs = {REGULATOR: maglev.run(SCENARIO, fmus=chosen.fmus),
                name: maglev.run(SCENARIO, controller=controller, fmus=chosen.fmus)}
    comparison = maglev.compare(runs)
    print(f"{'':34}  {REGULATOR:>14}  {name:>20}")
    for row in summary(comparison.rows):
        print(f"{row.name:34}{row.of:6}", *(f"{row.text(label):>14}" + (" *" if label in row.best else "  ")
                                            for label in runs))
    chosen.out.mkdir(parents=True, exist_ok=True)
    picture = chosen.out / f"{name}.png"
    comparison.plot().savefig(picture, dpi=80)
    # Lines need few colours, and a third of the bytes.
    with Image.open(picture) as drawn:
        drawn.convert("RGB").quantize(64, dither=Image.Dither.NONE).save(picture, optimize=True)
    print(picture)
