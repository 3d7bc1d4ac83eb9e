"""Programs that this process starts: their output, their limit, and their end with this process."""

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from facts import raises
from left_processes import processes_with, require_none

from maglev.files.programs import output_of, python_environment


def run(folder: Path, *lines: str, limit: float = 60.0) -> tuple[int, str]:
    return output_of([sys.executable, "-c", "\n".join(lines)], folder, dict(os.environ), limit)


def test_output_and_exit_code_are_those_of_the_program(tmp_path: Path) -> None:
    said = run(tmp_path, "import os, sys", "print(os.getcwd(), sys.stdin.read())", "sys.exit(3)")
    assert said == (3, f"{tmp_path} \n")
    assert run(tmp_path, "import os", "os.kill(os.getpid(), 11)") == (-signal.SIGSEGV, "")


def test_a_program_that_takes_too_long_is_named_and_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PLACE", str(tmp_path))
    with raises(TimeoutError, sys.executable, "0.2 s"):
        run(tmp_path, "import time", "time.sleep(600)", limit=0.2)
    require_none(tmp_path)


def test_another_python_imports_what_this_one_does(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Packages of `pip --target`, as machines for computing have them, are in `sys.path` alone."""
    (tmp_path / "packages").mkdir()
    (tmp_path / "packages" / "of_mine.py").write_text("print('here')")
    monkeypatch.syspath_prepend(str(tmp_path / "packages"))
    code, printed = output_of([sys.executable, "-c", "import of_mine, maglev.fmi"], tmp_path, python_environment())
    assert (code, printed.strip()) == (0, "here")


STARTS = """
import os, subprocess, sys
from pathlib import Path
sys.path[:] = {path!r}
from maglev.files.programs import output_of
child = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'import time; time.sleep(600)'])"
output_of([sys.executable, "-c", child], Path({folder!r}), dict(os.environ))
"""


@pytest.mark.skipif(not hasattr(os, "killpg"), reason="there are no groups of processes")
def test_nothing_that_it_has_started_survives_the_death_of_this_process(tmp_path: Path) -> None:
    parent = subprocess.Popen([sys.executable, "-c", STARTS.format(path=sys.path, folder=str(tmp_path))],
                              env={**os.environ, "PLACE": str(tmp_path)})
    require_some(tmp_path, 4)   # itself, the keeper, the program and what that has started
    parent.kill()
    parent.wait(60.0)
    require_none(tmp_path)


def require_some(folder: Path, number: int) -> None:
    """Wait until so many processes have the folder in their environment."""
    end = time.monotonic() + 60.0
    while len(processes_with(folder)) < number:
        assert time.monotonic() < end, processes_with(folder)
        time.sleep(0.05)
