"""A stage, with its commutation, as FMUs that are stepped over one row of numbers.

The FMUs' C functions read and write the row itself, so that a sample copies nothing and looks nothing up:

    commands | commutated with | positions, delivered currents | encoders | velocities | references
    set in the commutation                                        observation
               got from the plant, in one call

The commutation turns direct and quadrature currents into phase currents by encoders of its own: those of the
displacements and, where the platform tilts, of the gaps at the motors. Phase currents as commands go straight to the
plant. With a measurement both get what that makes of the encoders, as the controllers of runs do.
"""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from ctypes import addressof, c_double, c_int, c_size_t, c_uint32, c_void_p
from math import inf
from pathlib import Path
from typing import Any, NamedTuple, NoReturn

import numpy as np

from maglev.cosim.fmi_versions import WARNING
from maglev.cosim.fmu import Buffer, Fmu, read_description
from maglev.descriptions.own_fmus import own_fmu, stale
from maglev.files.errors import FmuError
from maglev.user.source import FmuFile
from pmlsm.stage_description import StageDescription

Call = tuple[Any, tuple[Any, ...]]   # a C function and its arguments


class Exchange(NamedTuple):
    """One operation of a sample: "Set" or "Get" variables of a part, or "step" it.

    Variables are at a place in the row, or are those of another part with the same names; a step uses the time at its
    "start" or at its "end".
    """

    verb: str
    part: str
    names: Sequence[str]
    where: int | str


def exchanges(stage: StageDescription, parts: Sequence[str], used: Sequence[str],
              ends: Sequence[int]) -> Iterator[Exchange]:
    """Return the operations of a sample on the given parts, in order; `ends` are the ends of the row's entries."""
    given = [f"{current}_cmd" for current in stage.phase_names]
    outputs = [*(f"{axis}.position" for axis in stage.axis_names), *stage.dq_names]

    def measured(encoders: Sequence[str]) -> list[str]:
        return [name.replace("encoder", "measured") for name in encoders]

    if "commutation" in parts:
        asked = [*(f"{current}_reference" for current in stage.dq_names), *measured(used)]
        yield Exchange("Set", "commutation", asked, 0)
        yield Exchange("step", "commutation", (), "start")
    yield Exchange("Set", "plant", given, "commutation" if "commutation" in parts else 0)
    yield Exchange("step", "plant", (), "start")
    if "measurement" not in parts:
        yield Exchange("Get", "plant", [*used, *outputs, *stage.encoders], ends[0])
        return
    yield Exchange("Get", "plant", outputs, ends[1])
    yield Exchange("Set", "measurement", stage.encoders, "plant")
    yield Exchange("step", "measurement", (), "end")
    yield Exchange("Get", "measurement", measured(used), ends[0])
    yield Exchange("Get", "measurement", measured(stage.encoders), ends[3])


class Saved(NamedTuple):
    """The state of a stage between two samples, which can be pickled: the saved states of the FMUs, and the row."""

    fmus: tuple[bytes, ...]
    row: bytes
    samples: int


