"""Results of a run as CSV: time first, then FMI names, each with the name of its FMU in front."""

import csv
from pathlib import Path

from fmi_export.whole_file import whole_file
from maglev.cosim.master import Recording


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
