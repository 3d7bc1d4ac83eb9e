"""The texts of functions, and where they stand."""

import ast
import inspect
import linecache
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from fmi_export.language.program import Untranslatable
from fmi_export.sources import parsed


@lru_cache(maxsize=512)
def definitions_in(text: str, file: str) -> dict[tuple[str, int], ast.FunctionDef]:
    """The functions in a module's text by name and by their first line, that of a decorator if there is one."""
    return {(node.name, min([node.lineno, *(each.lineno for each in node.decorator_list)])): node
            for node in ast.walk(parsed(text, file)) if isinstance(node, ast.FunctionDef)}


def shown_file(function: Callable[..., Any]) -> str:
    """File of a function as messages and comments name it: below its package, or its last name."""
    module = getattr(function, "__module__", "") or ""
    path = Path(inspect.unwrap(function).__code__.co_filename)
    parts = module.split(".")
    below = Path(*parts).with_suffix(".py")
    return below.as_posix() if len(parts) > 1 and path.parts[-len(parts):] == below.parts else path.name


def definition_of(function: Callable[..., Any]) -> ast.FunctionDef:
    """Syntax tree of a function; Untranslatable if its text is not to be had."""
    code = function.__code__
    linecache.checkcache(code.co_filename)
    text = "".join(linecache.getlines(code.co_filename, function.__globals__))
    found = definitions_in(text, code.co_filename).get((code.co_name, code.co_firstlineno)) if text else None
    if found is None:
        raise Untranslatable(f"{shown_file(function)}, line {code.co_firstlineno}: the text of {code.co_name} is not "
                             "there: expected a def in a file")
    return found
