"""Worker processes: each does one task after the other, sends the results, and does not outlive this process.

They start again, for a fork would share the FMUs' libraries and threads in the middle of something, and Ctrl-C does not
reach them. They are no children as multiprocessing starts them: a daemonic process, such as a worker of a cluster, may
have none of these.
"""

import os
import pickle
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from contextlib import suppress
from functools import partial
from pathlib import Path
from queue import Empty, SimpleQueue
from threading import Thread
from traceback import format_exc
from typing import Any, Literal, NamedTuple

from maglev.files.copies import Copies
from maglev.files.errors import FAILURES, in_one_line
from maglev.files.interrupts import held_interrupts, interrupts_blocked, terminate
from maglev.files.json_lines import line_of, value_of
from maglev.files.programs import end_with_children
from maglev.files.session import SESSION

PATIENCE = 10.0   # s, for a process that is asked to end
POLL = 0.05       # s, between two looks at a process
LONGEST = 1 << 30   # bytes of a line from third-party code
PROGRAM = ("import sys; sys.path[:] = {path!r}; from maglev.files.worker_process import serve; "
           "serve({folder!r}, {copies!r})")

Send = Callable[[object], None]   # called by a task with its reports
Task = Callable[[Send], Any]      # can be pickled, as can its reports and its result

Kind = Literal["report", "result", "error", "interrupt"]


class Said(NamedTuple):
    """A message of a process: a "report" of its task; at the end the "result", an "error", or an "interrupt"."""

    kind: Kind
    what: Any

    @property
    def last(self) -> bool:
        """Return True if the task sends nothing after this message."""
        return self.kind != "report"


class Gone(Exception):
    """A process that no longer answers; how it ended, as the end of a sentence.

    `how` is the signal or exit code of one that has ended.
    """

    def __init__(self, what: str, how: str = ""):
        super().__init__(what)
        self.how = how


class Forged(Gone):
    """A process has sent a message that no task of this project sends."""

    def __init__(self) -> None:
        super().__init__("has written into the pipe of its process")


class Silent(Gone):
    """A process has sent no message for too long."""


class Served:
    """Whether this process is a worker process that runs third-party code."""

    def __init__(self, third_party: bool = False):
        self.third_party = third_party


class WorkerProcess:
    """A process that does tasks for this one.

    A process with a folder to unpack in runs third-party code. It is ended from here alone, with all the processes that
    it has started, and the folder is removed with it. Its messages are not trusted. A process without such a folder
    takes SIGTERM, and the end of this process, as Ctrl-C, and reports what it leaves behind. Messages arrive in the
    inbox, which several processes may share; None when it has ended.
    """

    def __init__(self, folder: Path | None = None, inbox: "Inbox | None" = None):
        self.folder = folder
        self.inbox: Inbox = inbox or SimpleQueue()
        self.let_through: Callable[[], None] = lambda: None   # lets interrupts through that are held back
        self.left = False   # true if it has ended itself and left something that it has started
        program = PROGRAM.format(path=sys.path, folder=None if folder is None else str(folder),
                                 copies=str(SESSION.get(Copies).folder))
        with interrupts_blocked():
            self.process = subprocess.Popen([sys.executable, "-c", program], stdin=subprocess.PIPE,
                                            stdout=subprocess.PIPE, start_new_session=folder is not None)
        Thread(target=self.receive, daemon=True).start()
        self.send(sys.argv)   # not in the program: an argument has a largest length

    def receive(self) -> None:
        """Pass on the messages of the process, and at last that it has ended."""
        assert self.process.stdout is not None
        with self.process.stdout as pipe, suppress(EOFError, pickle.UnpicklingError):   # in the middle of a report
            while frame := pickle.load(pipe) if self.folder is None else pipe.readline(LONGEST):
                self.inbox.put((self, frame))   # the one that is its own by then
        self.inbox.put((self, None))

    def ask(self, task: Task | None) -> None:
        """Have a task done in the folder of this process; None asks it to end."""
        self.send(pickle.dumps(task and (os.getcwd(), task)))

    def send(self, frame: object) -> None:
        assert self.process.stdin is not None
        try:
            pickle.dump(frame, self.process.stdin)
            self.process.stdin.flush()
        except OSError:   # it has ended
            self.inbox.put((self, None))

    def next(self, limit: float, sign: Callable[[], object] = lambda: None) -> Said:
        """Return its next message, a report or the result; raise the error that the task has raised.

        The result of `sign` changes as long as the process lives. Gone if it has ended or closed its pipe, or something
        else than reports has come; Silent if that has taken longer than the limit (s).
        """
        silent, ended, before = 0.0, 0.0, sign()
        while True:
            self.let_through()
            try:
                _, frame = self.inbox.get(timeout=POLL)
                break
            except Empty:
                now = sign()
            if self.process.poll() is not None:   # a process that it has started holds the pipe
                self.end()
                ended += POLL
            if ended > PATIENCE:
                raise self.gone()
            # Looks are counted, not time: a machine that sleeps is no silence.
            silent, before = (silent + POLL, before) if now == before else (0.0, now)
            if silent > limit:
                raise Silent(f"has been silent for {limit:g} s")
        if frame is None:
            raise self.gone()
        try:
            said: Said = pickle.loads(frame) if self.folder is None else said_in(frame)
        except ValueError:
            raise Forged from None
        if said.kind == "error":
            raise said.what
        return said

    def gone(self) -> Gone:
        """Return the known facts about a process that sends nothing any more."""
        for _ in range(round(PATIENCE / POLL)):
            self.let_through()
            with suppress(subprocess.TimeoutExpired):
                self.process.wait(POLL)
                return Gone(f"ended its process with {self.how_it_ended()}", self.how_it_ended())
        return Gone("has closed the pipe of its process")

    def how_it_ended(self) -> str:
        """Signal or exit code of the process, which has ended."""
        code = self.process.returncode
        with suppress(ValueError):
            return signal.Signals(-code).name if code < 0 else f"exit code {code}"
        return f"signal {-code}"

    def end(self) -> None:
        """End it, whatever it does, and wait for that; with third-party code also the processes that it has started."""
        if self.folder is None:
            self.process.kill()
            with suppress(subprocess.TimeoutExpired):   # where the system itself does not come back
                self.process.wait(PATIENCE)
        elif end_with_children(self.process):
            self.left = True
        assert self.process.stdin is not None
        with suppress(OSError):
            self.process.stdin.close()


