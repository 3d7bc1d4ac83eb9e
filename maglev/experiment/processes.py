"""Tasks side by side, each in a process of its own: one that fails or dies leaves the others alone."""

import multiprocessing
import os
import signal
from collections import deque
from collections.abc import Callable, Mapping
from multiprocessing.connection import Connection, wait
from typing import Any, Generic, NamedTuple, TypeVar, cast

from maglev.cosim.master import Progress

T = TypeVar("T")

Task = Callable[[Progress], T]              # can be pickled, as can its result; reports its progress
Watcher = Callable[[str, int, int], None]   # name of a task, steps done, steps in all


class Report(NamedTuple, Generic[T]):
    """What a process says of its task: steps done and in all; at the end in `result` the result, alone in a tuple."""

    done: int
    steps: int
    result: tuple[T] | None = None


def processors() -> int:
    """Number of processors that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def side_by_side(tasks: Mapping[str, Task[T]], jobs: int, died: Callable[[str, str], T],
                 watch: Watcher) -> dict[str, T]:
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

    Returns
    -------
    dict of str to result
        In the order of the tasks.
    """
    # Each process starts anew: a fork would share the FMUs' libraries, and threads that are in the middle of something.
    context = multiprocessing.get_context("spawn")
    waiting = deque(tasks)
    running: dict[Connection, tuple[str, Any]] = {}
    results: dict[str, T] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                name = waiting.popleft()
                ours, theirs = context.Pipe(duplex=False)
                process = context.Process(target=work, args=(tasks[name], theirs), daemon=True)
                process.start()
                theirs.close()
                running[ours] = (name, process)
            for ready in wait(list(running)):
                pipe = cast(Connection, ready)
                name, process = running[pipe]
                try:
                    report: Report[T] = pipe.recv()
                except EOFError:
                    process.join()
                    report = Report(1, 1, (died(name, f"the process died with exit code {process.exitcode}, "
                                                      "expected 0"),))
                watch(name, report.done, report.steps)
                if report.result is not None:
                    results[name] = report.result[0]
                    del running[pipe]
                    pipe.close()
                    process.join()
    finally:
        for _, process in running.values():
            process.terminate()
    return {name: results[name] for name in tasks}


def work(task: Task[T], reports: Connection) -> None:
    """Do a task in this process, and send reports."""
    # Ctrl-C reaches every process of a terminal; the first one ends the others.
    signal.signal(signal.SIGINT, signal.SIG_IGN)

    def progress(done: int, steps: int) -> None:
        if done < steps:   # the last report has the result
            reports.send(Report(done, steps))

    reports.send(Report(1, 1, (task(progress),)))