class CompiledStage:
    """Plant of a stage, with its commutation unless the commands are phase currents, and perhaps a measurement.

    Views of one row, SI: `commands` are the commanded currents, motor by motor. `encoders` are those of the axes, or
    where the platform tilts, of the horizontal axes, then of the gaps at the motors; with a measurement they are its
    outputs. `positions`, `velocities` and `references` have shape (axes,); the user of this class writes the last two.
    `currents`, (2 motors,), are the delivered direct and quadrature currents. `observation` has encoders, velocities
    and references. FmuError if an FMU is missing, is not of this installation, or cannot be loaded.
    """

    def __init__(self, stage: StageDescription, folder: Path, parts: Sequence[str]):
        axes, motors = len(stage.axes), len(stage.motors)
        seen = stage.encoders
        used = seen if stage.rotations else seen[1:]   # the commutation needs the gap where each motor has its own
        widths = [(2 if "commutation" in parts else 3) * motors, len(used), axes, 2 * motors, len(seen), axes, axes]
        self.row = np.zeros(sum(widths))
        self.ends = np.cumsum(widths)[:-1].tolist()   # of the values in the row, except the last
        (self.commands, _, self.positions, self.currents, self.encoders, self.velocities,
         self.references) = np.split(self.row, self.ends)
        self.observation = self.row[self.ends[3]:]
        self.step = c_double(stage.sample_time)
        self.time, self.ahead = c_double(), c_double()   # a measurement is of the end of a step of the plant
        self.samples = 0
        with ExitStack() as stack:
            self.parts = {part: stack.enter_context(loaded(f"{part.title()}{stage.suffix}", folder)) for part in parts}
            self.stack = stack.pop_all()
        self.plant, self.measurement = self.parts["plant"], self.parts.get("measurement")
        self.stop = Buffer("Boolean", [self.plant.variable("at_stop")], self.plant.fmi)
        self.exchanges = [*exchanges(stage, parts, used, self.ends)]
        self.between: list[Any] = []   # memory for values that pass from one FMU to another
        first = [exchange[:2] for exchange in self.exchanges].index(("step", "plant")) + 1
        self.outputs = [made for exchange in self.exchanges[first:] for made in self.calls_of(exchange)]
        self.calls = [made for exchange in self.exchanges[:first] for made in self.calls_of(exchange)] + self.outputs
        self.calls.append((self.plant.get_functions["Boolean"], (self.plant.handle(), *self.stop.arguments())))

    def calls_of(self, exchange: Exchange) -> Iterator[Call]:
        """Return the calls for some operations."""
        verb, part, names, where = exchange
        fmu = self.parts[part]
        if verb == "step":
            yield fmu.do_step, (fmu.handle(), self.ahead if where == "end" else self.time, self.step, c_int(1))
        elif isinstance(where, int):
            yield call(fmu, verb, names, self.row.ctypes.data + where * self.row.itemsize)
        else:
            self.between.append((c_double * len(names))())
            yield call(self.parts[where], "Get", names, addressof(self.between[-1]))
            yield call(fmu, verb, names, addressof(self.between[-1]))

    def start(self, parameters: Mapping[str, float | bool], limit: float,
              measurement: Mapping[str, float | bool]) -> None:
        """Begin again at time 0, with parameters of the plant; direct and quadrature currents stay within ±limit (A).

        `measurement` has the parameters of that. FmuError if the plant or the measurement refuses its parameters.
        """
        starts: dict[str, Mapping[str, float | bool]] = {
            "plant": parameters, "commutation": {"current_limit": limit}, "measurement": measurement}
        for part, fmu in self.parts.items():
            if fmu.instance is None:
                closed()
            fmu.said()
            fmu.instance.reset()
            fmu.initialise(starts[part], 0.0, inf)
        self.samples, self.ahead.value = 0, 0.0
        for function, arguments in self.outputs:
            if function(*arguments) > WARNING:
                raise FmuError(self.said())
        self.velocities[:] = 0.0

    def change(self, part: str, name: str, value: float | bool) -> None:
        """Set an input or a tunable parameter of a part, from the next sample on."""
        fmu = self.parts[part]
        buffer, = fmu.buffers([fmu.variable(name)])
        buffer.values[0] = type(buffer.values[0])(value)
        fmu.set(buffer)

    def save(self) -> Saved:
        """Return the state from which the stage can continue later, here or in another process."""
        states = []
        for fmu in self.parts.values():
            state = fmu.instance.getFMUState()
            states.append(fmu.instance.serializeFMUState(state))
            fmu.instance.freeFMUState(state)
        return Saved(tuple(states), self.row.tobytes(), self.samples)

    def restore(self, saved: Saved) -> None:
        """Go back to a state; it must be one of a stage of the same stage and options that has been started."""
        if len(saved.fmus) != len(self.parts) or len(saved.row) != self.row.nbytes:
            raise FmuError("a state of another environment, expected one of the same stage and options")
        for fmu, content in zip(self.parts.values(), saved.fmus, strict=True):
            state = fmu.instance.deserializeFMUState(content)
            fmu.instance.setFMUState(state)
            fmu.instance.freeFMUState(state)
        self.row[:] = np.frombuffer(saved.row)
        self.samples = saved.samples

    def advance(self, samples: int) -> bool:
        """Advance by samples with the commands; return False if an FMU refuses one, with the row as before it."""
        for _ in range(samples):
            # Times as in the master of runs: never accumulated.
            self.time.value = self.samples * self.step.value
            if self.measurement is not None:
                self.ahead.value = (self.samples + 1) * self.step.value
            for function, arguments in self.calls:
                if function(*arguments) > WARNING:
                    return False
            self.samples += 1
        return True

    def at_stop(self) -> bool:
        """Return True if an axis was beyond an end stop in the last sample."""
        return bool(self.stop.values[0])

    def said(self) -> str:
        """Return the message of the FMU that failed in a sample."""
        return " ".join(filter(None, (fmu.said() for fmu in self.parts.values())))

    def close(self) -> None:
        """Free the FMUs; a sample is an FmuError from then on."""
        self.calls = [(closed, ())]
        self.stack.close()


def closed() -> NoReturn:
    """Refuse a call where there is no FMU any more."""
    raise FmuError("the environment is closed, expected a new one")


def loaded(name: str, folder: Path) -> Fmu:
    path = own_fmu(name, folder)
    if not path.is_file():
        raise FmuError(f"there is no file {path}, expected a native FMU: `maglev build --kind native` builds it; "
                       "without fmus= missing ones are built")
    if old := stale(name, path):
        raise FmuError(f"{old}; an environment runs no other FMU")
    return Fmu(name, FmuFile(path), read_description(name, path))


def call(fmu: Fmu, verb: str, names: Sequence[str], address: int) -> Call:
    references = (c_uint32 * len(names))(*(fmu.variable(name).valueReference for name in names))
    functions = fmu.set_functions if verb == "Set" else fmu.get_functions
    return functions["Real"], (fmu.handle(), references, c_size_t(len(names)), c_void_p(address))
