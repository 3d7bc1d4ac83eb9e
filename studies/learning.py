"""Sudden changes on the 3-DOF stage, under the regulator with fixed constants and under the adaptive one.

    python -m studies.learning [--samples 100] [--jobs 2] [--docs docs]

Prints the tables of docs/examples.md and draws its picture. Sizes and times of the changes are by a Sobol sequence, the
same for both laws.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import qmc

import maglev
from maglev.pictures import new_figure

SCENARIO = Path(__file__).with_name("learning.toml")
LAWS = {"fixed": "Regulator3DOF", "adaptive": "AdaptiveRegulator3DOF"}
THRUST, OTHER = ("C1", 0.6135), ("C2", 0.8224)
ATTRACTION, COILS = ("C3", 334.52), ("C4", 8.71)
MASSES = (("y.mass", 6.9), ("x.mass", 10.6), ("z.mass", 8.6))
FRICTION = (("y.friction.coulomb", 1.0), ("x.friction.coulomb", 1.2), ("z.friction.coulomb", 1.1))
TRACKING = tuple(f"mean tracking error of {axis}" for axis in "yxz")
Floats = NDArray[np.float64]
Values = dict[str, Floats]


def thrust(size: Floats) -> Values:
    """A share of the thrust of the pair alpha is lost."""
    return ends((THRUST,), 1.0 - size)


def magnets(size: Floats) -> Values:
    """A share of the field of all magnets is lost."""
    return ends((THRUST, OTHER, COILS), 1.0 - size) | ends((ATTRACTION,), (1.0 - size) ** 2)


def payload(size: Floats) -> Values:
    """A share of the mass of y lands, and moves along all axes."""
    return {end(name): mass + 6.9 * size for name, mass in MASSES}


def friction(size: Floats) -> Values:
    """Coulomb friction grows by a multiple of itself."""
    return ends(FRICTION, 1.0 + size)


CHANGES = {"a pair loses thrust": (thrust, 0.8), "the magnets lose field": (magnets, 0.2),
           "a payload lands": (payload, 0.4), "friction grows": (friction, 3.0)}   # with the largest size


def end(name: str) -> str:
    """What sets the value after the change."""
    return f"reference.plant.{name}.end"


def ends(of: tuple[tuple[str, float], ...], factor: Floats) -> Values:
    """Nominal values times a factor after the change."""
    return {end(name): nominal * factor for name, nominal in of}


def fly(law: str, values: Mapping[str, Floats], jobs: int | None) -> Values:
    """What was measured of each sample, and whether it was lost: at a stop, away at the end, or ended early."""
    batch = maglev.batch(SCENARIO, values, controller=LAWS[law], jobs=jobs,
                         metrics=["failed", "stop contact time", "mean tracking error"])
    lost = (batch["failed"] == 1.0) | np.array([why is not None for why in batch.failures])
    return {"lost": lost.astype(float), **{name: batch[name] for name in TRACKING}}


def design(samples: int, *ranges: tuple[float, float]) -> tuple[Floats, ...]:
    """Values that fill the ranges, one array for each."""
    unit = qmc.Sobol(len(ranges), seed=1).random(samples)
    return tuple(low + (high - low) * column for (low, high), column in zip(ranges, unit.T, strict=True))


def sudden(samples: int, jobs: int | None) -> dict[str, tuple[Floats, dict[str, Values]]]:
    """Each change at sizes up to its largest and times from 5 to 8 s: the sizes, and by law what was measured."""
    found = {}
    for name, (change, largest) in CHANGES.items():
        size, time = design(samples, (0.0, largest), (5.0, 8.0))
        values = change(size)
        values |= {key.removesuffix("end") + "time": time for key in values}
        found[name] = size, {law: fly(law, values, jobs) for law in LAWS}
    return found


def quiet(samples: int, jobs: int | None) -> tuple[Floats, Floats, Floats, dict[str, Values]]:
    """No change: less motion than it takes, more friction, noise. Share of the motion, friction, noise (m), by law."""
    motion, more, noise = design(samples, (0.1, 1.0), (0.0, 3.0), (0.0, 20e-6))
    values = friction(more) | {f"reference.{axis}.amplitude": motion for axis in "yxz"} | {
        f"measurement.{axis}.noise": noise for axis in "yxz"}
    values |= {key.removesuffix("end") + "time": np.full(samples, 1e-3) for key in values if key.endswith("end")}
    return motion, more, noise, {law: fly(law, values, jobs) for law in LAWS}


def border(size: Floats, lost: Floats) -> tuple[float, float]:
    """Smallest size that was lost (inf if none was), and largest that was not."""
    gone = lost > 0.0
    return float(size[gone].min(initial=np.inf)), float(size[~gone].max(initial=0.0))


def sudden_table(found: Mapping[str, tuple[Floats, dict[str, Values]]]) -> list[str]:
    """Rows by change: from where on each law loses the stage; median errors of the upper half of what both hold."""
    rows = ["| change | lost from: fixed | adaptive | error of y, x, z in µm: fixed | adaptive |",
            "|---|---|---|---|---|"]
    for name, (size, by) in found.items():
        borders = {law: border(size, values["lost"]) for law, values in by.items()}
        top = min(first for first, _ in borders.values())
        held = (size > 0.5 * min(top, size.max())) & (size < top)
        lost = [f"{100 * first:.1f} %" if np.isfinite(first) else f"not to {100 * last:.0f} %"
                for first, last in borders.values()]
        errors = [", ".join(f"{1e6 * np.median(values[axis][held]):.0f}" for axis in TRACKING)
                  for values in by.values()]
        rows.append(f"| {name} | {' | '.join(lost + errors)} |")
    return rows


def quiet_table(found: tuple[Floats, Floats, Floats, dict[str, Values]]) -> list[str]:
    """Rows by axis: the adaptive law's error over the fixed one's, without any change of constants."""
    rows = ["| axis | least | median | most | more than 2 % worse |", "|---|---:|---:|---:|---:|"]
    for axis in TRACKING:
        ratio = found[3]["adaptive"][axis] / found[3]["fixed"][axis]
        rows.append(f"| {axis[-1]} | {ratio.min():.2f} | {np.median(ratio):.2f} | {ratio.max():.2f} | "
                    f"{100 * np.mean(ratio > 1.02):.0f} % |")
    return rows


def draw(found: Mapping[str, tuple[Floats, dict[str, Values]]], path: Path) -> None:
    """Errors over the size of each change; a cross on the upper edge is a flight that was lost."""
    figure = new_figure(9.0, 6.0)
    panels = figure.subplots(2, 2).ravel()
    for panel, (name, (size, by)), axis in zip(panels, found.items(), ("x", "y", "y", "y"), strict=True):
        held = [values[f"mean tracking error of {axis}"][values["lost"] == 0.0] for values in by.values()]
        top = 1.15e6 * max(each.max() for each in held)
        for colour, (law, values) in zip(("#2b4fc7", "#b0306a"), by.items(), strict=True):
            gone = values["lost"] > 0.0
            error = 1e6 * values[f"mean tracking error of {axis}"]
            panel.plot(100 * size[~gone], error[~gone], "o", color=colour, markersize=2.5, label=law)
            edge = np.full(gone.sum(), top * (0.97 if law == "fixed" else 0.93))
            panel.plot(100 * size[gone], edge, "x", color=colour, markersize=4)
        panel.set(title=name, xlabel="size in %", ylabel=f"mean error of {axis} in µm", ylim=(0.0, top))
    panels[0].legend()
    figure.savefig(path, dpi=90)


def main() -> None:
    """Fly all, print the tables, draw the picture."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--samples", type=int, default=100)
    parser.add_argument("--jobs", type=int)
    parser.add_argument("--docs", type=Path, default=Path("docs"))
    options = parser.parse_args()
    changes = sudden(options.samples, options.jobs)
    draw(changes, options.docs / "learning.png")
    print("\n".join([*sudden_table(changes), "", *quiet_table(quiet(options.samples, options.jobs))]))


if __name__ == "__main__":
    main()
