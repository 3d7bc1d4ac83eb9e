"""One scenario run again and again in one process: loaded and wired once, reset between, arrays used again."""

from collections.abc import Collection, Mapping, Sequence
from ctypes import c_int64
from dataclasses import replace
from typing import Self

import numpy as np

from maglev.cosim.block_loop import DONE, ENDED, BlockLoop, block_loop
from maglev.cosim.lane_loop import LaneLoop, Taken, Varied, lane_loop
from maglev.cosim.master import Columns, Master
from maglev.files.arrays import Array
from maglev.files.errors import MaglevError
from maglev.many.measuring import Found, Measuring, Meter
from maglev.runs.metrics import phase_resistances
from maglev.runs.preparation import Experiment, is_foreign
from maglev.scenario.settings import REFERENCE, start_values, with_references
from maglev.user.blocks import Variables

Changes = Mapping[str, float | bool]   # start values `fmu.variable`, and references `reference.AXIS.amplitude`


class RepeatedRun:
    """An experiment to be run many times with other start values; a context manager that frees its FMUs.

    Only the columns `wanted` are recorded, or all if it is None. If there is a loop with the FMUs' blocks, `written`
    ones by name among them, it computes the metrics of `measuring` without a recording. After `widen` it makes several
    runs side by side. It stops as soon as `ended` is no longer 0.

    Each run gives, bit for bit, the result of an experiment that is prepared with the same values: FMUs of this
    project, and written ones, are as new after fmi2Reset. Third-party FMUs, and all FMUs after a refusal, are loaded
    again.
    """

    def __init__(self, experiment: Experiment, wanted: Collection[str] | None = None,
                 measuring: Measuring | None = None, ended: c_int64 | None = None,
                 written: Mapping[str, Variables] | None = None):
        self.experiment = experiment
        self.wanted = wanted
        self.measuring = measuring
        self.ended = c_int64() if ended is None else ended   # one of 0 counts as false
        self.written = written
        self.varied: Changes | None = None   # what runs side by side differ in
        self.loop: BlockLoop | None = None
        self.lanes: LaneLoop | None = None
        self.meters: dict[int, Meter] = {}   # of the references as they are now, by lane
        self.resettable = not any(is_foreign(path) for name, path in experiment.files.items()
                                  if name not in (written or {}))
        self.descriptions = experiment.check()
        self.drives = self.driven = experiment.drives(self.descriptions)   # of the experiment, and as they are now
        self.resistances = phase_resistances(experiment.plan)   # of phases by motor, ohm, for changes
        self.master: Master | None = None
        self.columns: Columns | None = None   # of the runs of one master, all in the same memory
        self.asked: Changes = {}   # what the references as they are were asked to be

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the FMUs; the next run loads them again."""
        if self.master is not None:
            self.master.__exit__()
        self.master = None

    def load(self, build: bool = False) -> Master:
        """FMUs and calls, loaded and wired if they are not yet.

        There is a loop with the FMUs' blocks if it was compiled before, or is compiled now, where `build` asks for it.
        """
        if self.master is None:
            experiment = self.experiment
            self.master = Master(experiment.setups(), experiment.connections, experiment.step, experiment.order,
                                 loop=experiment.loop)
            self.master.wire(self.experiment.plan.stop_time, self.drives)
            assert self.master.wiring is not None
            self.driven = self.drives
            self.columns = self.loop = self.lanes = None
            self.meters = {}
            signals = {name for track in self.master.wiring.tracks if track.signals is not None for name in track.names}
            axes = experiment.plan.axes.values()
            if self.measuring is not None and all(axis.reference in signals for axis in axes):
                self.loop = block_loop(self.master.wiring, *self.observer, build, self.written)
            self.asked = {}
            if self.varied is not None:
                self.widen(self.varied)
        return self.master

    @property
    def observer(self) -> tuple[str, dict[str, str]]:
        """Return the C that measures, and its variables."""
        assert self.measuring is not None and self.master is not None and self.master.wiring is not None
        recorded = {name for track in self.master.wiring.tracks for name in track.names}
        return self.measuring.source(), self.measuring.seen(recorded)

    def widen(self, changes: Changes, build: bool = False) -> None:
        """Measure runs with different changes side by side, if the loop was compiled for it before.

        It is compiled now if `build` is True.
        """
        self.varied = changes
        if self.loop is not None:
            assert self.master is not None and self.master.wiring is not None
            names = {f"{name}.{variable}" for name, own in self.start(changes).items() for variable in own
                     if name in self.experiment.files}
            varied = Varied(frozenset(names), bool(self.driven_by(changes)))
            self.lanes = lane_loop(self.loop, self.master.wiring, *self.observer, varied, build)

    @property
    def width(self) -> int:
        """Return the number of runs side by side."""
        return 1 if self.lanes is None else self.lanes.width

    def run(self, changes: Changes) -> tuple[Array, Mapping[str, Array]]:
        """Run with other values.

        Time (s) and columns by name as of a `Recording`, shape (n,) each, which the next run overwrites. MaglevError
        if an FMU refuses a value or a step; the message says when.
        """
        try:
            master = self.load()
            self.drive(master, changes)
            assert master.wiring is not None
            if self.columns is None:
                self.columns = Columns(master.wiring.tracks, master.steps + 1, np.float64, self.wanted)
            recording = master.run_again(self.start(changes), columns=self.columns)
        except BaseException:
            self.close()
            raise
        if not self.resettable:
            self.close()
        return recording.time, recording.columns

    def measure(self, runs: Sequence[Changes]) -> "list[Found | MaglevError | None]":
        """Return the results of runs with other values, `width` at most, without recordings, or why one cannot begin.

        Return None if there is no loop for it, an FMU refuses a value, or a result is not a number; `run` then gives
        the reason. KeyboardInterrupt if `ended` is no longer 0.
        """
        found: list[Found | MaglevError | None] = [None] * len(runs)
        taken = Taken()
        meters: dict[int, Meter] = {}   # of the runs in lanes, by number
        for number, changes in enumerate(runs):
            try:
                if not self.begin(changes):
                    continue
            except MaglevError as error:
                found[number] = error
                continue
            assert self.loop is not None
            meter = self.metering(len(meters))
            meter.resist(self.resistances(changes))
            if self.lanes is None:
                found[number] = self.found(meter, self.loop.run(self.steps, self.ended, meter.observer))
            elif self.lanes.take(taken) == DONE:
                meters[number] = meter
        if meters:
            assert self.lanes is not None
            endings = self.lanes.run(taken, self.steps, self.ended, [meter.observer for meter in meters.values()])
            for (number, meter), ending in zip(meters.items(), endings, strict=True):
                found[number] = self.found(meter, ending)
        return found

    def found(self, meter: Meter, ending: int) -> Found | None:
        if ending == ENDED:
            raise KeyboardInterrupt
        return meter.found() if ending == DONE else None

    @property
    def steps(self) -> int:
        assert self.measuring is not None
        return len(self.measuring.time) - 1

    def begin(self, changes: Changes) -> bool:
        """Prepare a run with other values for the loop; return False if there is none. Errors as in `run`."""
        try:
            master = self.load()
            if self.loop is not None:
                self.drive(master, changes)
                master.initialise(self.start(changes))
                master.begin()
        except BaseException:
            self.close()
            raise
        return self.loop is not None

    def metering(self, lane: int = 0) -> Meter:
        """Return the meter of runs with the present references, in a lane; there must be a loop for them."""
        if lane not in self.meters:
            assert self.master is not None and self.master.wiring is not None and self.measuring is not None
            given = {name: row for track in self.master.wiring.tracks if track.signals is not None
                     for name, row in zip(track.names, track.signals, strict=True)}
            self.meters[lane] = Meter(self.measuring, {name: given[axis.reference]
                                                       for name, axis in self.experiment.plan.axes.items()})
        return self.meters[lane]

    def start(self, changes: Changes) -> dict[str, dict[str, float | bool]]:
        by_fmu: dict[str, dict[str, float | bool]] = {}
        following = self.experiment.following
        for full, value in {**(following.settings(changes) if following else {}), **changes}.items():
            name, _, variable = full.partition(".")
            by_fmu.setdefault(name, {})[variable] = value
        return by_fmu

    def driven_by(self, changes: Changes) -> Changes:
        """Return those of the changes that references follow."""
        return {name: value for name, value in changes.items()
                if name.startswith(f"{REFERENCE}.") or name in self.drives}

    def drive(self, master: Master, changes: Changes) -> None:
        """Put the references of a run into the rows that the FMUs read."""
        asked = self.driven_by(changes)
        if asked != self.asked:
            # Those that a study varies go where it asks: a stop that is touched is what it finds.
            known = self.experiment.plan.signals, self.drives
            drives = self.with_changes(asked).references(self.descriptions, known) if asked else self.drives
            others = {name: values for name, values in drives.items() if values is not self.driven[name]}
            master.drive(others)
            self.driven = drives
            if any(axis.reference in others for axis in self.experiment.plan.axes.values()):
                self.meters = {}
            self.asked = asked

    def with_changes(self, changes: Changes) -> Experiment:
        plan, about_fmus, _ = with_references(self.experiment.plan, start_values(changes))
        fmus = dict(plan.fmus)
        for full, value in about_fmus.items():
            name, _, variable = full.partition(".")
            fmus[name] = fmus[name].model_copy(update={"start": {**fmus[name].start, variable: value}})
        return replace(self.experiment, plan=plan.model_copy(update={"fmus": fmus}))
