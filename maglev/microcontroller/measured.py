"""What a controller takes on a Cortex-M7, measured in an emulator over a whole run, and told."""

from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from maglev.cosim.master import Progress, Recording
from maglev.errors import FmuError
from maglev.experiment.preparation import Experiment
from maglev.microcontroller.emulator import MACHINE, Emulator, emulator_version
from maglev.microcontroller.generation import Generated
from maglev.microcontroller.image import linked
from maglev.microcontroller.in_the_loop import Emulated, in_the_loop


@dataclass(frozen=True)
class Measured:
    """What a controller takes on a Cortex-M7, and that it gives there what the run on this machine gives."""

    controller: str
    run: str
    flash: int   # bytes: code and constants with the example over the controller
    ram: int   # bytes that it keeps
    stack: int   # bytes, the deepest
    least: int   # instructions of a sample, as the next two
    mean: float
    most: int
    start: int   # instructions of the computations at the start
    samples: int
    columns: int   # signals of the run, of plant and controller, that have the same bits at every sample
    sample_time: float   # s
    compiler: str   # with its version, as the next one
    emulator: str
    clock: float   # Hz, assumed
    cycles: float   # of an instruction, assumed

    @property
    def time(self) -> float:
        """Estimated time of the longest sample, s."""
        return self.most * self.cycles / self.clock

    def as_data(self) -> dict[str, Any]:
        """The same as JSON has it, SI."""
        return asdict(self) | {"time": self.time}

    def __str__(self) -> str:
        share = 100.0 * self.time / self.sample_time
        rows = {
            "flash": f"{1e-3 * self.flash:.1f} kB, with the example and what the compiler adds",
            "RAM": f"{1e-3 * self.ram:.1f} kB, and {1e-3 * self.stack:.1f} kB of stack at its deepest",
            "instructions": f"{self.least} to {self.most} a sample, {self.mean:.0f} in the mean; {self.start} at the "
                            "start",
            "estimate": f"{1e6 * self.time:.1f} µs of {1e6 * self.sample_time:g} µs, {share:.1f} %, at "
                        f"{1e-6 * self.clock:g} MHz and {self.cycles:g} cycles an instruction",
            "bits": f"{self.columns} signals at {self.samples + 1} times of {self.run} are those of this machine"}
        head = f"{self.controller} on a Cortex-M7 ({self.emulator}, {self.compiler})"
        return "\n".join([head, *(f"  {name:14}{text}" for name, text in rows.items())]) + "\n"


def measured(generated: Generated, experiment: Experiment, place: str, folder: Path, clock: float, cycles: float,
             timeout: float, progress: Progress = lambda done, steps: None) -> Measured:
    """Run an experiment as it is, and again with a controller on an emulated Cortex-M7 in its place.

    `place` is the name in the experiment of the same controller as an FMU or a Python file; the executable is made in
    `folder`. With the clock, Hz, cycles of an instruction, and the longest time for an answer, s. MaglevError if either
    run ends early, or one value of a signal has other bits.
    """
    image = linked(generated.definition.name, generated.files, folder)
    here = experiment.run(lambda done, steps: progress(done, 2 * steps))
    outputs = sum(v.causality == "output" for v in generated.definition.variables)
    with Emulator(image.path, outputs, timeout) as emulator:
        emulated = Emulated(generated.definition, emulator)
        there = in_the_loop(experiment, place, emulated, lambda done, steps: progress(steps + done, 2 * steps))
    first, *samples = emulated.answers
    counts = np.array([answer.instructions for answer in samples])
    return Measured(
        generated.definition.name, experiment.plan.name, image.flash, image.ram,
        max(sample.stack for sample in samples), int(counts.min()),
        float(counts.mean()), int(counts.max()), first.instructions, len(counts),
        equal_columns(experiment, here, there), emulated.sample_time, image.compiler,
        f"QEMU {emulator_version()}, {MACHINE}", clock, cycles)


def equal_columns(experiment: Experiment, here: Recording, there: Recording) -> int:
    """Number of signals of two recordings; FmuError where a value of one has other bits."""
    for name, values in here.columns.items():
        own, other = (np.asarray(numbers, np.float64).view(np.uint64) for numbers in (values, there.columns[name]))
        apart = np.flatnonzero(own != other)
        if len(apart):
            k = int(apart[0])
            raise FmuError(f"{experiment.plan.name}: {name} at t = {here.time[k]:.9g} s is {there.columns[name][k]!r} "
                           f"with the controller in the emulator, expected the bits of this machine, {values[k]!r}")
    return len(here.columns)
