"""The key of a stored sample: a digest of all resolved inputs of its run."""

import hashlib
import json
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from maglev.files.arrays import Array
from maglev.files.cache import digest_of_all
from maglev.many.samples import Job, worker_files
from maglev.runs.preparation import Experiment
from maglev.scenario.run_plan import FmuTable, RunPlan, StartValue
from maglev.scenario.signals import Csv

# Members that do not count, by their class: words for readers, criteria that are judged elsewhere, and paths of files,
# whose content counts. A new member of a plan counts until it is listed here.
LEFT_OUT: dict[type, frozenset[str]] = {
    Job: frozenset({"key", "written", "native", "ahead"}),   # its FMUs are there
    Experiment: frozenset({"sources", "loop", "left_out", "notes", "changes", "put_in", "departures", "not_compared",
                           "stale", "parameter_sets"}),
    RunPlan: frozenset({"title", "description", "figures", "check_only", "another_reading", "claims", "check",
                        "procedure", "stage_file", "_source", "_own", "_sha256"}),
    FmuTable: frozenset({"file"}),
    Csv: frozenset({"file", "_told", "_said"})}   # what was read of it is there


def study_key(job: Job, values: Array, *further: object) -> str:
    """Return the SHA-256 of all inputs of a study's results: job, values of the targets, and the stored columns."""
    experiment = job.experiment
    said = [canonical(job), digest_of_all(worker_files(experiment)), canonical(experiment.plan.stage),
            canonical(values),
            canonical(further)]
    return hashlib.sha256(json.dumps(said).encode("utf-8")).hexdigest()


def canonical(value: Any) -> Any:
    """Return a value as JSON that differs for each other value; TypeError for an unknown type, so that none is ignored.
    """
    if isinstance(value, StartValue):   # however it was written, and wherever
        return canonical(value.given)
    if isinstance(value, BaseModel) or (is_dataclass(value) and not isinstance(value, type)):
        left_out = LEFT_OUT.get(type(value), frozenset())
        # Members of a model, private ones included.
        names = [field.name for field in fields(value)] if is_dataclass(value) else [
            *type(value).model_fields, *(value.__pydantic_private__ or {})]
        return [type(value).__name__, [[name, canonical(getattr(value, name))] for name in names
                                       if name not in left_out]]
    if isinstance(value, Mapping):
        return ["mapping", [[canonical(name), canonical(item)] for name, item in value.items()]]
    if isinstance(value, (list, tuple)):
        return [canonical(item) for item in value]
    if isinstance(value, np.ndarray):
        content = np.ascontiguousarray(value)
        return [str(content.dtype), list(content.shape), hashlib.sha256(content.tobytes()).hexdigest()]
    if value is None or isinstance(value, (bool, int, str)):
        return value
    if isinstance(value, float):
        return repr(value)
    if isinstance(value, Path):
        return str(value)
    raise TypeError(f"{value!r} is of {type(value)}, of which no key is known")
