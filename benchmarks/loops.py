"""What the gated benchmarks share: ways to run a pair of blocks or FMUs, rounds in which all are measured, options.

All ways set references, pass measurements and currents, and record every output at every step; each gives the time of
one step, s.
"""

import argparse
import ctypes
import lzma
import sys
import tempfile
from array import array
from collections.abc import Callable, Mapping
from pathlib import Path
from time import perf_counter
from typing import NamedTuple

from maglev.analysis.participant import Participant
from maglev.cosim.master import FmuSetup, Master
from maglev.descriptions.own_fmus import definition
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.fmi.compiler import compiled
from maglev.fmi.definition import reader
from maglev.fmi.native_build import host_platform
from maglev.user.scenario_loop import loop_table
from pmlsm.stage_description import StageDescription

ROUNDS = 7   # the fastest counts, which is the least disturbed
ENOUGH = 3   # for the gate, if none of them has a ratio that is too large: then the fastest have none

TooLarge = Callable[[Mapping[str, float]], dict[str, float]]   # by way, ratios above their limits

FROZEN = "reference implementation"
FOLDER = Path(__file__).with_name("reference")
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", "-fvisibility=hidden", "-fno-sanitize=all", "-g0", "-shared", "-fPIC",
         "-lm")   # as they were then, too


class Pair(NamedTuple):
    """A controller and a plant, and how they are connected."""

    title: str
    controller: str
    plant: str
    loop: str
    stage: StageDescription

    @property
    def dt(self) -> float:
        """Communication step, s."""
        return self.stage.sample_time

    @property
    def starts(self) -> list[float]:
        """Start positions, which are the references, m."""
        block = definition(self.plant).new_block()
        return [block.axes[self.stage.axis_number(axis)].position_start for axis in self.stage.axis_names]

    @property
    def connections(self) -> list[tuple[str, str]]:
        """From outputs to inputs."""
        return [(source, to) for source, to in loop_table(self.stage)["connections"]]


PAIRS = tuple(Pair(stage.suffix.replace("DOF", "-DOF"), f"Regulator{stage.suffix}", f"Plant{stage.suffix}",
                   f"ClosedLoop{stage.suffix}", stage) for stage in PACKAGED_STAGES.values())


def bare_loop(pair: Pair, steps: int) -> float:
    """The block of the closed loop in Python, called at every sample: no layer around it."""
    of_loop = definition(pair.loop)
    loop = of_loop.new_block()
    loop.start()
    outputs = reader([v.place for v in of_loop.variables if v.causality == "output"])
    record = array("d")
    dt = pair.dt
    begin = perf_counter()
    for k in range(steps):
        loop.step(k * dt, dt)
        record.extend(outputs(loop))
    return (perf_counter() - begin) / steps


def master_loop(pair: Pair, folder: Path, steps: int, plant: Path | None = None) -> float:
    """The FMUs of a folder under our master, or another plant than that of the folder."""
    drives = {}
    for axis, start in zip(pair.stage.axis_names, pair.starts, strict=True):
        drives[f"controller.{axis}.reference"] = [start] * (steps + 1)
        drives[f"controller.{axis}.reference_rate"] = [0.0] * (steps + 1)
    marks: list[tuple[int, float]] = []
    with Master([FmuSetup("controller", folder / f"{pair.controller}.fmu"),
                 FmuSetup("plant", plant or folder / f"{pair.plant}.fmu")], pair.connections, pair.dt) as master:
        # From the first report to the last: loading, wiring and initialization are no part of a step.
        master.run(steps * pair.dt, drives, lambda done, _: marks.append((done, perf_counter())))
    (first, begin), (last, end) = marks[0], marks[-1]
    return (end - begin) / (last - first)


def open_loop(pair: Pair, path: Path) -> Participant:
    """The closed loop in one FMU, initialised: each step is a second, and takes its references."""
    axes = pair.stage.axis_names
    return Participant(FmuSetup("loop", path), [f"{axis}.reference" for axis in axes],
                       [f"plant.{axis}.position" for axis in axes], 1.0)


def loop_fmu(pair: Pair, path: Path, seconds: int) -> float:
    """The closed loop in one FMU, one call for each second."""
    references = pair.starts
    with open_loop(pair, path) as loop:
        loop.step(references)
        begin = perf_counter()
        for _ in range(seconds):
            loop.step(references)
        return (perf_counter() - begin) / seconds * pair.dt


def reference_loop(pair: Pair, steps: int) -> Callable[[], float]:
    """One C loop over controller and plant as they were when sines came from the C library: the unit of all ratios.

    It is frozen, so that blocks that become faster do not make everything around them look slower. The folder
    `reference` has C that a translator of Python made of the blocks of commit eb32d8e, and for each stage a loop over
    them, which does what a master does: references, which are constant, measurements, controller, currents, plant, and
    a record.
    """
    text = lzma.decompress((FOLDER / f"{pair.stage.name}.c.xz").read_bytes()).decode("utf-8")
    platform = next(iter(host_platform().values()))
    with tempfile.TemporaryDirectory() as folder:
        name = f"{pair.stage.name}{platform.ending}"
        (Path(folder) / "loop.c").write_text(text, encoding="utf-8")
        compiled(Path(folder), [*FLAGS, "-target", platform.targets[0], "-o", name, "loop.c"])
        library = ctypes.CDLL(str(Path(folder) / name))
    run = library["run"]
    run.argtypes = [ctypes.c_int, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p]
    record = (ctypes.c_double * (steps * text.count("*record++")))()
    given = (ctypes.c_double * len(pair.starts))(*pair.starts)

    def measure() -> float:
        begin = perf_counter()
        if run(steps, pair.dt, given, record) != 0:
            sys.exit("the C loop was refused a step")
        return (perf_counter() - begin) / steps

    return measure


def read_arguments(about: str | None, gates: Mapping[str, float]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=about)
    parser.add_argument("--gate", action="store_true", help=f"only what is gated; fail if a ratio exceeds {gates}")
    parser.add_argument("--fmus", type=Path, help="folder of FMUs that are built, in its folders python and native")
    return parser.parse_args()


def fastest(ways: Mapping[str, Callable[[], float]], too_large: TooLarge, gate: bool,
            repeats: Mapping[str, int] | None = None) -> dict[str, float]:
    """Shortest time (s) of each way, measured in turn, so that a disturbance meets all of them.

    Some are measured several times in a round. For the gate a few rounds do, if each holds the limits.
    """
    times: dict[str, list[float]] = {name: [] for name in ways}
    held = 0
    for done in range(1, ROUNDS + 1):
        of_round = {name: min(way() for _ in range((repeats or {}).get(name, 1))) for name, way in ways.items()}
        for name, time in of_round.items():
            times[name].append(time)
        held += not too_large(of_round)
        if gate and held == done == ENOUGH:
            break
    return {name: min(taken) for name, taken in times.items()}
