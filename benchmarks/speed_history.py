"""Ratios of the benchmarks by commit: `python benchmarks/speed_history.py` writes docs/speed.md.

`make bench` adds a file to benchmarks/history. A ratio is of two times of one run on one machine.
"""

import json
import os
import subprocess
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import NamedTuple

ROOT = Path(__file__).parents[1]
FOLDER = ROOT / "benchmarks" / "history"

# What stands together, by what it is a multiple of.
STEP, PYTHON, WHOLE = "a step, of the C loop", "a step, of the bare Python loop", "a run, of the C loop"

PAGE = """# Speed by version

Ratios of `make bench`, the newest first: times of one run on one machine, divided by each other. They depend less on
the machine, but do: 4155c71a is of one on which the C loop takes 1.7 times as long as on that of f9d0bd7.
*C loop*: the translated blocks of controller and plant called in one loop, as they were at eb32d8e, with the C
library's sines; kept since as the unit (`benchmarks/reference`). Before it, each commit's own. *Native*, *Python*: both
as FMUs under our master, every output recorded; Python FMUs are compared with the same blocks called in Python. A *run*
is 3dof-setpoints-improved, measured; with CSV, it is also written. A *sample of a study* is one run of it.
[What a step costs](accuracy.md#what-a-step-costs) has the times.

`make bench` adds a file to `benchmarks/history`, and `python benchmarks/speed_history.py` makes this page of them. The
first two commits have what tables of pages said then.

"""


class Measured(NamedTuple):
    """A commit, when it was made (ISO 8601, UTC), the version, and ratios by group and name."""

    commit: str
    date: str
    version: str
    ratios: dict[str, dict[str, float]]


def history() -> list[Measured]:
    """What was recorded, in the order of the commits."""
    return sorted((Measured(**json.loads(path.read_text(encoding="utf-8"))) for path in FOLDER.glob("*.json")),
                  key=lambda entry: entry.date)


def head() -> tuple[str, str]:
    """Commit that is checked out, and when it was made (ISO 8601, UTC)."""
    commit, date = subprocess.run(["git", "log", "-1", "--date=iso-strict-local", "--format=%h %cd"], cwd=ROOT,
                                  env={**os.environ, "TZ": "UTC"}, capture_output=True, text=True,
                                  check=True).stdout.split()
    return commit, date


def record(group: str, ratios: Mapping[str, float]) -> None:
    """Add ratios to the file of the commit that is checked out."""
    commit, date = head()
    entry = next((known for known in history() if known.commit == commit),
                 Measured(commit, date, version("maglev-fmus"), {}))
    entry.ratios.setdefault(group, {}).update({name: round(ratio, 2) for name, ratio in ratios.items()})
    FOLDER.mkdir(exist_ok=True)
    (FOLDER / f"{commit}.json").write_text(json.dumps(entry._asdict(), indent=1) + "\n", encoding="utf-8")


def names(entries: list[Measured]) -> dict[str, list[str]]:
    rows: dict[str, list[str]] = {group: [] for group in (STEP, PYTHON, WHOLE)}
    for entry in entries:
        for group, ratios in entry.ratios.items():
            rows[group] += [name for name in ratios if name not in rows[group]]
    return rows


def speed_page(recorded: list[Measured]) -> str:
    """The page of what was recorded, the oldest first; the newest has the first column, which is seen on a phone."""
    entries = recorded[::-1]
    lines = [f"| | {' | '.join(f'{entry.commit}, {entry.date[:10]}' for entry in entries)} |",
             "|---" * (len(entries) + 1) + "|"]
    for group, members in names(entries).items():
        for name in members:
            cells = [entry.ratios.get(group, {}).get(name) for entry in entries]
            lines.append(f"| {name}: {group} | {' | '.join('' if cell is None else f'{cell:.2f}' for cell in cells)} |")
    return PAGE + "\n".join(lines) + "\n"


def main() -> None:
    (ROOT / "docs" / "speed.md").write_text(speed_page(history()), encoding="utf-8")


if __name__ == "__main__":
    main()
