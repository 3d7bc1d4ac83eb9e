"""A controller on a Cortex-M7 that QEMU emulates, exchanged with sample by sample."""

import os
import select
import shutil
import subprocess
import tempfile
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import MaglevError

PROGRAM = "qemu-system-arm"
MACHINE = "mps2-an500"
MISSING = f"{PROGRAM} is not installed: apt-get install qemu-system-arm"

# Instructions are counted by the machine's timer: 1024 ns pass with each of them. Standard input and output are the
# converters of the board (maglev/fmi/target/qemu/board_qemu.c).
OPTIONS = ("-machine", MACHINE, "-display", "none", "-monitor", "none", "-serial", "none", "-semihosting-config",
           "enable=on,target=native", "-icount", "shift=10", "-kernel")

PATIENCE = 10.0   # s, for a process to end

DOUBLE = np.dtype("<f8")


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
