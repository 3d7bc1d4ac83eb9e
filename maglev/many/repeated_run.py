"""Repeated runs of one scenario in one process: it is loaded and wired once, reset between runs, and reuses arrays."""

from collections.abc import Collection, Mapping, Sequence
from ctypes import c_int64
from dataclasses import replace
from typing import Self

import numpy as np

from maglev.cosim.lane_loop import DONE, LaneLoop, Taken, Varied, lane_loop
from maglev.cosim.master import Columns, Master
from maglev.files.arrays import Array
from maglev.files.errors import MaglevError
from maglev.runs.measuring import CHUNK, Found, Measuring, Meter
from maglev.runs.metrics import phase_resistances
from maglev.runs.preparation import Experiment
from maglev.scenario.settings import REFERENCE, start_values, with_references
from maglev.user.blocks import Variables

Changes = Mapping[str, float | bool]   # start values `fmu.variable`, and references `reference.AXIS.amplitude`


class RepeatedRun:
    """An experiment to be run many times with other start values; a context manager that frees its FMUs.

    Only the columns `wanted` are recorded, or all if it is None. After `widen`, if there is a loop with the FMUs'
    blocks, `written` ones by name among them, it makes several runs side by side, and computes the metrics of
    `measuring` without a recording. It stops as soon as `ended` is no longer 0.

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
        self.loop: LaneLoop | None = None
        self.meter: Meter | None = None      # of the present references
        self.meters: dict[str, Meter] = {}   # by the samples of steps
        self.resettable = not any(source.foreign for name, source in experiment.sources.items()
                                  if name not in (written or {}))
        self.descriptions = experiment.check()
        self.drives = self.driven = experiment.drives(self.descriptions)   # of the experiment, and the present ones
        self.resistances = phase_resistances(experiment.plan)   # of phases by motor, ohm, for changes
        self.master: Master | None = None
        self.columns: Columns | None = None   # of the runs of one master, all in the same memory
        self.asked: Changes = {}   # changes that gave the present references

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Free the FMUs; the next run loads them again."""
        if self.master is not None:
            self.master.__exit__()
        self.master = None

    def load(self) -> Master:
        """FMUs and calls, loaded and wired if they are not yet."""
        if self.master is None:
            experiment = self.experiment
            self.master = Master(experiment.setups(), experiment.connections, experiment.step, experiment.order,
                                 loop=experiment.loop)
            self.master.wire(self.experiment.plan.stop_time, self.drives)
            self.driven = self.drives
            self.columns = self.meter = None
            self.asked = {}
            if self.varied is not None:
                self.find_loop(self.varied, build=False)
        return self.master

    def widen(self, changes: Changes, build: bool = False) -> None:
        """Measure runs that differ in these changes side by side, if the loop for it was compiled before.

        It is compiled now if `build` is True.
        """
        self.load()
        self.varied = changes
        self.find_loop(changes, build)

    def find_loop(self, varied: Changes, build: bool) -> None:
        """Find the loop for runs side by side that differ in some changes; compile it now if `build` is True."""
        assert self.master is not None
        wiring, measuring = self.master.wiring, self.measuring
        self.loop = None
        if measuring is None or not {*self.given()} >= {axis.reference for axis in self.experiment.plan.axes.values()}:
            return
        recorded = {name for track in wiring.tracks for name in track.names}
        seen = ["" if name in measuring.optional and name not in recorded else name for name in measuring.names]
        names = {f"{name}.{variable}" for name, own in self.start(varied).items() for variable in own
                 if name in self.experiment.sources}
        self.loop = lane_loop(wiring, seen, measuring.amounts, Varied(frozenset(names), bool(self.driven_by(varied))),
                              build, self.written)

    def given(self) -> dict[str, Array]:
        """Return the present signals of the master by name, shape (points,)."""
        assert self.master is not None
        return {name: row for track in self.master.wiring.tracks if track.signals is not None
                for name, row in zip(track.names, track.signals, strict=True)}

    @property
    def width(self) -> int:
        """Return the number of runs side by side."""
        return 1 if self.loop is None else self.loop.width

    def run(self, changes: Changes) -> tuple[Array, Mapping[str, Array]]:
        """Run with other values.

        Time (s) and columns by name as of a `Recording`, shape (n,) each, which the next run overwrites. MaglevError
        if an FMU refuses a value or a step; the message says when.
        """
        try:
            master = self.load()
            self.drive(master, changes)
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
        lanes: list[tuple[int, Meter, Mapping[str, float]]] = []   # number, meter and resistances of the runs in lanes
        taken: Taken | None = None
        for number, changes in enumerate(runs):
            try:
                if not self.begin(changes):
                    continue
            except MaglevError as error:
                found[number] = error
                continue
            assert self.loop is not None
            taken = taken or self.loop.begin()
            if self.loop.take(taken, len(lanes)) == DONE:
                lanes.append((number, self.metering(), self.resistances(changes)))
        if taken is not None and lanes:
            of_meters = {meter: [lane for lane, own in enumerate(lanes) if own[1] is meter] for _, meter, _ in lanes}
            for meter, own in of_meters.items():
                meter.begin([lanes[lane][2] for lane in own])
            sizes = self.fly(taken, of_meters)
            for lane, (number, meter, _) in enumerate(lanes):
                result = meter.found(of_meters[meter].index(lane), sizes[..., lane])
                if taken.status[lane] == DONE and result.complete:
                    found[number] = result
        return found

    def fly(self, taken: Taken, of_meters: Mapping[Meter, Sequence[int]]) -> Array:
        """Make all steps of the runs that are taken; each meter measures the runs in its lanes.

        Returns the sums and the largest of the sizes of amounts, shape (amounts, 2, lanes).
        """
        assert self.loop is not None and self.measuring is not None
        points = len(self.measuring.time)
        chunk = CHUNK // self.loop.width
        rows = np.zeros((1 + min(chunk, points), len(self.measuring.names), self.loop.width))
        sizes = np.zeros((len(self.measuring.amounts), 2, self.loop.width))
        for first in range(0, points, chunk):
            if self.ended.value:
                raise KeyboardInterrupt
            rows[0] = rows[-1]
            rows = rows[:1 + points - first]
            self.loop.run(taken, first, points - 1, rows[np.newaxis, 1:], sizes[np.newaxis])
            if DONE not in taken.status:
                break
            for meter, own in of_meters.items():
                meter.take(first, rows if len(own) == self.loop.width else np.ascontiguousarray(rows[..., own]))
        return sizes

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

    def metering(self) -> Meter:
        """Return the meter of runs with the present references; there must be a loop for them."""
        if self.meter is None:
            assert self.measuring is not None
            given = self.given()
            new = Meter(self.measuring, {name: given[axis.reference]
                                         for name, axis in self.experiment.plan.axes.items()})
            self.meter = self.meters.setdefault(repr(new.own_steps), new)
        return self.meter

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
            # Studied samples may leave the range of a packaged run: touching a stop is then a result.
            known = self.experiment.plan.signals, self.drives
            drives = self.with_changes(asked).references(self.descriptions, known) if asked else self.drives
            others = {name: values for name, values in drives.items() if values is not self.driven[name]}
            master.drive(others)
            self.driven = drives
            if any(axis.reference in others for axis in self.experiment.plan.axes.values()):
                self.meter = None
            self.asked = asked

    def with_changes(self, changes: Changes) -> Experiment:
        plan, about_fmus, _ = with_references(self.experiment.plan, start_values(changes))
        fmus = dict(plan.fmus)
        for full, value in about_fmus.items():
            name, _, variable = full.partition(".")
            fmus[name] = fmus[name].model_copy(update={"start": {**fmus[name].start, variable: value}})
        return replace(self.experiment, plan=plan.model_copy(update={"fmus": fmus}))
