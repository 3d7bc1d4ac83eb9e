"""Batches on a graphics processor of NVIDIA: a sample a thread, in the loop with the FMUs' blocks, with its metrics.

Samples begin on this machine, where FMUs take or refuse values, and what was measured becomes metrics here. One that is
not completed there is run here, which says why.
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from ctypes import Structure, c_int64, c_void_p
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from fmi_export.errors import ExportError
from maglev.arrays import Array
from maglev.cosim.blocks.block_loop import DONE, FUNCTION_FILE, LOOP_FILE, RUN_FILE, BlockLoop, Common, words_of
from maglev.cosim.blocks.graphics_processor import driver, kernels, launch, sent
from maglev.errors import MaglevError, ScenarioError, option
from maglev.schema.settings import REFERENCE
from maglev.studies.flying.flight import Changes, Flight
from maglev.studies.flying.measuring import Found, Observer, complete
from maglev.studies.flying.samples import Batch, Job, Sample, Store, each_flown, gathered, rows_of

KERNEL = Path(__file__).with_name("kernel.c")
FUNCTION = "maglev_samples"
WORTH_SPECIALISING = 10_000_000_000   # steps, which take half a minute; the compilers take some ten seconds
# Samples at a time, for which Ctrl-C waits: twice what an H100 or H200 runs side by side, 8 warps of 32 on each of its
# 132 multiprocessors. Of a few more each takes as long as all of these.
MOST = 67_584
SHARE = 0.8        # of the memory that is free; the rest is for the threads' own
FOUND = ("whole", "of_windows", "of_events")   # as a meter takes them
AROUND = ("beginnings", "returned")   # what each sample has of its own beside what its observer has
SHARED = ("bands", "starts", "steady", "event_starts", "event_ends")   # what the observers of all samples have


class OnDevice(Structure):
    """The struct batch of kernel.c."""

    _fields_ = (("samples", c_int64), ("last", c_int64), ("beginnings", c_void_p), ("calls", c_void_p),
                ("rows", c_void_p), ("returned", c_void_p), ("first", Observer))


class Begun(NamedTuple):
    """Samples that begin: their numbers, what each begins with, and resistances of its phases by motor, ohm."""

    samples: list[int]
    beginnings: list[bytes]
    resistances: list[list[float]]


class Running(NamedTuple):
    """Samples under way: their numbers, and arrays of the processor, shape (samples, bytes)."""

    samples: list[int]
    arrays: dict[str, Any]


def fly_on_graphics_processor(job: Job, batches: list[Batch], values: Array, store: Store) -> None:
    """Fly batches, as many samples at a time as there is memory for; as `fly_here`.

    MaglevError without a loop for it, or where memory is short.
    """
    asked = option("device", "gpu")
    with job.flight() as flight:
        try:
            flight.load(build=True)
            if flight.loop is None:
                raise ScenarioError(f"{asked} needs native FMUs of this installation, with steps of one length, and a "
                                    f"reference for each axis, expected them, or {option('device', 'cpu')}")
            if job.limit is not None:
                raise ScenarioError(f"{option('sample_timeout', f'{job.limit:g} s')}: a graphics processor runs "
                                    f"samples side by side, expected none with {asked}, or {option('device', 'cpu')}")
        except (ExportError, OSError) as error:
            raise MaglevError(f"{asked}: {error}") from error
        kernel = Kernel(driver(), flight.loop, sum(len(batch.samples) for batch in batches)
                        * job.experiment.plan.stop_time / job.experiment.step >= WORTH_SPECIALISING)
        for together in at_once(batches):
            done: dict[int, Sample | Found] = {}
            for group in with_same_references(flight, job, values, together):
                done |= flown_group(partial(Device, kernel), flight, job, values, group)
            for batch in together:
                store(batch.number, gathered(job, batch.first, map(done.__getitem__, batch.samples)))


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


def with_same_references(flight: Flight, job: Job, values: Array, batches: Iterable[Batch]) -> Iterable[list[int]]:
    """Numbers of the samples of batches, those with the same references together."""
    columns = [column for column, target in enumerate(job.targets) if target.name in flight.drives
               or target.name.startswith(f"{REFERENCE}.")]
    groups: dict[bytes, list[int]] = {}
    for batch in batches:
        for sample in batch.samples:
            groups.setdefault(values[sample, columns].tobytes(), []).append(sample)
    return groups.values()


def flown_group(device_for: Callable[[Flight], "Device"], flight: Flight, job: Job, values: Array,
                group: list[int]) -> dict[int, Sample | Found]:
    """Fly samples that have the same references, by their numbers; as the processor runs some, the next begin here.

    Those that are not completed there are run here, which says why.
    """
    done: dict[int, Sample | Found] = {}
    if has_references(flight, job.changes(values[group[0]].tolist())):
        device = device_for(flight)
        size = device.at_a_time()
        under_way: list[Running] = []
        for first in range(0, len(group), size):
            begun = begin(flight, job, values, group[first:first + size])
            while under_way:   # one at a time: each takes the memory that there is
                done.update(device.completed(job, under_way.pop()))
            under_way.append(device.launch(begun))
        done.update(device.completed(job, under_way.pop()))
    if rest := [number for number in group if number not in done]:
        done |= dict(zip(rest, each_flown(job, values[rest]), strict=True))
    return done


def has_references(flight: Flight, changes: Changes) -> bool:
    """Put the references of a run into the rows of its signals; False where there are none such."""
    try:
        flight.drive(flight.load(), changes)
    except MaglevError:
        flight.close()
        return False
    return True


def begin(flight: Flight, job: Job, values: Array, samples: Iterable[int]) -> Begun:
    """Begin samples here; those that something is refused of are left out."""
    begun = Begun([], [], [])
    for sample in samples:
        changes = job.changes(values[sample].tolist())
        if beginning := flight.beginning(changes):
            resistances = flight.resistances(changes)
            begun.samples.append(sample)
            begun.beginnings.append(beginning)
            begun.resistances.append([resistances.get(motor, np.nan) for motor in job.experiment.plan.motors])
    return begun


class Kernel:
    """The function of a loop on a graphics processor, or, if it is to be special, one for what samples have in common.

    As soon as samples have it otherwise there is another one, for these, too. MaglevError if it cannot be compiled, or
    kept.
    """

    def __init__(self, cupy: Any, loop: BlockLoop, special: bool):
        self.cupy, self.special = cupy, special
        self.sources, self.moved = loop.sources, loop.moved
        self.common: Common | None = None
        self.function: Any = None
        if not special:
            self.compile("")

    def compile(self, common: str) -> None:
        try:
            self.function, = kernels(self.cupy, code_of(self.sources, common), FUNCTION)
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
    """The kernel on a graphics processor, with what samples with the references of a flight have in common."""

    def __init__(self, kernel: Kernel, flight: Flight):
        assert flight.loop is not None
        loop, meter, cupy = flight.loop, flight.metering(), kernel.cupy
        self.cupy, self.kernel, self.meter = cupy, kernel, meter
        self.shared = {name: cupy.asarray(meter.arrays[name]) for name in SHARED}
        self.calls = sent(cupy, loop.moved)
        self.signals = [None if track.signals is None else cupy.asarray(track.signals) for track in loop.tracks]
        self.rows = cupy.asarray(np.array([0 if track is None else track.data.ptr for track in self.signals], np.int64))
        found = dict(zip(FOUND, (meter.whole[0], meter.found_windows, meter.found_events), strict=True))
        found |= {name: meter.arrays[name] for name in ("kept", "errors", "resistances") if name in meter.arrays}
        self.measured = {name: (found[name].dtype, found[name].shape) for name in (*FOUND, "kept") if name in found}
        self.own = {name: array.nbytes for name, array in found.items()}
        self.own |= dict(zip(AROUND, (loop.size, 8), strict=True))   # bytes of a sample

    def fitting(self) -> int:
        """Samples for which there is memory now."""
        self.cupy.get_default_memory_pool().free_all_blocks()
        return int(SHARE * self.cupy.cuda.runtime.memGetInfo()[0] / sum(self.own.values()))

    def at_a_time(self) -> int:
        """Samples that are run at a time; MaglevError if there is not memory for one."""
        if (fits := self.fitting()) < 1:
            raise MaglevError(f"{option('device', 'gpu')}: a sample takes {sum(self.own.values()):,} bytes of the "
                              "graphics processor's memory, expected as much to be free, or "
                              f"{option('device', 'cpu')}")
        return min(MOST, fits)

    def launch(self, begun: Begun) -> Running:
        """Send samples, and begin to run them; MaglevError if memory is short."""
        count = len(begun.samples)
        try:
            arrays = {name: self.cupy.zeros((count, size), np.uint8) for name, size in self.own.items()
                      if name != "beginnings"}
            arrays["beginnings"] = self.kernel.ready(begun.beginnings)
            arrays["resistances"] = self.cupy.asarray(np.array(begun.resistances))
            observer = Observer.from_buffer_copy(self.meter.observer)
            for name, array in {**self.shared, **arrays}.items():
                if name not in AROUND:
                    setattr(observer, name, array.data.ptr)
            batch = sent(self.cupy, OnDevice(
                count, len(self.meter.measuring.time) - 1, arrays["beginnings"].data.ptr, self.calls.data.ptr,
                self.rows.data.ptr, arrays["returned"].data.ptr, observer))
        except MemoryError as error:
            raise MaglevError(f"{option('device', 'gpu')}: {count:,} samples of {sum(self.own.values()):,} bytes do "
                              "not fit into the memory of the graphics processor, which others use too: expected a "
                              f"batch of at most {self.fitting():,}") from error
        if count:
            launch(self.kernel.function, count, batch)
        return Running(begun.samples, arrays)

    def completed(self, job: Job, running: Running) -> Iterator[tuple[int, Sample]]:
        """Samples that were completed, as soon as all have ended, with their numbers."""
        returned = self.cupy.asnumpy(running.arrays["returned"]).view(np.int64)[:, 0]
        found = {name: self.cupy.asnumpy(running.arrays[name]).view(form).reshape(len(returned), *shape)
                 for name, (form, shape) in self.measured.items()}
        done = np.flatnonzero((returned == DONE) & complete(found["whole"]))
        if len(done):
            rows = rows_of(job, self.meter.metrics(*(found[name][done] for name in FOUND)))
            kept = found["kept"][done] if "kept" in found else [None] * len(done)
            for k, values, trajectories in zip(done.tolist(), rows, kept, strict=True):
                yield running.samples[k], Sample(values, None, trajectories)


def code_of(sources: Mapping[str, str], common: str = "") -> dict[str, str]:
    """C files of the kernel by name, from those of a loop and of what is common."""
    return {**{name: text for name, text in sources.items() if name not in (LOOP_FILE, FUNCTION_FILE)},
            "kernel.c": f'#include "{RUN_FILE}"\n{common}{KERNEL.read_text(encoding="utf-8")}'}
