"""Tasks in processes of their own: results in order, and a dead process is one result, not the end."""

import os
import pickle
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import pytest

from maglev.files.session import SESSION
from maglev.files.side_by_side import Idle, kept_processes, side_by_side
from maglev.files.worker_process import PROGRAM

pytestmark = pytest.mark.usefixtures("slow")


@pytest.fixture
def idle() -> Iterator[Idle]:
    with SESSION.anew(), kept_processes() as processes:
        yield processes


Task = Callable[[Callable[[int, int], None]], int]


def square(number: int, progress: Callable[[int, int], None]) -> int:
    """A task."""
    progress(1, 3)
    progress(3, 3)
    return number * number


def die(code: int, progress: Callable[[int, int], None]) -> int:
    """A task whose process ends at once."""
    progress(1, 3)
    os._exit(code)


def meet(folder: Path, name: str, progress: Callable[[int, int], None]) -> int:
    """A task that waits until another one is under way; 1 if that happens within a minute."""
    (folder / name).touch()
    end = time.monotonic() + 60.0
    while len(list(folder.iterdir())) < 2 and time.monotonic() < end:
        time.sleep(0.01)
    return len(list(folder.iterdir())) - 1


def test_results_are_in_order_and_a_dead_process_is_one_of_them(idle: Idle) -> None:
    watched = []
    tasks = {"two": partial(square, 2), "dead": partial(die, 7), "three": partial(square, 3)}
    results = side_by_side(tasks, 1, lambda name, message: -1 if name == "dead" and "code 7" in message else 0,
                           lambda *report: watched.append(report), idle)
    assert list(results) == ["two", "dead", "three"]
    assert (results["two"], results["three"]) == (4, 9)
    assert results["dead"] == -1
    assert watched == [("two", 1, 3), ("two", 1, 1), ("dead", 1, 3), ("dead", 1, 1), ("three", 1, 3), ("three", 1, 1)]


def own_process(progress: Callable[[int, int], None]) -> int:
    """A task that tells its process."""
    return os.getpid()


def test_a_process_does_one_task_after_the_other_until_one_kills_it(idle: Idle) -> None:
    tasks: dict[str, Task] = {"first": own_process, "second": own_process, "dead": partial(die, 7),
                              "third": own_process}
    results = side_by_side(tasks, 1, lambda *_: -1, lambda *_: None, idle)
    assert results["first"] == results["second"] != results["third"]
    assert results["dead"] == -1
    assert results["first"] != os.getpid() != results["third"]
    again = side_by_side({"fourth": own_process}, 1, lambda *_: -1, lambda *_: None, idle)
    assert again["fourth"] == results["third"], "it waits for what comes next"
    (process,) = idle
    assert process.process.poll() is None


def leave_a_child(progress: Callable[[int, int], None]) -> int:
    """A task that ends its process, whose pipe a copy of it keeps open."""
    if os.fork():
        os._exit(7)
    time.sleep(5.0)
    os._exit(0)


def test_a_process_that_has_ended_is_noticed_where_its_pipe_is_held(idle: Idle, monkeypatch: pytest.MonkeyPatch
                                                                    ) -> None:
    """The task after it gets another process."""
    monkeypatch.setattr("maglev.files.side_by_side.PATIENCE", 0.2)
    said = []

    def lost(name: str, message: str) -> int:
        said.append((name, message))
        return -1

    results = side_by_side({"gone": leave_a_child, "next": partial(square, 3)}, 1, lost, lambda *_: None, idle)
    assert results == {"gone": -1, "next": 9}
    assert said == [("gone", "the process ended with exit code 7 before it gave a result")]
    assert len(idle) == 1


def test_processes_that_are_kept_end_with_the_block() -> None:
    with SESSION.anew(), kept_processes() as idle:
        side_by_side({"a": own_process}, 1, lambda *_: -1, lambda *_: None, idle)
        (process,) = idle
    assert process.process.returncode is not None


def test_as_many_at_a_time_as_asked_for(tmp_path: Path, idle: Idle) -> None:
    tasks = {name: partial(meet, tmp_path, name) for name in ("a", "b")}
    assert side_by_side(tasks, 2, lambda *_: 0, lambda *_: None, idle) == {"a": 1, "b": 1}


class TermWhileLoaded:
    """What gets SIGTERM as a process unpickles it."""

    def __reduce__(self) -> tuple[Callable[..., None], tuple[int]]:
        return signal.raise_signal, (signal.SIGTERM,)


@pytest.mark.parametrize("frames", [
    [TermWhileLoaded()],                                   # instead of the arguments of the command
    [["maglev"], pickle.dumps((".", TermWhileLoaded()))],   # instead of a task, which imports what it needs
], ids=["arguments", "task"])
def test_a_process_that_is_asked_to_end_as_it_starts_says_nothing(frames: list[object]) -> None:
    program = PROGRAM.format(path=sys.path, folder=None, copies=".")
    done = subprocess.run([sys.executable, "-c", program], input=b"".join(map(pickle.dumps, frames)),
                          capture_output=True, timeout=120)
    assert (done.returncode, done.stdout, done.stderr) == (-signal.SIGTERM, b"", b"")
