"""Ctrl-C and SIGTERM, which must not reach Python code inside an FMU: it would take them for errors of its own."""

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import FrameType
from typing import Any

from maglev.files.errors import Interrupted


@contextmanager
def held_interrupts() -> Iterator[Callable[[], None]]:
    """Hold back Ctrl-C and SIGTERM during a block that calls FMUs.

    The function that is given lets through what has come; so does the end of the block, but not where the block has
    failed already. A second one is not held back. Signals without a handler in Python do as always.
    """
    handlers: dict[int, Callable[[int, FrameType | None], Any]] = {}
    came: list[int] = []

    def hold(number: int, frame: FrameType | None) -> None:
        if came:
            handlers[number](number, frame)
        came.append(number)

    def let_through() -> None:
        if came:
            number = came.pop(0)
            handlers[number](number, None)

    if threading.current_thread() is threading.main_thread():   # the only one that gets signals
        for number in (int(signal.SIGINT), int(signal.SIGTERM)):
            handler = signal.getsignal(number)
            if callable(handler):
                handlers[number] = handler
                signal.signal(number, hold)
    try:
        yield let_through
    finally:
        for number, handler in handlers.items():
            signal.signal(number, handler)
    let_through()


def terminate(_number: int, _frame: FrameType | None) -> None:
    """Handle SIGTERM like Ctrl-C: running work is ended in order."""
    raise Interrupted("terminated", signal.SIGTERM)


@contextmanager
def termination_like_interrupt() -> Iterator[None]:
    """Handle SIGTERM with `terminate` during a block."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = signal.signal(signal.SIGTERM, terminate)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


@contextmanager
def interrupts_blocked() -> Iterator[None]:
    """Delay SIGINT for the time of a block; a process that is started in it never gets the signal."""
    if not hasattr(signal, "pthread_sigmask"):
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)
