"""Results of a study, for the terminal."""

import re
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np
import pyarrow as pa
from rich.console import Console

from maglev.files.arrays import Array, Bools
from maglev.files.console import ResultTable, heading, result_table
from maglev.files.fmi_units import typeset_unit
from maglev.pages.sample_commands import command_of
from maglev.scenario.quantities import metric_text

MOST_SHOWN = 3   # failures that are named
MOST_ROWS = 12   # samples of which each has a row
QUANTILES = ("metric", "least", "median", "largest")

SHOWN = re.compile(r"(rms error|settling time to .*|peak current) of (\S+)")   # of a sample that has a row


def show_study(console: Console, table: pa.Table, about: Mapping[str, Any]) -> None:
    """Print how many samples passed, quantiles of the metrics, and the first samples that failed."""
    count, passing = table.num_rows, sum(table["passed"].to_pylist())
    failures = [(row, why) for row, why in enumerate(table["failure"].to_pylist()) if why is not None]
    console.print(heading(about["name"], about["title"]))
    console.print(passing_text(passing, count)
                  + (f", {len(failures)} were not completed" if failures else ""), highlight=False)
    console.print(sample_table(table, about) if count <= MOST_ROWS else result_table("", (*QUANTILES, "limits"), (
        [*quantiles(name, unit, values), limits_text(about, name, unit)]
        for name, unit, values in metrics_of(table) if len(values))))
    for row, why in failures[:MOST_SHOWN]:
        console.print(f"sample {row}: {why}\n  {command_of(about, table.slice(row, 1).to_pylist()[0])}",
                      highlight=False, soft_wrap=True)


def passing_text(passing: int, count: int) -> str:
    """How many samples pass."""
    return f"{passing:,} of {counted(count)} pass{'es' if count == 1 else ''}"


def counted(count: int) -> str:
    """A number of samples."""
    return f"{count:,} sample{'' if count == 1 else 's'}"


def sample_table(table: pa.Table, about: Mapping[str, Any]) -> ResultTable:
    """Return a row for each sample: its settings, the metrics with limits, or else the main ones of axes and motors."""
    units = units_of(table)
    varied = [name for name in dict.fromkeys([*(parameter["name"] for parameter in about["vary"]), *about["targets"]])
              if name in table.column_names]
    # Of bands to settle in the last one, the narrowest.
    main = {(match[1].split(" to ")[0], match[2]): name for name, _, _ in metrics_of(table)
            if (match := SHOWN.fullmatch(name))}
    metrics = [name for name in about["limits"] if name in table.column_names] or list(main.values())
    return result_table("", ("sample", *varied, *metrics), (
        [str(number), *(f"{row[name]:g} {typeset_unit(units[name])}".strip() for name in varied),
         *("–" if row[name] is None else metric_text(name, row[name], units[name]) for name in metrics)]
        for number, row in enumerate(table.select([*varied, *metrics]).to_pylist())), left=0, keys=1 + len(varied))


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
    """Which values of a metric are beyond its limits; one that was not measured, NaN, is not."""
    limits = about["limits"].get(name, {})
    low, high = limits.get("min"), limits.get("max")
    return (values < (-np.inf if low is None else low)) | (values > (np.inf if high is None else high))


def limits_text(about: Mapping[str, Any], name: str, unit: str) -> str:
    """Limits on a metric; empty if there are none."""
    limits = about["limits"].get(name, {})
    words = [f"{sign} {metric_text(name, limits[key], unit)}" for key, sign in (("min", "≥"), ("max", "≤"))
             if limits.get(key) is not None]
    return ", ".join(words)
