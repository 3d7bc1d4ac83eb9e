"""Processor in the loop: an emulated controller in a run, in the role of an FMU, and its costs."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from maglev.analysis.emulator import MACHINE, Answer, Emulator, EmulatorError, emulator_version
from maglev.analysis.image import linked
from maglev.cosim.master import Master, Recording
from maglev.cosim.user_class import InProcessFmu
from maglev.files.arrays import Array
from maglev.files.errors import FmuError
from maglev.files.side_by_side import Progress
from maglev.fmi.definition import SAMPLE_TIME, FmuDefinition, look, put
from maglev.fmi.freestanding import ports_of
from maglev.fmi.slave import RUNNING, BlockSlave, Refused
from maglev.runs.preparation import Experiment


class Emulated(BlockSlave):
    """The slave of a controller whose start and samples an emulator computes: the block here has the values of both."""

    def __init__(self, definition: FmuDefinition, emulator: Emulator):
        super().__init__(definition, instance_name=definition.name)
        self.emulator = emulator
        self.settable, self.readable = ([v.slot(self.block) for v in ports] for ports in ports_of(definition))
        self.sample_time = 0.0            # s
        self.answers: list[Answer] = []   # at the start, and of each sample

    @property
    def values(self) -> Array:
        """Return the values for a sample, shape (settable variables,)."""
        return np.array([float(look(*slot)) for slot in self.settable])

    def setup_experiment(self, start_time: float, stop_time: float | None = None, *_: Any) -> None:
        if start_time != 0.0:
            raise Refused(f"start time = {start_time} s, expected 0.0 s")

    def refresh(self) -> None:
        """An emulator has no outputs before it has all parameters and inputs, and starts."""

    def exit_initialization_mode(self) -> None:
        """Give parameters and inputs, which are checked there, and start."""
        sampling, = (v for v in self.variables if v.name == SAMPLE_TIME)
        self.sample_time = float(sampling.read(self.block))
        self.exchange()
        self.phase, self.stale = RUNNING, False

    def do_step(self, current_time: float, step_size: float) -> bool:
        """Take a sample, at a time (s) that it counts itself."""
        if step_size != self.sample_time:
            raise Refused(f"communication step = {step_size} s, expected sample_time = {self.sample_time} s: the code "
                          "of the microcontroller has this sample time")
        self.exchange(current_time, step_size)
        return True

    def exchange(self, time: float = 0.0, step: float = 0.0) -> None:
        """Give what is set, and take what comes back."""
        try:
            answer = self.emulator.exchange(self.values)
        except EmulatorError as error:
            raise Refused(str(error)) from error
        self.refuse(answer.status, time, step)
        for (owner, name), value in zip(self.readable, answer.outputs.tolist(), strict=True):
            put(owner, name, type(look(owner, name))(value))
        self.answers.append(answer)


def in_the_loop(experiment: Experiment, place: str, emulated: Emulated,
                progress: Progress | None = None) -> Recording:
    """Run an experiment with an emulated controller in the place of one of its FMUs."""
    drives = experiment.drives(experiment.check())
    with Master(experiment.setups(), experiment.connections, experiment.step, experiment.order, loop=experiment.loop,
                opened={place: partial(InProcessFmu, slave=emulated)}) as master:
        return master.run(experiment.plan.stop_time, drives, progress)


@dataclass(frozen=True)
class Measured:
    """The costs of a controller on a Cortex-M7, whose signals are those of the run on this machine."""

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
        """Return it in JSON form, SI."""
        return asdict(self) | {"time": self.time}

    def __str__(self) -> str:
        share = 100.0 * self.time / self.sample_time
        rows = {
            "flash": f"{1e-3 * self.flash:.1f} kB, with the example and the compiler's own code",
            "RAM": f"{1e-3 * self.ram:.1f} kB, and {1e-3 * self.stack:.1f} kB of stack at its deepest",
            "instructions": f"{self.least} to {self.most} a sample, {self.mean:.0f} in the mean; {self.start} at the "
                            "start",
            "estimate": f"{1e6 * self.time:.1f} µs of {1e6 * self.sample_time:g} µs, {share:.1f} %, at "
                        f"{1e-6 * self.clock:g} MHz and {self.cycles:g} cycles an instruction",
            "bits": f"{self.columns} signals at {self.samples + 1} times of {self.run} are those of this machine"}
        head = f"{self.controller} on a Cortex-M7 ({self.emulator}, {self.compiler})"
        return "\n".join([head, *(f"  {name:14}{text}" for name, text in rows.items())]) + "\n"


def on_target(controller: FmuDefinition, files: Mapping[str, str], experiment: Experiment, place: str, folder: Path,
              clock: float, cycles: float, timeout: float, progress: Progress = lambda done, steps: None) -> Measured:
    """Run an experiment as it is, and again with a controller on an emulated Cortex-M7 in its place.

    `files` are its C; `place` is the name in the experiment of the same controller as an FMU or a Python file; the
    executable is made in `folder`. With the clock, Hz, cycles of an instruction, and the longest time for an answer, s.
    MaglevError if either run ends early, or one value of a signal has other bits.
    """
    image = linked(controller.name, files, folder)
    here = experiment.run(lambda done, steps: progress(done, 2 * steps))
    outputs = sum(v.causality == "output" for v in controller.variables)
    with Emulator(image.path, outputs, timeout) as emulator:
        emulated = Emulated(controller, emulator)
        there = in_the_loop(experiment, place, emulated, lambda done, steps: progress(steps + done, 2 * steps))
    first, *samples = emulated.answers
    counts = np.array([answer.instructions for answer in samples])
    return Measured(
        controller.name, experiment.plan.name, image.flash, image.ram, max(sample.stack for sample in samples),
        int(counts.min()), float(counts.mean()), int(counts.max()), first.instructions, len(counts),
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
