"""Fixed-step master for co-simulation FMUs of FMI 2.0 and 3.0, Gauss–Seidel if not asked for Jacobi.

At t_k = k h every FMU, in its order, gets its inputs, steps to t_k + h and gives its outputs, which the FMUs after it
already see. With the controller first and the plant second this is the sampled loop with a zero-order hold.
"""

import signal
from collections.abc import Callable, Collection, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, get_args

import numpy as np
import numpy.typing as npt

from maglev.cosim import Order
from maglev.cosim.fmu import Fmu
from maglev.cosim.open import describe, open_fmu
from maglev.cosim.port_map import PortMap, apply
from maglev.cosim.step_loop import StepFailed, Stepper, new_counter, own_loop
from maglev.cosim.wiring import Call, Drives, Rate, Track, Wiring, wire
from maglev.files.cache import Kept
from maglev.files.errors import (
    FmuError,
    Interrupted,
    MaglevError,
    QuantityError,
    ended_by,
    one_of,
    shortened,
    signal_of,
    size_text,
)
from maglev.files.interrupts import held_interrupts
from maglev.files.side_by_side import Progress
from maglev.files.time_grid import whole_steps
from maglev.files.units import positive_time, refused_as
from maglev.user.source import Given, Source, source_of

MOST_MEMORY = 4e9      # bytes of a recording
PROGRESS_STEPS = 500   # communication steps between two reports of progress


@dataclass(frozen=True, init=False)
class FmuSetup:
    """An FMU of a co-simulation: its name in it, the FMU and start values; of a third-party one names and units.

    The FMU is given by its path, or a user's class by its Python file, itself, or an object of it.
    """

    name: str
    source: Source
    start: Mapping[str, float | bool | str]
    ports: PortMap | None

    def __init__(self, name: str, source: Given, start: Mapping[str, float | bool | str] | None = None,
                 ports: PortMap | None = None):
        vars(self).update(name=name, source=source_of(source), start=start or {}, ports=ports)


@dataclass(frozen=True, repr=False)
class Recording:
    """Outputs of every FMU and the driven inputs at each communication point."""

    time: npt.NDArray[np.float64]   # communication points, s; shape (n,)
    columns: Mapping[str, npt.NDArray[Any]]   # by name, `fmu.variable`; Booleans as 0 and 1; shape (n,)
    notes: tuple[str, ...] = ()   # about messages of FMUs that continued, and about errors after the end

    def __repr__(self) -> str:
        return f"<Recording: {len(self.time)} points to {self.time[-1]:g} s, {len(self.columns)} columns>"


class RunFailed(MaglevError):
    """A co-simulation that ended early; `recording` has what was recorded until then."""

    def __init__(self, message: str, recording: Recording):
        super().__init__(message)
        self.recording = recording


class RunInterrupted(Interrupted):
    """A co-simulation that Ctrl-C or SIGTERM ended; `recording` has what was recorded until then."""

    def __init__(self, message: str, recording: Recording, number: int = signal.SIGINT):
        super().__init__(message, number)
        self.recording = recording


class Observer:
    """Whoever wants to know how a co-simulation continues; this one does not.

    `counter[0]` is the number of calls of FMUs that were begun in the steps, those before the first one included.
    """

    whole = False   # true if the arrays are of the whole run, not of a few hundred steps

    def __init__(self) -> None:
        self.counter = new_counter()

    def working(self, fmu: str, doing: str) -> None:
        """Called before the stepping, with the present work on an FMU."""

    def allocate(self, shape: tuple[int, int], kind: type) -> npt.NDArray[Any]:
        return np.zeros(shape, kind)

    def wired(self, wiring: Wiring) -> None:
        """Before the stepping: the calls that will be made."""


