"""Run the study of where laws land with every law, finely where outcomes change: a page with their maps, and a picture.

    python -m studies.landing [--out results] [--docs docs] [--fine 4] [--jobs 2]

A map begins with the study's grid. Squares whose corners differ, and those next to them, are halved as often as
`--fine`
says; the others take the outcome of their corners. How often that is wrong is asked of samples at random, and printed.
A level that is done is not run again. With 4 it takes half an hour on two processors.
"""

import argparse
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation

import maglev
from maglev.files.arrays import Array, Bools
from maglev.files.pictures import new_figure
from maglev.many.study_design import tried_values
from maglev.many.study_file import load_study, read_study
from maglev.pages.outcome_map import Factor, LawMap, Outcomes, grid_of, outcomes_of
from maglev.pages.sample_commands import command_of
from maglev.pages.study_page import write_maps

STUDY, DESCRIPTION = "landing-3dof", "3dof"
COMPARED = ("nonlinear", "linear", "scheduled", "pid", "interpolated")
NAMES = {"pid": "PID"}
WORDS = ("lands", "lands after it touched a stop", "is not yet there after 2 s", "trips", "stays at a stop",
         "is not run to its end")
COLOURS = ("#2a9d5c", "#a8d5a2", "#8fa7c4", "#8e6bb0", "#c8503c", "#000000")
SAID = ("From which gap and speed each law of the 3-DOF stage lands: the mover is thrown as the controller starts. "
        "{:,} places, of which those near a change of outcome were run, and the others taken from their neighbours.")
CHECKED = 500   # samples of a law that show how often a filled square is wrong

Where = NDArray[np.int64]   # places in a map, shape (samples, 3): layer, row, column


def refined(classify: Callable[[Where], Outcomes], layers: int, rows: int, columns: int, fine: int
            ) -> tuple[Outcomes, Bools]:
    """Map of outcomes whose squares were halved `fine` times where something changes, and which of it was run.

    Both have the shape (layers, (rows - 1) 2^fine + 1, (columns - 1) 2^fine + 1); `classify` is asked for places in it.
    """
    cells = np.zeros((layers, rows, columns), np.uint8)
    run, due = np.zeros(cells.shape, bool), np.ones(cells.shape, bool)
    for level in range(fine + 1):
        where = np.argwhere(due & ~run)
        cells[tuple(where.T)] = classify(where * [1, 2 ** (fine - level), 2 ** (fine - level)])
        run |= due
        if level < fine:
            corners = np.stack([cells[:, a:a - 1 or None, b:b - 1 or None] for a, b in product((0, 1), repeat=2)])
            mixed = binary_dilation((corners != corners[0]).any(axis=0), np.ones((1, 3, 3), bool))
            cells = cells.repeat(2, axis=1).repeat(2, axis=2)[:, :-1, :-1]
            due, old = np.zeros(cells.shape, bool), run
            run = np.zeros(cells.shape, bool)
            run[:, ::2, ::2] = old
            for a, b in product(range(3), repeat=2):
                due[:, a:due.shape[1] - 2 + a:2, b:due.shape[2] - 2 + b:2] |= mixed
    return cells, run


