"""Standard streams that nobody reads, that are full, or that were closed before the command began."""

import os
import pty
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

import pytest
import typer
from command_line import maglev

from maglev.cli.terminal import one_line_errors

MAGLEV = [sys.executable, "-m", "maglev"]
PRINTED = {"a table": ["list"], "the help": ["--help"], "a line": ["--version"],
           "a model": ["linearise", "Plant2DOF", "--at", "v=20mm"]}


def redirected(redirections: str, *command: str) -> subprocess.CompletedProcess[str]:
    """Run a command with redirections as a shell has them."""
    return subprocess.run(["sh", "-c", f'exec "$@" {redirections}', "sh", *command], capture_output=True, text=True,
                          check=False)


@pytest.mark.few(2)
@pytest.mark.parametrize("what", PRINTED)
@pytest.mark.usefixtures("slow")
def test_a_reader_that_has_gone_ends_the_command_without_a_word(what: str) -> None:
    """As `maglev list | head` does; the exit code is that of SIGPIPE, not 1, which means that a check deviates."""
    reader, writer = os.pipe()
    os.close(reader)
    command = subprocess.run([*MAGLEV, *PRINTED[what]], stdout=writer, stderr=subprocess.PIPE, check=False)
    os.close(writer)
    assert command.returncode == 141
    assert command.stderr == b""


@pytest.mark.few(2)
@pytest.mark.parametrize("what", PRINTED)
@pytest.mark.usefixtures("slow")
def test_a_full_disk_behind_the_output_is_one_line(what: str) -> None:
    done = redirected(">/dev/full", *MAGLEV, *PRINTED[what])
    assert (done.returncode, done.stderr) == (2, "maglev: standard output: No space left on device\n")


@pytest.mark.usefixtures("slow")
def test_errors_that_cannot_be_written_keep_their_exit_code() -> None:
    for redirection in ("2>/dev/full", "2>&-"):
        assert redirected(redirection, *MAGLEV, "run", "no-such-run").returncode == 2


@pytest.mark.usefixtures("slow")
def test_a_closed_output_leaves_the_result(tmp_path: Path) -> None:
    file = tmp_path / "lqi.py"
    assert redirected("<&- >&- 2>&-", *MAGLEV, "new", "controller", str(file)).returncode == 0
    assert "class LQI:" in file.read_text()


def test_no_file_gets_the_number_of_a_closed_stream(tmp_path: Path) -> None:
    """What an FMU prints would be written into it."""
    script = "import os, sys; from maglev.cli.streams import whole_streams; whole_streams(); " \
             "file = os.open(sys.argv[1], os.O_WRONLY | os.O_CREAT); os.write(file, str(file).encode()); print('lost')"
    redirected("<&- >&- 2>&-", sys.executable, "-c", script, str(tmp_path / "number"))
    assert int((tmp_path / "number").read_text()) > 2


@pytest.mark.usefixtures("slow")
def test_a_bug_is_no_deviation() -> None:
    """Of a check the exit code 1 says that it deviates; Python ends with it after any error."""
    script = "from maglev.cli.streams import CommandLine\napp = CommandLine()\n@app.command()\ndef run(): 1 / 0\napp()"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert "ZeroDivisionError" in done.stderr


@pytest.mark.usefixtures("slow")
def test_a_build_shows_its_progress_where_a_person_looks_on(tmp_path: Path) -> None:
    """And only there: a file of what was said has no bars in it."""
    terminal, screen = pty.openpty()
    arguments = ("build", "PID2DOF", "PID3DOF", "--fmus", str(tmp_path))
    with subprocess.Popen([*MAGLEV, *arguments], stdout=subprocess.DEVNULL, stderr=screen) as build:
        os.close(screen)
        shown = b""
        with suppress(OSError):   # the end of what a terminal shows
            while more := os.read(terminal, 100_000):
                shown += more
    os.close(terminal)
    assert build.returncode == 0
    assert b"FMUs" in shown
    assert b" 50%" in shown
    done = maglev(*arguments)
    assert (done.exit_code, done.stderr) == (0, "")


def test_too_deep_nesting_for_a_library_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    """Such as an expression for the translator to C; printing the traceback would itself recurse too deeply."""
    def nested(level: int) -> int:
        return nested(level + 1)

    with pytest.raises(typer.Exit) as end, one_line_errors(debug=False):
        nested(0)
    assert end.value.exit_code == 2
    assert capsys.readouterr().err.startswith("maglev: a file is nested too deeply, expected ")
