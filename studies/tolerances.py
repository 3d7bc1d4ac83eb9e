"""Run every law with noise and delay of its measurements, with lost samples and with a low bus voltage.

    python -m studies.tolerances [--stage 3dof] [--out results] [--docs docs] [--data FILE] [--jobs 2]

It draws pictures of docs/results_faults.md, prints its tables, and writes its results as data of the package, which the
report draws. With --stage it does so for one stage, and the others stay. It takes some ten minutes on two processors. A
study that is done is not run again.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import MaglevError
from maglev.many.dataset import read_dataset
from maglev.many.study_file import StudyFile, read_study
from maglev.pages import tolerances as page
from maglev.pages.grids import Grid, StageGrids
from maglev.pages.law_map import Outcomes
from maglev.pages.study_text import units_of
from maglev.scenario.layers import PACKAGED
from pmlsm.stage_description import StageDescription
from studies.laws import NAMES, RunStudy, map_laws, origin_of, shares_markdown, write_picture

FAR, TILTED = 1e-3, 5e-3   # m; rad of a tilt: as `fail_error` and `fail_tilt` of scenarios

SIZES = (1.0, 3.0)    # mm, by which the gap is asked to become smaller, from where the loops of the steps begin
BESIDE = {False: "5 mm", True: "2 mrad"}   # steps of horizontal axes with it, or of the tilts of a platform that tilts

COLOURS = ("#2a9d5c", "#f4c152", "#c8503c", "#8e6bb0")   # of the outcomes

SCENARIO = """\
extends = ["{steps}", "{measurement}"]
name = "tolerance-{stage}-{law}"
title = "{title}: a step with measurements and a supply that are not ideal"
stop_time = "5 s"
"""


def outcomes(columns: Mapping[str, NDArray[Any]], tilts: tuple[str, ...]) -> Outcomes:
    """Outcome of each sample by a study's metrics, shape (samples,), some axes being tilts; the first cause counts."""
    far = np.any([~(values <= (TILTED if name.removeprefix("end error of ") in tilts else FAR))
                  for name, values in columns.items() if name.startswith("end error of ")], axis=0)
    tripped, touched = columns["trip time"], columns["stop contact time"]
    return np.select([np.isfinite(tripped) & (tripped <= touched), np.isfinite(touched), far],
                     [page.TRIPPED, page.STOPPED, page.ASTRAY], page.HOLDS).astype(np.uint8)


def read_outcomes(path: Path, question: page.Question) -> Outcomes:
    """Outcomes in a study's dataset; each step needs the values of the sides once."""
    samples = read_dataset(path)
    columns = {name: samples[name].to_numpy() for name in samples.column_names if name != "failure"}
    tilts = tuple(name.removeprefix("end error of ") for name, unit in units_of(samples).items()
                  if name.startswith("end error of ") and unit == "rad")
    ends = outcomes(columns, tilts)
    # A run that its FMUs ended, by running away, was beyond a stop before.
    ends[[failure is not None for failure in samples["failure"].to_pylist()]] = page.STOPPED
    shape = len(question.down.values), len(question.along.values)
    if len(ends) % (shape[0] * shape[1]):
        raise MaglevError(f"{path}: {len(ends)} samples, expected {shape[0]} by {shape[1]} for each step")
    # Samples of a grid are in the order of the varied quantities, the steps last.
    return np.moveaxis(ends.reshape(*shape, -1), -1, 0)


def study_of(stage: StageDescription, law: str, question: page.Question, folder: Path) -> StudyFile:
    """Study of a question with a law; its scenario is written into a folder."""
    scenario = folder / f"tolerance-{stage.name}-{law}.toml"
    folder.mkdir(parents=True, exist_ok=True)
    scenario.write_text(SCENARIO.format(
        steps=(PACKAGED / "steps" / f"{stage.name}-{law}.toml").as_posix(), title=stage.title, stage=stage.name,
        law=law,
        measurement=(PACKAGED / "loops" / f"{stage.name}-measurement.toml").as_posix()), encoding="utf-8")
    gap, start = stage.vertical.name, 1e3 * stage.vertical.start
    measured = [encoder.rpartition(".")[0] for encoder in stage.encoders]
    vary = [{"name": side.name, "kind": "list", "values": [f"{value:g} {side.unit}" for value in side.values],
             "set": [side.sets.format(name) for name in measured] if "{}" in side.sets else [side.sets]}
            for side in (question.down, question.along)]
    steps = {"name": "target gap", "kind": "list", "values": [f"{start - size:g} mm" for size in SIZES],
             "set": [f"reference.{gap}.end", *(["controller.setpoint"] if law == "linear" else [])]}
    beside = {f"reference.{axis.name}.end": BESIDE[bool(stage.rotations)]
              for axis in stage.rotations or stage.horizontal}
    return read_study({"name": f"tolerance-{stage.name}-{law}-{question.name}", "scenario": str(scenario.resolve()),
                       "vary": [*vary, steps], "set": beside, "metrics": ["end error"]}, scenario)


def run_stage(name: str, laws: tuple[str, ...], run_study: RunStudy, options: argparse.Namespace) -> StageGrids:
    stage, paths, grids = PACKAGED_STAGES[name], list[Path](), dict[str, Grid]()
    for question in page.QUESTIONS:
        outcomes_of_laws = {}
        for law in laws:
            paths.append(run_study(study_of(stage, law, question, options.out / "tolerances")))
            outcomes_of_laws[NAMES.get(law, law)] = read_outcomes(paths[-1], question)
        sides = {f"{side.name}, {side.unit}": np.array(side.values) for side in (question.down, question.along)}
        grids[question.name] = Grid({page.STEP: np.array(SIZES), **sides}, outcomes_of_laws)
    of_stage = StageGrids(grids, origin_of(paths))
    write_picture(options.docs / f"tolerances-{name}.png", f"{stage.title}: tolerance of each law",
                  page.maps_of(of_stage), page.OUTCOMES, COLOURS)
    print(f"\n{name}\n\n{shares_markdown(page.table(of_stage))}", flush=True)
    return of_stage


if __name__ == "__main__":
    map_laws(__doc__, page.FILE, page.OUTCOMES, run_stage)
