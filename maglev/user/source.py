"""A block of the user's, such as a controller: a class of a Python file, or a class itself."""

import ast
import hashlib
import inspect
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass
from importlib.util import module_from_spec, spec_from_file_location
from itertools import count
from pathlib import Path
from traceback import walk_tb

from controller_fmu.drawings import WRITTEN_ICON, WRITTEN_SKETCH
from controller_fmu.sample_clock import SampleClock
from maglev.files.copies import copied, original
from maglev.files.errors import ControllerError, nearest, nearest_file, shortened
from maglev.files.regular_file import regular
from maglev.fmi.declaration import Undeclared, WrittenDefinition, definition_of
from maglev.fmi.trouble import RAISED, error_text
from maglev.language.errors import ExportError
from maglev.language.sources import parsed
from maglev.user.declaring_lines import declaring_line
from maglev.user.own_modules import OwnModules, own_modules

SOURCE = re.compile(r"(.*\.py)(?::(\w+))?$", re.DOTALL)   # lqi.py, lqi.py:LQI
GIVEN = "class "                                           # begins the name of a path that stands for a class

HELP = "`maglev new controller lqi.py` and `maglev new plant mover.py` write one to begin with"

# Functions of `math` that every machine rounds alike, and modules of Python in which none can be told.
EXACT = {"pi", "tau", "e", "inf", "nan", "sqrt", "fabs", "floor", "ceil", "trunc", "fmod", "remainder", "copysign",
         "isfinite", "isnan", "isinf"}
LIBRARIES = {"math", "cmath", "random", "statistics", "time", "os", "ctypes"}

Given = str | Path | type | object   # a block: its name, its FMU or Python file, its class, or an object of this

CLASSES: dict[Path, type] = {}                # classes that were given as such, by the path that stands for them
LOADED: dict[tuple[Path, str], "Written"] = {}   # by path and digest of everything that is read


@dataclass(frozen=True)
class Written:
    """A user's class that can run."""

    definition: WrittenDefinition
    file: Path | None                      # None if it was given as a class
    requires: tuple[str, ...]              # packages that it imports, and that no FMU carries
    sha256: tuple[tuple[str, str], ...]    # names and digests of its file and the modules next to it; of a class's text


def is_written(path: Path) -> bool:
    """Return True if a path names a Python file, perhaps with a class in it, or stands for a class."""
    return is_class(path) or SOURCE.match(str(path)) is not None


def is_class(path: Path) -> bool:
    """Return True if a path stands for a class, which no other process knows."""
    return str(path).startswith(GIVEN)


def path_of(given: Given) -> Path:
    """Path of a block; one that stands for it if a class is given, or an object, as which those of a run begin.

    ControllerError if the object cannot be copied.
    """
    if isinstance(given, str | Path):
        return Path(given)
    written = given if isinstance(given, type) else class_of(given)
    paths = (Path(f"{GIVEN}{written.__name__}{f' ({number})' if number > 1 else ''}") for number in count(1))
    return next(path for path in paths if CLASSES.setdefault(path, written) is written)


def class_of(given: object) -> type:
    """Class whose objects begin as copies of one."""
    own = type(given)
    try:
        kept = deepcopy(given)
    except RAISED as error:
        raise ControllerError(f"an object of the class {own.__name__} cannot be copied: {error_text(error)}; expected "
                              "one that can, or its class") from error
    about = {"__module__": own.__module__, "__qualname__": f"{own.__qualname__}.object", "__doc__": own.__doc__}
    try:
        return type(own.__name__, (own,), {**about, "__new__": lambda _: deepcopy(kept), "__init__": lambda _: None})
    except TypeError:   # of a function, for one
        raise ControllerError(f"{shortened(given)}: expected a file, a class with a method step, or an object of "
                              "one") from None


def carried(given: Given) -> str | Path:
    """Return the form of a block that an FMU can carry: for a class, the file that defines it, with its name.

    ControllerError if an object is given, if no file defines the class at its top level, or if the file is a script.
    """
    if isinstance(given, str | Path):
        return given
    try:
        file = inspect.getsourcefile(given) if isinstance(given, type) and given.__module__ != "__main__" else None
    except (OSError, TypeError):
        file = None
    if file is None or not Path(file).is_file() or given.__qualname__ != given.__name__:   # type: ignore[attr-defined]
        kind = "a class" if isinstance(given, type) else "an object"
        raise ControllerError(f"{name_of(given)}: {kind} outside any module, which only this process can run; give "
                              "its file, such as lqi.py or lqi.py:LQI")
    return Path(f"{file}:{name_of(given)}")


