"""Standard streams of the command line that are there whatever was closed, and a command line whose reader may go."""

import io
import os
import sys
from typing import Any

from maglev.cli.help_text import Group
from maglev.cli.terminal import say

UNREAD = 141   # exit code where nobody reads the output any more: that of a command which SIGPIPE ends
ERROR = 2


class Output(io.FileIO):
    """Standard output or error.

    If the reader of the output has gone, as with `head`, the command ends in order. Output next to the results is lost
    if it cannot be written, because that is no reason to end a run.
    """

    def write(self, data: Any, /) -> int:
        try:
            return super().write(data)
        except OSError as error:
            # The rest of the buffer must not fail once more at the end of the process.
            with open(os.devnull, "wb") as nothing:
                os.dup2(nothing.fileno(), self.fileno())
            if self.fileno() == 2:
                return len(data)
            if isinstance(error, BrokenPipeError):
                raise SystemExit(UNREAD) from None
            say(f"standard output: {error.strerror}")
            raise SystemExit(ERROR) from None


def whole_streams() -> None:
    """Open what was closed, lest a file of results get its number; have `Output` write what is printed."""
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.set_inheritable(os.open(os.devnull, os.O_RDWR), True)   # it gets the lowest free number, this one
    for name, number in (("stdout", 1), ("stderr", 2)):
        stream = getattr(sys, name)
        setattr(sys, name, io.TextIOWrapper(
            io.BufferedWriter(Output(number, "w", closefd=False)), encoding=getattr(stream, "encoding", "utf-8"),
            errors="replace", line_buffering=getattr(stream, "line_buffering", False),
            write_through=getattr(stream, "write_through", False)))


class CommandLine(Group):
    """Run commands as a program; exit code 1 means only that a check deviates."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        whole_streams()
        try:
            return super().__call__(*arguments, **options)
        except Exception as error:
            sys.excepthook(type(error), error, error.__traceback__)   # it prints the traceback
            raise SystemExit(ERROR) from None
