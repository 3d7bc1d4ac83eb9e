"""Cost of a communication step: the pythonfmu pair under the master, against a bare Python loop over the same blocks.

Both record every output at every step. The bare loop has no layer between the blocks: it assigns attributes and appends
the outputs to an array. Times depend on the machine; the ratio is what `--gate` judges.
"""

import argparse
import sys
import tempfile
from array import array
from collections.abc import Sequence
from operator import attrgetter
from pathlib import Path
from time import perf_counter
from typing import Any

from rich.console import Console
from rich.table import Table

from controller_fmu.regulator_2dof import Regulator2DOF
from controller_fmu.regulator_3dof import Regulator3DOF
from plant_fmu.stage_2dof import Stage2DOF
from plant_fmu.stage_3dof import Stage3DOF
from scenarios.catalogue import build, definition
from scenarios.master import Master, Participant

LARGEST_RATIO = 1.7
STEPS = 5000
ROUNDS = 7   # of both loops in turn; the fastest of each counts, which is the least disturbed

PAIRS = {
    "2-DOF": (Regulator2DOF, "Regulator2DOF", Stage2DOF, "Plant2DOF", ("v", "h"), ("motor",), 0.5e-3),
    "3-DOF": (Regulator3DOF, "Regulator3DOF", Stage3DOF, "Plant3DOF", ("y", "x", "z"), ("alpha", "beta"), 0.2e-3),
}
PHASES = ("i_a_cmd", "i_b_cmd", "i_c_cmd")


def outputs(name: str) -> attrgetter:   # type: ignore[type-arg]
    """Getter of every output of an FMU's block."""
    return attrgetter(*(v.name for v in definition(name).variables if v.causality == "output"))


def bare_loop(controller: Any, controller_name: str, plant: Any, plant_name: str, axes: Sequence[str],
              motors: Sequence[str], dt: float) -> float:
    """Time of one step of the blocks called directly, s."""
    controller.start()
    plant.start()
    measured = [(getattr(controller, axis), getattr(plant, axis)) for axis in axes]
    commands = [(getattr(plant, motor), getattr(controller, motor)) for motor in motors]
    references = [axis for axis, _ in measured]
    row = array("d", [axis.reference for axis in references])
    controller_outputs, plant_outputs = outputs(controller_name), outputs(plant_name)
    record = array("d")
    begin = perf_counter()
    for k in range(STEPS):
        for axis, reference in zip(references, row, strict=True):
            axis.reference = reference
            axis.reference_rate = 0.0
        for to, source in measured:
            to.measured = source.encoder
        controller.step(k * dt, dt)
        record.extend(controller_outputs(controller))
        for to, source in commands:
            to.i_a_cmd = source.i_a_cmd
            to.i_b_cmd = source.i_b_cmd
            to.i_c_cmd = source.i_c_cmd
        plant.step(k * dt, dt)
        record.extend(plant_outputs(plant))
        record.extend(row)
    return (perf_counter() - begin) / STEPS


def master_loop(folder: Path, controller_name: str, plant_name: str, axes: Sequence[str], motors: Sequence[str],
                dt: float, starts: Sequence[float]) -> float:
    """Time of one step of the FMUs under the master, s."""
    connections = [(f"plant.{axis}.encoder", f"controller.{axis}.measured") for axis in axes]
    connections += [(f"controller.{motor}.{phase}", f"plant.{motor}.{phase}") for motor in motors for phase in PHASES]
    drives = {}
    for axis, start in zip(axes, starts, strict=True):
        drives[f"controller.{axis}.reference"] = [start] * (STEPS + 1)
        drives[f"controller.{axis}.reference_rate"] = [0.0] * (STEPS + 1)
    marks: list[float] = []
    with Master([Participant("controller", folder / f"{controller_name}.fmu"),
                 Participant("plant", folder / f"{plant_name}.fmu")], connections, dt) as master:
        # From the first report to the last: loading, wiring and initialization are no part of a step.
        master.run(STEPS * dt, drives, lambda done, _: marks.append(perf_counter()))
    return (marks[-1] - marks[0]) / (STEPS * (len(marks) - 1) / len(marks))


def measure(folder: Path) -> list[tuple[str, float, float, float]]:
    """For each stage: name, bare time (s), time under the master (s), communication step (s)."""
    rows = []
    for stage, (regulator, controller_name, plant_block, plant_name, axes, motors, dt) in PAIRS.items():
        starts = [getattr(plant_block(), axis).position_start for axis in axes]
        bare, master = [], []
        for _ in range(ROUNDS):
            bare.append(bare_loop(regulator(), controller_name, plant_block(), plant_name, axes, motors, dt))
            master.append(master_loop(folder, controller_name, plant_name, axes, motors, dt, starts))
        rows.append((stage, min(bare), min(master), dt))
    return rows


def main() -> int:
    """Print the table; with --gate, return 1 if a ratio is too large."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--gate", action="store_true", help=f"fail if a ratio is above {LARGEST_RATIO}")
    gate = parser.parse_args().gate
    with tempfile.TemporaryDirectory() as folder:
        build([name for pair in PAIRS.values() for name in (pair[1], pair[3])], Path(folder))
        rows = measure(Path(folder))
    table = Table("stage", "step (ms)", "bare loop (µs)", "FMUs, master (µs)", "ratio", "real time, bare",
                  "real time, FMUs", title="Cost of a communication step, every output recorded")
    for stage, bare, master, dt in rows:
        table.add_row(stage, f"{1e3 * dt:g}", f"{1e6 * bare:.1f}", f"{1e6 * master:.1f}", f"{master / bare:.2f}",
                      f"{dt / bare:.1f} ×", f"{dt / master:.1f} ×")
    Console(width=110).print(table)
    too_slow = [f"{stage}: {master / bare:.2f}" for stage, bare, master, _ in rows if master / bare > LARGEST_RATIO]
    if too_slow:
        print(f"ratio above {LARGEST_RATIO}: {', '.join(too_slow)}")
    return 1 if gate and too_slow else 0


if __name__ == "__main__":
    sys.exit(main())
