"""The texts of functions, and where they stand."""

import ast
import inspect
import linecache
import re
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from maglev.language.program import Untranslatable
from maglev.language.sources import parsed


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
    if inspect.iscoroutinefunction(function):
        raise Untranslatable(f"{shown_file(function)}, line {code.co_firstlineno}: async: expected a plain def")
    found = definitions_in(text, code.co_filename).get((code.co_name, code.co_firstlineno)) if text else None
    if found is None:
        raise Untranslatable(f"{shown_file(function)}, line {code.co_firstlineno}: the text of {code.co_name} is not "
                             "there: expected a def in a file")
    return found


def place_of_attribute(kind: type, text: str) -> str:
    """File and line, with a colon, where a class sets the attribute that a text begins with; nothing if not found."""
    begins = re.match(r"self\.\w+", text)
    setter = inspect.getattr_static(kind, "__init__")
    if begins is None or not inspect.isfunction(setter):
        return ""
    try:
        node = definition_of(setter)
    except Untranslatable:
        return ""
    lines = [each.lineno for each in ast.walk(node) if isinstance(each, ast.Attribute)
             and isinstance(each.ctx, ast.Store) and ast.unparse(each) == begins[0]]
    return f"{shown_file(setter)}, line {lines[-1] if lines else node.lineno}: "
