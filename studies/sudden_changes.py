"""Maps of sudden changes on the 3-DOF stage over their size and time, under three laws.

    python -m studies.sudden_changes [--changes field payload] [--cells 13] [--jobs 2] [--out results] [--picture FILE]

It draws docs/sudden_changes.png, each map of a grid of cells by cells runs, and prints a table of them. A run takes
some 0.05 s of a processor. With 13 cells all runs take three minutes; with 100 cells, which are 10,000 runs of each
change under each law, they take three hours. Maps are kept in `results` as they are done, and taken from there.
"""

import argparse
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

import maglev
from maglev.files.marked import markdown_table
from maglev.files.pictures import new_figure, write_figure

SCENARIO = Path(__file__).with_name("sudden_changes.toml")
LAWS = {"fixed": "Regulator3DOF", "adaptive": "AdaptiveRegulator3DOF",
        "ADRC": SCENARIO.parents[1] / "examples" / "adapting" / "adrc.py"}
TIMES = (1.0, 7.0)   # s
PUBLISHED = {"C1": 0.6135, "C2": 0.8224, "C3": 334.52, "C4": 8.71, "y.mass": 6.9, "x.mass": 10.6, "z.mass": 8.6,
             "y.friction.coulomb": 1.0, "x.friction.coulomb": 1.2, "z.friction.coulomb": 1.1}   # before the change, SI
MASS = PUBLISHED["y.mass"]
Floats = NDArray[np.float64]
Maps = Mapping[str, Mapping[str, Floats]]   # by change and law


@dataclass(frozen=True)
class Change:
    """A change, the axis whose error is drawn, and the other differences."""

    title: str
    sizes: tuple[float, float]
    axis: str
    after: Mapping[str, Any]   # of each constant that changes: factor on it, by size
    beside: Mapping[str, float] = field(default_factory=dict)


def lost(size: Floats) -> Floats:
    return 1.0 - size


FIELD = {"C1": lost, "C2": lost, "C3": lambda size: (1.0 - size) ** 2, "C4": lost}
CHANGES = {
    "thrust": Change("a pair loses thrust", (0.1, 0.75), "x", {"C1": lost}),
    "field": Change("magnets lose field", (0.02, 0.4), "y", FIELD),
    "payload": Change("a payload lands", (0.05, 0.4), "y", {
        name: lambda size, name=name: 1.0 + MASS * size / PUBLISHED[name] for name in ("y.mass", "x.mass", "z.mass")}),
    "friction": Change("friction grows", (0.25, 3.0), "y", {
        f"{axis}.friction.coulomb": lambda size: 1.0 + size for axis in "yxz"}),
    "noise": Change("field, 20 µm of noise", (0.02, 0.4), "y", FIELD,
                    {f"measurement.{axis}.noise": 20e-6 for axis in "yxz"}),
    "bounds": Change("field, bounds of 5 %", (0.02, 0.4), "y", FIELD, {"controller.adaptation.range": 0.05}),
    "motion": Change("field, a tenth of the motion", (0.02, 0.4), "y", FIELD,
                     {f"reference.{axis}.amplitude": 0.1 for axis in "yxz"}),
}


def grid(change: Change, cells: int) -> tuple[Floats, Floats]:
    """Sizes and times (s) of the samples, each of shape (cells²,): the time varies first."""
    size, time = np.meshgrid(np.linspace(*change.sizes, cells), np.linspace(*TIMES, cells), indexing="ij")
    return size.ravel(), time.ravel()


def values_of(change: Change, law: str, cells: int) -> dict[str, Floats]:
    """Values of the samples; bounds of adaptation only where there is one."""
    size, time = grid(change, cells)
    values = {f"reference.plant.{name}.end": PUBLISHED[name] * factor(size) for name, factor in change.after.items()}
    values |= {f"reference.plant.{name}.time": time for name in change.after}
    return values | {name: np.full(size.shape, value) for name, value in change.beside.items()
                     if law == "adaptive" or not name.startswith("controller.adaptation")}


def run_change(change: Change, law: str, cells: int, jobs: int | None) -> Floats:
    """Largest error of the axis from 10 s on (m), shape (cells, cells), sizes down; infinite where it is lost."""
    batch = maglev.batch(SCENARIO, values_of(change, law, cells), controller=LAWS[law], jobs=jobs,
                         metrics=["failed", "ended off", "peak tracking error"])
    flawed = (batch["failed"] == 1.0) | (batch["ended off"] == 1.0)
    gone = flawed | np.array([why is not None for why in batch.failures])
    return np.where(gone, np.inf, batch[f"peak tracking error of {change.axis}"]).reshape(cells, cells)


def border(change: Change, errors: Floats) -> str:
    """Smallest size that is lost at any time of the change, and from which on it is lost at all times, in percent."""
    sizes, gone = 100.0 * np.linspace(*change.sizes, len(errors)), np.isinf(errors)
    some, every = gone.any(axis=1), gone.all(axis=1)
    if not some.any():
        return "held"
    return f"{sizes[some.argmax()]:.1f}" + (f", {sizes[every.argmax()]:.1f}" if every.any() else ", never")