def map_law(law: str, options: argparse.Namespace) -> LawMap:
    """Map of a law; its runs are printed."""
    study, path = load_study(STUDY)
    scenario = (path.parent / study.scenario).with_name(f"{DESCRIPTION}-{law}.toml").resolve()
    sides = study.vary
    commands: list[tuple[str, list[Factor]]] = []

    def outcomes_at(name: str, values: Array) -> Outcomes:
        """Outcomes of samples, shape (samples, 3), in the order of the varied quantities."""
        vary = [{"name": side.column, "set": side.set, "mode": side.mode, "kind": "list", "values": column.tolist()}
                for side, column in zip(sides, values.T, strict=True)]
        table = {"name": f"{STUDY}-{law}-{name}", "scenario": str(scenario), "vary": vary, "design": {"kind": "rows"},
                 "metrics": study.metrics, "limits": {key: {"max": limit.max.written} for key, limit in
                                                      study.limits.items() if limit.max is not None}}
        computed = maglev.study(read_study(table, path), out=options.out, jobs=options.jobs, resume=True)
        rows = computed.to_arrow()
        commands.append((command_of(computed.about, None), grid_of(rows, computed.about)))
        return outcomes_of(rows)

    down, across, layers = (np.array(tried_values(side), np.float64) for side in sides)
    fine = [np.linspace(side[0], side[-1], (len(side) - 1) * 2 ** options.fine + 1) for side in (down, across)]

    def values_at(where: Where) -> Array:
        return np.column_stack([fine[0][where[:, 1]], fine[1][where[:, 2]], layers[where[:, 0]]])

    levels = iter(range(options.fine + 1))
    cells, known = refined(lambda where: outcomes_at(f"level-{next(levels)}", values_at(where)), len(layers), len(down),
                           len(across), options.fine)
    where = np.random.default_rng(0).permutation(np.argwhere(~known))[:CHECKED]
    wrong = int((outcomes_at("checked", values_at(where)) != cells[tuple(where.T)]).sum()) if len(where) else 0
    shares = ", ".join(f"{word} {100 * (cells == k).mean():.1f} %" for k, word in enumerate(WORDS))
    print(f"{law}: {known.sum()} of {known.size} run; of {len(where)} others at random {wrong} are not as filled; "
          f"{shares}", flush=True)
    command, grid = commands[0]
    grid = [replace(factor, values=values, sets=dict.fromkeys(factor.sets, values))
            for factor, values in zip(grid, fine, strict=False)] + grid[2:]
    return LawMap(NAMES.get(law, law), command, grid, cells)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("results"))
    parser.add_argument("--docs", type=Path, default=Path("docs"))
    parser.add_argument("--fine", type=int, default=4)
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args()
    maps = [map_law(law, options) for law in COMPARED]
    write_maps(options.out / f"{STUDY}.html", "From where each law lands the 3-DOF stage",
               SAID.format(sum(law.cells.size for law in maps)), maps, WORDS)
    write_picture(options.docs / f"{STUDY}.png", maps)


def write_picture(path: Path, maps: Sequence[LawMap]) -> None:
    """Write a PNG of the maps: a column for each law, a row for each payload."""
    from matplotlib.colors import ListedColormap  # an extra: only who draws needs it
    from matplotlib.patches import Patch

    down, across, payload = maps[0].factors
    figure = new_figure(2.5 * len(maps) + 1.0, 2.3 * len(payload.values) + 0.9)
    figure.suptitle("3-DOF stage: from where each law lands")
    grid = figure.subplots(len(payload.values), len(maps), squeeze=False)
    for k, (places, kilograms) in enumerate(zip(grid, payload.values, strict=True)):
        for law, axes in zip(maps, places, strict=True):
            axes.pcolormesh(law.cells[k], cmap=ListedColormap(COLOURS), vmin=-0.5, vmax=len(WORDS) - 0.5)
            axes.set_xticks(*ticks(across.values), fontsize=7)
            axes.set_yticks(*ticks(1e3 * down.values), fontsize=7)
            axes.tick_params(length=0)
            axes.set_xlabel("speed downwards, m/s", fontsize=8)
        places[0].set_ylabel(f"Payload {1e3 * kilograms:g} g\ngap, mm", fontsize=9)
    for law, axes in zip(maps, grid[0], strict=True):
        axes.set_title(law.name)
    occurring = np.unique([law.cells for law in maps]).tolist()
    figure.legend(handles=[Patch(color=COLOURS[outcome], label=WORDS[outcome]) for outcome in occurring],
                  loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(path, dpi=100)


def ticks(values: Array) -> tuple[Array, list[str]]:
    """Return the places and the labels of five values of a side."""
    at = np.linspace(0, len(values) - 1, 5).astype(int)
    return at + 0.5, [f"{value:.3g}" for value in values[at]]


if __name__ == "__main__":
    main()
