"""Results of a run as CSV: time first, then FMI names, each with the name of its FMU in front."""

from pathlib import Path

from maglev.cosim.master import Recording


def write_csv(path: Path, recording: Recording, every: int = 1) -> None:
    """Write every n-th communication point of a recording, and the last one.

    Numbers are written such that reading them gives the same bits. The file appears under its name when it is
    complete: what stood there before is intact until then.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    unfinished = path.with_name(path.name + ".part")
    rows = list(range(0, len(recording.time), every))
    if rows[-1] != len(recording.time) - 1:
        rows.append(len(recording.time) - 1)
    columns = [recording.time[rows].tolist(), *(column[rows].tolist() for column in recording.columns.values())]
    with unfinished.open("w", encoding="utf-8", newline="\n") as file:
        file.write(",".join(["time", *recording.columns]) + "\n")
        for row in zip(*columns, strict=True):
            file.write(",".join(map(repr, row)) + "\n")
    unfinished.replace(path)
