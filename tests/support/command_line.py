"""The command line as a user types it."""

import os
import subprocess
import sys
from pathlib import Path
from unittest.mock import patch

from typer.main import get_command
from typer.testing import CliRunner, Result

from maglev.cli.app import app
from maglev.scenario.layers import PACKAGED

SCRIPTS = PACKAGED / "scripts"
COMMAND = get_command(app)   # which typer makes again at each call, in a third of the time of most


def maglev(*arguments: str | Path) -> Result:
    """Run the command with the arguments."""
    with patch("typer.testing._get_command", lambda _: COMMAND):
        return CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=False)


def error_line(result: Result) -> str:
    """The error of a failed command: one line, exit code 2, no traceback."""
    assert result.exit_code == 2, result.output
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1, result.stderr
    assert lines[0].startswith("maglev: ")
    return lines[0]


def run_script(name: str, fmus: Path, out: Path, **settings: str) -> None:
    """Run a command line of the folder scripts, the result to a file; fails the test on a warning."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    done = subprocess.run(["sh", str(SCRIPTS / name)], cwd=out.parent, capture_output=True, text=True, check=True,
                          env={**os.environ, "FMUS": str(fmus), "OUT": str(out), "PATH": path, **settings})
    assert done.stdout + done.stderr == f"results: {out}\n", name
