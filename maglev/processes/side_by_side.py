"""Tasks side by side in processes, each of which does one after the other: a task that dies leaves the others alone."""

import math
import os
import signal
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from multiprocessing import Pipe
from multiprocessing.connection import Connection, wait
from multiprocessing.process import BaseProcess
from typing import Any, Generic, NamedTuple, TypeVar, cast

from maglev.errors import in_one_line, name_of, signal_of
from maglev.processes.child import PATIENCE, end, end_with_parent, how_it_ended, start
from maglev.processes.interrupts import held_interrupts, terminate

T = TypeVar("T")

REPORT_EVERY = 0.1   # s, at least, between two reports of progress
STARTING = 60.0      # s, at least, that a task has before its first report: its process has to start

Progress = Callable[[int, int], None]       # steps done, steps in all
Task = Callable[[Progress], T]              # can be pickled, as can its result; reports its progress
Watcher = Callable[[str, int, int], None]   # name of a task, steps done, steps in all


class Report(NamedTuple, Generic[T]):
    """What a process says of its task: steps done and in all; at the end in `result` the result, alone in a tuple.

    A task that was asked to end says in `interrupted` what stands.
    """

    done: int
    steps: int
    result: tuple[T] | None = None
    interrupted: str = ""


class Stopped(KeyboardInterrupt):
    """Ctrl-C or SIGTERM ended tasks: the results of those that were done, and what others left, by name."""

    def __init__(self, number: int, what: str, results: Mapping[str, Any], left: Mapping[str, str]):
        super().__init__(what)
        self.number = number
        self.what = what
        self.results = results
        self.left = left


Idle = list[tuple[Connection, BaseProcess]]   # processes that wait for tasks, each with the pipe to it


@contextmanager
def kept_processes() -> Iterator[Idle]:
    """Processes that one `side_by_side` leaves to the next; they end with the block."""
    idle: Idle = []
    try:
        yield idle
    finally:
        for _, process in idle:
            end(process)


def side_by_side(tasks: Mapping[str, Task[T]], jobs: int, died: Callable[[str, str], T], watch: Watcher,
                 idle: Idle, silent: float = math.inf) -> dict[str, T]:
    """Do the tasks, at most `jobs` at a time.

    Parameters
    ----------
    tasks : mapping of str to callable
        By name; a task says itself what becomes of its errors.
    jobs : int
        Number of processes at a time.
    died : callable
        From the name of a task and a message to the result of a task whose process ended without one.
    watch : callable
        Told now and then of the steps that a task has done, and at its end that all are.
    idle : list
        As of `kept_processes`: those that are taken before others are started, and left there.
    silent : float
        Longest time between two reports, s; the process of a task that says nothing for longer is ended.

    Returns
    -------
    dict of str to result
        In the order of the tasks.

    Raises
    ------
    Stopped
        After Ctrl-C or SIGTERM; the tasks that were under way have ended.
    """
    waiting = deque(tasks)
    running: dict[Connection, tuple[str, BaseProcess]] = {}
    limits: dict[Connection, tuple[float, float]] = {}   # since when something is silent, and how long it may be
    results: dict[str, T] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                name = waiting.popleft()
                pipe, process = idle.pop() if idle else started()
                running[pipe] = (name, process)
                limits[pipe] = (time.monotonic(), max(silent, STARTING))
                with suppress(ConnectionError):   # that it has ended already is seen below
                    pipe.send(tasks[name])
            soonest = min(sum(limits[pipe]) for pipe in running)
            ready = wait(list(running), None if soonest == math.inf else max(0.0, soonest - time.monotonic()))
            now = time.monotonic()
            for pipe, (name, process) in list(running.items()):
                if pipe not in ready and now < sum(limits[pipe]):
                    continue
                report = received(pipe) if pipe in ready else None
                if pipe not in ready:
                    end(process)
                    report = Report(1, 1, (died(name, f"has been silent for {limits[pipe][1]:g} s, expected a step or "
                                                      "a result within this time"),))
                elif report is None:
                    process.join()
                    report = Report(1, 1, (died(name, f"the process ended with {how_it_ended(process)}, expected a "
                                                      "result before that"),))
                elif report.interrupted:
                    process.join()
                    report = Report(1, 1, (died(name, report.interrupted),))
                elif report.result is not None:
                    idle.append((pipe, process))
                limits[pipe] = (now, silent)
                if report.result is not None:
                    results[name] = report.result[0]
                    del running[pipe]
                watch(name, report.done, report.steps)
    except KeyboardInterrupt as error:
        left = asked_to_end(running, results)
        raise Stopped(signal_of(error), name_of(error), results, left) from None
    finally:
        for _, process in running.values():
            end(process)
    return {name: results[name] for name in tasks}


def started() -> tuple[Connection, BaseProcess]:
    """A process that waits for tasks, and the pipe to it."""
    ours, theirs = Pipe()
    process = start(work, theirs)
    theirs.close()
    return ours, process


def received(pipe: Connection) -> Report[Any] | None:
    """Next report; None after the last one."""
    try:
        return cast(Report[Any], pipe.recv())
    except (EOFError, OSError):
        return None


def asked_to_end(running: Mapping[Connection, tuple[str, BaseProcess]], results: dict[str, Any]) -> dict[str, str]:
    """Ask processes to end, wait a while for it, keep late results, and return what others say that they leave."""
    for _, process in running.values():
        process.terminate()
    left = {}
    until = time.monotonic() + PATIENCE
    waiting = dict(running)
    while waiting and (ready := wait(list(waiting), until - time.monotonic())):
        for pipe in cast(Iterable[Connection], ready):
            name, _ = waiting[pipe]
            report = received(pipe)
            if report is None:
                del waiting[pipe]
            elif report.interrupted:
                left[name] = report.interrupted
            elif report.result is not None:
                results[name] = report.result[0]
    return left


def work(pipe: Connection) -> None:
    """Do tasks in this process, one after the other, and send reports."""
    signal.signal(signal.SIGTERM, terminate)
    end_with_parent(end_in_order)
    try:
        while True:
            last = done(pipe.recv(), pipe)
            with held_interrupts():   # half a report could not be read
                pipe.send(last)
            if last.interrupted:
                return
    except (EOFError, ConnectionError, KeyboardInterrupt):   # nobody wants to know, or more
        return


def done(task: Task[T], pipe: Connection) -> Report[T]:
    """Last report about a task, which is done here; those before it are sent."""
    latest = -math.inf

    def progress(done: int, steps: int) -> None:
        nonlocal latest
        now = time.monotonic()
        if done < steps and now - latest > REPORT_EVERY:   # the last report has the result
            latest = now
            pipe.send(Report(done, steps))

    try:
        return Report(1, 1, (task(progress),))
    except KeyboardInterrupt as error:
        return Report(1, 1, interrupted=in_one_line(error))


def end_in_order() -> None:
    """End the task of this process, such that it removes what it has unpacked; give it a while."""
    os.kill(os.getpid(), signal.SIGTERM)
    time.sleep(PATIENCE)
