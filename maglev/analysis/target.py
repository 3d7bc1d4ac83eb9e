"""A controller on a microcontroller: its C, its executable for a Cortex-M7, and its run there, emulated by QEMU.

zig links the executable. A run has the emulated controller in the role of an FMU, and gives its costs.
"""

import os
import select
import shutil
import struct
import subprocess
import tempfile
from collections.abc import Mapping
from contextlib import nullcontext, suppress
from dataclasses import asdict, dataclass
from functools import partial
from importlib.metadata import version
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from maglev.cosim.fmi_versions import OWN_TOOL
from maglev.cosim.master import Master, Recording
from maglev.cosim.user_class import InProcessFmu
from maglev.descriptions.own_fmus import definition
from maglev.files.arrays import Array
from maglev.files.errors import BuildError, FmuError, MaglevError
from maglev.files.packages import IN_FMUS
from maglev.files.side_by_side import Progress
from maglev.fmi.compiler import compiled, require_zig
from maglev.fmi.definition import SAMPLE_TIME, FmuDefinition, look, put
from maglev.fmi.freestanding import freestanding, ports_of
from maglev.fmi.slave import RUNNING, BlockSlave, Refused
from maglev.language.errors import ExportError
from maglev.runs.preparation import Experiment
from maglev.user.build import Buildable, buildable
from maglev.user.source import PythonFile

# A Cortex-M7 with double precision, and the options that give the bits of the FMU. Each function has a section, so that
# the linker omits unused functions.
FLAGS = ("-target", "thumb-freestanding-eabihf", "-mcpu=cortex_m7+fp_armv8d16", "-std=c99", "-O2", "-ffreestanding",
         "-ffp-contract=off", "-fno-math-errno", "-fno-sanitize=all", "-fno-unwind-tables",
         "-fno-asynchronous-unwind-tables", "-ffunction-sections", "-g0", "-I.", "-Iqemu")
BOARD = "qemu/board_qemu.c"
SCRIPT = "qemu/mps2_an500.ld"

PROGRAM = "qemu-system-arm"
MACHINE = "mps2-an500"
MISSING = f"{PROGRAM} is not installed: apt-get install qemu-system-arm"

# Instructions are counted by the machine's timer: 1024 ns pass with each of them. Standard input and output are the
# converters of the board (maglev/fmi/target/qemu/board_qemu.c).
OPTIONS = ("-machine", MACHINE, "-display", "none", "-monitor", "none", "-serial", "none", "-semihosting-config",
           "enable=on,target=native", "-icount", "shift=10", "-kernel")

PATIENCE = 10.0   # s, for a process to end

DOUBLE = np.dtype("<f8")


def generated(controller: str | Path | PythonFile) -> tuple[FmuDefinition, dict[str, str]]:
    """A controller, by the name of an FMU or in a Python file, and its freestanding C: files by name.

    MaglevError, with file and line, if no controller has the name, or it cannot be translated to C.
    """
    with buildable(controller, native=True) if isinstance(controller, PythonFile) else nullcontext(
            Buildable(definition(str(controller)), {})) as built:
        described = built.definition
        if not described.sampled:
            raise BuildError(f"{controller}: has no sample_time, expected a controller, or another block that samples")
        try:
            return described, freestanding(described, IN_FMUS, f"{OWN_TOOL} {version('maglev-fmus')}")
        except ExportError as error:
            raise BuildError(f"{controller}: {error}") from None


@dataclass(frozen=True)
class Image:
    """An executable, and how much of it is the controller with the example over it: bytes of flash and of RAM.

    The board of the emulator is not counted; nor is the stack, which only a run shows.
    """

    path: Path
    flash: int
    ram: int
    compiler: str