class Columns:
    """Contents of tracks, with each column as one piece of memory: a reader of one column passes over no other.

    Rows are taken over as soon as some hundred have been written, when they are still in the processor's cache. Only
    the `wanted` columns are taken, all without a name; without a `kind` for all, each has that of its track, and
    Booleans that of FMI 2.0.
    """

    def __init__(self, tracks: Sequence[Track], rows: int, kind: type | None = None,
                 wanted: Collection[str] | None = None):
        self.tracks = tracks
        self.kinds = [kind or countable(track.array.dtype) for track in tracks]
        self.chosen = [[i for i, name in enumerate(track.names) if wanted is None or name in wanted]
                       for track in tracks]
        self.tables = [np.empty((len(chosen) if track.signals is None else 0, rows), kind) for track, chosen, kind
                       in zip(tracks, self.chosen, self.kinds, strict=True)]   # signals have theirs already
        self.taken = 0

    def take(self, rows: int, origin: int = 0) -> None:
        """Take over the rows up to this number that were not yet; those of the tracks begin with `origin`."""
        for track, chosen, table in zip(self.tracks, self.chosen, self.tables, strict=True):
            if track.signals is None:
                written = track.array[self.taken - origin:rows - origin].T
                table[:, self.taken:rows] = written if len(chosen) == len(written) else written[chosen]
        self.taken = rows

    def recording(self, step: float, notes: tuple[str, ...] = ()) -> Recording:
        """Recording of the rows that were taken over, a communication step (s) apart; the memory is the same."""
        columns: dict[str, npt.NDArray[Any]] = {}
        for track, chosen, kind, recorded in zip(self.tracks, self.chosen, self.kinds, self.tables, strict=True):
            table = recorded if track.signals is None else track.signals[chosen].astype(kind, copy=False)
            columns.update(zip((track.names[i] for i in chosen), table[:, :self.taken], strict=True))
        return Recording(step * np.arange(self.taken, dtype=np.float64), columns, notes)


