"""Results of a run as CSV: time first, then FMI names, each with the name of its FMU in front."""

import csv
from dataclasses import dataclass
from pathlib import Path

from fmi_export.whole_file import whole_file
from maglev.cosim.master import Recording


@dataclass(frozen=True)
class ResultFiles:
    """Files of a run in the folder of the results: CSV, what is known beside it, and what a failed run leaves."""

    folder: Path
    name: str

    @property
    def csv(self) -> Path:
        """Columns of a run that was flown to its end."""
        return self.folder / f"{self.name}.csv"

    @property
    def json(self) -> Path:
        """Provenance and metrics of that run."""
        return self.folder / f"{self.name}.json"

    @property
    def partial(self) -> Path:
        """Columns of a run that ended early."""
        return self.folder / f"{self.name}.partial.csv"

    @property
    def previous(self) -> Path:
        """Columns of an earlier run, after one that ended early."""
        return self.folder / f"{self.name}.previous.csv"

    def set_aside(self) -> None:
        """Give the results of an earlier run a name that says so; a picture and metrics without a run go."""
        if self.csv.is_file():
            self.csv.replace(self.previous)
        self.json.unlink(missing_ok=True)
        self.forget_reports()

    def forget_reports(self) -> None:
        """Remove text and picture, which are made of the results of all runs later."""
        (self.folder / f"{self.name}.txt").unlink(missing_ok=True)
        (self.folder / f"{self.name}.png").unlink(missing_ok=True)

    def forget_failures(self) -> None:
        """Remove what a failed run has left."""
        self.partial.unlink(missing_ok=True)
        self.previous.unlink(missing_ok=True)


def write_csv(path: Path, recording: Recording, every: int = 1) -> None:
    """Write every n-th communication point of a recording, and the last one.

    Numbers are written such that reading them gives the same bits. The file appears under its name when it is
    complete: what stood there before is intact until then.
    """
    rows = list(range(0, len(recording.time), every))
    if rows[-1] != len(recording.time) - 1:
        rows.append(len(recording.time) - 1)
    columns = [recording.time[rows].tolist(), *(column[rows].tolist() for column in recording.columns.values())]
    with whole_file(path) as unfinished, unfinished.open("w", encoding="utf-8", newline="\n") as file:
        csv.writer(file, lineterminator="\n").writerow(["time", *recording.columns])   # an array's name has a comma
        for row in zip(*columns, strict=True):
            file.write(",".join(map(repr, row)) + "\n")
