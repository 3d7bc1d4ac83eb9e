"""What starting costs: processor time of the command and of a spawned run, as ratios to the import of NumPy.

    python benchmarks/startup.py

Processor time, user and system, of all processes together; the ratios depend little on the machine.
"""

import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from statistics import median

from rich.console import Console
from rich.table import Table

from maglev.catalogue import build

MAGLEV = Path(sys.executable).with_name("maglev")
ROUNDS = 5
FEW, MANY = 2, 6   # runs; from two on, each has a process of its own

ONE_STEP = """
extends = "loops/2dof.toml"
name = "start"
title = "One communication step"
stop_time = "0.5 ms"
"""


def processor_time(*command: str | Path) -> float:
    """Processor time of a command and the processes that it starts, s."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL, env={**os.environ, "OMP_NUM_THREADS": "1"})
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def scenario(folder: Path, runs: int) -> Path:
    """Scenario file of runs of one step each."""
    path = folder / f"start{runs}.toml"
    variants = "".join(f'[variants.number{k}]\ntitle = "Number {k}"\n' for k in range(runs))
    path.write_text(ONE_STEP + variants, encoding="utf-8")
    return path


def spawned_run(folder: Path) -> float:
    """Processor time of one more run, s: almost all of it is spent before the first step, for there is only one."""
    few, many = (processor_time(MAGLEV, "run", scenario(folder, runs), "--jobs", "1", "--fmus", folder, "--out", folder)
                 for runs in (FEW, MANY))
    return (many - few) / (MANY - FEW)


def main() -> None:
    """Print the table."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        build(["Plant2DOF", "Regulator2DOF", "PID2DOF"], folder)
        ways: dict[str, Callable[[], float]] = {
            'python -c "import numpy"': lambda: processor_time(sys.executable, "-c", "import numpy"),
            "maglev --help": lambda: processor_time(MAGLEV, "--help"),
            "maglev list": lambda: processor_time(MAGLEV, "list"),
            "spawned run, to its first step": lambda: spawned_run(folder)}
        times: dict[str, list[float]] = {way: [] for way in ways}
        for _ in range(ROUNDS):   # in turn, so that a disturbance meets all of them
            for way, measure in ways.items():
                times[way].append(measure())
    reference = median(next(iter(times.values())))
    table = Table("start", "processor time (s)", "of NumPy's import", title="Processor time of a start, medians")
    for way, found in times.items():
        table.add_row(way, f"{median(found):.2f}", f"{median(found) / reference:.1f}")
    Console(width=100).print(table)


if __name__ == "__main__":
    main()
