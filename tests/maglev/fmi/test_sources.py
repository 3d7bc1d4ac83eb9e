"""One function parses Python, under a lock: builds run in threads; CPython 3.11 counts their depth together."""

import ast
from pathlib import Path

import pytest

from maglev.files.packages import PACKAGES

PROJECT = Path(__file__).parents[3]


@pytest.mark.parametrize("package", sorted(PACKAGES))
def test_nothing_else_parses(package: str) -> None:
    places = {str(file.relative_to(PROJECT)) for file in (PROJECT / package).rglob("*.py")
              for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
              if isinstance(node, ast.Attribute) and ast.unparse(node) in ("ast.parse", "ast.literal_eval")}
    assert places <= {"maglev/language/sources.py"}
