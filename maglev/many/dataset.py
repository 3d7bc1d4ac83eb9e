"""The dataset of a study: one Parquet file of its samples, merged from a part for each batch.

The dataset carries the digest of its own rows and metadata, so that an edited file is not taken for a result.
"""

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.parquet as pq

from maglev.files.errors import MaglevError, in_one_line
from maglev.files.regular_file import regular
from maglev.files.whole_file import whole_file
from maglev.many.samples import BatchResult
from maglev.many.study_columns import FLAWS, METADATA, passed
from maglev.many.study_plan import PlannedStudy

ROWS_OF_A_GROUP = 10_000
SEAL = b"maglev.sha256"    # key of the file's metadata: `Contents` of its rows


def as_bytes(table: pa.Table) -> bytes:
    """Content of a Parquet file with a table."""
    sink = pa.BufferOutputStream()
    pq.write_table(table, sink)
    return bytes(sink.getvalue())


def merge_parts(contents: Iterator[bytes], schema: pa.Schema, path: Path) -> None:
    """Write one file of all parts, in their order, a few at a time."""
    with whole_file(path) as unfinished, pq.ParquetWriter(unfinished, schema, write_page_checksum=True) as writer:
        rows = Contents(schema)
        for table in row_groups(contents):
            writer.write_table(table.replace_schema_metadata(schema.metadata), row_group_size=ROWS_OF_A_GROUP)
            rows.add(table)
        writer.add_key_value_metadata({SEAL: rows.sha256})


class Contents:
    """SHA-256 of the rows of a table, added some at a time, in whatever portions, and of its schema with metadata."""

    def __init__(self, schema: pa.Schema):
        said = [[field.name, str(field.type), json_of(field.metadata)] for field in schema]
        self.whole = hashlib.sha256(json.dumps([said, json_of(schema.metadata)]).encode("utf-8"))
        self.columns = [hashlib.sha256() for _ in schema]

    def add(self, rows: pa.Table | pa.RecordBatch) -> None:
        """Add rows: of each column which are null, and the bits of the others."""
        for digest, column in zip(self.columns, rows.columns, strict=True):
            values = column.combine_chunks() if isinstance(column, pa.ChunkedArray) else column
            if not (pa.types.is_primitive(values.type) or pa.types.is_boolean(values.type)):
                digest.update("".join(f"{json.dumps(text, default=str)}\n" for text in values.to_pylist()).encode())
                continue
            bits = np.ascontiguousarray(values.fill_null(False if pa.types.is_boolean(values.type) else 0)
                                        .to_numpy(zero_copy_only=False))
            # A row at a time, so that portions do not matter: whether it is null, then its value.
            row = np.empty(len(bits), np.dtype([("null", np.uint8), ("value", bits.dtype)]))
            row["null"], row["value"] = values.is_null().to_numpy(zero_copy_only=False), bits
            digest.update(row.tobytes())

    @property
    def sha256(self) -> str:
        """Digest of all that was added so far."""
        whole = self.whole.copy()
        for column in self.columns:
            whole.update(column.digest())
        return whole.hexdigest()


def json_of(metadata: Mapping[bytes, bytes] | None) -> list[list[str]]:
    """Metadata of a schema or a field, in the order of their keys."""
    return sorted([key.decode("utf-8"), value.decode("utf-8")] for key, value in (metadata or {}).items()
                  if not key.startswith(b"PARQUET:"))


def row_groups(contents: Iterator[bytes]) -> Iterator[pa.Table]:
    """Yield tables with the rows of a full group each, except the last one."""
    waiting: list[pa.Table] = []
    for content in contents:
        waiting.append(pq.read_table(pa.BufferReader(content)))
        rows = sum(table.num_rows for table in waiting)
        if rows >= ROWS_OF_A_GROUP:
            whole = pa.concat_tables(waiting)
            full = rows - rows % ROWS_OF_A_GROUP
            yield whole.slice(0, full).combine_chunks()
            waiting = [whole.slice(full)] if rows > full else []
    if waiting:
        yield pa.concat_tables(waiting).combine_chunks()


