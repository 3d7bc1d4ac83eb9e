"""A scenario of a fifth of a second, and studies of it."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from faulty_fmus import faulty, faulty_run

from maglev.files.arrays import Array
from maglev.many.samples import BatchResult, Job, gathered, run_samples
from maglev.many.study_file import StudyFile, read_study
from maglev.many.study_plan import PlannedStudy, plan_study
from maglev.runs.preparation import Experiment, prepare
from maglev.scenario.loading import load_plan

SCENARIO = """\
extends = ["loops/2dof.toml", "gains/2dof.toml"]
name = "tiny"
title = "A short step of both axes"
stop_time = "0.2 s"

[fmus.plant.start]
"v.position_start" = "20 mm"
"h.position_start" = "0 mm"

[[signals]]
to = "controller.v.reference"
kind = "steps"
unit = "mm"
times = [0, 0.05]
values = [20, 20.5]

[[signals]]
to = "controller.h.reference"
kind = "steps"
unit = "mm"
times = [0, 0.05]
values = [0, 1]
"""

UNCHANGED = {"scenario": "tiny.toml", "set": {}, "options": {}}   # what its samples are run with


def scenario(folder: Path, more: str = "") -> Path:
    """File of the scenario, with more tables, in a folder."""
    path = folder / "tiny.toml"
    path.write_text(SCENARIO + more, encoding="utf-8")
    return path


def tiny(**table: object) -> StudyFile:
    """Study of the scenario; what it varies is a mass if nothing else is given."""
    vary = [{"set": "plant.v.mass", "kind": "grid", "from": 4.0, "to": 5.0, "number": 20}]
    return read_study({"name": "study", "scenario": "tiny.toml", "vary": vary, **table}, Path("study.toml"))


def experiment(folder: Path, fmus: Path, more: str = "") -> Experiment:
    """The scenario made ready."""
    return prepare(load_plan(scenario(folder, more)), fmus, {}, {})


def planned(folder: Path, fmus: Path, **table: object) -> PlannedStudy:
    """A study made ready."""
    return plan_study(tiny(**table), experiment(folder, fmus), "study.toml", folder, UNCHANGED)


def simulate_samples(job: Job, first: int, values: Array) -> BatchResult:
    """Run samples in this process, whatever their limit of time."""
    return gathered(job, first, run_samples(job, values))


def of_a_crash(fmus: Path, folder: Path, **changed: Any) -> PlannedStudy:
    """A study of one sample, whose plant crashes; what is changed is of its job."""
    crashing = faulty_run(faulty("crash", folder), fmus)
    study = plan_study(tiny(vary=[{"set": "plant.v.mass", "kind": "list", "values": [4.0]}]), crashing, "study.toml",
                       folder, UNCHANGED)
    return replace(study, job=replace(study.job, **changed))
