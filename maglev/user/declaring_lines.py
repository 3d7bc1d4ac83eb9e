"""The lines in which a user's class declares its ports and parameters."""

import ast

from maglev.fmi.declaration import TABLES
from maglev.language.sources import parsed


def table_lines(tree: ast.Module, name: str | None) -> list[tuple[int, int]]:
    """First and last lines of the tables of a class; of all without a name."""
    return [(node.lineno, node.end_lineno or node.lineno) for statement in tree.body
            if isinstance(statement, ast.ClassDef) and name in (None, statement.name) for node in statement.body
            if isinstance(node, (ast.Assign, ast.AnnAssign))
            and any(isinstance(target, ast.Name) and target.id in TABLES
                    for target in (node.targets if isinstance(node, ast.Assign) else [node.target]))]


def declaring_line(text: str, name: str | None, word: str) -> int | None:
    """Line in which a class, or any class, declares a port, a parameter, or a table of these; None without one."""
    tree = parsed(text)
    tables = table_lines(tree, name)
    words = [(node.lineno, node.value if isinstance(node, ast.Constant) else node.id)
             for node in ast.walk(tree) if isinstance(node, ast.Constant | ast.Name)]
    return next((line for line, known in words if known == word
                 and any(first <= line <= last for first, last in tables)), None)
