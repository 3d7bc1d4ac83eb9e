"""A planned study run: on a cluster, part by part, merged at the end; Ctrl-C keeps what is done."""

from contextlib import suppress
from pathlib import Path

from maglev.files.errors import Interrupted, ScenarioError, ended_by, option, signal_of
from maglev.files.side_by_side import Progress, Say
from maglev.many import dataset
from maglev.many.batches import runners
from maglev.many.samples import Batch, BatchResult
from maglev.many.study_parts import Parts
from maglev.many.study_plan import PlannedStudy


def trajectories_path(path: Path) -> Path:
    """File of the trajectories next to a study's samples."""
    return path.with_name(f"{path.stem}.trajectories.parquet")


def run_study(planned: PlannedStudy, out: Path, jobs: int, scheduler: str | None, resume: bool,
              watch: Progress, say: Say) -> Path:
    """Run a study; return the path of its dataset.

    While it continues, `NAME.parts` holds the finished parts. `NAME.trajectories.parquet` has the kept trajectories.
    `say` receives a note on missing or broken parts. MaglevError if it cannot be run, another process is writing there,
    or parts are there without `resume`. Interrupted after Ctrl-C or SIGTERM; finished parts are kept.
    """
    parts = Parts(out / f"{planned.study.name}.parts", planned.job.key)
    path = out / f"{planned.study.name}.parquet"
    samples, job = len(planned.values), planned.job
    # By kind of part; the file that marks a study as done comes last.
    files = {"trajectories": (dataset.trajectories_schema(planned), dataset.trajectories_table,
                              trajectories_path(path))} if job.kept else {}
    files["samples"] = dataset.samples_schema(planned), dataset.samples_table, path

    def whole_batches() -> set[Batch]:
        return {batch for batch in planned.batches if all(part(kind, batch.number) in parts.files for kind in files)}

    with parts.alone():
        others = parts.find()
        done = whole_batches()
        by_first = {batch.first: batch for batch in planned.batches}
        lost = sum(part("samples", batch.number) in parts.files for batch in planned.batches) - len(done)
        kept_samples = sum(len(batch.samples) for batch in done)
        if parts.files and not resume:
            raise ScenarioError(f"{parts.folder}: {kept_samples} of {samples} samples are done: continue with "
                                f"{option('resume', True)}, or remove the folder")
        if resume and not parts.folder.exists() and dataset.metadata_of(path).get("key") == planned.job.key:
            if all(dataset.is_as_written(file, job.key) for _, _, file in files.values()):
                return path   # it was done before
            say(f"{path}: incomplete, without its trajectories, or edited: all samples are run again")
        if lost or others:
            say(f"{parts.folder}: {lost + others} of the parts are missing or changed; {kept_samples} of {samples} "
                "samples are complete, the others are run again")

        def store(result: BatchResult) -> None:
            nonlocal kept_samples
            batch = by_first[result.first]
            if not batch.is_whole(result):
                return   # parts are whole
            for kind, (schema, table, _) in files.items():
                parts.write(part(kind, batch.number), dataset.as_bytes(table(planned, result, schema)))
            kept_samples += len(result.failures)
            watch(kept_samples, samples)

        waiting = [batch for batch in planned.batches if batch not in done]
        try:
            if waiting:
                with runners(scheduler, jobs) as run_batches:
                    parts.begin()
                    watch(kept_samples, samples)
                    run_batches(planned.job, waiting, planned.values, store)
        except KeyboardInterrupt as error:
            with suppress(ScenarioError):   # of a folder that has not begun
                parts.find()                # a part may have been written whole when the signal came
            kept_samples = sum(len(batch.samples) for batch in whole_batches())
            raise Interrupted(f"{ended_by(error)}: {kept_samples} of {samples} samples are kept in {parts.folder}, "
                              f"{option('resume', True)} continues with them", signal_of(error)) from error
        for kind, (schema, _, file) in files.items():
            dataset.merge_parts((parts.read(part(kind, batch.number)) for batch in planned.batches), schema, file)
        parts.remove()
        return path


def part(kind: str, batch: int) -> str:
    return f"{kind}-{batch:07d}.parquet"
