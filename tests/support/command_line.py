"""The command line as a user types it."""

from pathlib import Path

from typer.testing import CliRunner, Result

from maglev.cli.app import app


def maglev(*arguments: str | Path) -> Result:
    """Run the command with the arguments."""
    return CliRunner().invoke(app, [str(a) for a in arguments], catch_exceptions=False)


def error_line(result: Result) -> str:
    """The error of a failed command: one line, exit code 2, no traceback."""
    assert result.exit_code == 2, result.output
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1, result.stderr
    assert lines[0].startswith("maglev: ")
    return lines[0]
