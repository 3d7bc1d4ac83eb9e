"""Results of a study, for the terminal."""

import re
from collections.abc import Mapping
from typing import Any

import pyarrow as pa
from rich.console import Console

from maglev.files.console import ResultTable, heading
from maglev.files.fmi_units import typeset_unit
from maglev.pages.sample_commands import command_of
from maglev.pages.study_text import QUANTILES, limits_text, metrics_of, quantiles, units_of
from maglev.pages.study_verdict import answer
from maglev.runs.endings import COMPLETED
from maglev.scenario.quantities import metric_text

MOST_SHOWN = 3   # failures that are named
MOST_ROWS = 12   # most samples with a row each
SHOWN = re.compile(r"(rms error|settling time to .*|peak current) of (\S+)")   # of a sample that has a row


def show_study(console: Console, table: pa.Table, about: Mapping[str, Any]) -> None:
    """Print how many samples passed and why others failed, metrics, and the samples that did not complete."""
    failures = [(row, why) for row, why in enumerate(table["failure"].to_pylist()) if why is not None]
    console.print(heading(about["name"], about["title"]))
    console.print("".join(answer(table, about)), highlight=False)
    console.print(sample_table(table, about) if table.num_rows <= MOST_ROWS else ResultTable(
        "", (*QUANTILES, "limits"), ([*quantiles(name, unit, values), limits_text(about, name, unit)]
                                     for name, unit, values in metrics_of(table) if len(values))))
    for row, why in failures[:MOST_SHOWN]:
        console.print(f"sample {row}: {why}\n  {command_of(about, table.slice(row, 1).to_pylist()[0])}",
                      highlight=False, soft_wrap=True)


def sample_table(table: pa.Table, about: Mapping[str, Any]) -> ResultTable:
    """Return a row for each sample: its end, its settings, the metrics with limits, or else the main ones.

    If all samples completed, their ends are left out. The main metrics are those of axes and motors.
    """
    units = units_of(table)
    varied = [name for name in dict.fromkeys([*(parameter["name"] for parameter in about["vary"]), *about["targets"]])
              if name in table.column_names]
    # Of several settling bands the last one, the narrowest.
    main = {(match[1].split(" to ")[0], match[2]): name for name, _, _ in metrics_of(table)
            if (match := SHOWN.fullmatch(name))}
    metrics = [name for name in about["limits"] if name in table.column_names] or list(main.values())
    ends = ["ending"] if {*table["ending"].to_pylist()} != {COMPLETED} else []
    return ResultTable("", ("sample", *ends, *varied, *metrics), (
        [str(number), *(row[name] for name in ends),
         *(f"{row[name]:g} {typeset_unit(units[name])}".strip() for name in varied),
         *("–" if row[name] is None else metric_text(name, row[name], units[name]) for name in metrics)]
        for number, row in enumerate(table.select([*ends, *varied, *metrics]).to_pylist())),
        left=len(ends) and 2, keys=1 + len(ends) + len(varied))
