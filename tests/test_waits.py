"""Everything ends: what waits for something else has a limit, or stands here with the reason why it ends."""

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

from maglev.files.packages import PACKAGES

ROOT = Path(__file__).parents[1]

# Calls that wait, with the number of their positional arguments from which on one of these is a limit.
WAITS = {"wait": 1, "communicate": 2, "join": 1, "get": 1, "result": 1, "exception": 1, "acquire": 2, "select": 4,
         "flock": 9, "lockf": 9, "locking": 9, "run": 9, "call": 9, "check_call": 9, "check_output": 9, "shutdown": 9,
         "map": 9, "as_completed": 2, "urlopen": 3}
OWNERS = {**dict.fromkeys(("run", "call", "check_call", "check_output"), "subprocess"), "map": "pool",
          "select": "select"}   # of calls that are many others' as well

# By file, what waits without a limit there, and why it ends.
ENDS = {
    "maglev/files/programs.py": {
        "pool.shutdown()": "each program has `LONGEST`"},
    "maglev/files/one_writer.py": {
        "fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)": "it does not wait",
        "msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)": "it does not wait"},
    "maglev/files/scratch.py": {
        "fcntl.flock(lock, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)":
            "who waits has just made the folder, which another process holds while it looks at it"},
    "maglev/files/worker_process.py": {
        "tasks.get()": "the process ends when the pipe does from which tasks come"},
    "maglev/scenario/catalogue.py": {
        "loop.result()": "it runs a compiler, which has a limit",
        "pool.map(lambda definition: make(definition, unfinished), chosen)": "they run a compiler, which has a limit"},
    "maglev/many/vector_environment.py": {
        "self.pool.map(share, self.shares)": "threads that step stages in C, so many steps",
        "self.pool.shutdown()": "the same"},
    "maglev/many/batches.py": {
        "as_completed([*waiting])": "threads that step FMUs of this project in C, so many steps",
        "future.result()": "it is done", "future.exception()": "the loop in C looks at `ended`",
        "pool.shutdown(cancel_futures=True)": "the loop in C looks at `ended`"},
    "maglev/many/dask_workers.py": {
        "as_completed(more())": "the scheduler gives up a worker that it has lost",
        "future.result()": "it is done"}}


def waits(tree: ast.AST) -> Iterator[str]:
    """Calls in a module that wait for something else without a limit."""
    for node in ast.walk(tree):
        if not isinstance(node, ast.Call):
            continue
        name = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        owner = ast.unparse(node.func.value) if isinstance(node.func, ast.Attribute) else ""
        if name not in WAITS or any(word.arg in ("timeout", "limit") for word in node.keywords):
            continue
        if OWNERS.get(name, owner) not in owner or any(ast.unparse(word) == "wait=False" for word in node.keywords):
            continue
        if owner != "spelling" and len(node.args) < WAITS[name]:
            yield ast.unparse(node)


def test_every_wait_has_a_limit_or_a_reason() -> None:
    found: dict[str, set[str]] = {}
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("*.py")):
            if calls := set(waits(ast.parse(path.read_text(encoding="utf-8")))):
                found[path.relative_to(ROOT).as_posix()] = calls
    assert found == {file: set(calls) for file, calls in ENDS.items()}
    assert all(reason for calls in ENDS.values() for reason in calls.values())


@pytest.mark.parametrize(("text", "number"), [
    ("process.wait()", 1), ("process.wait(3.0)", 0), ("process.wait(timeout=3.0)", 0), ("inbox.get()", 1),
    ("inbox.get(timeout=1.0)", 0), ("','.join(names)", 0), ("thread.join()", 1), ("subprocess.run(['a'])", 1),
    ("subprocess.run(['a'], timeout=1)", 0), ("process.communicate()", 1), ("pool.map(one, many)", 1),
    ("map(one, many)", 0), ("select.select([a], [], [])", 1), ("select.select([a], [], [], 1.0)", 0)])
def test_the_search_finds_waits(text: str, number: int) -> None:
    assert len(list(waits(ast.parse(text)))) == number
