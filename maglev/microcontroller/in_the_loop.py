"""Processor in the loop: the emulated controller takes its place in a run, as an FMU would."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from fmpy.model_description import ModelDescription

from fmi_export.definition import FmuDefinition
from fmi_export.slave import Refused
from fmi_export.target.freestanding import REFUSED_VALUE, ports_of
from maglev.cosim.fmu import Fmu
from maglev.cosim.master import Master, Progress, Recording
from maglev.cosim.port_map import Scale
from maglev.cosim.user_classes.fmu import InProcessFmu
from maglev.experiment.preparation import Experiment
from maglev.microcontroller.emulator import Answer, Emulator, EmulatorError


class Emulated:
    """A controller in an emulator, with the functions of a slave: references are numbers of its variables."""

    def __init__(self, definition: FmuDefinition, emulator: Emulator):
        self.definition, self.emulator = definition, emulator
        settable, readable = ports_of(definition)
        number = {v.name: k for k, v in enumerate(definition.variables)}
        self.settable = {number[v.name]: k for k, v in enumerate(settable)}
        self.readable = {number[v.name]: k for k, v in enumerate(readable)}
        self.values = np.array([float(definition.start_value(v)) for v in settable])
        self.sample_time = 0.0
        self.answers: list[Answer] = []   # at the start, and of each sample

    def setup_experiment(self, start_time: float, stop_time: float | None = None) -> None:
        """Take in the start time (s): a microcontroller begins at 0."""
        if start_time != 0.0:
            raise Refused(f"start time = {start_time} s, expected 0.0 s")

    def enter_initialization_mode(self) -> None:
        """Nothing is to be done."""

    def exit_initialization_mode(self) -> None:
        """Give parameters and inputs, and start."""
        self.sample_time = float(self.values[next(
            k for k, v in enumerate(ports_of(self.definition).settable) if v.name == "sample_time")])
        self.exchange()

    def do_step(self, time: float, step: float) -> None:
        """Take a sample, at a time (s) that it counts itself."""
        if step != self.sample_time:
            raise Refused(f"communication step = {step} s, expected sample_time = {self.sample_time} s: a "
                          "microcontroller knows no other")
        self.exchange()

    def terminate(self) -> None:
        """Nothing is to be done: the emulator ends with whoever started it."""

    def exchange(self) -> None:
        """Give what is set, and take what comes back."""
        try:
            answer = self.emulator.exchange(self.values)
        except EmulatorError as error:
            raise Refused(str(error)) from error
        if answer.status:
            raise Refused(self.refusal(answer.status))
        self.answers.append(answer)

    def refusal(self, status: int) -> str:
        if status in self.definition.refusals:
            return self.definition.refusals[status]
        number = status - REFUSED_VALUE
        v = self.definition.variables[number]
        value = f"{self.values[self.settable[number]]} {v.unit}".rstrip()
        return f"{v.name} = {value}, expected a number within its range"

    def set_real(self, references: list[int], values: list[float]) -> None:
        """Set inputs and parameters, for the next sample."""
        for reference, value in zip(references, values, strict=True):
            self.values[self.settable[reference]] = value

    def get_real(self, references: list[int]) -> list[float]:
        """Read outputs, of the last sample, and what was set."""
        return [float(self.answers[-1].outputs[self.readable[reference]] if reference in self.readable
                      else self.values[self.settable[reference]]) for reference in references]

    def set_boolean(self, references: list[int], values: list[bool]) -> None:
        self.set_real(references, [float(value) for value in values])

    def get_boolean(self, references: list[int]) -> list[bool]:
        return [value != 0.0 for value in self.get_real(references)]


class EmulatedFmu(InProcessFmu):
    """An emulated controller with the face of the FMU that it stands for."""

    def __init__(self, name: str, path: Path, description: ModelDescription, scales: Mapping[str, Scale], *,
                 emulated: Emulated):
        self.emulated = emulated
        super().__init__(name, path, description, scales)

    def made(self) -> Emulated:
        return self.emulated


def in_the_loop(experiment: Experiment, place: str, emulated: Emulated,
                progress: Progress | None = None) -> Recording:
    """Run an experiment with an emulated controller in the place of one of its FMUs."""
    drives = experiment.drives(experiment.check())

    def opened(name: str, path: Path, description: ModelDescription, scales: Mapping[str, Scale]) -> Fmu:
        return EmulatedFmu(name, path, description, scales, emulated=emulated)

    with Master(experiment.setups(), experiment.connections, experiment.step, experiment.order, loop=experiment.loop,
                opened={place: opened}) as master:
        return master.run(experiment.plan.stop_time, drives, progress)
