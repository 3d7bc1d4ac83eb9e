"""Cost of a communication step, in one run on one machine: the blocks bare, as FMUs, and native.

Times depend on the machine; `--gate` judges ratios to a reference implementation measured in the same run.
"""

import resource
import sys
import tempfile
from collections.abc import Callable, Mapping
from functools import partial
from importlib.util import find_spec
from math import inf
from pathlib import Path

import loops
from exchange_alone import for_exchange_alone
from loops import FROZEN, PAIRS, Pair
from rich.console import Console
from rich.table import Table

from maglev.scenario.catalogue import HOST, build

# Largest ratios to the loop that each refers to. On three machines the master took 0.70 to 1.12, the loop in one FMU
# 0.56 to 0.75, Python FMUs 1.01 to 1.1 of the bare loop: twice the largest fails, which no disturbance of a busy
# machine reaches.
GATES = {"FMUs, master": 2.2, "native, master": 2.25, "native, loop in one FMU": 1.5}
STEPS = 5000
GATE_STEPS = 1000        # of the two ways in Python, whose steps take a tenth of a millisecond
C_STEPS = 50_000
EXCHANGE_STEPS = 1000   # progress is reported every 500
# In a round: they take milliseconds.
TIMES = dict.fromkeys((FROZEN, "native, loop in one FMU", "native, master", "native, FMI 3.0, master"), 3)
MEMORY_STEPS = 10**7
LARGEST_GROWTH = 2**20   # bytes


def too_large(times: Mapping[str, float]) -> dict[str, float]:
    reference = {way: times.get("bare Python loop" if way == "FMUs, master" else FROZEN, inf) for way in GATES}
    return {way: times[way] / reference[way] for way, largest in GATES.items()
            if way in times and times[way] > largest * reference[way]}


def step_times(pair: Pair, folder: Path, native: bool, fmi3: Path | None) -> dict[str, float]:
    """Time of one step by what was measured, s.

    The folder has the FMUs in its folders python and native, `fmi3` those of FMI 3.0; without it a few rounds do, where
    each holds the limits, and fewer steps in Python.
    """
    in_python = STEPS if fmi3 is not None else GATE_STEPS
    ways: dict[str, Callable[[], float]] = {
        "bare Python loop": lambda: loops.bare_loop(pair, in_python),
        "FMUs, master": lambda: loops.master_loop(pair, folder / "python", in_python)}
    if native:
        ways[FROZEN] = loops.reference_loop(pair, C_STEPS)
        ways["native, loop in one FMU"] = lambda: loops.loop_fmu(pair, folder / "native" / f"{pair.loop}.fmu", 5)
        ways["native, master"] = lambda: loops.master_loop(pair, folder / "native", 4 * STEPS)
        if fmi3 is not None:
            ways["native, FMI 3.0, master"] = lambda: loops.master_loop(pair, fmi3, 4 * STEPS)
            other = fmi3 / f"{pair.plant}.fmu"
            ways["native, FMI 2.0 and 3.0, master"] = partial(
                loops.master_loop, pair, folder / "native", 4 * STEPS, other)
            for version, made in (("2.0", folder / "native"), ("3.0", fmi3)):
                exchanged = for_exchange_alone(made / other.name, fmi3 / f"exchanged{version}{other.name}")
                ways[f"native, FMI {version}, master, plant by CVODE"] = partial(
                    loops.master_loop, pair, made, EXCHANGE_STEPS, exchanged)
    return loops.fastest(ways, too_large, fmi3 is None, TIMES)


def growth(pair: Pair, folder: Path) -> int:
    """Bytes by which the process grows while the loop in one FMU does ten million samples."""
    references = pair.starts
    with loops.open_loop(pair, folder / "native" / f"{pair.loop}.fmu") as loop:
        for _ in range(10):
            loop.step(references)
        before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        for _ in range(round(MEMORY_STEPS * pair.dt)):
            loop.step(references)
        return 1024 * (resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before)


def main() -> int:
    """Print the table; with --gate, return 1 if a ratio is too large."""
    asked = loops.read_arguments(__doc__, GATES)
    gate: bool = asked.gate
    native = find_spec("ziglang") is not None
    console = Console(width=110)
    too_slow = []
    with tempfile.TemporaryDirectory() as name:
        folder: Path = asked.fmus or Path(name)
        fmus = [fmu for pair in PAIRS for fmu in (pair.controller, pair.plant)]
        if asked.fmus is None:
            build(fmus, folder / "python")
        if native and asked.fmus is None:
            build([*fmus, *(pair.loop for pair in PAIRS)], folder / "native", HOST)
        if native and not gate:
            build(fmus, Path(name) / "fmi3", HOST._replace(fmi=3))
        if not native:
            console.print("without native FMUs: the extra `native` is not installed")
        table = Table("stage", "way", "step (µs)", "of the reference", "of the bare loop", "real time",
                      title="Cost of a communication step, every output recorded")
        for pair in PAIRS:
            times = step_times(pair, folder, native, None if gate else Path(name) / "fmi3")
            for way, time in sorted(times.items(), key=lambda item: item[1]):
                of_c = f"{time / times[FROZEN]:.2f}" if native else ""
                table.add_row(pair.title, way, f"{1e6 * time:.2f}", of_c, f"{time / times['bare Python loop']:.2f}",
                              f"{pair.dt / time:.1f} ×")
            too_slow += [f"{pair.title}, {way}: {ratio:.2f}, expected at most {GATES[way]}"
                         for way, ratio in too_large(times).items()]
        console.print(table)
        if native and not gate:
            for pair in PAIRS:
                bytes_more = growth(pair, folder)
                console.print(f"{pair.title}: {bytes_more} bytes more after {MEMORY_STEPS:.0e} samples of the loop")
                if bytes_more > LARGEST_GROWTH:
                    too_slow.append(f"{pair.title}: memory grew by {bytes_more} bytes, expected at most "
                                    f"{LARGEST_GROWTH}")
    for line in too_slow:
        console.print(line)
    return 1 if gate and too_slow else 0


if __name__ == "__main__":
    sys.exit(main())
