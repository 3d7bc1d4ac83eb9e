"""Tasks side by side in processes, each of which does one after the other: a task that dies leaves the others alone."""

import math
import os
import pickle
import sys
import time
import warnings
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager, nullcontext
from functools import partial
from queue import Empty, SimpleQueue
from typing import Any, TypeVar

from maglev.files.errors import Interrupted, ScenarioError, ended_by, signal_of
from maglev.files.session import SESSION
from maglev.files.units import whole_number
from maglev.files.worker_process import PATIENCE, POLL, Inbox, Said, Send, WorkerProcess

T = TypeVar("T")

REPORT_EVERY = 0.1   # s, at least, between two reports of progress
OURS = ("maglev", "contextlib")   # modules, with those below them, at whose lines a caller is not told anything

Progress = Callable[[int, int], None]       # steps done, steps in all
Task = Callable[[Progress], T]              # can be pickled, as can its result; reports its progress
Watcher = Callable[[str, int, int], None]   # name of a task, steps done, steps in all
Idle = list[WorkerProcess]                  # processes that wait for tasks
Say = Callable[[str], None]                 # takes sentences about the work that continues
Watch = Callable[[Sequence[str]], AbstractContextManager[Watcher]]   # from the names of tasks to their watcher


class Stopped(Interrupted):
    """Ctrl-C or SIGTERM ended tasks: the results of finished tasks, and the notes of the others, by name."""

    def __init__(self, number: int, what: str, results: Mapping[str, Any], left: Mapping[str, str]):
        super().__init__(what, number)
        self.what = what
        self.results = results
        self.left = left


def processors(asked: int | None = None, name: str = "jobs") -> int:
    """How many processes or threads: as many as `asked`, or as this process has processors.

    ScenarioError, which begins with the name, if it is no number of them.
    """
    if asked is not None:
        return whole_number(asked, ScenarioError, name)
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


class Workers:
    """The processes that do tasks: how many a command starts, those that wait, and whether they outlive a command."""

    def __init__(self, number: int | None = None, stay: bool = False):
        self.number = number
        self.stay = stay
        self.idle: Idle = []

    def close(self) -> None:
        while self.idle:
            self.idle.pop().end()


def processes(asked: int | None) -> int:
    """Return the number of processes of a command: as many as `asked`, or as there are processors; see `processors`."""
    return processors(SESSION.get(Workers).number if asked is None else asked)


@contextmanager
def kept_processes() -> Iterator[Idle]:
    """Processes that one `side_by_side` leaves to the next; they end with the block, unless they stay."""
    workers = SESSION.get(Workers)
    try:
        yield workers.idle
    finally:
        if not workers.stay:
            workers.close()


def side_by_side(tasks: Mapping[str, Task[T]], jobs: int, died: Callable[[str, str], T], watch: Watcher,
                 idle: Idle, take: Callable[[str, T], None] | None = None) -> dict[str, T]:
    """Do the tasks, by name, in a limited number of processes at a time; the results are in the order of the tasks.

    Each task handles its own errors; `died` returns, for its name and a message, the result of a task whose process
    ended without one. Idle processes from `kept_processes` are used before others are started, and returned there. With
    `take`, each result is passed to it when it arrives, and is not kept. Stopped after Ctrl-C or SIGTERM: the tasks
    that were under way have ended.

    The messages of these processes are unpickled: tasks run only code of this project, and leave all other code to
    `other_process`. They have no time limit, for each call of other code has one. `concurrent.futures` would lose all
    tasks with one that dies, and those under way after Ctrl-C.
    """
    waiting, inbox = deque(tasks), SimpleQueue[tuple[WorkerProcess, bytes | None]]()
    running: dict[WorkerProcess, str] = {}
    ended: dict[WorkerProcess, float] = {}   # since when a process has ended, whose pipe something else has
    results: dict[str, T] = {}
    try:
        while waiting or running:
            while waiting and len(running) < jobs:
                process = idle.pop() if idle else WorkerProcess(inbox=inbox)
                process.inbox = inbox
                running[process] = waiting.popleft()
                process.ask(partial(watched, tasks[running[process]]))
            heard, said = next_of(inbox)
            now = time.monotonic()
            for process, name in list(running.items()):
                if process is heard and said is not None and not said.last:
                    watch(name, *said.what)
                    continue
                if process is not heard and (process.process.poll() is None
                                             or now < ended.setdefault(process, now) + PATIENCE):
                    continue
                if process is not heard or said is None:
                    gone = process.gone()
                    what = f"ended with {gone.how}" if gone.how else f"{gone}"
                    result = died(name, f"the process {what} before it gave a result")
                    process.end()
                elif said.kind == "interrupt":
                    result = died(name, said.what)
                else:
                    result = said.what
                    idle.append(process)
                del running[process]
                if take is None:
                    results[name] = result
                else:
                    take(name, result)
                watch(name, 1, 1)
    except KeyboardInterrupt as error:
        left = asked_to_end(running, inbox, results)
        raise Stopped(signal_of(error), ended_by(error), results, left) from None
    finally:
        for process in running:
            process.end()
    return {name: results[name] for name in tasks if name in results}


def next_of(inbox: Inbox) -> tuple[WorkerProcess | None, Said | None]:
    """Return the next message and its process, if one arrives soon; None instead of the message if it has ended."""
    try:
        process, frame = inbox.get(timeout=POLL)
    except Empty:
        return None, None
    return process, None if frame is None else pickle.loads(frame)


def asked_to_end(running: Mapping[WorkerProcess, str], inbox: Inbox, results: dict[str, Any]) -> dict[str, str]:
    """Ask processes to end, wait a while for it, keep late results, and return their notes about remains."""
    for process in running:
        process.process.terminate()
    left: dict[str, str] = {}
    until, waiting = time.monotonic() + PATIENCE, dict(running)
    while waiting and time.monotonic() < until:
        heard, said = next_of(inbox)
        if heard in waiting and said is None:
            del waiting[heard]
        elif heard in waiting and said is not None and said.last:
            # Nothing else comes: a process that has sent its result waits for another task.
            (left if said.kind == "interrupt" else results)[waiting.pop(heard)] = said.what
    return left


def watched(task: Task[T], send: Send) -> T:
    """Do a task in another process, and report its progress now and then; the result is more than the last report."""
    latest = -math.inf

    def progress(done: int, steps: int) -> None:
        nonlocal latest
        now = time.monotonic()
        if done < steps and now - latest > REPORT_EVERY:
            latest = now
            send((done, steps))

    return task(progress)


def warn(sentence: str) -> None:
    """Warn with a sentence, as Python does, at the line that called this package."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_globals["__name__"].partition(".")[0] in OURS:
        frame, level = frame.f_back, level + 1
    warnings.warn(sentence, stacklevel=level)


def unwatched(_names: Sequence[str]) -> AbstractContextManager[Watcher]:
    return nullcontext(lambda _name, _done, _steps: None)
