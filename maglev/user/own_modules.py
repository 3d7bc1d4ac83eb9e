"""The file of a user's controller and the modules next to it, as an FMU carries them: under names of their own."""

import ast
import hashlib
import sys
from dataclasses import dataclass
from pathlib import Path

from maglev.files.cache import digest_at
from maglev.files.errors import ControllerError
from maglev.files.packages import BLOCKS, HERE, PACKAGES
from maglev.fmi.trouble import OWN
from maglev.language.sources import parsed


@dataclass(frozen=True)
class OwnModule:
    """A user's module: its file, its text, and its text with imports of the names in an FMU."""

    file: Path
    text: str
    renamed: str


@dataclass(frozen=True)
class OwnModules:
    """A controller's file and the modules next to it that it imports."""

    modules: dict[str, OwnModule]   # by name in an FMU; the controller's file first
    requires: tuple[str, ...]       # packages that are neither next to it, nor ours, nor Python's own
    problems: tuple[str, ...]       # imports that an FMU could not make

    @property
    def sha256(self) -> tuple[tuple[str, str], ...]:
        return tuple((module.file.name, digest_at(module.file)) for module in self.modules.values())


def own_modules(file: Path) -> OwnModules:
    """Read a controller's file, and the modules that it imports from its folder.

    SyntaxError, UnicodeDecodeError or ValueError if a file is not in Python, ControllerError if a module next to it has
    the name of a package of this project.
    """
    reader = Reader(file.absolute().parent)
    waiting: list[tuple[str, Path]] = [(file.stem, file)]
    modules: dict[str, OwnModule] = {}
    while waiting:
        name, path = waiting.pop(0)
        if own_name(name) not in modules:
            text = path.read_text(encoding="utf-8-sig")
            renamed = reader.renamed(name, path, text)
            modules[own_name(name)] = OwnModule(path, text, renamed)
            waiting += reader.imported
            reader.imported = []
    return OwnModules(modules, tuple(sorted(reader.requires)), tuple(reader.problems))


def own_name(module: str) -> str:
    """Name in an FMU of a user's module: no two have the same, as `lib.gains` and `lib_gains` would."""
    flat = "".join(letter if letter.isascii() and letter.isalnum() else "_" for letter in module)
    return OWN + (flat if flat == module else f"{flat}_{hashlib.sha256(module.encode()).hexdigest()[:8]}")


class Reader:
    """Reads modules of a folder; keeps in `imported` what they import from it, in `requires` what from elsewhere."""

    def __init__(self, folder: Path):
        self.folder = folder
        self.imported: list[tuple[str, Path]] = []
        self.requires: set[str] = set()
        self.problems: list[str] = []

    def path(self, module: str) -> Path | None:
        beside = self.folder.joinpath(*module.split("."))
        return next((path for path in (beside / "__init__.py", beside.with_suffix(".py")) if path.is_file()), None)

    def own(self, module: str) -> bool:
        """Return True if a module is the user's, and so is read. ControllerError if it has a name of this project."""
        path, top = self.path(module), module.split(".")[0]
        if top in PACKAGES:
            if path is not None and HERE not in path.resolve().parents:
                raise ControllerError(f"{path}: maglev-fmus has a module {module}, expected another name for the file "
                                      "next to the controller")
            path = None
        if path is not None:
            self.imported.append((module, path))
        return path is not None

    def renamed(self, name: str, file: Path, text: str) -> str:
        """Text whose imports from the folder have the names of an FMU, line by line as before."""
        lines = text.encode("utf-8").split(b"\n")
        nodes = [node for node in ast.walk(parsed(text, str(file)))
                 if isinstance(node, (ast.Import, ast.ImportFrom))]
        for node in sorted(nodes, key=lambda node: (node.lineno, node.col_offset), reverse=True):
            written = self.imports(name, file, node)
            if written is not None:
                assert node.end_lineno is not None
                first, last = node.lineno - 1, node.end_lineno - 1
                after = lines[last][node.end_col_offset:]
                lines[first] = lines[first][:node.col_offset] + written.encode() + after
                lines[first + 1:last + 1] = [b""] * (last - first)
        return b"\n".join(lines).decode("utf-8")

    def imports(self, name: str, file: Path, node: ast.Import | ast.ImportFrom) -> str | None:
        """Return an import with the names of an FMU; None if it does not change."""
        place = f"{file.name}, line {node.lineno}"
        if isinstance(node, ast.Import):
            parts = [self.module(place, alias) for alias in node.names]
            kept = [ast.unparse(ast.Import([alias])) for alias in node.names]
            return None if not any(parts) else "; ".join(part or own for part, own in zip(parts, kept, strict=True))
        if node.level:
            package = name.split(".")[:-node.level] if self.path(name) != self.folder.joinpath(
                *name.split("."), "__init__.py") else name.split(".")[:len(name.split(".")) - node.level + 1]
            module = ".".join([*package, *([node.module] if node.module else [])])
        else:
            module = node.module or ""
        known = bool(module) and self.own(module)
        inner = {alias.name: f"{module}.{alias.name}".lstrip(".") for alias in node.names}
        modules = [alias for alias in node.names if alias.name != "*" and self.own(inner[alias.name])]
        names = [alias for alias in node.names if alias not in modules]
        written = [f"import {own_name(inner[alias.name])} as {alias.asname or alias.name}" for alias in modules]
        if known and names:
            written.insert(0, ast.unparse(ast.ImportFrom(own_name(module), names, 0)))
        if not written:
            if not node.level:   # for a relative one, Python raises its own error
                self.elsewhere(module, place, "." in module)
            return None
        return "; ".join(written)

    def module(self, place: str, alias: ast.alias) -> str | None:
        """`import module` of one that is in the folder; None if it is not."""
        if not self.own(alias.name):
            self.elsewhere(alias.name, place, False)
            return None
        if "." in alias.name and alias.asname is None:
            self.problems.append(f"{place}: import {alias.name}, expected from {alias.name} import ...: an FMU gives "
                                 "modules other names")
            return None
        return f"import {own_name(alias.name)} as {alias.asname or alias.name}"

    def elsewhere(self, module: str, place: str, parts: bool) -> None:
        """Note an import from elsewhere; ours can be carried only in the way in which our own modules have it."""
        top = module.split(".")[0]
        if top in BLOCKS and not parts:
            self.problems.append(f"{place}: import of {module}, expected from {top}.MODULE import ...: an FMU carries "
                                 "modules, not packages")
        if top not in (*BLOCKS, *sys.stdlib_module_names):
            self.requires.add(top)
