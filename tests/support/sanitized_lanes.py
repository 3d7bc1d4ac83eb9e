"""Runs side by side in a loop compiled with sanitizers: `python sanitized_lanes.py WIDTH FMUS` prints a digest of each.

The process must have loaded the address sanitizer before Python.
"""

import hashlib
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from unittest.mock import patch

import numpy as np

from maglev.cosim import lane_loop
from maglev.cosim.lane_loop import LaneLoop, Taken, Vectors
from maglev.fmi.compiler import UNIT, Platform, in_one_unit
from maglev.many.repeated_run import Changes, RepeatedRun
from maglev.runs.measuring import Found, Measuring
from maglev.runs.preparation import prepare
from maglev.scenario.loading import load_plan

SANITIZERS = ("-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
RUN = "2dof-laws-nonlinear"
NOT_A_NUMBER = 3   # the run that is given one after a third of its steps
# Masses too light for a stiff stop are refused, at different times; others trip at once or late, or touch a stop. One
# never begins, after which all FMUs are loaded again.
VALUES = [(4.35, 0.1, 1.0e6, 0.02), (0.001, 0.1, 1.0e8, 0.02), (5.0, 1.0e-4, 1.0e6, 0.02), (4.4, 0.1, 1.0e6, 0.02),
          (0.003, 0.1, 1.0e8, 0.015), (4.3, 0.1, 1.0e6, 1.0), (4.2, 2.0e-3, 1.0e6, 0.021), (9.0, 0.1, 1.0e6, 0.024),
          (0.002, 0.1, 1.0e8, 0.024), (4.0, 0.02, 2.0e6, 0.018), (4.5, 0.1, 1.0e6, 0.02)]


def sanitized(sources: Mapping[str, str], name: str, _platform: Platform) -> bytes:
    """Library of C files, compiled by gcc with sanitizers."""
    with in_one_unit(sources, name) as root:
        subprocess.run(["gcc", "-std=c99", "-w", "-ffp-contract=off", "-DBLOCKS_IN_ONE_UNIT", "-shared", "-fPIC",
                        *SANITIZERS, UNIT.format(name), "-o", "lanes.so", "-lm"], cwd=root, check=True)
        return (root / "lanes.so").read_bytes()


def main(width: int, fmus: Path) -> None:
    """Print one line for each run: its number, and a digest of its result, or that there is none."""
    experiment = prepare(load_plan(RUN), fmus, {}, {})
    measuring = Measuring(experiment.plan, experiment.times,
                          [axis.position for axis in experiment.plan.axes.values()], 10)
    runs: list[Changes] = [{"plant.v.mass": mass, "controller.trip_error": trip, "plant.v.stop.stiffness": stiffness,
                            "plant.v.position_start": start, "reference.h.amplitude": 1.0 + number}
                           for number, (mass, trip, stiffness, start) in enumerate(VALUES)]
    take, taken_runs = LaneLoop.take, [0]

    def take_and_spoil(loop: LaneLoop, taken: Taken, lane: int) -> int:
        status = take(loop, taken, lane)
        if taken_runs[0] == NOT_A_NUMBER:
            next(iter(taken.signals.values()))[lane, 0, 1007] = np.nan
        taken_runs[0] += 1
        return status

    found: list[object] = []
    with patch.object(lane_loop, "library", sanitized), patch.object(LaneLoop, "take", take_and_spoil), \
            patch.object(lane_loop, "widest", lambda: Vectors(width, "baseline", frozenset())), \
            RepeatedRun(experiment, measuring=measuring) as repeated:
        repeated.widen(runs[0], build=True)
        assert repeated.width == width
        for first in range(0, len(runs), width):
            found += repeated.measure(runs[first:first + width])
    for number, one in enumerate(found):
        print(number, digest(one) if isinstance(one, Found) else "refused" if one is None else "never began")


def digest(found: Found) -> str:
    """SHA-256 of all that was found on a run."""
    state = [(name, values.tobytes()) for name, values in found.state.items()]
    return hashlib.sha256(repr((state, found.kept.tobytes())).encode()).hexdigest()


if __name__ == "__main__":
    main(int(sys.argv[1]), Path(sys.argv[2]))
