"""A stage, with its commutation, as FMUs that are stepped over one row of numbers.

The FMUs' C functions read and write the row itself, so that a sample copies nothing and looks nothing up:

    commands | commutated with | positions, delivered currents | encoders | velocities | references
    set in the commutation                                        observation
               got from the plant, in one call

The commutation turns direct and quadrature currents into phase currents by encoders, which are there again for it:
those of the displacements, and where the platform tilts, of the gaps at the motors too. Phase currents as commands go
straight to the plant. With a measurement both get what that makes of the encoders, as the controllers of runs do.
"""

from collections.abc import Mapping, Sequence
from contextlib import ExitStack
from ctypes import addressof, c_double, c_int, c_size_t, c_uint32, c_void_p
from math import inf
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from maglev.cosim.fmu import Buffer, Fmu, read_description
from maglev.cosim.versions.fmi import WARNING
from maglev.errors import FmuError
from maglev.own_fmus import own_fmu, stale
from pmlsm.rig import Rig

Call = tuple[Any, tuple[Any, ...]]   # a C function and its arguments


class Saved(NamedTuple):
    """State of a stage between two samples, which can be pickled: what each FMU wrote of itself, and the row."""

    fmus: tuple[bytes, ...]
    row: bytes
    samples: int


class CompiledStage:
    """Plant of a rig, and unless the commands are phase currents, its commutation.

    Parameters
    ----------
    rig : Rig
    folder : Path
        Folder with the FMUs.
    in_phases : bool
        Whether commands are three phase currents of each motor, or direct and quadrature current.
    with_measurement : bool
        Whether a measurement lies behind the encoders.

    Attributes
    ----------
    commands : ndarray, shape (commands,)
        Currents to be commanded, A, motor by motor; a view of the row, as the others.
    encoders : ndarray, shape (encoders,)
        Of the axes, m; where the platform tilts, of the horizontal axes, then of the gaps at the motors. What the
        measurement makes of them, where there is one.
    positions, velocities, references : ndarray, shape (axes,)
        In the order of the rig's axes, m and m/s, or rad and rad/s. Velocities and references are the user's of this
        class to write.
    currents : ndarray, shape (2 motors,)
        Direct and quadrature currents that the amplifiers deliver, A.
    observation : ndarray, shape (encoders + 2 axes,)
        Encoders, velocities and references.

    Raises
    ------
    FmuError
        If an FMU is missing, is not of this installation, or cannot be loaded.
    """

    def __init__(self, rig: Rig, folder: Path, in_phases: bool, with_measurement: bool = False):
        self.rig = rig
        axes, motors = len(rig.axes), len(rig.motors)
        given = [f"{current}_cmd" for current in rig.phase_names]
        seen = rig.encoders
        used = seen if rig.rotations else seen[1:]   # the commutation needs the gap where each motor has its own
        widths = [(3 if in_phases else 2) * motors, len(used), axes, 2 * motors, len(seen), axes, axes]
        ends = [sum(widths[:i + 1]) for i in range(len(widths))]
        self.row = np.zeros(ends[-1])
        parts = np.split(self.row, ends[:-1])
        self.commands, _, self.positions, self.currents, self.encoders, self.velocities, self.references = parts
        self.observation = self.row[ends[3]:]
        self.step = c_double(rig.sample_time)
        self.time = c_double()
        self.samples = 0
        with ExitStack() as stack:
            self.plant = stack.enter_context(loaded(f"Plant{rig.suffix}", folder))
            self.commutation = None if in_phases else stack.enter_context(
                loaded(f"Commutation{rig.suffix}", folder))
            self.measurement = None if not with_measurement else stack.enter_context(
                loaded(f"Measurement{rig.suffix}", folder))
            self.stack = stack.pop_all()
        self.fmus = [fmu for fmu in (self.plant, self.commutation, self.measurement) if fmu is not None]
        self.stop = Buffer("Boolean", [self.plant.variable("at_stop")], self.plant.fmi)
        found = [*(f"{axis}.position" for axis in rig.axis_names), *rig.dq_names]
        self.outputs = [self.values(self.plant, "Get", [*used, *found, *seen], ends[0])]
        if self.measurement is not None:
            self.raw = (c_double * len(seen))()
            measured_as = [name.replace("encoder", "measured") for name in seen]
            self.ahead = c_double()   # a measurement is of the end of a step of the plant
            self.outputs = [
                self.values(self.plant, "Get", found, ends[1]), call(self.plant, "Get", seen, addressof(self.raw)),
                call(self.measurement, "Set", seen, addressof(self.raw)),
                (self.measurement.do_step, (self.measurement.handle(), self.ahead, self.step, c_int(1))),
                self.values(self.measurement, "Get", [name.replace("encoder", "measured") for name in used], ends[0]),
                self.values(self.measurement, "Get", measured_as, ends[3])]
        self.calls = [self.values(self.plant, "Set", given, 0), self.stepping(self.plant), *self.outputs,
                      (self.plant.get_functions["Boolean"], (self.plant.handle(), *self.stop.arguments()))]
        if self.commutation is not None:
            self.phases = (c_double * len(given))()
            address = addressof(self.phases)
            asked = [f"{current}_reference" for current in rig.dq_names]
            measured = [name.replace("encoder", "measured") for name in used]
            self.calls[0] = call(self.plant, "Set", given, address)
            self.calls = [self.values(self.commutation, "Set", [*asked, *measured], 0),
                          self.stepping(self.commutation), call(self.commutation, "Get", given, address), *self.calls]

    def values(self, fmu: Fmu, verb: str, names: Sequence[str], place: int) -> Call:
        """Call that sets or gets variables from a place in the row on."""
        return call(fmu, verb, names, self.row.ctypes.data + place * self.row.itemsize)

    def stepping(self, fmu: Fmu) -> Call:
        return fmu.do_step, (fmu.handle(), self.time, self.step, c_int(1))

    def start(self, parameters: Mapping[str, float | bool], limit: float,
              measurement: Mapping[str, float | bool]) -> None:
        """Begin anew at time 0, with parameters of the plant, and direct and quadrature currents limited to ±limit (A).

        `measurement` has the parameters of that. FmuError if the plant or the measurement refuses its parameters.
        """
        for fmu, start in ((self.plant, parameters), (self.commutation, {"current_limit": limit}),
                           (self.measurement, measurement)):
            if fmu is not None:
                if fmu.instance is None:
                    closed()
                fmu.said()
                fmu.instance.reset()
                fmu.initialise(start, 0.0, inf)
        self.samples = 0
        if self.measurement is not None:
            self.ahead.value = 0.0
        for function, arguments in self.outputs:
            if function(*arguments) > WARNING:
                raise FmuError(self.said())
        self.velocities[:] = 0.0

    def push(self, values: Mapping[str, float]) -> None:
        """Set inputs of the plant, from the next sample on."""
        self.plant.instance.setReal([self.plant.variable(name).valueReference for name in values], [*values.values()])

    def save(self) -> Saved:
        """State from which the stage can go on later, here or in another process."""
        states = []
        for fmu in self.fmus:
            state = fmu.instance.getFMUState()
            states.append(fmu.instance.serializeFMUState(state))
            fmu.instance.freeFMUState(state)
        return Saved(tuple(states), self.row.tobytes(), self.samples)

    def restore(self, saved: Saved) -> None:
        """Go back to a state; it must be one of a stage of the same rig and options that has been started."""
        for fmu, content in zip(self.fmus, saved.fmus, strict=True):
            state = fmu.instance.deserializeFMUState(content)
            fmu.instance.setFMUState(state)
            fmu.instance.freeFMUState(state)
        self.row[:] = np.frombuffer(saved.row)
        self.samples = saved.samples

    def advance(self, samples: int) -> bool:
        """Go on by samples with the commands; False if an FMU refuses one, which leaves the row as before it."""
        for _ in range(samples):
            # As the master of runs has it: never accumulated.
            self.time.value = self.samples * self.step.value
            if self.measurement is not None:
                self.ahead.value = (self.samples + 1) * self.step.value
            for function, arguments in self.calls:
                if function(*arguments) > WARNING:
                    return False
            self.samples += 1
        return True

    def at_stop(self) -> bool:
        """Whether an axis was beyond an end stop in the last sample."""
        return bool(self.stop.values[0])

    def said(self) -> str:
        """Why an FMU has refused a sample."""
        return " ".join(filter(None, (fmu.said() for fmu in self.fmus)))

    def close(self) -> None:
        """Free the FMUs; a sample is an FmuError from then on."""
        self.calls = [(closed, ())]
        self.stack.close()


def closed() -> NoReturn:
    """Refuse a call where there is no FMU any more."""
    raise FmuError("the environment is closed, expected a new one")


def loaded(name: str, folder: Path) -> Fmu:
    """FMU of a folder."""
    path = own_fmu(name, folder)
    if not path.is_file():
        raise FmuError(f"there is no file {path}, expected a native FMU: `maglev build --kind native` makes those of "
                       "this project in a folder, and without fmus= they are built where they are missing")
    if old := stale(name, path):
        raise FmuError(f"{old}, and nothing else runs in the process of an environment")
    return Fmu(name, path, read_description(name, path))


def call(fmu: Fmu, verb: str, names: Sequence[str], address: int) -> Call:
    """Call that sets or gets Real variables at an address."""
    references = (c_uint32 * len(names))(*(fmu.variable(name).valueReference for name in names))
    functions = fmu.set_functions if verb == "Set" else fmu.get_functions
    return functions["Real"], (fmu.handle(), references, c_size_t(len(names)), c_void_p(address))
