"""Parts that the studies of maps of laws share: command line, runs, origin, tables and pictures."""

import argparse
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

import numpy as np

import maglev
from maglev.files.marked import markdown_table
from maglev.files.pictures import new_figure
from maglev.many.dataset import metadata_of
from maglev.many.study_file import StudyFile
from maglev.pages.grids import Origin, StageGrids, read_grids, write_grids
from maglev.pages.law_map import LawMap, seen

LAWS = {"2dof": ("nonlinear", "linear", "pid"), "3dof": ("nonlinear", "linear", "scheduled", "pid"),
        "5dof": ("nonlinear", "linear", "pid")}
NAMES = {"pid": "PID"}

FINE = 50   # cells along a side from which on they have no edges

RunStudy = Callable[[StudyFile], Path]   # a study to its dataset


def map_laws(words: str, data: Path, outcomes: Sequence[str],
             run_stage: Callable[[str, tuple[str, ...], RunStudy, argparse.Namespace], StageGrids]) -> None:
    """Run the stages that the command line selects, and write the results; with --stage the other stages keep theirs.

    `words` say what the command does, and grids stand in `data` if the command line names no file. `run_stage` runs the
    laws of a stage and draws them: name of the stage, its laws, how to run a study, options.
    """
    parser = argparse.ArgumentParser(description=words, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--stage", choices=LAWS)
    parser.add_argument("--out", type=Path, default=Path("results"))
    parser.add_argument("--docs", type=Path, default=Path("docs"))
    parser.add_argument("--data", type=Path, default=data)
    parser.add_argument("--jobs", type=int)
    options = parser.parse_args()

    def run_study(study: StudyFile) -> Path:
        return maglev.study(study, out=options.out, jobs=options.jobs, resume=True).path

    stages = read_grids(options.data) if options.stage and options.data.exists() else {}
    for stage in [options.stage] if options.stage else LAWS:
        stages[stage] = run_stage(stage, LAWS[stage], run_study, options)
    write_grids(options.data, outcomes, stages)


def origin_of(paths: Iterable[Path]) -> Origin:
    """Origin of studies' datasets: versions, commits where known, and FMUs."""
    provenances = [metadata_of(path)["provenance"] for path in paths]
    commits = sorted({provenance["commit"] for provenance in provenances} - {None})
    return Origin(", ".join(sorted({provenance["version"] for provenance in provenances})), ", ".join(commits) or None,
                  {fmu["model"]: fmu["guid"] for provenance in provenances for fmu in provenance["fmus"]})


def shares_markdown(rows: Sequence[Sequence[str]]) -> str:
    """Return rows of texts, the heading first, as a table in Markdown; all but the first two columns are numbers."""
    return markdown_table(rows[0], rows[1:], len(rows[0]) - 2)


def write_picture(path: Path, title: str, maps: Sequence[Sequence[LawMap]], outcomes: Sequence[str],
                  colours: Sequence[str], dotted: str = "") -> None:
    """Write a PNG of maps of all laws, a row for each layer, whose factors are texts.

    Marked places, an outcome more, have the colour of the first one and a dot; `dotted` is the dot's meaning.
    """
    from matplotlib.colors import ListedColormap  # an extra: only who draws needs it
    from matplotlib.patches import Patch

    rows = [(of_laws, k) for of_laws in maps for k in range(len(of_laws[0].cells))]
    figure = new_figure(2.5 * len(maps[0]) + 1.0, 2.3 * len(rows) + 0.9)
    grid = figure.subplots(len(rows), len(maps[0]), squeeze=False)
    figure.suptitle(title)
    for (of_laws, k), places in zip(rows, grid, strict=True):
        down, along, layers = of_laws[0].factors
        for law, axes in zip(of_laws, places, strict=True):
            axes.pcolormesh(law.cells[k] % len(outcomes), cmap=ListedColormap(colours), vmin=-0.5,
                            vmax=len(outcomes) - 0.5, edgecolors="white",
                            linewidth=0.4 if len(along.values) < FINE else 0.0)
            if dotted:
                up, right = np.nonzero(law.cells[k] == len(outcomes))
                axes.plot(right + 0.5, up + 0.5, "k.", markersize=3)
            axes.set_xticks(np.arange(len(along.values)) + 0.5, along.values.tolist(), fontsize=7)
            axes.set_yticks(np.arange(len(down.values)) + 0.5, down.values.tolist(), fontsize=7)
            axes.tick_params(length=0)
            axes.set_xlabel(f"{along.name}, {along.unit}", fontsize=8)
        # Words that two sides share, with which some headings begin, are at the sides.
        places[0].set_ylabel(f"{layers.values[k].rpartition(', ')[2]}\n{down.name}, {down.unit}", fontsize=9)
    for law, axes in zip(maps[0], grid[0], strict=True):
        axes.set_title(law.name)
    occurring = seen(law.cells % len(outcomes) for of_laws in maps for law in of_laws)
    figure.legend(handles=[Patch(color=colours[outcome], label=outcomes[outcome]) for outcome in occurring],
                  loc="outside lower center", ncols=4, frameon=False, title=f"·  {dotted}" if dotted else None)
    figure.savefig(path, dpi=100)
