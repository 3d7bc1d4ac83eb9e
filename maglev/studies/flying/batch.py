"""What a worker does: it flies a batch of samples in one process, on one instance of each FMU, reset between."""

import hashlib
import shutil
from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from importlib.metadata import version
from pathlib import Path

from distributed import Worker, WorkerPlugin, get_worker

from maglev.arrays import Array
from maglev.cosim.step_loop import LIBRARY
from maglev.errors import MaglevError
from maglev.experiment.preparation import Experiment
from maglev.studies.flying.samples import Flown, Job, each_flown, each_flown_apart, gathered


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
    """FMUs of an experiment, and the C loop that lies beside each, by their paths on a worker."""
    paths = {f"{name}/{path.name}": path for name, fmu in experiment.files.items()
             for path in (fmu, fmu.with_name(LIBRARY))}
    return {place: path.read_bytes() for place, path in paths.items() if path.name != LIBRARY or path.is_file()}


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
        folder = Path(worker.local_directory) / f"maglev-{digest(self.files)}"
        for name, content in self.files.items():
            path = folder / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
        self.folder = folder

    def teardown(self, worker: Worker) -> None:
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
    job = files.local_job()
    return gathered(job, first, len(values), each_flown(job, values) if job.limit is None else
                    each_flown_apart(job, values, job.limit))
