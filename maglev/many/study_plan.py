"""A study made ready: every error of its file is found here, before the first run."""

import shutil
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import QuantityError, ScenarioError, nearest, size_text
from maglev.files.time_grid import whole_steps
from maglev.many.batches import batches_of
from maglev.many.sample_key import study_key
from maglev.many.samples import Batch, Job, code_of_package
from maglev.many.study_columns import Column, columns_of, named_values
from maglev.many.study_design import Target, samples, target_values, targets_of
from maglev.many.study_file import StudyFile
from maglev.runs.execution import expected
from maglev.runs.preparation import Experiment
from maglev.user.blocks import built_blocks

LEAST_FREE = 1e8           # bytes that a study leaves on the disk
LIMIT_OF_FOREIGN = 600.0   # s of wall time that a sample may take with FMUs that are not of this project
LARGEST_LIMIT = 1e6        # s, more than a week and less than the longest wait of a system's clock


@dataclass(frozen=True)
class PlannedStudy:
    """A study that can be run."""

    study: StudyFile
    job: Job
    varied: Mapping[str, str]   # units of the varied quantities, by name
    about: Mapping[str, Any]    # what stands in the metadata
    design: Array               # shape (samples, number that vary)
    values: Array               # of the targets, shape (samples, targets)
    batches: list[Batch]
    times: Array                # s, of the trajectories that are kept, shape (rows,)


def plan_study(study: StudyFile, experiment: Experiment, origin: str, out: Path,
               run: Mapping[str, Any]) -> PlannedStudy:
    """Plan a study of an experiment, whose results go to the folder `out`.

    `origin`, the file, is the source that errors name. `run` has the options of a full run of the experiment, see
    `maglev.pages.sample_commands`. MaglevError if something in it cannot be used, is out of range for some samples, or
    does not fit on the disk.
    """
    plan = experiment.plan
    require_alone(experiment, study.scenario, origin)
    targets = targets_of(study.vary, experiment, origin)
    design = samples(study)
    count = len(design)
    known = named_values(plan, expected(experiment))
    columns = columns_of(known, study.metrics, study.limits, origin)
    every = rows_every(study.keep_interval, experiment, origin)
    known_signals = {*experiment.drives(experiment.check()), *(
        name for name, variable in experiment.variables().items()
        if variable.causality == "output" and variable.type in ("Real", "Boolean"))}
    if unknown := [name for name in study.keep if name not in known_signals]:
        raise ScenarioError(f"{origin}: keep = {unknown[0]!r}: is recorded by no FMU; "
                            f"{nearest(unknown[0], known_signals)}")
    rows = len(experiment.times[::every]) if study.keep else 0
    require_disk(study, out, 8 * count * (len(columns) + len(study.vary) + len(targets))
                 + 8 * count * rows * len(study.keep), count)
    values = target_values(targets, design, origin)
    job = job_of(experiment, targets, columns, study.sample_timeout, origin)
    job = replace(job, kept=tuple(study.keep), every=every)
    varied = {parameter.column: "" if parameter.mode == "factor" else
              next(target.unit.removeprefix("1") for target in targets if target.column == i)
              for i, parameter in enumerate(study.vary)}
    for name in {parameter.column for parameter in study.vary} & {*known, "sample", "passed", "ending", "failure"}:
        raise ScenarioError(f"{origin}: vary.name = {name!r}: expected another name than that of a metric")
    job = replace(job, key=study_key(job, values, varied, design, bool(study.limits)))
    return PlannedStudy(study, job, varied, about(study, job, experiment, run, count), design, values,
                        batches_of(job, count, rows), experiment.times[::every])


def rows_every(keep_interval: float | None, experiment: Experiment, origin: str) -> int:
    """Communication steps between two rows of the trajectories that are kept."""
    if keep_interval is None:
        return experiment.output_every()
    step, stop_time = experiment.step, experiment.plan.stop_time
    with suppress(QuantityError):
        if keep_interval <= stop_time:
            return whole_steps(keep_interval, step)
    raise ScenarioError(f"{origin}: keep_interval = {keep_interval:g} s: expected a whole number of communication "
                        f"steps of {step:g} s, up to the stop time = {stop_time:g} s")


def require_alone(experiment: Experiment, scenario: str, origin: str) -> None:
    """Refuse a scenario that starts from the results of other runs."""
    if needs := experiment.plan.needs:
        raise ScenarioError(f"{origin}: scenario = {scenario!r}: starts from the results of "
                            f"{', '.join(sorted(needs))}, expected one that stands for itself")


def job_of(experiment: Experiment, targets: Iterable[Target], columns: Iterable[Column], timeout: float | None,
           origin: str) -> Job:
    """Return the job of a study or a tuning, without its key; `timeout` is the longest wall time of a sample, s.

    Without `timeout` only third-party FMUs have a limit: those of this installation do not hang, and written ones
    cannot. ScenarioError if it is too long.
    """
    written = built_blocks(experiment.fmu_files)
    if timeout is None and any(source.foreign for name, source in experiment.sources.items() if name not in written):
        timeout = LIMIT_OF_FOREIGN
    if timeout is not None and timeout > LARGEST_LIMIT:
        raise ScenarioError(f"{origin}: sample_timeout = {timeout:g} s: expected at most {LARGEST_LIMIT:g} s")
    native = all(fmu.kind == "native" for fmu in experiment.provenance().fmus)   # a foreign one may run Python inside
    return Job("", code_of_package(), experiment, tuple(targets), tuple(columns), limit=timeout, written=written,
               native=native)


def require_disk(study: StudyFile, out: Path, needed: float, count: int) -> None:
    """Refuse a study whose results do not fit on the disk: its parts, and all of them merged."""
    folder = next(parent for parent in (out, *out.absolute().parents) if parent.exists())
    free = shutil.disk_usage(folder).free
    if 2.0 * needed > free - LEAST_FREE:
        raise ScenarioError(f"{study.name}: {count} samples would take {size_text(2 * needed)} in {out}, where "
                            f"{size_text(free)} are free, expected less: fewer samples, or fewer trajectories")


def about(study: StudyFile, job: Job, experiment: Experiment, run: Mapping[str, Any], count: int) -> dict[str, Any]:
    """Return the metadata of the dataset; the same for the same study, however it was run."""
    provenance = {key: value for key, value in experiment.provenance().as_data().items() if key != "command"}
    return {"name": study.name, "title": study.title or experiment.plan.title,
            "description": study.description, "key": job.key, "samples": count,
            "design": study.design.model_dump(), "correlated": [group.of for group in study.correlated],
            "scenario": experiment.plan.name, "provenance": provenance, "run": run,
            "vary": [{"name": parameter.column, "set": parameter.set, "mode": parameter.mode, "kind": parameter.kind,
                      **nominal_of([target for target in job.targets if target.column == i])}
                     for i, parameter in enumerate(study.vary)],
            "limits": {column.name: {"min": finite(column.min), "max": finite(column.max)} for column in job.columns
                       if finite(column.min) is not None or finite(column.max) is not None},
            "targets": [target.name for target in job.targets], "kept": list(job.kept)}


def nominal_of(targets: Sequence[Target]) -> dict[str, Any]:
    """Return the nominal value, SI, of the targets of a factor or an offset, and its unit; nothing where they differ.
    """
    values = {(target.nominal, target.unit) for target in targets if target.mode != "value"}
    return dict(zip(("nominal", "unit"), *values, strict=True)) if len(values) == 1 else {}


def finite(value: float) -> float | None:
    return value if np.isfinite(value) else None