def said_in(line: bytes) -> Said:
    """Return the message in a line; ValueError if `serve` cannot have written the line."""
    said = value_of(line)
    if (not isinstance(said, Said) or (said.kind == "error") != isinstance(said.what, Exception)
            or said.kind == "interrupt"):   # only a process with this project's code is asked to end in order
        raise ValueError(f"{said!r}")
    return said


Inbox = SimpleQueue[tuple[WorkerProcess, bytes | None]]


def serve(folder: str | None, copies: str) -> None:
    """Do tasks in this process as they are asked for, with copies in a folder; see `WorkerProcess`."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)   # the first process handles it for all
    SESSION.use(Served(bool(folder)))
    SESSION.use(Copies(Path(copies)))
    if folder:
        signal.signal(signal.SIGTERM, signal.SIG_IGN)   # else it ends without a word until a task begins
        tempfile.tempdir = folder   # unpacked files go with it, however this process ends
    given, said = os.fdopen(os.dup(0), "rb"), os.fdopen(os.dup(1), "wb")
    os.dup2(os.open(os.devnull, os.O_RDONLY), 0)
    os.dup2(2, 1)   # prints are no results
    sys.stdout = sys.stderr
    try:
        sys.argv[:] = pickle.load(given)
    except (EOFError, pickle.UnpicklingError):   # the parent ended before this process was there
        if folder:
            shutil.rmtree(folder, ignore_errors=True)
        return
    tasks: SimpleQueue[bytes] = SimpleQueue()
    own = os.getpid()

    def receive() -> None:
        with suppress(EOFError, pickle.UnpicklingError):
            while True:
                tasks.put(pickle.load(given))
        if folder:
            shutil.rmtree(folder, ignore_errors=True)
            if hasattr(os, "killpg"):
                os.killpg(own, signal.SIGKILL)
        else:
            os.kill(os.getpid(), signal.SIGTERM)   # the task removes its unpacked files
            time.sleep(PATIENCE)
        os._exit(1)

    def send(kind: Kind, what: object) -> None:
        if os.getpid() != own:   # a copy of this process that a task has made
            os._exit(0)
        frame = line_of(Said(kind, what)) if folder else pickle.dumps(pickle.dumps(Said(kind, what)))
        with held_interrupts():   # half of it could not be read
            try:
                said.write(frame)
                said.flush()
            except OSError as error:
                while not isinstance(error, ConnectionError):   # the task has closed the pipe: the other side ends it
                    time.sleep(PATIENCE)
                raise

    Thread(target=receive, daemon=True).start()
    asked = () if folder else (KeyboardInterrupt,)
    caught = (Exception,) if folder else ()   # in a task of this project it is a bug, which ends the process
    with suppress(ConnectionError, *asked):   # nobody wants to know, or more
        while (task := pickle.loads(tasks.get())) is not None:
            folder_here, work = task
            os.chdir(folder_here)
            if not folder:
                signal.signal(signal.SIGTERM, terminate)
            try:
                result = work(partial(send, "report"))
            except asked as error:
                send("interrupt", in_one_line(error))
                break
            except caught as error:
                error.add_note(format_exc())
                send("error", error if isinstance(error, FAILURES) else RuntimeError(format_exc()))
            else:
                send("result", result)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)   # it ends
