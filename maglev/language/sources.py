"""The Python modules that an FMU carries, renamed so that no other module of the process is taken for them."""

import ast
import re
import threading
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

PARSING = threading.Lock()   # builds run side by side, and CPython's parser counts its depth for all threads together


def parsed(text: str, file: str = "<unknown>") -> ast.Module:
    """Syntax tree of a module's text, one at a time in this process; SyntaxError names the file."""
    with PARSING:
        return ast.parse(text, file)


def parsed_expression(text: str) -> ast.expr:
    """Syntax tree of an expression; see `parsed`."""
    with PARSING:
        return ast.parse(text, mode="eval").body


def carried_modules(entry: str, packages: tuple[str, ...]) -> dict[str, str]:
    """Return the text of a module and of all modules that it imports from packages or modules, by dotted name."""
    texts: dict[str, str] = {}
    waiting = [entry]
    while waiting:
        module = waiting.pop()
        if module in texts:
            continue
        texts[module] = module_path(module).read_text(encoding="utf-8")
        waiting.extend(imported for imported in imported_modules(module, texts[module])
                       if is_of(imported, packages))
    return texts


def is_of(module: str, packages: tuple[str, ...]) -> bool:
    """Return True if a module is one of the given packages and modules, or is in one."""
    return any(module == package or module.startswith(f"{package}.") for package in packages)


def module_path(module: str) -> Path:
    spec = find_spec(module)
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"module {module} not found, expected it next to the others of the FMU")
    return Path(spec.origin)


@lru_cache(maxsize=1024)   # FMUs have most of their modules in common
def imported_modules(module: str, text: str) -> tuple[str, ...]:
    """Modules that a module's text imports, relative ones resolved."""
    imported: list[str] = []
    for node in ast.walk(parsed(text)):
        if isinstance(node, ast.ImportFrom) and node.module:
            parent = module.split(".")[:-node.level] if node.level else []
            imported.append(".".join([*parent, node.module]))
        elif isinstance(node, ast.Import):
            imported.extend(alias.name for alias in node.names)
    return tuple(imported)


def renamed(text: str, packages: tuple[str, ...], prefix: str) -> str:
    """Return the text with imports of the given packages redirected to copies inside another package."""
    names = "|".join(re.escape(name) for name in sorted(packages, key=len, reverse=True))
    return re.sub(rf"(^\s*|; )(from|import) ({names})\b", rf"\1\2 {prefix}.\3", text, flags=re.MULTILINE)
