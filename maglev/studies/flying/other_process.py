"""Samples flown in a process beside the worker: an FMU that hangs or crashes there costs its sample, and no worker."""

from collections.abc import Iterator
from functools import partial

from maglev.arrays import Array
from maglev.cosim.other_process.helper import other_process
from maglev.errors import MaglevError
from maglev.processes.beside import Gone, Send
from maglev.studies.flying.samples import Job, Sample, each_flown, failed

STARTED_WITHIN = 60.0   # s, of the process, at least: no sample is to blame for a machine that takes its time
FLIGHTS = 2             # of a sample whose process dies: the first time it may be want of memory


def each_flown_apart(job: Job, values: Array, limit: float) -> Iterator[Sample]:
    """Fly samples in a process beside this one, and in another after each that takes longer than `limit`, s.

    MaglevError if the FMUs cannot be loaded.
    """
    done, deaths, patience = 0, 0, max(limit, STARTED_WITHIN)
    while done < len(values):
        loaded = False
        with other_process() as (beside, _):
            beside.ask(partial(fly, job, values[done:]))
            try:
                beside.next(patience)
                loaded = True
                while not (said := beside.next(limit)).last:
                    yield said.what
                    done, deaths = done + 1, 0
            except Gone as gone:
                deaths += bool(gone.how)
                if gone.how and deaths < FLIGHTS:
                    continue
                why = f"the process that flew it ended ({gone.how})"
                if not loaded:
                    raise MaglevError(f"the FMUs cannot be loaded: {why}" if gone.how else
                                      f"the FMUs were not loaded within {patience:g} s") from None
                yield failed(job, why if gone.how else f"took longer than {limit:g} s")
                done, deaths = done + 1, 0


def fly(job: Job, values: Array, send: Send) -> None:
    """Fly samples in this process, and send first that the FMUs are loaded, then each sample."""
    for sample in each_flown(job, values, partial(send, None)):
        send(sample)