class Master:
    """Co-simulation of FMUs; a context manager that frees them.

    Parameters
    ----------
    setups : sequence of FmuSetup
        In the order in which they step.
    connections : sequence of (str, str)
        From an output to an input, both `fmu.variable`.
    step : float or str
        Communication step h, s or with a unit.
    order : str
        "sequential" or "jacobi", see `wire`.
    observer : Observer, optional
    loop : Kept, optional
        Library that makes the steps; that of this installation if not given.
    opened : mapping of str to callable, optional
        Who opens an FMU, by its name, instead of `open_fmu`.

    Raises
    ------
    FmuError
        If an FMU cannot be loaded, or two have one name.

    Examples
    --------
    Any FMUs, without a scenario, a stage or a controller of this project:

    >>> import maglev
    >>> pair = [maglev.FmuSetup("law", "law.fmu", {"gain": 3.0}), maglev.FmuSetup("tank", "tank.fmu")]
    >>> wires = [("tank.level", "law.measured"), ("law.flow", "tank.inflow")]
    >>> with maglev.Master(pair, wires, step=1e-3) as master:      # doctest: +SKIP
    ...     recording = master.run(10.0)
    """

    def __init__(self, setups: Sequence[FmuSetup], connections: Sequence[tuple[str, str]], step: float | str,
                 order: Order = "sequential", observer: Observer | None = None, loop: Kept | None = None,
                 opened: Mapping[str, Callable[..., Fmu]] | None = None):
        self.step = positive_time(step, FmuError, f"communication step = {step!r}")
        if order not in get_args(Order):
            raise FmuError(f"order = {order!r}, expected {one_of(order, get_args(Order))}")
        names = [setup.name for setup in setups]
        for name in names:
            if names.count(name) > 1:
                raise FmuError(f"two FMUs are called {name}, expected different names")
        self.order = order
        self.setups = setups
        self.connections = connections
        self.observer = observer or Observer()
        self.loop = loop or own_loop()
        self.stack = ExitStack()
        self.fmus: dict[str, Fmu] = {}
        self.wiring: Wiring   # as soon as it is wired
        self.has_run = self.closed = False
        described = [(p, describe(p.name, p.source)) for p in setups]
        try:
            with held_interrupts():
                for setup, description in described:
                    scales = {} if setup.ports is None else apply(setup.ports, description)
                    self.observer.working(setup.name, "loading")
                    open_it: Callable[..., Fmu] = (opened or {}).get(setup.name, open_fmu)
                    fmu = open_it(setup.name, setup.source, description, scales)
                    self.fmus[setup.name] = self.stack.enter_context(fmu)
        except BaseException:
            self.stack.close()
            raise

    def __enter__(self) -> "Master":
        return self

    def __exit__(self, *_: object) -> None:
        self.closed = True
        with held_interrupts():
            self.stack.close()

    def __repr__(self) -> str:
        return f"<Master of {', '.join(self.fmus)}: every {self.step:g} s>"

    def run(self, stop_time: float | str, drives: Drives | None = None,
            progress: Progress | None = None) -> Recording:
        """Run from 0 to the stop time (s), which must be a whole number of communication steps.

        Parameters
        ----------
        stop_time : float or str
            End of the run, s or with a unit.
        drives : mapping of str to sequence of float or ndarray
            Values of driven inputs, `fmu.variable`, at every communication point, the last one included.
        progress : callable, optional
            Called now and then with the steps done and the steps in all.

        Raises
        ------
        FmuError
            If the wiring or a start value is wrong.
        RunFailed
            If an FMU refuses a step; the recording until then is in the error.
        RunInterrupted
            After Ctrl-C or SIGTERM, likewise.
        """
        self.wire(positive_time(stop_time, FmuError, f"stop time = {stop_time!r}"), drives or {})
        return self.terminated(self.run_again({}, progress))

    def wire(self, stop_time: float, drives: Drives) -> None:
        """Prepare runs from 0 to the stop time (s); parameters and errors as in `run`."""
        if self.closed:
            raise FmuError("the FMUs are freed: run before you leave the co-simulation, or make another Master")
        self.stop_time, self.steps = stop_time, self.steps_to(stop_time)
        self.block = self.steps if self.observer.whole else PROGRESS_STEPS
        for target, values in drives.items():
            if np.shape(values) != (self.steps + 1,) or np.asarray(values).dtype.kind not in "biuf":
                given = f"{len(values)} values" if np.ndim(values) == 1 else shortened(values)
                raise FmuError(f"{target} is driven by {given}, expected {self.steps + 1} numbers, one for each "
                               "communication point")
        rates = {p.name: step_rate(p.name, p.ports.step, self.step, self.steps) for p in self.setups
                 if p.ports is not None and p.ports.step is not None}
        self.wiring = wire(self.fmus, self.connections, drives, self.block + 1, self.step, self.order, rates,
                           self.observer.allocate)
        self.observer.wired(self.wiring)

    def drive(self, drives: Drives) -> None:
        """Give driven inputs other values for the next run; the others keep theirs."""
        for track in self.wiring.tracks:
            for row, name in zip(() if track.signals is None else track.signals, track.names, strict=False):
                if name in drives:
                    row[:] = drives[name]

    def run_again(self, start: Mapping[str, Mapping[str, float | bool]], progress: Progress | None = None,
                  columns: Columns | None = None) -> Recording:
        """Run as prepared by `wire`, again after fmi2Reset; errors as in `run`.

        Start values `start`, by the name of an FMU, go before those of its setup. `columns` is where the recording is,
        to be used again; without it the next run leaves a recording as it is.
        """
        phases, tracks = self.wiring.phases, self.wiring.tracks
        columns = columns or Columns(tracks, self.steps + 1)
        done = origin = columns.taken = 0
        with held_interrupts() as let_through:
            self.initialise(start)
            stepper = Stepper(phases, self.loop, self.observer.counter)
            try:
                self.begin()
                while done < self.steps:
                    let_through()
                    if done == origin + self.block:
                        origin = done
                        for track in tracks:
                            track.begin(origin)
                    last = min(done + PROGRESS_STEPS, self.steps)
                    stepper.step_over(done, last, origin)
                    require_booleans(tracks, origin, done + 1, last)
                    done = last
                    columns.take(done + 1, origin)
                    if progress is not None:
                        progress(done, self.steps)
            except (FmuError, StepFailed, KeyboardInterrupt) as error:
                reason: BaseException = error
                if isinstance(error, StepFailed):
                    done, reason = error.step, error.reason
                columns.take(done + 1, origin)
                raise early_end(reason, done * self.step, columns.recording(self.step)) from reason
            stepper.tell_warnings()
            return columns.recording(self.step, self.notes())

    def initialise(self, start: Mapping[str, Mapping[str, float | bool]]) -> None:
        """Initialise the FMUs for a run, as new; `start` as in `run_again`. FmuError if one refuses it."""
        own = {setup.name: setup.start for setup in self.setups}
        for track in self.wiring.tracks:
            track.begin(0)
        for name, calls in self.wiring.begin.items():
            if self.has_run:
                self.fmus[name].reset()
            self.observer.working(name, "its initialization")
            self.fmus[name].initialise({**own[name], **start.get(name, {})}, 0.0, self.stop_time,
                                       partial(call_all, calls))
        self.has_run = True

    def begin(self) -> None:
        """Get the outputs at the first communication point; FmuError if an FMU refuses, StepFailed of no Boolean."""
        for call in self.wiring.initial:
            self.observer.counter[0] += 1
            call.at(0)
        require_booleans(self.wiring.tracks, 0, 0, 0)

    def terminated(self, recording: Recording) -> Recording:
        """End a run that has given this recording; RunFailed where an FMU refuses its end."""
        with held_interrupts():
            for call in self.wiring.final:
                self.observer.counter[0] += 1
                try:
                    call.at(0)
                except FmuError as error:
                    raise early_end(error, self.stop_time, recording) from error
        return replace(recording, notes=self.notes())

    def notes(self) -> tuple[str, ...]:
        return tuple(filter(None, (fmu.note() for fmu in self.fmus.values())))

    def steps_to(self, stop_time: float) -> int:
        """Number of communication steps in a run to the stop time (s); FmuError if it is not whole."""
        with refused_as(FmuError, f"stop time = {stop_time} s"):
            return whole_steps(stop_time, self.step)

    def require_memory(self, stop_time: float) -> None:
        """Raise for a run to a stop time (s) whose recording would not fit."""
        steps = self.steps_to(stop_time)
        outputs = sum(variable.causality == "output" for fmu in self.fmus.values()
                      for variable in fmu.description.modelVariables)
        if 8 * outputs * steps > MOST_MEMORY:
            raise FmuError(f"{steps} steps of {self.step} s with {outputs} outputs would take "
                           f"{size_text(8 * outputs * steps)} of memory, expected at most {size_text(MOST_MEMORY)}: "
                           "a shorter run or a longer step")


