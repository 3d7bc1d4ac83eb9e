"""Run the studies of the operating range with every law; their maps are for docs/results_faults.md and the report.

    python -m studies.operating_range [--stage 3dof] [--out results] [--docs docs] [--data FILE] [--jobs 2]

It draws the pictures of that page, prints its tables of shares, and writes the maps as data of the package, which the
report draws. With --stage it does one stage, and the others stay. The 2-DOF stage takes a minute on
two processors, the 3-DOF stage two. A study that is done is not run again.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.arrays import Array, Bools
from maglev.files.errors import MaglevError
from maglev.many.dataset import read_dataset
from maglev.many.study_file import StudyFile, load_study
from maglev.pages import operating_range as page
from maglev.pages.grids import Grid, StageGrids
from maglev.pages.law_map import Outcomes
from studies.laws import NAMES, RunStudy, map_laws, origin_of, shares_markdown, write_picture

CURRENT_LIMIT = 4.0   # A, of the commands of all laws
ENDING = 1.0          # s, in which a command at its limit counts

COLOURS = ("#2a9d5c", "#a8d5a2", "#f4c152", "#8fa7c4", "#8e6bb0", "#c8503c")   # of the outcomes


def outcomes(columns: Mapping[str, NDArray[Any]], at_limit: Bools) -> Outcomes:
    """Outcome of each sample, an index of `OUTCOMES`, by a study's metrics and whether a command ends at its limit.

    All have the shape (samples,); of the metrics "trip time", "stop contact time", and "end error of" every axis count.
    """
    near = np.all([values <= page.NEAR for name, values in columns.items() if name.startswith("end error of ")],
                  axis=0)
    tripped, touched = (np.isfinite(columns[name]) for name in ("trip time", "stop contact time"))
    # A trip lets the mover fall on a stop, and a mover on a stop is at its limit: the first cause counts.
    return np.select([tripped, near & ~touched, near, touched, at_limit],
                     [page.TRIPPED, page.SETTLED, page.RECOVERED, page.STOPPED, page.LIMITED],
                     page.ASTRAY).astype(np.uint8)


def read_outcomes(path: Path) -> tuple[dict[str, Array], Outcomes]:
    """Varied quantities of a study's dataset, and the outcomes, also by the trajectories of commands next to it."""
    samples = read_dataset(path)
    columns = {name: samples[name].to_numpy() for name in samples.column_names if name != "failure"}
    if not all(failure is None for failure in samples["failure"].to_pylist()):
        raise MaglevError(f"{path}: some samples were not run to their end, expected all to be")
    rows = read_dataset(path.with_name(f"{path.stem}.trajectories.parquet"))
    time = rows["time"].to_numpy()
    commands = np.column_stack([np.abs(rows[name].to_numpy()) for name in rows.column_names
                                if name not in ("sample", "time")])
    beyond = (commands >= CURRENT_LIMIT).any(axis=1) & (time > time.max() - ENDING)
    at_limit = np.zeros(len(samples), dtype=np.bool_)
    at_limit[rows["sample"].to_numpy()[beyond]] = True
    what = next(name for name in page.STEPS if name in columns)
    # Samples of a grid are in the order of the varied quantities. Nine digits are as they were set.
    varied = {name: np.unique(columns[name]).round(9) for name in ("initial gap", "target gap", what, "constants")}
    ends = outcomes(columns, at_limit).reshape([len(values) for values in varied.values()])
    return {name: varied[name] for name in (what, "constants", "initial gap", "target gap")}, ends.transpose(2, 3, 0, 1)


def study_of(stage: str, law: str) -> StudyFile:
    """The study of a stage, run with one of its laws; the linear regulator is linearised about each target."""
    study, path = load_study(f"range-{stage}")
    scenario = (path.parent / study.scenario).with_name(f"{stage}-{law}.toml").resolve()
    vary = [varied.model_copy(update={"set": [*varied.set, "controller.setpoint"]})
            if law == "linear" and varied.column == "target gap" else varied for varied in study.vary]
    return study.model_copy(update={"name": f"{study.name}-{law}", "scenario": str(scenario), "vary": vary})


def run_stage(stage: str, laws: tuple[str, ...], run_study: RunStudy, options: argparse.Namespace) -> StageGrids:
    paths = {law: run_study(study_of(stage, law)) for law in laws}
    read = {NAMES.get(law, law): read_outcomes(path) for law, path in paths.items()}
    varied = next(iter(read.values()))[0]
    grid = Grid(varied, {law: ends for law, (_, ends) in read.items()})
    of_stage = StageGrids({"moves": grid}, origin_of(paths.values()))
    write_picture(options.docs / f"range-{stage}.png", f"{PACKAGED_STAGES[stage].title}: from one air gap to another",
                  page.maps_of(of_stage), page.OUTCOMES, COLOURS, page.SETTLED_NOMINAL)
    print(f"\n{stage}\n\n{shares_markdown(page.table(of_stage))}", flush=True)
    return of_stage


if __name__ == "__main__":
    map_laws(__doc__, page.FILE, page.OUTCOMES, run_stage)