def name_of(given: Given) -> str:
    """Name of a block that was given: of its class, if it is a class or an object."""
    if isinstance(given, str | Path):
        return Path(given).name
    return (given if isinstance(given, type) else type(given)).__name__


def file_of(path: Path) -> tuple[Path, str | None]:
    """File that a path names, and the class in it."""
    match = SOURCE.match(str(path))
    assert match is not None
    return Path(match[1]), match[2]


@contextmanager
def folder_first(folder: Path) -> Iterator[None]:
    """Import from a folder first, as a script in it does; its modules are removed, as other folders may have the same.

    Modules that a folder of copies lacks come from the original folder.
    """
    before = set(sys.modules)
    writes = sys.dont_write_bytecode
    sys.dont_write_bytecode = True   # a module that changes twice in a second looks like its compiled form
    folders = list(dict.fromkeys((folder, original(folder))))
    sys.path[:0] = map(str, folders)
    try:
        yield
    finally:
        sys.dont_write_bytecode = writes
        for path in folders:
            sys.path.remove(str(path))
        for name in set(sys.modules) - before:
            if Path(getattr(sys.modules[name], "__file__", None) or ".").parent in folders:
                del sys.modules[name]


def load(path: Path) -> Written:
    """Read and execute the file or class that a path names.

    ControllerError if there is no such file or class, it cannot be executed, or it declares what does not fit.
    """
    if is_class(path):
        return load_class(path)
    file, name = existing(path), file_of(path)[1]
    modules = read_modules(file)
    key = (path.absolute(), str(modules.sha256))
    if key not in LOADED:
        LOADED[key] = Written(defined(file, name, modules), file, modules.requires, modules.sha256)
    return LOADED[key]


def digests(path: Path) -> tuple[tuple[str, str], ...]:
    """Names and digests of the file that a path names and of the modules next to it, or of a class's text.

    Nothing is executed; errors of the files as in `load`.
    """
    return load_class(path).sha256 if is_class(path) else read_modules(existing(path)).sha256


def requirements(path: Path) -> tuple[str, ...]:
    """Return the packages that a path's file imports, and that no FMU carries; none for a class. Errors as above."""
    return () if is_class(path) else read_modules(existing(path)).requires


def keeps_bits(path: Path) -> bool:
    """Return True if the code at a path computes the same bits everywhere: it imports only ours and exact functions.

    False for a class, whose file is not known; errors of files as in `load`.
    """
    if is_class(path):
        return False
    modules = read_modules(existing(path))
    return not modules.requires and all(
        set(imported_names(module.text)) <= EXACT for module in modules.modules.values())


def imported_names(text: str) -> Iterator[str]:
    """Names that a text takes from `math`; the module itself, where it imports that."""
    for node in ast.walk(parsed(text)):
        if isinstance(node, ast.ImportFrom) and node.module == "math":
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in LIBRARIES)
        elif isinstance(node, ast.ImportFrom) and node.module in LIBRARIES:
            yield node.module or ""


def existing(path: Path) -> Path:
    """File that a path names; ControllerError if there is none."""
    file = file_of(path)[0]
    if not regular(file).is_file():
        raise ControllerError(f"there is no file {file}{nearest_file(file)}; {HELP}")
    return file


def copy_of(path: Path) -> Path:
    """Path of copies of the file and of the modules next to it, errors as in `load`; for a class its own path."""
    if is_class(path):
        return path
    file, name = existing(path), file_of(path)[1]
    folder = file.absolute().parent
    modules = {module.file.absolute() for module in read_modules(file).modules.values()}
    packages = {parent / "__init__.py" for path in modules for parent in path.parents if folder in parent.parents}
    files = {str(path.relative_to(folder)): path.read_bytes() for path in {*modules, *packages} if path.is_file()}
    copy = copied(files, folder) / file.name
    return copy if name is None else Path(f"{copy}:{name}")


