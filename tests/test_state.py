"""Modules keep no state: objects that live on from one call to the next belong to the session."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from maglev.files.packages import PACKAGES

ROOT = Path(__file__).parents[1]

# Methods that change a list, a set, a dictionary or an event, and functions whose result is one.
CHANGES = {"add", "append", "appendleft", "clear", "discard", "extend", "insert", "pop", "popitem", "popleft", "remove",
           "set", "setdefault", "update"}
CONTAINERS = {"Counter", "Event", "count", "defaultdict", "deque", "dict", "iter", "list", "set"}

# What the interpreter itself keeps, and who may change it: the modules that execute Python files of users, a worker
# process for itself, and the command line for an empty variable that NumPy cannot read.
INTERPRETER = ("os.environ", "sys.", "tempfile.tempdir")
ALLOWED = {"maglev/user/source.py", "maglev/user/build.py", "maglev/files/worker_process.py",
           "maglev/files/environment.py", "maglev/fmi/slave.py"}


def is_container(value: ast.expr | None) -> bool:
    """Return True if the value of a name can change: a literal, a comprehension, or a call that makes a container."""
    if isinstance(value, ast.Call):
        return ast.unparse(value.func).rpartition(".")[2] in CONTAINERS
    return isinstance(value, ast.Dict | ast.DictComp | ast.List | ast.ListComp | ast.Set | ast.SetComp)


def containers(tree: ast.AST) -> set[str]:
    """Names of the containers of a module, and of its classes."""
    names = set()
    for node in ast.walk(tree):
        for each in node.body if isinstance(node, ast.Module | ast.ClassDef) else ():
            targets = each.targets if isinstance(each, ast.Assign) else [each.target] if isinstance(
                each, ast.AnnAssign) else []
            names |= {target.id for target in targets if isinstance(target, ast.Name)
                      and is_container(each.value)}   # type: ignore[attr-defined]
    return names


def changed(tree: ast.AST) -> Iterator[tuple[int, str]]:
    """Lines with what changes there: `X[…] = …`, `del X[…]`, `X.add(…)`, `X.y = …`, each by its X, and `global X`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Global):
            yield node.lineno, f"global {', '.join(node.names)}"
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in CHANGES:
            yield node.lineno, ast.unparse(node.func.value)
        elif isinstance(node, ast.Assign | ast.AugAssign | ast.AnnAssign | ast.Delete):
            for target in [node.target] if isinstance(node, ast.AugAssign | ast.AnnAssign) else node.targets:
                if isinstance(target, ast.Subscript):
                    yield node.lineno, ast.unparse(target.value)
                elif isinstance(target, ast.Attribute):
                    yield node.lineno, ast.unparse(target)


def state_of(tree: ast.AST, everywhere: set[str], interpreter: bool) -> list[str]:
    """Lines of a module that change a container of a module; with `interpreter` also what the interpreter keeps."""
    own, found = containers(tree), []
    for line, what in changed(tree):
        last = what.rpartition(".")[2]
        of_module = what in own or (last.isupper() and last in everywhere) or what.startswith("global ")
        if of_module or (interpreter and what.startswith(INTERPRETER)):
            found.append(f"{line}: {what}")
    return found


def test_no_module_keeps_mutable_state() -> None:
    trees = {path: ast.parse(path.read_text(encoding="utf-8")) for package in PACKAGES
             for path in (ROOT / package).rglob("*.py")}
    everywhere = set().union(*map(containers, trees.values()))
    assert not {str(path.relative_to(ROOT)): found for path, tree in trees.items()
                if (found := state_of(tree, everywhere, str(path.relative_to(ROOT)) not in ALLOWED))}


@pytest.mark.parametrize("text", [
    "KEPT = {}\ndef keep(x): KEPT[x] = 1", "KEPT = set()\ndef keep(x): KEPT.add(x)", "def keep():\n    global KEPT",
    "from maglev.cosim import fmu\nfmu.ELSEWHERE.append(1)", "ELSEWHERE[:] = [1]", "import os\nos.environ['A'] = 'b'",
    "import sys\nsys.meta_path.insert(0, None)", "class Table:\n    KNOWN = []\ndef note(x): Table.KNOWN.append(x)"])
def test_state_is_found(text: str) -> None:
    assert state_of(ast.parse(text), {"ELSEWHERE", "KNOWN"}, interpreter=True)