def linked(name: str, files: Mapping[str, str], folder: Path) -> Image:
    """Compile and link the files of a controller in a folder; ExportError without ziglang, or where it refuses them."""
    require_zig()
    for file, text in files.items():
        place = folder / file
        place.parent.mkdir(exist_ok=True)
        place.write_text(text, encoding="utf-8", newline="\n")
    compiled(folder, [*FLAGS, "-Wl,--gc-sections", "-Wl,--entry=reset", f"-Wl,--wrap={name}_start",
                      f"-Wl,--wrap={name}_sample", "-T", SCRIPT, f"{name}.c", "main.c", BOARD, "-o", f"{name}.elf"])
    path = folder / f"{name}.elf"
    sizes = sections(path.read_bytes())
    return Image(path, sum(sizes.get(section, 0) for section in (".vectors", ".text", ".data")),
                 sum(sizes.get(section, 0) for section in (".data", ".bss")), f"zig {version('ziglang')} -O2")


def sections(elf: bytes) -> dict[str, int]:
    """Sizes of the sections of an executable in the 32-bit ELF format, bytes, by name."""
    table, = struct.unpack_from("<I", elf, 32)
    size, count, names = struct.unpack_from("<HHH", elf, 46)
    headers = [struct.unpack_from("<10I", elf, table + size * k) for k in range(count)]
    text = headers[names][4]
    return {elf[text + header[0]:elf.index(b"\0", text + header[0])].decode("ascii"): header[5] for header in headers}


class EmulatorError(MaglevError):
    """An emulator that does not run, or does not answer."""


class Answer(NamedTuple):
    """The answer of the emulator: a status, instructions since the values came, the deepest stack until then (bytes),
    outputs.
    """

    status: int
    instructions: int
    stack: int
    outputs: Array   # shape (n,)


def require_emulator() -> str:
    """Return the path of QEMU; EmulatorError with the remedy if it is not installed."""
    path = shutil.which(PROGRAM)
    if path is None:
        raise EmulatorError(MISSING)
    return path


def emulator_version() -> str:
    said = subprocess.run([require_emulator(), "--version"], capture_output=True, text=True, check=True,
                          timeout=PATIENCE).stdout
    return said.split("version ")[-1].split(maxsplit=1)[0]


class Emulator:
    """A running emulator of an executable that gives `outputs` values, each within `timeout`, s; a context manager."""

    def __init__(self, image: Path, outputs: int, timeout: float):
        self.timeout = timeout
        self.size = (3 + outputs) * DOUBLE.itemsize
        self.said = tempfile.TemporaryFile()   # noqa: SIM115  # until the process ends
        self.process = subprocess.Popen([require_emulator(), *OPTIONS, image], stdin=subprocess.PIPE,
                                        stdout=subprocess.PIPE, stderr=self.said, bufsize=0, start_new_session=True)

    def __enter__(self) -> "Emulator":
        return self

    def __exit__(self, *_: object) -> None:
        self.process.kill()
        assert self.process.stdin is not None and self.process.stdout is not None
        with self.said, self.process.stdin, self.process.stdout, suppress(subprocess.TimeoutExpired, BrokenPipeError):
            self.process.wait(PATIENCE)

    def exchange(self, values: Array) -> Answer:
        """Send the values of a sample, shape (m,), and return the answer."""
        assert self.process.stdin is not None and self.process.stdout is not None
        try:
            self.process.stdin.write(values.astype(DOUBLE, copy=False).tobytes())
        except BrokenPipeError:
            raise EmulatorError(self.ended()) from None
        data, file = b"", self.process.stdout.fileno()
        while len(data) < self.size:
            if not select.select([file], [], [], self.timeout)[0]:
                raise EmulatorError(f"{PROGRAM} has been silent for {self.timeout:g} s")
            part = os.read(file, self.size - len(data))
            if not part:
                raise EmulatorError(self.ended())
            data += part
        status, instructions, stack, *_ = numbers = np.frombuffer(data, DOUBLE)
        return Answer(int(status), int(instructions), int(stack), numbers[3:])

    def ended(self) -> str:
        try:
            code = self.process.wait(PATIENCE)
        except subprocess.TimeoutExpired:   # it has closed its output
            return f"{PROGRAM} has closed its output"
        self.said.seek(0)
        words = " ".join(self.said.read().decode("utf-8", "replace").split())
        return f"{PROGRAM} ended with {code}: {words or 'the processor met a fault'}"


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