def read_modules(file: Path) -> OwnModules:
    """Text of a file and of the modules next to it; ControllerError if one is not in Python."""
    try:
        return own_modules(file)
    except SyntaxError as error:
        raise ControllerError(error_text(error)) from error
    except (UnicodeDecodeError, ValueError) as error:
        raise ControllerError(f"{file}: {error}, expected a Python file in UTF-8") from error
    except (RecursionError, MemoryError):   # of the parser, for which a sum of 10 000 terms is too deep as well
        raise ControllerError(f"{file}: an expression is nested too deeply, expected shorter ones") from None


def defined(file: Path, name: str | None, modules: OwnModules) -> WrittenDefinition:
    """Execute a file and take its class."""
    folder = file.absolute().parent
    unique = f"maglev_written_{file.stem}_{modules.sha256[0][1][:12]}"
    specification = spec_from_file_location(unique, file.absolute())
    assert specification is not None and specification.loader is not None
    module = module_from_spec(specification)
    module.__file__ = str(original(file.absolute()))   # data may lie next to it
    sys.modules[unique] = module   # where pickle and dataclasses look for it
    with folder_first(folder):
        try:
            specification.loader.exec_module(module)
        except RAISED as error:
            raise ControllerError(in_file(error, file)) from error
        classes = {member.__name__: member for member in vars(module).values()
                   if isinstance(member, type) and member.__module__ == unique}
        return declared(chosen(file, name, classes), file)


def in_file(error: BaseException, file: Path) -> str:
    """Error of a file that was executed, with the line in it."""
    if isinstance(error, SyntaxError):
        return error_text(error)
    lines = [line for frame, line in walk_tb(error.__traceback__) if frame.f_code.co_filename == str(file.absolute())]
    text = " ".join(str(error).split())
    return f"{file.name}{f', line {lines[-1]}' if lines else ''}: {type(error).__name__}: {text}"


def chosen(file: Path, name: str | None, classes: dict[str, type]) -> type:
    """Class of that name; the only one with outputs if there is no name."""
    blocks = [name for name, member in classes.items() if hasattr(member, "outputs") or hasattr(member, "inputs")]
    if name is not None:
        if name not in classes:
            raise ControllerError(f"{file.name}:{name}: there is no class {name} in it, "
                                  f"{nearest(name, blocks or classes)}")
        return classes[name]
    if not blocks:
        raise ControllerError(f"{file.name}: there is no class with ports in it, expected one with inputs, outputs and "
                              f"step; {HELP}")
    if len(blocks) > 1:
        raise ControllerError(f"{file.name}: there are {len(blocks)} classes with ports in it, {', '.join(blocks)}; "
                              f"expected one of them to be named: {file.name}:{blocks[0]}")
    return classes[blocks[0]]


def load_class(path: Path) -> Written:
    if path not in CLASSES:
        raise ControllerError(f"{path}: a class runs only in the process that defines it, and this needs others; give "
                              "its file, such as lqi.py or lqi.py:LQI")
    given = CLASSES[path]
    try:
        text = inspect.getsource(given)
    except (OSError, TypeError):
        sha256: tuple[tuple[str, str], ...] = ()   # it was typed, and not kept
    else:
        sha256 = ((str(path), hashlib.sha256(text.encode("utf-8")).hexdigest()),)
    return Written(declared(given, None), None, (), sha256)


def declared(written: type, file: Path | None) -> WrittenDefinition:
    """Definition of a class; ControllerError names its file, and the line in it."""
    try:
        return definition_of(written, SampleClock, WRITTEN_ICON, WRITTEN_SKETCH)
    except Undeclared as error:
        place = f"{line_in(file, written.__name__, error.word)}: " if file else ""
        raise ControllerError(f"{place}{error}") from error
    except ExportError as error:
        raise ControllerError(f"{file.name}: {error}" if file else str(error)) from error


def line_in(file: Path, name: str | None, word: str) -> str:
    """Return file and line of a class's port, parameter or table; the file alone if it has no such line."""
    line = declaring_line(file.read_text(encoding="utf-8-sig"), name, word)
    return file.name if line is None else f"{file.name}, line {line}"


def declared_in(path: Path, word: str) -> str:
    """Return the same for the class that a path names, without executing it; its name if a class was given."""
    return str(path) if is_class(path) else line_in(*file_of(path), word)
