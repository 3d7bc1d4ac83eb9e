"""A clocked controller of FMI 3.0 in fmpy: `simulate_fmu` rejects clocks, but other functions can tick them.

    maglev build --kind native --fmi 3 --clocked --target host Plant3DOF Regulator3DOF
    python examples/clocked_fmpy.py fmus/clocked

At each tick the importer enters event mode, activates the clock, sets its inputs, gets its outputs, updates the
discrete states, and returns to step mode, in the order of FMI 3.0.
"""

import ctypes
import shutil
import sys
from collections.abc import Sequence
from pathlib import Path

from fmpy import extract, read_model_description
from fmpy.fmi3 import FMU3Slave

AXES, MOTORS, PHASES = "yxz", ("alpha", "beta"), "abc"
GAP, STEP_TO, STEP_AT = 25e-3, 26e-3, 0.01   # m, m, s


class Instance:
    """An FMU in co-simulation, initialised, whose variables have their names."""

    def __init__(self, path: Path, events: bool):
        description = read_model_description(path)
        self.folder = extract(path)
        self.references = {v.name: v.valueReference for v in description.modelVariables}
        self.clocks = [v.valueReference for v in description.modelVariables if v.type == "Clock"]
        self.fmu = FMU3Slave(guid=description.guid, unzipDirectory=self.folder, instanceName=path.stem,
                             modelIdentifier=description.coSimulation.modelIdentifier)
        self.fmu.instantiate(eventModeUsed=events)
        self.fmu.enterInitializationMode(startTime=0.0)
        self.intervals = []   # s
        for clock in self.clocks:
            interval, qualifier = (ctypes.c_double * 1)(), (ctypes.c_int * 1)()
            self.fmu.getIntervalDecimal((ctypes.c_uint32 * 1)(clock), interval, qualifier)
            self.intervals.append(interval[0])
        self.fmu.exitInitializationMode()
        if events:
            self.to_steps()

    def set(self, names: Sequence[str], values: Sequence[float]) -> None:
        self.fmu.setFloat64([self.references[name] for name in names], list(values))

    def get(self, names: Sequence[str]) -> list[float]:
        return list(self.fmu.getFloat64([self.references[name] for name in names]))

    def tick(self) -> None:
        """Enter event mode with the clocks active."""
        self.fmu.enterEventMode()
        self.fmu.setClock(self.clocks, [True] * len(self.clocks))

    def to_steps(self) -> None:
        """End an event."""
        while self.fmu.updateDiscreteStates()[0]:   # asks for another update
            pass
        self.fmu.enterStepMode()

    def close(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
        shutil.rmtree(self.folder)


def trajectory(folder: Path, stop_time: float) -> list[list[float]]:
    """Positions y, x, z (m) at each sample, with a step of the air gap, to a stop time (s)."""
    controller, plant = (Instance(folder / f"{name}.fmu", events) for name, events in (
        ("Regulator3DOF", True), ("Plant3DOF", False)))
    interval, = controller.intervals
    encoders, positions = ([f"{axis}.{what}" for axis in AXES] for what in ("encoder", "position"))
    measured = [f"{axis}.measured" for axis in AXES]
    currents = [f"{motor}.i_{phase}_cmd" for motor in MOTORS for phase in PHASES]
    rows = [plant.get(positions)]
    for k in range(round(stop_time / interval)):
        time = k * interval
        controller.tick()
        controller.set(["y.reference", *measured], [GAP if time < STEP_AT else STEP_TO, *plant.get(encoders)])
        commands = controller.get(currents)   # before the update: the clock's outputs exist while it is active
        controller.to_steps()
        controller.fmu.doStep(time, interval)
        plant.set(currents, commands)         # held over the step
        plant.fmu.doStep(time, interval)
        rows.append(plant.get(positions))
    controller.close()
    plant.close()
    return rows


if __name__ == "__main__":
    gaps = [y for y, *_ in trajectory(Path(sys.argv[1]), 1.0)]
    print(f"air gap: {1e3 * gaps[0]:.3f} mm, at most {1e3 * max(gaps):.3f} mm, after 1 s {1e3 * gaps[-1]:.3f} mm")
