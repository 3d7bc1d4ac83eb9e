"""Processes beside this one: they start anew, Ctrl-C does not reach them, and they do not outlive their parent."""

import multiprocessing
import os
import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from multiprocessing.connection import wait
from multiprocessing.context import SpawnProcess
from multiprocessing.process import BaseProcess
from types import ModuleType
from typing import Any

from maglev.errors import MaglevError

PATIENCE = 10.0   # s, for a process that is asked to end
POLL = 0.05       # s, between two looks at a process


def start(target: Callable[..., None], *arguments: Any, name: str | None = None) -> SpawnProcess:
    """Start a process that calls a function of a module; the function calls `end_with_parent` first.

    A fork would share the FMUs' libraries, and threads that are in the middle of something. The arguments are short:
    where they fill the pipe to a process that has died, multiprocessing waits for ever.
    """
    if multiprocessing.current_process().daemon:
        raise MaglevError("this is a daemonic process, expected one that may start others: "
                          "concurrent.futures.ProcessPoolExecutor in place of multiprocessing.Pool")
    process = multiprocessing.get_context("spawn").Process(target=target, args=arguments, name=name)
    track_resources()
    with interrupts_blocked(), without_script():
        process.start()
    return process


def track_resources() -> None:
    """Start multiprocessing's tracker, which unblocks SIGINT: in the middle of a start, that would let it through."""
    if hasattr(signal, "pthread_sigmask"):
        from multiprocessing import resource_tracker

        resource_tracker.ensure_running()


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Block SIGINT in a block: it waits, and a process that is started meanwhile never gets it, not even at first."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


@contextmanager
def without_script() -> Iterator[None]:
    """Hide the script that runs: a process that is started would run it again, if it does not guard against that."""
    script = sys.modules["__main__"]
    sys.modules["__main__"] = ModuleType("__main__")
    try:
        yield
    finally:
        sys.modules["__main__"] = script


def end_with_parent(prepare: Callable[[], None]) -> None:
    """End this process when its parent ends, after `prepare`; ignore Ctrl-C, which the first one handles for all."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None

    def watch() -> None:
        wait([parent.sentinel])
        prepare()
        os._exit(1)

    threading.Thread(target=watch, daemon=True).start()


def end(process: BaseProcess) -> None:
    """End a process that has nothing more to do, whatever it does, and wait for it."""
    process.kill()
    process.join()


def how_it_ended(process: BaseProcess) -> str:
    """Signal or exit code of a process that has ended."""
    return named_end(process.exitcode)


def named_end(code: int | None) -> str:
    """Signal or exit code, in words, of an exit code as Python has it."""
    if code is None or code >= 0:
        return f"exit code {code}"
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"signal {-code}"
