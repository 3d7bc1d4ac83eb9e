"""A scenario of a fifth of a second, and studies of it."""

from contextlib import AbstractContextManager
from pathlib import Path
from typing import Any

import dask

from maglev.arrays import Array
from maglev.experiment.preparation import Experiment, prepare
from maglev.schema.loading import load_plan
from maglev.studies.flying.samples import Flown, Job, each_flown, gathered
from maglev.studies.planning import PlannedStudy, plan_study
from maglev.studies.schema import StudyFile, read_study

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

UNCHANGED = {"scenario": "tiny.toml", "set": {}, "options": {}}   # what its samples are flown with


def scenario(folder: Path) -> Path:
    """File of the scenario in a folder."""
    path = folder / "tiny.toml"
    path.write_text(SCENARIO, encoding="utf-8")
    return path


def tiny(**table: object) -> StudyFile:
    """Study of the scenario; what it varies is a mass if nothing else is given."""
    vary = [{"set": "plant.v.mass", "kind": "grid", "from": 4.0, "to": 5.0, "number": 20}]
    return read_study({"name": "study", "scenario": "tiny.toml", "vary": vary, **table}, Path("study.toml"))


def experiment(folder: Path, fmus: Path) -> Experiment:
    """The scenario made ready."""
    return prepare(load_plan(scenario(folder)), fmus, {}, {})


def planned(folder: Path, fmus: Path, **table: object) -> PlannedStudy:
    """A study made ready."""
    return plan_study(tiny(**table), experiment(folder, fmus), "study.toml", folder, UNCHANGED)


def address_of(client: Any) -> str:
    """Address of the scheduler of a client of Dask's."""
    return str(client.scheduler.address)


def trusted(security: Any) -> AbstractContextManager[object]:
    """Make the certificate of a cluster that of this process, as in Dask's configuration: its address is enough."""
    return dask.config.set({"distributed.comm.tls.ca-file": security.tls_ca_file,
                            "distributed.comm.tls.client.cert": security.tls_client_cert,
                            "distributed.comm.tls.client.key": security.tls_client_key})


def fly_samples(job: Job, first: int, values: Array) -> Flown:
    """Fly samples in this process, whatever their limit of time."""
    return gathered(job, first, len(values), each_flown(job, values))
