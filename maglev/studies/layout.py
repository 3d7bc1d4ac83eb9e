"""Columns of what a study leaves, from its plan. Arrow is imported where there is a table to make, not to plan one."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from maglev.arrays import Array
from maglev.studies.columns import passed
from maglev.studies.flying.samples import Flown, Job

if TYPE_CHECKING:
    import pyarrow as pa

METADATA = b"maglev"       # key of the schema's metadata, JSON


@dataclass(frozen=True)
class Layout:
    """Columns of the dataset: names and units of what varies and of what it sets, the metrics, and all about them."""

    job: Job
    varied: Mapping[str, str]   # units of what varies, by name
    limited: bool               # whether the study has limits
    about: Mapping[str, Any]    # what stands in the metadata

    @property
    def settings(self) -> list[int]:
        """Numbers of the targets that have a column of their own: not the same as what varies."""
        return [i for i, target in enumerate(self.job.targets) if target.name not in self.varied]

    def schema(self) -> "pa.Schema":
        import pyarrow as pa

        def field(name: str, kind: "pa.DataType", unit: str, role: str) -> "pa.Field":
            return pa.field(name, kind, metadata={"unit": unit, "role": role})

        job = self.job
        boolean = {target.column for target in job.targets if target.boolean}
        fields = [field("sample", pa.int64(), "", "sample")]
        fields += [field(name, pa.bool_() if i in boolean else pa.float64(), unit, "varied")
                   for i, (name, unit) in enumerate(self.varied.items())]
        fields += [field(job.targets[i].name, pa.bool_() if job.targets[i].boolean else pa.float64(),
                         job.targets[i].unit, "setting") for i in self.settings]
        fields += [field(column.name, pa.bool_() if column.name == "failed" else pa.float64(), column.unit, "metric")
                   for column in job.columns]
        fields += [field("passed", pa.bool_(), "", "verdict"), field("failure", pa.string(), "", "verdict")]
        return pa.schema(fields, metadata={METADATA: json.dumps(self.about, ensure_ascii=False).encode()})

    def table(self, flown: Flown, design: Array, values: Array) -> "pa.Table":
        """Rows of a batch, from the design and the targets' values of its samples."""
        import pyarrow as pa

        last = flown.first + len(flown.failures)
        schema = self.schema()
        columns: list[Any] = [np.arange(flown.first, last)]
        columns += [design[flown.first:last, i] for i in range(len(self.varied))]
        columns += [values[flown.first:last, i] for i in self.settings]
        columns += [flown.values[:, i] for i in range(len(self.job.columns))]
        columns += [[passed(self.job.columns, row, failure, self.limited)
                     for row, failure in zip(flown.values.tolist(), flown.failures, strict=True)],
                    list(flown.failures)]
        return pa.table([array(column, field.type) for column, field in zip(columns, schema, strict=True)],
                        schema=schema)


def array(values: Any, kind: "pa.DataType") -> "pa.Array":
    """Arrow array in which NaN, which nothing was measured for, is null."""
    import pyarrow as pa

    if kind == pa.bool_() and isinstance(values, np.ndarray):
        return pa.array([None if value != value else bool(value) for value in values.tolist()], kind)
    return pa.array(values, kind, from_pandas=True)
