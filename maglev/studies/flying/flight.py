"""One scenario flown again and again in one process: loaded and wired once, reset between, arrays used again."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from maglev.cosim.master import FmuSetup, Master, whole_steps
from maglev.cosim.stepping import StepFailed, Stepper
from maglev.cosim.wiring import Wiring, wire
from maglev.errors import FmuError
from maglev.experiment.preparation import Experiment, is_foreign
from maglev.schema.settings import REFERENCE, read_setting, with_references

Changes = Mapping[str, float | bool]   # start values `fmu.variable`, and references `reference.AXIS.amplitude`

ROWS_AT_A_TIME = 512   # of a recording that is transposed: as much as a processor's nearest cache holds


class Flight:
    """An experiment to be flown many times with other start values; a context manager that frees its FMUs.

    Each flight gives, bit for bit, what the experiment gives that is prepared with the same values: FMUs of this
    project are as new after fmi2Reset. Those of others, and all after a refusal, are loaded anew.
    """

    def __init__(self, experiment: Experiment):
        self.experiment = experiment
        self.descriptions = experiment.check()
        self.steps = whole_steps(experiment.plan.stop_time, experiment.step)
        self.time = experiment.step * np.arange(self.steps + 1, dtype=np.float64)
        self.resettable = not any(map(is_foreign, experiment.files.values()))
        self.drives = experiment.drives(self.descriptions)
        self.recorded: dict[str, NDArray[np.float64]] = {}
        self.master: Master | None = None
        self.wiring: Wiring | None = None
        self.flown = False        # since the FMUs were loaded
        self.redriven = False     # the references are not those of the experiment

    def __enter__(self) -> "Flight":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the FMUs; the next flight loads them again."""
        if self.master is not None:
            self.master.__exit__()
        self.master = self.wiring = None

    def load(self) -> tuple[Master, Wiring]:
        """FMUs and calls, loaded and wired if they are not yet."""
        if self.master is None or self.wiring is None:
            plan, experiment = self.experiment.plan, self.experiment
            setups = [FmuSetup(name, path, {}, experiment.ports.get(name)) for name, path in experiment.files.items()]
            self.master = Master(setups, list(plan.wires.values()), experiment.step, experiment.order)
            self.wiring = wire(self.master.fmus, self.master.connections, self.drives, self.steps + 1, experiment.step,
                               experiment.order)
            self.flown = self.redriven = False
        return self.master, self.wiring

    def fly(self, changes: Changes) -> dict[str, NDArray[np.float64]]:
        """Fly with other values; columns by name as of a `Recording`, shape (n,), which the next flight overwrites.

        Raises
        ------
        MaglevError
            If an FMU refuses a value or a step; the message says when.
        """
        try:
            columns = self.flown_with(changes)
        except BaseException:
            self.close()
            raise
        if not self.resettable:
            self.close()
        return columns

    def flown_with(self, changes: Changes) -> dict[str, NDArray[np.float64]]:
        """Reset, initialise and step the FMUs."""
        master, wiring = self.load()
        self.drive(wiring, changes)
        for name, fmu in master.fmus.items():
            if self.flown:
                assert fmu.instance is not None
                fmu.instance.reset()
            start = {variable: value.value for variable, value in self.experiment.plan.fmus[name].start.items()}
            own = {full.partition(".")[2]: value for full, value in changes.items() if full.startswith(f"{name}.")}
            fmu.initialise({**start, **own}, 0.0, self.experiment.plan.stop_time)
        self.flown = True
        for call in wiring.initial:
            call.at(0)
        folders = dict.fromkeys(parent for path in self.experiment.files.values() for parent in path.parents[:2])
        stepper = Stepper(wiring.phases, folders)
        try:
            stepper.step_over(0, self.steps)
        except StepFailed as error:
            raise FmuError(f"at t = {error.step * master.step:.9g} s: {error.reason}") from error
        return self.columns(wiring)

    def drive(self, wiring: Wiring, changes: Changes) -> None:
        """Put the references of a flight into the rows that the FMUs read."""
        varied = any(name.startswith(f"{REFERENCE}.") or name in self.drives for name in changes)
        if not varied and not self.redriven:
            return
        drives = self.drives
        if varied:
            drives = self.with_changes(changes).drives(self.descriptions)
        for track in wiring.tracks:
            if all(name in drives for name in track.names):
                for column, name in enumerate(track.names):
                    track.array[:, column] = drives[name]
        self.redriven = varied

    def with_changes(self, changes: Changes) -> Experiment:
        """The experiment with other references."""
        plan, about_fmus, _ = with_references(self.experiment.plan, [f"{name}={value!r}" for name, value
                                                                      in changes.items()])
        fmus = dict(plan.fmus)
        for setting in about_fmus:
            name, variable, value = read_setting(setting)
            fmus[name] = fmus[name].model_copy(update={"start": {**fmus[name].start, variable: value}})
        return replace(self.experiment, plan=plan.model_copy(update={"fmus": fmus}))

    def columns(self, wiring: Wiring) -> dict[str, NDArray[Any]]:
        """What was recorded, column by column: what is measured reads each of them several times."""
        for track in wiring.tracks:
            key = track.names[0]
            if key not in self.recorded:
                self.recorded[key] = np.empty((len(track.names), self.steps + 1))
            columns = self.recorded[key]
            for row in range(0, self.steps + 1, ROWS_AT_A_TIME):
                columns[:, row:row + ROWS_AT_A_TIME] = track.array[row:row + ROWS_AT_A_TIME].T
        return {name: self.recorded[track.names[0]][i] for track in wiring.tracks
                for i, name in enumerate(track.names)}