def samples_schema(planned: PlannedStudy) -> pa.Schema:
    """Return the columns of the samples: varied quantities, values set by them if different, metrics, and verdicts."""
    job, numbers, flags = planned.job, pa.float64(), pa.bool_()
    boolean = {target.column for target in job.targets if target.boolean}
    columns = [("sample", pa.int64(), "", "sample"),
               *((name, flags if i in boolean else numbers, unit, "varied")
                 for i, (name, unit) in enumerate(planned.varied.items())),
               *((target.name, flags if target.boolean else numbers, target.unit, "setting")
                 for target in job.targets if target.name not in planned.varied),
               *((column.name, flags if column.name in FLAWS else numbers, column.unit, "metric")
                 for column in job.columns),
               ("passed", flags, "", "verdict"), ("ending", pa.string(), "", "verdict"),
               ("failure", pa.string(), "", "verdict")]
    return pa.schema([pa.field(name, kind, metadata={"unit": unit, "role": role})
                      for name, kind, unit, role in columns], metadata=metadata(planned.about))


def samples_table(planned: PlannedStudy, result: BatchResult, schema: pa.Schema) -> pa.Table:
    """Return the rows of a batch; NaN, for a missing measurement, becomes null."""
    job, rows = planned.job, slice(result.first, result.first + len(result.failures))
    columns: dict[str, Any] = {target.name: planned.values[rows, i] for i, target in enumerate(job.targets)}
    columns |= zip(planned.varied, planned.design[rows].T, strict=True)
    columns |= {column.name: result.values[:, i] for i, column in enumerate(job.columns)}
    columns |= {"sample": np.arange(rows.start, rows.stop), "ending": list(result.endings),
                "failure": list(result.failures), "passed": [
        passed(job.columns, row, failure, bool(planned.study.limits))
        for row, failure in zip(result.values.tolist(), result.failures, strict=True)]}
    return pa.table([pa.array(columns[field.name], from_pandas=True).cast(field.type) for field in schema],
                    schema=schema)


def trajectories_schema(planned: PlannedStudy) -> pa.Schema:
    job = planned.job
    fields = [pa.field("sample", pa.int64()), pa.field("time", pa.float64(), metadata={"unit": "s"})]
    fields += [pa.field(name, pa.float64(), metadata={"unit": unit}) for name, unit in
               job.experiment.units(job.kept).items()]
    return pa.schema(fields, metadata=metadata(planned.about))


def metadata(about: Mapping[str, Any]) -> dict[bytes, bytes]:
    return {METADATA: json.dumps(about, ensure_ascii=False).encode()}


def trajectories_table(planned: PlannedStudy, result: BatchResult, schema: pa.Schema) -> pa.Table:
    """Return the trajectories of a batch, a row for each sample and time; no rows of a sample that was not completed.
    """
    if result.trajectories is None:
        return schema.empty_table()
    whole, times = [i for i, failure in enumerate(result.failures) if failure is None], planned.times
    kept = result.trajectories[whole].reshape(-1, len(planned.job.kept))
    columns: Sequence[Any] = [np.repeat(result.first + np.array(whole, dtype=np.int64), len(times)),
                              np.tile(times, len(whole)), *kept.T]
    return pa.table([pa.array(column, field.type) for column, field in zip(columns, schema, strict=True)],
                    schema=schema)


def metadata_of(path: Path) -> dict[str, Any]:
    """Return the metadata of a dataset; empty if this project did not write it."""
    if path.exists() and not path.is_file():   # a pipe would wait for ever
        return {}
    try:
        about: dict[str, Any] = json.loads((pq.read_schema(regular(path)).metadata or {})[METADATA])
    except (OSError, KeyError, ValueError, pa.ArrowException):
        return {}
    return about


def read_dataset(path: Path) -> pa.Table:
    """Return the table of a study's file; MaglevError if it cannot be read, or has changed since."""
    try:
        return pa.Table.from_batches(batches_as_written(path), pq.read_schema(regular(path)))
    except (OSError, ValueError, pa.ArrowException) as error:
        raise MaglevError(f"{path}: {in_one_line(error)}, expected the unchanged dataset of a study; `maglev study` "
                          "writes it again") from None


def batches_as_written(path: Path) -> Iterator[pa.RecordBatch]:
    """Yield rows of a study's file; at the end ValueError if one has changed since it was written."""
    with pq.ParquetFile(regular(path), page_checksum_verification=True) as file:
        rows = Contents(file.schema_arrow)
        for batch in file.iter_batches():
            rows.add(batch)
            yield batch
        if (file.metadata.metadata or {}).get(SEAL, b"").decode("ascii", "replace") != rows.sha256:
            raise ValueError("was edited after it was written, or by another version")


def is_as_written(path: Path, key: str) -> bool:
    """Return True if a file is the unchanged and complete result of the study of a key."""
    try:
        for _ in batches_as_written(path):
            pass
    except (OSError, ValueError, pa.ArrowException):
        return False
    return metadata_of(path).get("key") == key
