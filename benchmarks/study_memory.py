"""Memory of a study: a hundred thousand short samples, and what the processes of `maglev study` hold all the while.

What counts is the proportional set size of the command and of all processes that it starts, summed, once a second:
pages that several share count once. Linux only, which says it.
"""

import argparse
import re
import subprocess
import sys
import tempfile
from pathlib import Path
from time import monotonic, sleep

SCENARIO = """\
extends = ["loops/3dof.toml", "gains/3dof-improved.toml"]
name = "short"
title = "A short step of the gap"
stop_time = "{stop_time} s"

[[signals]]
to = "controller.y.reference"
kind = "steps"
unit = "mm"
times = [0, 0.02]
values = [25, 25.5]
"""

STUDY = """\
name = "many"
scenario = "short.toml"
{keep}
[[vary]]
set = "plant.y.mass"
kind = "uniform"
low = 6.5
high = 7.5

[[vary]]
name = "friction"
set = ["plant.x.friction.coulomb", "plant.z.friction.coulomb"]
kind = "percent"
percent = "20 %"

[design]
kind = "latin hypercube"
samples = {samples}
"""


def tree(root: int) -> list[int]:
    """A process and all that descend from it."""
    parents = {}
    for folder in Path("/proc").glob("[0-9]*"):
        try:
            parents[int(folder.name)] = int((folder / "stat").read_text().rpartition(")")[2].split()[1])
        except OSError:   # it has ended
            continue
    found = [root]
    for process in found:
        found += [child for child, parent in parents.items() if parent == process]
    return found


def memory(processes: list[int]) -> float:
    """Proportional set size of processes, MB."""
    found = 0.0
    for process in processes:
        try:
            said = Path(f"/proc/{process}/smaps_rollup").read_text()
        except OSError:
            continue
        found += sum(1024e-6 * int(each) for each in re.findall(r"^Pss: +(\d+) kB", said, re.MULTILINE))
    return found


def main() -> None:
    """Fly, and print the memory every so many seconds and at the end."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--samples", type=int, default=100_000)
    parser.add_argument("--stop-time", type=float, default=0.1, help="of a sample, s")
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument("--keep", action="store_true", help="keep the trajectory of the gap, every 10 ms")
    parser.add_argument("--every", type=float, default=10.0, help="s between two lines")
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        keep = 'keep = ["plant.y.position"]\nkeep_interval = "10 ms"\n' if chosen.keep else ""
        (Path(folder) / "short.toml").write_text(SCENARIO.format(stop_time=chosen.stop_time))
        (Path(folder) / "many.toml").write_text(STUDY.format(samples=chosen.samples, keep=keep))
        process = subprocess.Popen([sys.executable, "-m", "maglev", "study", f"{folder}/many.toml", "--out", folder,
                                    "--jobs", str(chosen.jobs)])
        begin, shown, largest = monotonic(), 0.0, 0.0
        while process.poll() is None:
            processes = tree(process.pid)
            now = memory(processes)
            largest = max(largest, now)
            if monotonic() - begin >= shown:
                print(f"{monotonic() - begin:6.0f} s  {now:6.0f} MB in {len(processes)} processes", flush=True)
                shown += chosen.every
            sleep(1.0)
        size = sum(path.stat().st_size for path in Path(folder).rglob("many*") if path.is_file())
        print(f"{chosen.samples} samples in {monotonic() - begin:.0f} s: at most {largest:.0f} MB, "
              f"{1e-6 * size:.0f} MB of results and page")
        sys.exit(process.returncode)


if __name__ == "__main__":
    main()
