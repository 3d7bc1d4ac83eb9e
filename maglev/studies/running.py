"""A planned study flown: on a cluster, part by part, merged at the end; Ctrl-C keeps what is done."""

from collections.abc import Callable
from pathlib import Path

from maglev.errors import Interrupted, ScenarioError, name_of, signal_of
from maglev.studies.dataset import Parts, metadata_of, trajectories_table
from maglev.studies.flying.batches import fly_all
from maglev.studies.flying.cluster import connected
from maglev.studies.flying.samples import Flown
from maglev.studies.planning import PlannedStudy, trajectory_schema

Watcher = Callable[[int, int], None]   # samples done, samples in all


def dataset_path(out: Path, name: str) -> Path:
    """File of a study's samples."""
    return out / f"{name}.parquet"


def run_study(planned: PlannedStudy, out: Path, jobs: int, scheduler: str | None, resume: bool,
              watch: Watcher) -> Path:
    """Fly a study; returns the path of its dataset.

    While it goes on, `NAME.parts` holds what is done. `NAME.trajectories.parquet` has what is kept of trajectories.

    Raises
    ------
    MaglevError
        If it cannot be flown, or parts are there and `resume` is not asked for.
    Interrupted
        After Ctrl-C or SIGTERM; what is done is kept.
    """
    path, parts = dataset_path(out, planned.study.name), Parts(out / f"{planned.study.name}.parts", planned.job.key)
    samples, sizes = len(planned.values), {batch.number: batch.last - batch.first for batch in planned.batches}
    done = parts.found()
    kept_samples = sum(sizes[number] for number in done)
    if done and not resume:
        raise ScenarioError(f"{parts.folder}: {kept_samples} of {samples} samples are done, "
                            "expected --resume to go on with them, or no such folder")
    if resume and not done and metadata_of(path).get("key") == planned.job.key:
        return path   # it was done before
    schema = trajectory_schema(planned) if planned.job.kept else None

    def store(number: int, flown: Flown) -> None:
        nonlocal kept_samples
        table = planned.layout.table(flown, planned.design, planned.values)
        kept = None if schema is None else trajectories_table(planned.job, flown, planned.times, schema)
        parts.write(number, table, kept)
        kept_samples += sizes[number]
        watch(kept_samples, samples)

    waiting = [batch for batch in planned.batches if batch.number not in done]
    try:
        if waiting:
            with connected(scheduler, jobs) as client:
                parts.begin()
                watch(kept_samples, samples)
                fly_all(client, planned.job, waiting, planned.values, store)
    except KeyboardInterrupt as error:
        raise Interrupted(f"{name_of(error)}: {kept_samples} of {samples} samples are kept in {parts.folder}, "
                          "--resume goes on with them", signal_of(error)) from error
    if schema is not None:
        parts.merge("trajectories", len(planned.batches), schema, out / f"{planned.study.name}.trajectories.parquet")
    parts.merge("samples", len(planned.batches), planned.layout.schema(), path)
    parts.remove()
    return path