def beside_fixed(fixed: Floats, errors: Floats) -> list[str]:
    """Compare a law with the fixed one: runs that it saves, runs that only it loses, and the ratio of the errors.

    Of errors, where both hold, the median, the largest, and the share that is over 2 % worse.
    """
    both = np.isfinite(fixed) & np.isfinite(errors)
    ratio = errors[both] / fixed[both]
    return [f"{np.sum(np.isinf(fixed) & np.isfinite(errors))}", f"{np.sum(np.isinf(errors) & np.isfinite(fixed))}",
            f"{np.median(ratio):.2f}", f"{ratio.max():.2f}", f"{100.0 * np.mean(ratio > 1.02):.0f} %"]


def table(found: Maps) -> str:
    """A row for each map: its borders, and how it compares with that of the fixed law."""
    rows = []
    for name, maps in found.items():
        for law, errors in maps.items():
            cells = [""] * 5 if law == "fixed" else beside_fixed(maps["fixed"], errors)
            rows.append([CHANGES[name].title if law == "fixed" else "", law, border(CHANGES[name], errors), *cells])
    return markdown_table(("", "law", "lost from, at any time from (%)", "saved", "lost alone", "error/fixed: median",
                           "largest", "worse in"), rows, 5)


def draw(found: Maps, path: Path) -> None:
    """Write maps: errors of each law, and adaptive over fixed.

    Dark is lost; in the last column green what the fixed one loses alone, and yellow what the adaptive one does.
    """
    from matplotlib.colors import ListedColormap, LogNorm  # an extra: only who draws needs it
    from matplotlib.ticker import LogLocator

    figure = new_figure(9.6, 1.75 * len(found))
    grid_of_axes = figure.subplots(len(found), len(LAWS) + 1, squeeze=False, sharex=True, sharey="row")
    for (name, maps), places in zip(found.items(), grid_of_axes, strict=True):
        change, fixed, adaptive = CHANGES[name], maps["fixed"], maps["adaptive"]
        held = np.concatenate([errors[np.isfinite(errors)] for errors in maps.values()])
        norm = LogNorm(1e6 * held.min(), 1e6 * held.max())
        extent = (*TIMES, *(100.0 * size for size in change.sizes))
        options: dict[str, Any] = {"extent": extent, "origin": "lower", "aspect": "auto", "interpolation": "nearest"}
        for place, law in zip(places, LAWS, strict=False):   # the last place has what adapting does
            if law in maps:
                place.set_facecolor("0.25")
                image = place.imshow(np.where(np.isfinite(maps[law]), 1e6 * maps[law], np.nan), norm=norm,
                                     cmap="viridis", **options)
            else:
                place.set_axis_off()
        figure.colorbar(image, ax=places[len(LAWS) - 1], label=f"error of {change.axis}, µm", format="%g",
                        ticks=LogLocator(subs=(1.0, 2.0, 5.0))).minorticks_off()
        both = np.isfinite(fixed) & np.isfinite(adaptive)
        ratio = np.divide(adaptive, fixed, out=np.full(fixed.shape, np.nan), where=both)
        places[-1].set_facecolor("0.25")
        image = places[-1].imshow(ratio, norm=LogNorm(0.2, 5.0), cmap="RdBu_r", **options)
        only = np.where(np.isfinite(adaptive) & ~np.isfinite(fixed), 0.0,
                        np.where(np.isfinite(fixed) & ~np.isfinite(adaptive), 1.0, np.nan))
        places[-1].imshow(only, cmap=ListedColormap(["#2a9d5c", "#f4c152"]), vmin=0.0, vmax=1.0, **options)
        bar = figure.colorbar(image, ax=places[-1], label="adaptive/fixed", ticks=[0.2, 0.5, 1.0, 2.0, 5.0])
        bar.ax.set_yticklabels(["0.2", "0.5", "1", "2", "5"])
        bar.ax.minorticks_off()
        places[0].set_ylabel(change.title.replace(", ", ",\n") + "\nsize, %")
    for place, title in zip(grid_of_axes[0], (*LAWS, "what adapting does"), strict=True):
        place.set_title(title)
    for place in grid_of_axes[-1]:
        place.set_xlabel("time of the change, s")
    write_figure(path, figure)


def kept_map(folder: Path, name: str, law: str, cells: int, jobs: int | None) -> Floats:
    """A map, from the folder if it is there."""
    path = folder / f"sudden-changes-{name}-{law}-{cells}.npy"
    if path.exists():
        print(f"{path}: taken as it is; without it the runs are made again")
        return np.asarray(np.load(path))
    errors = run_change(CHANGES[name], law, cells, jobs)
    folder.mkdir(parents=True, exist_ok=True)
    np.save(path, errors)
    return errors


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--changes", nargs="+", choices=CHANGES, default=list(CHANGES))
    parser.add_argument("--cells", type=int, default=13)
    parser.add_argument("--jobs", type=int)
    parser.add_argument("--out", type=Path, default=Path("results"))
    parser.add_argument("--picture", type=Path, default=Path("docs/sudden_changes.png"))
    options = parser.parse_args()
    # Questions about adaptation are compared with the fixed law alone.
    found = {name: {law: kept_map(options.out, name, law, options.cells, options.jobs) for law in LAWS
                    if law != "ADRC" or "controller.adaptation.range" not in CHANGES[name].beside}
             for name in options.changes}
    draw(found, options.picture)
    print(table(found))


if __name__ == "__main__":
    main()
