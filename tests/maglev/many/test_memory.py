"""Memory of a study does not grow with its samples: what was run goes to the disk, batch by batch."""

import gc
import tracemalloc
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from numpy.typing import NDArray
from tiny_study import planned

from maglev.many import batches as batches_module
from maglev.many import dataset
from maglev.many import study_run as running
from maglev.many.batches import RunBatches
from maglev.many.samples import Batch, BatchResult, Job

FEW, MANY = 2_000, 8_000
BATCH = 100   # samples


@contextmanager
def nobody(*_: object) -> Iterator[RunBatches]:
    yield zeros


def zeros(job: Job, batches: list[Batch], _values: NDArray[np.float64],
          store: Callable[[BatchResult], None]) -> None:
    """Runs that take no time: results of the right shape."""
    for batch in batches:
        count = batch.last - batch.first
        store(BatchResult(batch.first, np.zeros((count, len(job.columns))), (None,) * count, ("completed",) * count,
                          np.zeros((count, 41, len(job.kept)))))


def most_memory(folder: Path, fmus: Path, samples: int) -> float:
    """Most memory (bytes) that Python, NumPy and Arrow hold while a study is planned, stored and merged."""
    before = pa.default_memory_pool()
    pool = pa.proxy_memory_pool(before)   # one whose largest use is that of this study
    pa.set_memory_pool(pool)
    gc.collect()
    tracemalloc.start()
    try:
        study = planned(folder, fmus, keep=["plant.v.position", "plant.h.position"], keep_interval="5 ms", vary=[
            {"set": "plant.v.mass", "kind": "grid", "from": 4.0, "to": 5.0, "number": samples}])
        path = running.run_study(study, folder, 1, None, False, lambda _done, _all: None, print)
        python = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
        pa.set_memory_pool(before)
    assert len(study.times) == 41
    assert pq.read_metadata(path).num_rows == samples
    return python + pool.max_memory()


@pytest.mark.thorough
def test_planning_and_writing_take_no_more_memory_for_more_samples(fastest_fmus: Path, tmp_path: Path,
                                                                   monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "runners", nobody)
    # Of both as large: a batch, and a group of rows.
    monkeypatch.setattr(batches_module, "STEPS_OF_A_BATCH", BATCH * 400)
    monkeypatch.setattr(dataset, "ROWS_OF_A_GROUP", 1000)
    most_memory(tmp_path, fastest_fmus, FEW)   # imports and caches
    few, many = (most_memory(tmp_path, fastest_fmus, samples) for samples in (FEW, MANY))
    # Of a sample stays what varies and what it sets, as is planned; its row has 900 bytes, its trajectories 1300.
    assert many - few < 70 * (MANY - FEW)
