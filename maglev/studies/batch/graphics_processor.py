"""Batches on a graphics processor of NVIDIA: a sample a thread, in the loop with the FMUs' blocks, with its metrics.

Samples begin on this machine, where FMUs take or refuse values, and what was measured becomes metrics here. One that is
not completed there is run here, which says why.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from ctypes import Structure, c_int64, c_void_p
from dataclasses import dataclass, field
from itertools import groupby
from pathlib import Path
from typing import Any

import numpy as np

from fmi_export.errors import ExportError
from maglev.arrays import Array
from maglev.cosim.blocks.block_loop import DONE, FUNCTION_FILE, LOOP_FILE, RUN_FILE, BlockLoop, Common, words_of
from maglev.cosim.blocks.graphics_processor import driver, kernels, launch, sent
from maglev.errors import MaglevError, ScenarioError, option
from maglev.judging.endings import endings
from maglev.schema.settings import REFERENCE
from maglev.studies.batch.measuring import Found, Meter, Observer, complete
from maglev.studies.batch.repeated_run import RepeatedRun
from maglev.studies.batch.samples import Batch, Job, Sample, Store, gathered, metric_rows, run_samples

KERNEL = Path(__file__).with_name("kernel.c")
FUNCTION = "maglev_samples"
WORTH_SPECIALISING = 10_000_000_000   # steps, which take half a minute; the compilers take some ten seconds
# Samples at a time, for which Ctrl-C waits: twice what an H100 or H200 runs side by side, 8 warps of 32 on each of its
# 132 multiprocessors. Of a few more each takes as long as all of these.
MOST = 67_584
SHARE = 0.4        # of the memory that is free: signals of the next samples come as some run; threads have their own
AROUND = ("beginnings", "returned", "rows", "windows")   # what each sample has of its own beside its observer
SHARED = ("bands", "event_starts", "event_ends")   # what the observers of all samples have


class OnDevice(Structure):
    """The struct batch of kernel.c."""

    _fields_ = (("samples", c_int64), ("last", c_int64), ("beginnings", c_void_p), ("calls", c_void_p),
                ("rows", c_void_p), ("tracks", c_int64), ("returned", c_void_p), ("windows", c_void_p),
                ("first", Observer))


@dataclass(frozen=True, eq=False)
class Given:
    """What samples with the same signals are given: what measures them, and arrays of the processor.

    Those are signals, by track `places`, 0 of a track without them, and when windows start and are steady.
    """

    meter: Meter
    signals: list[Any]
    places: list[int]
    starts: Any
    steady: Any

    @property
    def size(self) -> int:
        """Bytes there."""
        return sum(int(array.nbytes) for array in (*self.signals, self.starts, self.steady))


@dataclass
class Begun:
    """Samples that begin: numbers, what each begins with and is given, and resistances of its phases by motor (ohm)."""

    samples: list[int] = field(default_factory=list)
    beginnings: list[bytes] = field(default_factory=list)
    resistances: list[list[float]] = field(default_factory=list)
    given: list[Given] = field(default_factory=list)
    size: int = 0   # bytes of all of them, there


def run_on_graphics_processor(job: Job, batches: list[Batch], values: Array, store: Store) -> None:
    """Run batches as `run_here` does, many samples at a time; MaglevError without a loop, or where memory is short."""
    asked = option("device", "gpu")
    with job.repeated_run() as repeated:
        try:
            repeated.load(build=True)
            if repeated.loop is None:
                raise ScenarioError(f"{asked} needs native FMUs of this installation, with steps of one length, and a "
                                    f"reference for each axis, expected them, or {option('device', 'cpu')}")
            if job.limit is not None:
                raise ScenarioError(f"{option('sample_timeout', f'{job.limit:g} s')}: a graphics processor runs "
                                    f"samples side by side, expected none with {asked}, or {option('device', 'cpu')}")
        except (ExportError, OSError) as error:
            raise MaglevError(f"{asked}: {error}") from error
        kernel = Kernel(driver(), repeated.loop, sum(len(batch.samples) for batch in batches)
                        * job.experiment.plan.stop_time / job.experiment.step >= WORTH_SPECIALISING)
        for together in at_once(batches):
            done = run_together(kernel, repeated, job, values, together)
            for batch in together:
                store(gathered(job, batch.first, map(done.__getitem__, batch.samples)))


def at_once(batches: Iterable[Batch]) -> Iterator[list[Batch]]:
    """Batches that are run together: of at most `MOST` samples, or one that has more."""
    together: list[Batch] = []
    count = 0
    for batch in batches:
        if together and count + len(batch.samples) > MOST:
            yield together
            together, count = [], 0
        together.append(batch)
        count += len(batch.samples)
    if together:
        yield together


def run_together(kernel: "Kernel", repeated: RepeatedRun, job: Job, values: Array, batches: Sequence[Batch]
                 ) -> dict[int, Sample | Found]:
    """Run samples, by their numbers; as the processor runs some, the next begin here."""
    done: dict[int, Sample | Found] = {}
    under_way: list[tuple[Device, Begun, dict[str, Any]]] = []

    def complete() -> None:
        while under_way:   # one at a time: each takes the memory that there is
            device, begun, arrays = under_way.pop()
            done.update(device.completed(job, begun, arrays))

    for device, begun in launches(kernel, repeated, job, values, with_same_references(repeated, job, values, batches)):
        complete()
        under_way.append((device, begun, device.launch(begun)))
    complete()
    if rest := [sample for batch in batches for sample in batch.samples if sample not in done]:
        done |= dict(zip(rest, run_samples(job, values[rest]), strict=True))
    return done


def with_same_references(repeated: RepeatedRun, job: Job, values: Array, batches: Iterable[Batch]) -> list[list[int]]:
    """Numbers of the samples of batches, those with the same signals together, beside those with the same references.

    They keep their order where nothing tells them apart.
    """
    def about_axes(name: str) -> bool:
        return name.removeprefix(f"{REFERENCE}.").rpartition(".")[0] in job.experiment.plan.axes

    columns = [column for column, target in enumerate(job.targets) if target.name in repeated.drives
               or target.name.startswith(f"{REFERENCE}.")]
    columns.sort(key=lambda column: not about_axes(job.targets[column].name))
    groups: dict[tuple[float, ...], list[int]] = {}
    for batch in batches:
        for sample in batch.samples:
            groups.setdefault(tuple(values[sample, columns].tolist()), []).append(sample)
    return [groups[key] for key in sorted(groups)]


def launches(kernel: "Kernel", repeated: RepeatedRun, job: Job, values: Array, groups: Iterable[list[int]]
             ) -> Iterator[tuple["Device", Begun]]:
    """Samples that begin, as many together as there is memory for, and what runs them; groups have the same signals.

    Those that something is refused of are left out.
    """
    device: Device | None = None
    begun = Begun()
    for group in groups:
        try:
            repeated.drive(repeated.load(), job.changes(values[group[0]].tolist()))
        except MaglevError:   # there are no such references
            repeated.close()
            continue
        device = device or Device(kernel, repeated)
        given = device.given(repeated)
        for sample in group:
            if not device.takes(begun, given):
                yield device, begun
                begun = Begun()
            changes = job.changes(values[sample].tolist())
            if beginning := repeated.beginning(changes):
                resistances = repeated.resistances(changes)
                begun.samples.append(sample)
                begun.beginnings.append(beginning)
                begun.resistances.append([resistances.get(motor, np.nan) for motor in job.experiment.plan.motors])
                begun.size += device.size_of(begun, given)
                begun.given.append(given)
    if device is not None:
        yield device, begun


class Kernel:
    """The function of a loop on a graphics processor, or, if it is to be special, one for what samples have in common.

    As soon as samples have it otherwise there is another one, for these, too. MaglevError if it cannot be compiled, or
    kept.
    """

    def __init__(self, cupy: Any, loop: BlockLoop, special: bool):
        self.cupy, self.special = cupy, special
        self.sources, self.moved = loop.sources, loop.moved
        self.room = free(cupy)
        self.common: Common | None = None
        self.function: Any = None
        if not special:
            self.compile("")

    def compile(self, common: str) -> None:
        try:
            self.function, = kernels(self.cupy, kernel_code(self.sources, common), FUNCTION)
        except (ExportError, OSError) as error:
            raise MaglevError(f"{option('device', 'gpu')}: {error}") from error

    def ready(self, beginnings: Sequence[bytes]) -> Any:
        """Have a function for samples; returns what each begins with, as that takes it, on the processor."""
        if not self.special or not beginnings:
            return sent(self.cupy, b"".join(beginnings))
        words = words_of(beginnings)
        if self.common is None or not self.common.holds(words):
            self.common = Common.of(words, self.common)
            self.compile(self.common.code(self.moved))
        own = words[:, self.common.places] if self.common.places else words[:, :1]
        return sent(self.cupy, own.tobytes())


class Device:
    """The kernel on a graphics processor, and what all samples are measured by, whatever their references."""

    def __init__(self, kernel: Kernel, repeated: RepeatedRun):
        assert repeated.loop is not None
        loop, meter, cupy = repeated.loop, repeated.metering(), kernel.cupy
        self.cupy, self.kernel, self.observer = cupy, kernel, meter.observer
        self.last = len(meter.measuring.time) - 1
        self.shared = {name: cupy.asarray(meter.arrays[name]) for name in SHARED}
        self.calls = sent(cupy, loop.moved)
        found = {"whole": meter.whole[0], "of_events": meter.found_events}
        found |= {name: meter.arrays[name] for name in ("kept", "errors", "resistances") if name in meter.arrays}
        self.measured = {name: (found[name].dtype, found[name].shape) for name in ("whole", "of_events", "kept")
                         if name in found}
        self.window = meter.found_windows.dtype
        self.own = {name: array.nbytes for name, array in found.items()}
        self.tracks = len(loop.tracks)
        self.own |= dict(zip(AROUND, (loop.size, 8, 8 * self.tracks, 32), strict=True))   # bytes of a sample

    def given(self, repeated: RepeatedRun) -> Given:
        """Send the signals as they are now, with what is measured by them."""
        meter = repeated.metering()
        assert repeated.loop is not None
        with self.memory_for(1):
            there = {number: self.cupy.asarray(track.signals) for number, track in enumerate(repeated.loop.tracks)
                     if track.signals is not None}
            starts, steady = (self.cupy.asarray(meter.arrays[name]) for name in ("starts", "steady"))
        return Given(meter, [*there.values()], [there[number].data.ptr if number in there else 0
                                                for number in range(self.tracks)], starts, steady)

    def size_of(self, begun: Begun, given: Given) -> int:
        """Bytes of one more sample, there."""
        own: int = sum(self.own.values()) + len(given.meter.windows) * self.window.itemsize
        return own if begun.given and begun.given[-1] is given else own + given.size

    def takes(self, begun: Begun, given: Given) -> bool:
        """Whether there is memory for one more sample; MaglevError if there is not memory for one."""
        size = self.size_of(begun, given)
        if size > self.kernel.room:
            raise MaglevError(f"{option('device', 'gpu')}: a sample takes {size:,} bytes of the graphics processor's "
                              f"memory, expected as much to be free, or {option('device', 'cpu')}")
        return len(begun.samples) < MOST and begun.size + size <= self.kernel.room

    def launch(self, begun: Begun) -> dict[str, Any]:
        """Send samples, and begin to run them: arrays, shape (samples, bytes) but of windows, of which some have more.

        MaglevError if memory is short.
        """
        count = len(begun.samples)
        windows = [len(given.meter.windows) for given in begun.given]
        with self.memory_for(count):
            arrays = {name: self.cupy.zeros((count, size), np.uint8) for name, size in self.own.items()
                      if name not in ("beginnings", "rows", "windows")}
            found = self.cupy.zeros((sum(windows), self.window.itemsize), np.uint8)
            arrays["beginnings"] = self.kernel.ready(begun.beginnings)
            arrays["rows"] = self.cupy.asarray(np.array([given.places for given in begun.given], np.int64).reshape(
                count, self.tracks))
            first = found.data.ptr + self.window.itemsize * (np.cumsum(windows) - windows)
            arrays["windows"] = self.cupy.asarray(np.array([
                (number, given.starts.data.ptr, given.steady.data.ptr, place)
                for number, given, place in zip(windows, begun.given, first, strict=True)], np.int64))
            arrays["resistances"] = self.cupy.asarray(np.array(begun.resistances))
            observer = Observer.from_buffer_copy(self.observer)
            for name, array in {**self.shared, **arrays}.items():
                if name not in AROUND:
                    setattr(observer, name, array.data.ptr)
            batch = sent(self.cupy, OnDevice(
                count, self.last, arrays["beginnings"].data.ptr, self.calls.data.ptr, arrays["rows"].data.ptr,
                self.tracks, arrays["returned"].data.ptr, arrays["windows"].data.ptr, observer))
        if count:
            launch(self.kernel.function, count, batch)
        return {**arrays, "of_windows": found}

    @contextmanager
    def memory_for(self, count: int) -> Iterator[None]:
        """MaglevError where there is not memory for so many samples after all."""
        try:
            yield
        except MemoryError as error:
            size = sum(self.own.values())
            raise MaglevError(f"{option('device', 'gpu')}: {count:,} samples of {size:,} bytes, and their signals, do "
                              "not fit into the memory of the graphics processor, which others use too: expected a "
                              f"batch of at most {int(free(self.cupy) / size):,}") from error

    def completed(self, job: Job, begun: Begun, arrays: Mapping[str, Any]) -> Iterator[tuple[int, Sample]]:
        """Samples that were completed, as soon as all have ended, with their numbers."""
        returned = self.cupy.asnumpy(arrays["returned"]).view(np.int64)[:, 0]
        found = {name: self.cupy.asnumpy(arrays[name]).view(form).reshape(len(returned), *shape)
                 for name, (form, shape) in self.measured.items()}
        windows = self.cupy.asnumpy(arrays["of_windows"]).view(self.window).ravel()
        done = (returned == DONE) & complete(found["whole"])
        for meter, same in groupby(range(len(returned)), key=lambda k: begun.given[k].meter):
            group = np.array([*same])
            own, windows = np.split(windows, [len(group) * len(meter.windows)])
            ended, group = done[group], group[done[group]]
            if not len(group):
                continue
            metrics = meter.metrics(found["whole"][group], own.reshape(len(ended), -1)[ended],
                                    found["of_events"][group])
            rows = zip(metric_rows(job, metrics), endings(job.experiment.plan, metrics), strict=True)
            kept = found["kept"][group] if "kept" in found else [None] * len(group)
            for k, (values, said), trajectories in zip(group.tolist(), rows, kept, strict=True):
                yield begun.samples[k], Sample(values, said, None, trajectories)


def free(cupy: Any) -> int:
    """Bytes of a graphics processor's memory that samples can have now."""
    cupy.get_default_memory_pool().free_all_blocks()
    available: int = cupy.cuda.runtime.memGetInfo()[0]
    return int(SHARE * available)


def kernel_code(sources: Mapping[str, str], common: str = "") -> dict[str, str]:
    """C files of the kernel by name, from those of a loop and of what is common."""
    return {**{name: text for name, text in sources.items() if name not in (LOOP_FILE, FUNCTION_FILE)},
            "kernel.c": f'#include "{RUN_FILE}"\n{common}{KERNEL.read_text(encoding="utf-8")}'}
