"""Instances of FMI 3.0 FMUs under fmpy: by plain steps, with event mode, and with a clock."""

import ctypes
from collections.abc import Callable
from functools import lru_cache, partial
from pathlib import Path
from typing import Any

import fmpy
import pytest
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Slave
from fmpy.model_description import ModelDescription

SAMPLE = 2e-4   # s

AMPLITUDES = {"A": 0.5, "N": 2.0, "m": 1e-4, "m/s": 1e-3}   # of inputs, by their units


def unpacked(fmu: Path, folder: Path) -> Path:
    """Folder of an FMU's files, for instances of one library."""
    return Path(fmpy.extract(str(fmu), str(folder / fmu.stem)))


@lru_cache
def described(folder: Path) -> ModelDescription:
    """Model description in the folder of an FMU's files."""
    return fmpy.read_model_description(str(folder))


class Instance:
    """An instance of an unpacked FMU, and what it says; its number tells its inputs from those of others."""

    def __init__(self, folder: Path, early: bool = True, events: bool = True, number: int = 0):
        description = described(folder)
        self.variables = description.modelVariables
        self.references = {v.name: v.valueReference for v in self.variables}
        self.outputs = [v.valueReference for v in self.variables if v.type == "Float64" and v.causality == "output"]
        self.events, self.number = events, number
        self.said: list[str] = []
        self.fmu = FMU3Slave(guid=description.guid, unzipDirectory=str(folder), modelIdentifier=description.modelName,
                             instanceName=f"number {number}")
        self.fmu.instantiate(eventModeUsed=events, earlyReturnAllowed=early,
                             logMessage=lambda *message: self.said.append(message[-1].decode()))

    def begin(self, start: float = 0.0) -> "Instance":
        """Go through the initialization."""
        self.fmu.enterInitializationMode(startTime=start, stopTime=start + 1.0)
        self.fmu.exitInitializationMode()
        return self

    def measure(self, gap: float) -> None:
        """Give the gap (m) to a regulator."""
        self.fmu.setFloat64([self.references["y.measured"]], [gap])

    def command(self) -> float:
        """A current (A) that a regulator commands."""
        return float(self.fmu.getFloat64([self.references["alpha.i_d_cmd"]])[0])

    def tick(self) -> None:
        """Activate the clock."""
        self.fmu.setClock([self.references["clock"]], [True])

    def interval(self) -> tuple[float, int]:
        """Interval of the clock (s), and its qualifier."""
        value, qualifier = (ctypes.c_double * 1)(), (ctypes.c_int * 1)()
        self.fmu.getIntervalDecimal((ctypes.c_uint32 * 1)(self.references["clock"]), value, qualifier)
        return value[0], qualifier[0]

    def refusal(self, call: Callable[[], object]) -> str:
        """Message of a call that is refused."""
        with pytest.raises(FMICallException):
            call()
        return self.said[-1]

    def state(self) -> bytes:
        """The whole state."""
        state = self.fmu.getFMUState()
        data: bytes = self.fmu.serializeFMUState(state)
        self.fmu.freeFMUState(state)
        return data

    def calls(self, k: int) -> list[Callable[[], Any]]:
        """What an importer calls from sample k to the next one; inputs jump at each."""
        inputs = [v for v in self.variables if v.type == "Float64" and v.causality == "input"]
        give = partial(self.fmu.setFloat64, [v.valueReference for v in inputs], [
            float(v.start) + AMPLITUDES.get(v.unit, 0.0) * ((k * (i + 3)) % 7 - 3) / (3 + self.number)
            for i, v in enumerate(inputs)])
        take = partial(self.fmu.getFloat64, self.outputs)
        if not self.events:
            return [give, partial(self.fmu.doStep, k * SAMPLE, SAMPLE), take]
        return [*([self.tick] if "clock" in self.references else []), give, take, self.fmu.updateDiscreteStates,
                self.fmu.enterStepMode, partial(self.fmu.doStep, k * SAMPLE, SAMPLE / 2),
                partial(self.fmu.doStep, (k + 0.5) * SAMPLE, SAMPLE / 2), self.fmu.enterEventMode]

    def run(self, first: int, count: int) -> list[Any]:
        """Go over samples; what the calls return."""
        return [call() for k in range(first, first + count) for call in self.calls(k)]
