"""Columns, counts and limits of a study, in words."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pyarrow as pa

from maglev.files.arrays import Array, Bools
from maglev.scenario.quantities import metric_text

QUANTILES = ("metric", "least", "median", "largest")


def passing_text(passing: int, count: int) -> str:
    """Return how many samples pass, in words."""
    return f"{passing:,} of {counted(count)} pass{'es' if count == 1 else ''}"


def counted(count: int) -> str:
    """A number of samples."""
    return f"{count:,} sample{'' if count == 1 else 's'}"


def quantiles(name: str, unit: str, values: Array) -> list[str]:
    """A metric in the columns of `QUANTILES`."""
    return [name, *(metric_text(name, quantile, unit)
                    for quantile in np.quantile(values, [0.0, 0.5, 1.0], method="nearest").tolist())]


def metrics_of(table: pa.Table) -> Iterator[tuple[str, str, Array]]:
    """Names, units and values, without those that were not measured, of the metrics that are numbers."""
    for field in table.schema:
        said = field.metadata or {}
        if said.get(b"role") == b"metric" and field.type == pa.float64():
            yield field.name, said[b"unit"].decode(), table[field.name].drop_null().to_numpy()


def units_of(table: pa.Table) -> dict[str, str]:
    """SI units by column."""
    return {field.name: (field.metadata or {}).get(b"unit", b"").decode() for field in table.schema}


def numbers(table: pa.Table, name: str) -> Array:
    """A column as numbers, shape (samples,); NaN where nothing was measured."""
    return np.array(table[name].to_pylist(), dtype=np.float64)


def beyond_limits(values: Array, about: Mapping[str, Any], name: str) -> Bools:
    """Return which values of a metric are beyond its limits; a value that was not measured, NaN, is not."""
    limits = about["limits"].get(name, {})
    low, high = limits.get("min"), limits.get("max")
    return (values < (-np.inf if low is None else low)) | (values > (np.inf if high is None else high))


def limits_text(about: Mapping[str, Any], name: str, unit: str) -> str:
    """Limits on a metric; empty if there are none."""
    limits = about["limits"].get(name, {})
    words = [f"{sign} {metric_text(name, limits[key], unit)}" for key, sign in (("min", "≥"), ("max", "≤"))
             if limits.get(key) is not None]
    return ", ".join(words)
