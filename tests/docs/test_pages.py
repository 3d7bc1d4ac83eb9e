"""What the pages tell people to type: commands with options that there are, runs, files, imports, scripts that load."""

import ast
import re
import runpy
import shlex
import sys
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType

import pytest
import typer

from maglev.cli.app import app
from maglev.descriptions.own_fmus import DEFINITIONS
from maglev.scenario.layers import packaged_files, packaged_runs

ROOT = Path(__file__).parents[2]
PAGES = [*(ROOT / name for name in ("README.md", "CONTRIBUTING.md", "MAINTAINING.md")),
         *sorted((ROOT / "docs").glob("*.md")), *sorted((ROOT / "examples").rglob("*.md"))]
SCRIPTS = sorted((ROOT / "benchmarks").glob("*.py"))

every_page = pytest.mark.parametrize("path", PAGES, ids=lambda path: str(path.relative_to(ROOT)))

# Folders of this repository; others that pages name are made by commands, or are the reader's.
FOLDERS = ("benchmarks", "controller_fmu", "docs", "examples", "maglev", "plant_fmu", "pmlsm", "scenarios", "stages",
           "studies", "tests", "tools")
# What such a folder had, or a package was called, before.
OTHERS = ("identification",)
# Not installed with the tests: clusters.
ELSEWHERE = ("dask_jobqueue", "dask_kubernetes")


def blocks(path: Path) -> list[str]:
    """Indented blocks of a page, without their indentation; fenced ones are not used."""
    found: list[list[str]] = [[]]
    for line in path.read_text(encoding="utf-8").splitlines():
        if line.startswith("    "):
            found[-1].append(line[4:])
        elif found[-1] and line.strip():
            found.append([])
    return ["\n".join(lines) for lines in found if lines]


def spans(path: Path) -> list[str]:
    """What stands in single backticks, line by line."""
    return [span for line in path.read_text(encoding="utf-8").splitlines() if not line.startswith("    ")
            for span in re.findall(r"`([^`]+)`", line)]


def commands(path: Path, program: str) -> list[list[str]]:
    """Words of the commands of a page that begin with a program, without comments and what a pipe does with them."""
    lines = [line for block in blocks(path) for line in block.replace("\\\n", " ").splitlines()]
    found = []
    for line in (*lines, *spans(path)):
        if line.startswith(f"{program} "):
            words = shlex.split(line.replace("'", "\\'") if line.count("'") % 2 else line, comments=True)
            found.append(words[:next((k for k, word in enumerate(words) if word in ("|", "&&", ">", ";")), len(words))])
    return found


@every_page
def test_commands_have_the_options_that_pages_name(path: Path) -> None:
    known = typer.main.get_command(app)
    for words in commands(path, "maglev"):
        command, rest = known, words[1:]
        while rest and not rest[0].startswith("-") and rest[0] in getattr(command, "commands", {}):
            command, rest = command.commands[rest[0]], rest[1:]   # type: ignore[attr-defined]
        options = {option for parameter in command.params for option in (*parameter.opts, *parameter.secondary_opts)}
        if getattr(command, "commands", None) and command is known:
            assert not rest or rest[0] in ("--help", "--version", "--install-completion", "…", "COMMAND"), words
        for word in rest:
            if word.startswith("--"):
                assert word in {*options, "--help"}, f"{' '.join(words)}: there is no {word}"


def test_commands_are_found() -> None:
    assert sum(len(commands(path, "maglev")) for path in PAGES) > 100


@every_page
def test_no_line_is_a_comment_on_the_site(path: Path) -> None:
    """MyST leaves out a line that begins with a percent sign, also in the middle of a paragraph."""
    lost = [line for line in path.read_text(encoding="utf-8").splitlines() if line.lstrip().startswith("%")]
    assert lost == []


@every_page
def test_runs_and_fmus_that_pages_name_are_there(path: Path) -> None:
    known = {*packaged_runs(), *packaged_files(), *DEFINITIONS}
    for words in commands(path, "maglev"):
        if words[1:2] in (["run"], ["report"], ["compare"], ["check"]):
            for word in words[2:]:
                if re.fullmatch(r"[23]dof-[\w.-]+", word) and not word.endswith((".toml", ".csv")):
                    assert word in known, f"{' '.join(words)}: there is no run {word}"


@every_page
def test_files_that_pages_name_are_there(path: Path) -> None:
    for span in spans(path):
        if re.fullmatch(r"[\w.-]+(/[\w.-]+)+/?", span) and span.split("/")[0] in (*FOLDERS, *OTHERS):
            beside = path.parent / span
            assert (ROOT / span).exists() or beside.exists() or "_build" in span, f"there is no {span}"


def imports(block: str) -> list[tuple[str, str]]:
    """Modules that a block of Python imports, and names from them; none of a block in another language."""
    try:
        tree = ast.parse(block)
    except SyntaxError:
        return []
    return [(module, name) for node in ast.walk(tree)
            for module, name in ([(alias.name, "") for alias in node.names] if isinstance(node, ast.Import) else
                                 [(node.module or "", alias.name) for alias in node.names]
                                 if isinstance(node, ast.ImportFrom) else [])]


@every_page
def test_imports_of_pages_are_there(path: Path) -> None:
    for block in blocks(path):
        for module, name in imports(block):
            if module.split(".")[0] in ELSEWHERE:
                continue
            found: ModuleType = import_module(module)
            assert not name or hasattr(found, name) or find_spec(f"{module}.{name}"), f"{module} has no {name}"


@every_page
def test_functions_that_pages_call_are_there(path: Path) -> None:
    import maglev

    for name in re.findall(r"\bmaglev\.([a-z]\w*)\(", path.read_text(encoding="utf-8")):
        assert hasattr(maglev, name), f"maglev has no {name}"


@every_page
def test_scripts_that_pages_name_are_there(path: Path) -> None:
    for program in ("python", "PYTHONPATH=tests/support python"):
        for words in commands(path, program):
            script = next((word for word in words if word.endswith(".py")), None)
            assert script is None or (ROOT / script).exists() or (path.parent / script).exists(), script


def test_every_benchmark_is_run() -> None:
    """By a target of the Makefile, or by a benchmark that is."""
    targets = (ROOT / "Makefile").read_text(encoding="utf-8")
    imported = {module.split(".")[0] for path in SCRIPTS for module, _ in imports(path.read_text(encoding="utf-8"))}
    assert not [path.name for path in SCRIPTS if f"benchmarks/{path.name}" not in targets and path.stem not in imported]


@pytest.mark.parametrize("path", SCRIPTS, ids=lambda path: path.name)
def test_benchmarks_load(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """They take too long to be run here; what they import may have changed."""
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    monkeypatch.setattr(sys, "argv", [str(path)])
    runpy.run_path(str(path), run_name="imported")
