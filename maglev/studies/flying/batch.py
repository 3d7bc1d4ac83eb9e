"""What a worker does: it flies a batch of samples in one process, on one instance of each FMU, reset between."""

import hashlib
import shutil
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from importlib.metadata import version
from math import nan
from pathlib import Path

import numpy as np
from distributed import Worker, WorkerPlugin, get_worker
from numpy.typing import NDArray

from maglev.cosim.step_loop import LIBRARY
from maglev.errors import MaglevError, in_one_line
from maglev.experiment.preparation import Experiment
from maglev.judging.metrics import evaluate
from maglev.studies.columns import Column, named_values
from maglev.studies.flying.flight import Flight
from maglev.studies.targets import Target

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Job:
    """What every batch of a study has in common.

    Attributes
    ----------
    key : str
        Of the study: SHA-256 of all that its result depends on.
    code : str
        Of the package that plans it, see `code_of_package`.
    experiment : Experiment
        Its files are those of the machine that plans the study.
    targets : tuple of Target
    columns : tuple of Column
    kept : tuple of str
        Signals whose trajectories are kept.
    every : int
        Communication steps between two rows of these.
    """

    key: str
    code: str
    experiment: Experiment
    targets: tuple[Target, ...]
    columns: tuple[Column, ...]
    kept: tuple[str, ...] = ()
    every: int = 1


@dataclass(frozen=True)
class Flown:
    """A batch that was flown.

    Attributes
    ----------
    first : int
        Number of its first sample.
    values : ndarray, shape (samples, columns)
        Metrics, SI; NaN where a sample was not flown to its end, or has no such metric.
    failures : tuple of str or None
        Why a sample was not flown to its end.
    trajectories : ndarray, shape (samples, rows, signals), or None
    """

    first: int
    values: Array
    failures: tuple[str | None, ...]
    trajectories: Array | None = None


@cache
def code_of_package() -> str:
    """Version of this package and SHA-256 of its modules: two of one version may differ before a release."""
    folder = Path(__file__).parents[2]
    found = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        found.update(str(path.relative_to(folder).as_posix()).encode())
        found.update(path.read_bytes())
    return f"{version('maglev-fmus')} ({found.hexdigest()[:12]})"


def files_of(experiment: Experiment) -> dict[str, bytes]:
    """FMUs of an experiment, and the C loop that lies beside them, by their paths on a worker."""
    found = {f"{name}/{path.name}": path.read_bytes() for name, path in experiment.files.items()}
    loops = (path.parent / LIBRARY for path in experiment.files.values())
    loop = next((path for path in loops if path.is_file()), None)
    return found if loop is None else {**found, LIBRARY: loop.read_bytes()}


def digest(files: Mapping[str, bytes]) -> str:
    """SHA-256 of files with their names."""
    found = hashlib.sha256()
    for name, content in sorted(files.items()):
        found.update(f"{name}\0{len(content)}\0".encode())
        found.update(content)
    return found.hexdigest()


class StudyFiles(WorkerPlugin):
    """The job of a study and its FMUs, which Dask gives to every worker, also to one that comes later.

    The files lie in the worker's own folder, in one that is named after their content.
    """

    def __init__(self, job: Job, files: Mapping[str, bytes]):
        self.job = job
        self.files = files
        self.name = f"maglev-{job.key}"
        self.folder: Path | None = None

    def setup(self, worker: Worker) -> None:
        """Write the files."""
        folder = Path(worker.local_directory) / f"maglev-{digest(self.files)}"
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        self.folder = folder

    def teardown(self, worker: Worker) -> None:
        """Remove them."""
        if self.folder is not None:
            shutil.rmtree(self.folder, ignore_errors=True)

    def local_job(self) -> Job:
        """The job with the files of this worker."""
        assert self.folder is not None   # Dask sets a plugin up before it is asked
        files = {name: self.folder / name / path.name for name, path in self.job.experiment.files.items()}
        return replace(self.job, experiment=replace(self.job.experiment, files=files))


def fly_batch(plugin: str, first: int, values: Array) -> Flown:
    """Fly the samples from number `first` on with values of the targets, shape (samples, targets); on a worker."""
    files = get_worker().plugins[plugin]
    assert isinstance(files, StudyFiles)
    if files.job.code != code_of_package():
        raise MaglevError(f"a worker has maglev-fmus {code_of_package()}, expected {files.job.code}")
    return fly_samples(files.local_job(), first, values)


def fly_samples(job: Job, first: int, values: Array) -> Flown:
    """Fly samples in this process; one that fails has a row that says why."""
    plan = job.experiment.plan
    rows = np.full((len(values), len(job.columns)), nan)
    failures: list[str | None] = []
    kept = None
    with Flight(job.experiment) as flight:
        flight.load()   # what fails here is no sample's fault
        if job.kept:
            kept = np.full((len(values), len(flight.time[::job.every]), len(job.kept)), nan)
        for row, sample in enumerate(values.tolist()):
            changes = {target.name: bool(value) if target.boolean else value
                       for target, value in zip(job.targets, sample, strict=True)}
            try:
                columns = flight.fly(changes)
                found = named_values(plan, evaluate(plan, flight.time, columns))
            except MaglevError as error:
                failures.append(in_one_line(error))
                continue
            failures.append(None)
            rows[row] = [found.get(column.name, (nan, ""))[0] for column in job.columns]
            if kept is not None:
                kept[row] = np.column_stack([columns[name][::job.every] for name in job.kept])
    return Flown(first, rows, tuple(failures), kept)
