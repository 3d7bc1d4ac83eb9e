"""Results of a run as CSV or Parquet: time first, then FMI names, each with the name of its FMU in front."""

import csv
import io
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from pathlib import Path
from typing import Any, get_args

import numpy as np
import orjson
from numpy.typing import NDArray

from maglev.cosim.master import Recording
from maglev.files.errors import ScenarioError, extra, option
from maglev.files.one_writer import Busy, NoLock, only_writer
from maglev.files.whole_file import whole_file
from maglev.scenario.options import Format

ROWS = 4096   # that are text at a time
ABOUT = ("json", "txt", "png")   # endings of the files that are made from the columns


@dataclass(frozen=True)
class ResultFiles:
    """Files of a run in the folder of the results.

    NAME.csv or NAME.parquet has the columns of a run, NAME.json its provenance and metrics. A run that does not
    complete leaves NAME.partial.csv; the files of an earlier one are then NAME.previous.csv, NAME.previous.json and so
    on, until a run completes.
    """

    folder: Path
    name: str

    def file(self, ending: str) -> Path:
        return self.folder / f"{self.name}.{ending}"

    def set_aside(self) -> None:
        """Give the files of an earlier run names that say so: they must not pass for those of one that has failed.

        A text alone is of a run that failed, too, and stays.
        """
        forms = get_args(Format)
        if any(self.file(ending).is_file() for ending in (*forms, "json")):
            for ending in (*forms, *ABOUT):
                if self.file(ending).is_file():
                    self.file(ending).replace(self.file(f"previous.{ending}"))

    def forget_others(self, form: Format) -> None:
        """Remove what other runs than the one with these columns have left: text and picture are still to be made."""
        forms = get_args(Format)
        for ending in ("partial.csv", "txt", "png", *(other for other in forms if other != form),
                       *(f"previous.{ending}" for ending in (*forms, *ABOUT))):
            self.file(ending).unlink(missing_ok=True)


@contextmanager
def alone(folder: Path, runs: Iterable[str]) -> Iterator[None]:
    """Keep others from writing runs, by name, into a folder for the block; ScenarioError if somebody does so.

    Where the file system has no locks nobody is kept out, and files that do not belong together are known by digests.
    """
    with ExitStack() as held:
        for name in runs:
            try:
                with suppress(NoLock):
                    held.enter_context(only_writer(folder / f".{name}.lock"))
            except Busy:
                raise ScenarioError(f"{folder / name}: another process is writing the files of this run: wait for it, "
                                    f"or give another {option('out')}") from None
        yield


def write_csv(path: Path, recording: Recording, every: int = 1) -> None:
    """Write every n-th communication point of a recording, and the last one.

    Each number is the shortest text that gives the same bits when it is read. The file appears under its name when it
    is complete; a former file is intact until then.
    """
    columns = thinned_columns(recording, every)
    with whole_file(path) as unfinished, unfinished.open("wb") as file:
        header = io.StringIO()
        csv.writer(header, lineterminator="\n").writerow(columns)   # an array's name has a comma
        file.write(header.getvalue().encode("utf-8"))
        for first in range(0, len(columns["time"]), ROWS):
            groups = groupby((column[first:first + ROWS] for column in columns.values()), attrgetter("dtype"))
            texts = [rows_as_text(np.column_stack([*group])) for _, group in groups]
            file.write(b"\n".join(map(b",".join, zip(*texts, strict=True))) + b"\n")


def write_parquet(path: Path, recording: Recording, units: Mapping[str, str], about: Mapping[str, Any],
                  every: int = 1) -> None:
    """Write the same as `write_csv` does, as Parquet.

    Each column has its unit in its metadata, under "unit"; the file has what is known `about` the run, under "maglev",
    as JSON.
    """
    require_parquet()
    import pyarrow
    from pyarrow import parquet

    columns = thinned_columns(recording, every)
    # From buffers, because pyarrow.array imports pandas if it is installed, to ask whether a column is a pandas.Series.
    arrays = [pyarrow.Array.from_buffers(pyarrow.from_numpy_dtype(column.dtype), len(column),
                                         [None, pyarrow.py_buffer(column)]) for column in columns.values()]
    table = pyarrow.Table.from_arrays(arrays, names=[*columns])
    fields = [field.with_metadata({"unit": {"time": "s", **units}.get(field.name, "")}) for field in table.schema]
    known = {"maglev": json.dumps(about, ensure_ascii=False, allow_nan=False)}
    with whole_file(path) as unfinished, unfinished.open("wb") as file:
        parquet.write_table(table.cast(pyarrow.schema(fields, known)), file)


def require_parquet() -> None:
    """Raise MaglevError if pyarrow, which writes Parquet, is not installed."""
    extra("pyarrow", "data", "Parquet")


def thinned_columns(recording: Recording, every: int) -> dict[str, Any]:
    """Every n-th communication point of a recording, and the last one: time, then the columns, by name."""
    last = len(recording.time) - 1
    rows = np.append(np.arange(0, last, every), last)
    return {"time": recording.time[rows], **{name: column[rows] for name, column in recording.columns.items()}}


def rows_as_text(table: NDArray[Any]) -> list[bytes]:
    """Rows of numbers, each as short as gives the same bits; of those that are no numbers what Python calls them."""
    if not np.isfinite(table).all():
        return [",".join(map(repr, row)).encode("ascii") for row in table.tolist()]
    # A table at once: texts of single numbers would take four times as long.
    return orjson.dumps(table, option=orjson.OPT_SERIALIZE_NUMPY)[2:-2].split(b"],[")
