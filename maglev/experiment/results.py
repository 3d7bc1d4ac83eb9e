"""Results of a run as CSV or Parquet: time first, then FMI names, each with the name of its FMU in front."""

import csv
import io
import json
from collections.abc import Iterable, Iterator, Mapping
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any, get_args

import numpy as np

from maglev.cosim.master import Recording
from maglev.errors import ScenarioError
from maglev.experiment.form import Format
from maglev_files.one_writer import Busy, NoLock, only_writer
from maglev_files.whole_file import whole_file


@dataclass(frozen=True)
class ResultFiles:
    """Files of a run in the folder of the results: columns, what is known beside them, and what a failed run leaves."""

    folder: Path
    name: str

    def columns(self, form: Format) -> Path:
        """Columns of a run that was flown to its end."""
        return self.folder / f"{self.name}.{form}"

    @property
    def json(self) -> Path:
        """Provenance and metrics of that run."""
        return self.folder / f"{self.name}.json"

    @property
    def partial(self) -> Path:
        """Columns of a run that ended early."""
        return self.folder / f"{self.name}.partial.csv"

    def previous(self, form: Format) -> Path:
        """Columns of an earlier run, after one that ended early."""
        return self.folder / f"{self.name}.previous.{form}"

    @property
    def lock(self) -> Path:
        """What keeps others from writing them, see `only_writer`."""
        return self.folder / f".{self.name}.lock"

    def set_aside(self) -> None:
        """Give the results of an earlier run a name that says so; a picture and metrics without a run go."""
        for form in get_args(Format):
            if self.columns(form).is_file():
                self.columns(form).replace(self.previous(form))
        self.json.unlink(missing_ok=True)
        self.forget_reports()

    def forget_reports(self) -> None:
        """Remove text and picture, which are made of the results of all runs later."""
        (self.folder / f"{self.name}.txt").unlink(missing_ok=True)
        (self.folder / f"{self.name}.png").unlink(missing_ok=True)

    def forget_others(self, form: Format) -> None:
        """Remove what a failed run has left, and the columns of an earlier one in another form."""
        self.partial.unlink(missing_ok=True)
        for each in get_args(Format):
            self.previous(each).unlink(missing_ok=True)
            if each != form:
                self.columns(each).unlink(missing_ok=True)


@contextmanager
def alone(folder: Path, runs: Iterable[str]) -> Iterator[None]:
    """Keep others from writing runs, by name, into a folder for the block; ScenarioError if somebody does so.

    Where the file system has no locks nobody is kept out, and files that do not belong together are known by digests.
    """
    with ExitStack() as held:
        for name in dict.fromkeys(runs):
            try:
                with suppress(NoLock):
                    held.enter_context(only_writer(ResultFiles(folder, name).lock))
            except Busy:
                raise ScenarioError(f"{folder / name}: another process is writing the files of this run, expected one "
                                    "at a time: wait for it, or give another --out") from None
        yield


def write_csv(path: Path, recording: Recording, every: int = 1) -> None:
    """Write every n-th communication point of a recording, and the last one.

    Numbers are written as short as gives the same bits when they are read. The file appears under its name when it is
    complete: what stood there before is intact until then.
    """
    from pyarrow.csv import WriteOptions
    from pyarrow.csv import write_csv as write_table

    table = table_of(recording, every, as_text=True)
    with whole_file(path) as unfinished, unfinished.open("wb") as file:
        header = io.StringIO()
        csv.writer(header, lineterminator="\n").writerow(table.column_names)   # an array's name has a comma
        file.write(header.getvalue().encode("utf-8"))
        write_table(table, file, WriteOptions(include_header=False, quoting_style="none"))


def write_parquet(path: Path, recording: Recording, units: Mapping[str, str], about: Mapping[str, Any],
                  every: int = 1) -> None:
    """Write the same as `write_csv` does, as Parquet.

    Each column has its unit in its metadata, under "unit"; the file has what is known `about` the run, under "maglev",
    as JSON.
    """
    import pyarrow
    from pyarrow import parquet

    table = table_of(recording, every)
    fields = [field.with_metadata({"unit": {"time": "s", **units}.get(field.name, "")}) for field in table.schema]
    known = {"maglev": json.dumps(about, ensure_ascii=False, allow_nan=False)}
    with whole_file(path) as unfinished, unfinished.open("wb") as file:
        parquet.write_table(table.cast(pyarrow.schema(fields, known)), file)


def table_of(recording: Recording, every: int, as_text: bool = False) -> Any:
    """Every n-th communication point of a recording, and the last one, as a pyarrow.Table: time, then the columns.

    On the way to text, columns most of whose values are those before them are text already.
    """
    import pyarrow

    last = len(recording.time) - 1
    rows = np.append(np.arange(0, last, every), last)
    columns = [recording.time[rows], *(column[rows] for column in recording.columns.values())]
    # From buffers, for pyarrow.array imports pandas where it is installed, to ask whether a column is a pandas.Series.
    arrays = [pyarrow.Array.from_buffers(pyarrow.from_numpy_dtype(column.dtype), len(rows),
                                         [None, pyarrow.py_buffer(column)]) for column in columns]
    if as_text:
        arrays = [texts(array) if 2 * np.count_nonzero(column[1:] != column[:-1]) < len(rows) else array
                  for array, column in zip(arrays, columns, strict=True)]
    return pyarrow.Table.from_arrays(arrays, names=["time", *recording.columns])


def texts(numbers: Any) -> Any:
    """A pyarrow.Array of numbers as text, with each number, by its bits, written once: that is what a CSV costs."""
    found = numbers.view(f"int{numbers.type.bit_width}").dictionary_encode()
    return found.dictionary.view(numbers.type).cast("string").take(found.indices)