def require_booleans(tracks: Sequence[Track], origin: int, first: int, last: int) -> None:
    """Raise for values that are no Booleans at communication points; rows of the tracks begin with point `origin`."""
    for track in tracks:
        wrong = track.first_wrong(first - origin, last - origin)
        if wrong is not None:
            raise StepFailed(max(0, origin + wrong[0] - 1), FmuError(wrong[1]))


def call_all(calls: Sequence[Call]) -> None:
    """Make calls at the first communication point."""
    for call in calls:
        call.at(0)


def step_rate(name: str, own: float, step: float, steps: int) -> Rate:
    """Steps of an FMU that wants steps of its own (s) among communication steps (s); FmuError if they misfit."""
    try:
        own_rate = Rate(every=whole_steps(own, step)) if own > step else Rate(parts=whole_steps(step, own))
    except QuantityError:
        raise FmuError(f"{name}: step = {own} s, expected a multiple of the communication step, {step} s, or a whole "
                       "fraction of it") from None
    if steps % own_rate.every:
        raise FmuError(f"{name}: step = {own} s, expected a whole fraction of the stop time, "
                       f"{steps * step:.9g} s")
    return own_rate


def early_end(reason: BaseException, time: float, recording: Recording) -> RunFailed | RunInterrupted:
    """Error for a run that ended early at a time (s)."""
    if isinstance(reason, KeyboardInterrupt):
        return RunInterrupted(f"at t = {time:.9g} s: {ended_by(reason)}", recording, signal_of(reason))
    return RunFailed(f"at t = {time:.9g} s: {reason}", recording)


def countable(kind: npt.DTypeLike) -> npt.DTypeLike:
    """Type of a column with which one can reckon: Booleans of one byte become those of FMI 2.0."""
    return np.int32 if kind == np.uint8 else kind
