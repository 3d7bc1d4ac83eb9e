"""Help of every command: one line an option at 80 columns, and examples to paste."""

import re
import shlex
import subprocess
import sys
from collections.abc import Iterator
from typing import Any

import pytest
from command_line import maglev
from typer.main import get_command

from maglev.cli.app import app
from maglev.files.packages import PACKAGES

MOST = 10   # options before those of the other panels


def commands(words: tuple[str, ...] = (), command: Any = None) -> Iterator[tuple[tuple[str, ...], Any]]:
    command = command or get_command(app)
    yield words, command
    for name, each in getattr(command, "commands", {}).items():
        yield from commands((*words, name), each)


COMMANDS = dict(commands())
every_command = pytest.mark.parametrize("words", COMMANDS, ids=lambda words: " ".join(words) or "maglev")


def sections(text: str) -> dict[str, list[str]]:
    """Lines of each section, from its heading to the next."""
    parts = re.split(r"^(\S.*):\n(?=  \S)", text, flags=re.MULTILINE)
    return dict(zip(parts[1::2], (part.strip("\n").splitlines() for part in parts[2::2]), strict=True))


@every_command
def test_each_option_takes_one_line(words: tuple[str, ...]) -> None:
    said = maglev(*words, "--help").output
    assert max(map(len, said.splitlines())) <= 80
    assert not re.search(r"[`]|x[<>]=", said)
    options = sections(said)["Options"]
    assert options[-1].split(", ")[0].strip() == "-h" and len(options) <= MOST
    rows = [row for panel, lines in sections(said).items() if panel not in ("Arguments", "Commands") for row in lines]
    if words:   # those of all commands are typer's
        assert [row for row in rows if not row.startswith("  -")] == []
        assert len(rows) == 1 + sum(each.param_type_name == "option" for each in COMMANDS[words].params)


@every_command
def test_examples_are_commands_with_known_options(words: tuple[str, ...]) -> None:
    said = maglev(*words, "--help").output.replace("\\\n", "")
    examples = [shlex.split(line) for line in said.splitlines() if re.match(" {4}\\S", line)]
    for program, *rest in examples:
        assert program == "maglev"
        path = next(tuple(rest[:k]) for k in (2, 1) if tuple(rest[:k]) in COMMANDS)
        known = {flag for each in COMMANDS[path].params for flag in (*each.opts, *each.secondary_opts)}
        assert {word for word in rest if word.startswith("--")} <= known | {"--help"}, rest
    assert hasattr(COMMANDS[words], "commands") or any(rest[1:len(words) + 1] == [*words] for rest in examples)


def test_first_page_names_every_command_in_one_line() -> None:
    said = maglev("--help").output
    listed = dict(re.findall(r"^  ([a-z]+) {2,}(\S.*)$", said, re.MULTILINE))
    assert listed.keys() == {words[0] for words in COMMANDS if len(words) == 1}
    assert listed["list"].startswith("List the scenarios and the FMUs, or ")
    assert maglev("-h").output == said


def test_help_imports_little() -> None:
    """The command line, with options and errors: no description of a stage, neither NumPy nor parts of rich."""
    code = ("import sys\nbefore = set(sys.modules)\nfrom maglev.__main__ import main\nsys.argv = ['maglev', '--help']\n"
            "try:\n    main()\nfinally:\n    print(*sorted(set(sys.modules) - before), file=sys.stderr)")
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    imported = set(done.stderr.split())
    assert {"maglev.cli.app", "typer.main"} <= imported
    assert {name.split(".")[0] for name in imported} - sys.stdlib_module_names <= {
        *PACKAGES, "typer", "click", "shellingham", "typing_extensions", "annotated_doc", "rich", "colorama"}
    assert not [name for name in imported if name.startswith("rich.")]
    ours = [name for name in sorted(imported) if name.count(".") == 2 and name.startswith("maglev.")]
    assert [name for name in ours if not name.startswith("maglev.cli.")] == [
        "maglev.files.errors", "maglev.files.interrupts", "maglev.files.packages", "maglev.identification.settings",
        "maglev.language.sources", "maglev.scenario.options"]
