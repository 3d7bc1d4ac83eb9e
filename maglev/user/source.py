"""Where a block comes from: an FMU, a class in a Python file of the user, or a class of this process."""

import ast
import hashlib
import inspect
import re
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from copy import deepcopy
from dataclasses import dataclass, replace
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from traceback import walk_tb
from typing import NoReturn

from controller_fmu.drawings import WRITTEN_ICON, WRITTEN_SKETCH
from controller_fmu.sample_clock import SampleClock
from maglev.descriptions.own_fmus import built_here
from maglev.files.cache import digest_at
from maglev.files.copies import copied, original
from maglev.files.errors import ControllerError, nearest, nearest_file, shortened
from maglev.files.regular_file import regular
from maglev.files.session import SESSION
from maglev.fmi.declaration import Undeclared, WrittenDefinition, definition_of
from maglev.fmi.trouble import RAISED, error_text
from maglev.language.errors import ExportError
from maglev.language.sources import parsed
from maglev.user.declaring_lines import declaring_line
from maglev.user.own_modules import OwnModules, own_modules

NAMED = re.compile(r"(.*\.py)(?::(\w+))?$", re.DOTALL)   # lqi.py, lqi.py:LQI

HELP = "`maglev new controller lqi.py` and `maglev new plant mover.py` write one to begin with"

# Functions of `math` that every machine rounds equally, and modules of Python that have no others.
EXACT = {"pi", "tau", "e", "inf", "nan", "sqrt", "fabs", "floor", "ceil", "trunc", "fmod", "remainder", "copysign",
         "isfinite", "isnan", "isinf"}
LIBRARIES = {"math", "cmath", "random", "statistics", "time", "os", "ctypes"}

Given = str | Path | type | object   # a block: its name, its FMU or Python file, its class, or an object of this
Digests = tuple[tuple[str, str], ...]   # names and digests of files


@dataclass(frozen=True)
class Written:
    """A user's class that can run."""

    definition: WrittenDefinition
    file: Path | None                      # None if it was given as a class
    requires: tuple[str, ...]              # packages that it imports, and that no FMU carries
    sha256: Digests                        # of its file and the modules next to it; of a class's text


class Loaded:
    """Code that this process has executed: classes by file, name and digests of all that is read; names of modules."""

    def __init__(self) -> None:
        self.classes: dict[tuple[Path, str | None, Digests], Written] = {}
        self.modules: set[str] = set()

    def close(self) -> None:
        for name in self.modules:
            sys.modules.pop(name, None)


@dataclass(frozen=True)
class FmuFile:
    """The file of an FMU, which need not be there."""

    path: Path

    def __str__(self) -> str:
        return str(self.path)

    @property
    def name(self) -> str:
        """Return its name in messages."""
        return self.path.name

    @property
    def exists(self) -> bool:
        return self.path.is_file()

    @property
    def built_here(self) -> bool:
        return built_here(self.path)

    @property
    def foreign(self) -> bool:
        """Return True if it is not of this installation; a missing file is refused later."""
        return self.exists and not self.built_here

    @property
    def runs_apart(self) -> bool:
        """Return True if it runs in another process."""
        return self.foreign

    def copy(self) -> "FmuFile":
        """Return a copy of the file as it is now; a copy itself, or a missing file, is returned as it is."""
        if not self.exists or original(self.path) != self.path:
            return self
        return FmuFile(copied({self.name: self.path.read_bytes()}, self.path.parent) / self.name)

    def digests(self) -> Digests:
        """Return the name and the digest of the file."""
        return ((self.name, digest_at(self.path)),)

    def keeps_bits(self) -> bool:
        """Return True if it computes the same bits everywhere: this installation builds it."""
        return self.built_here


@dataclass(frozen=True)
class PythonFile:
    """A class in a Python file: the one of a name, or the only one with ports."""

    path: Path
    class_name: str | None = None

    exists = runs_apart = True   # a missing file is refused when it is read
    built_here = foreign = False

    def __str__(self) -> str:
        return str(self.path) if self.class_name is None else f"{self.path}:{self.class_name}"

    @property
    def name(self) -> str:
        """Return its name in messages."""
        return str(replace(self, path=Path(self.path.name)))

    def modules(self) -> OwnModules:
        """Return the text of the file and of the modules next to it; ControllerError if it cannot be read."""
        if not regular(self.path).is_file():
            raise ControllerError(f"there is no file {self.path}{nearest_file(self.path)}; {HELP}")
        return read_modules(self.path)

    def load(self) -> Written:
        """Read and execute the file.

        ControllerError if there is no such file or class, it cannot be executed, or it declares what does not fit.
        """
        modules, loaded = self.modules(), SESSION.get(Loaded)
        key = (self.path.absolute(), self.class_name, modules.sha256)
        if key not in loaded.classes:
            loaded.classes[key] = Written(defined(self.path, self.class_name, modules), self.path, modules.requires,
                                          modules.sha256)
        return loaded.classes[key]

    def copy(self) -> "PythonFile":
        """Return copies of the file and of the modules next to it, as they are now; errors as in `load`."""
        folder = self.path.absolute().parent
        modules = {module.file.absolute() for module in self.modules().modules.values()}
        packages = {parent / "__init__.py" for path in modules for parent in path.parents if folder in parent.parents}
        files = {str(path.relative_to(folder)): path.read_bytes() for path in {*modules, *packages} if path.is_file()}
        return replace(self, path=copied(files, folder) / self.path.name)

    def digests(self) -> Digests:
        """Return names and digests of the file and of the modules next to it; errors of the files as in `load`."""
        return self.modules().sha256

    def keeps_bits(self) -> bool:
        """Return True if it computes the same bits everywhere: it imports only ours and exact functions."""
        modules = self.modules()
        return not modules.requires and all(
            set(imported_names(module.text)) <= EXACT for module in modules.modules.values())

    def place_of(self, word: str) -> str:
        """Return file and line in which its class declares a port, a parameter or a table."""
        return line_in(self.path, self.class_name, word)


@dataclass(frozen=True)
class PythonClass:
    """A class that runs in this process alone, because no other process knows it."""

    written: type

    exists = True
    runs_apart = built_here = foreign = False

    def __str__(self) -> str:
        return f"class {self.written.__name__}"

    def __reduce__(self) -> NoReturn:
        raise ControllerError(f"{self}: a class runs only in the process that defines it, and this needs others; give "
                              "its file, such as lqi.py or lqi.py:LQI")

    @property
    def name(self) -> str:
        """Return its name in messages."""
        return str(self)

    def load(self) -> Written:
        """Return the class with its declarations; ControllerError if it declares what does not fit."""
        return Written(declared(self.written, None), None, (), self.digests())

    def copy(self) -> "PythonClass":
        """Return the class, which no edit reaches."""
        return self

    def digests(self) -> Digests:
        """Return the digest of its text, if that is known: it may have been typed, and not kept."""
        try:
            text = inspect.getsource(self.written)
        except (OSError, TypeError):
            return ()
        return ((str(self), hashlib.sha256(text.encode("utf-8")).hexdigest()),)

    def keeps_bits(self) -> bool:
        """Return False: its imports are not known."""
        return False

    def place_of(self, _word: str) -> str:
        """Return its name: it has no lines."""
        return str(self)


Source = FmuFile | PythonFile | PythonClass


def source_of(given: Given) -> Source:
    """Return the source of a block; an object gives a class whose objects begin as its copies.

    ControllerError if the object cannot be copied.
    """
    if isinstance(given, FmuFile | PythonFile | PythonClass):
        return given
    if isinstance(given, str | Path):
        return file_source(given)
    return PythonClass(given if isinstance(given, type) else class_of(given))


def file_source(path: str | Path) -> FmuFile | PythonFile:
    """Return the class in a Python file, `lqi.py` or `lqi.py:LQI`, or the FMU of any other path."""
    named = NAMED.match(str(path))
    return FmuFile(Path(path)) if named is None else PythonFile(Path(named[1]), named[2])


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


def carried(given: Given) -> str | Path | PythonFile:
    """Return a block in a form that an FMU can carry: its name or its FMU as given, or the Python file of a class.

    ControllerError if an object is given, if no file defines the class at its top level, or if the file is a script.
    """
    if isinstance(given, str | Path):
        source = file_source(given)
        return source if isinstance(source, PythonFile) else given
    try:
        file = inspect.getsourcefile(given) if isinstance(given, type) and given.__module__ != "__main__" else None
    except (OSError, TypeError):
        file = None
    if file is None or not Path(file).is_file() or given.__qualname__ != given.__name__:   # type: ignore[attr-defined]
        kind = "a class" if isinstance(given, type) else "an object"
        raise ControllerError(f"{name_of(given)}: {kind} outside any module, which only this process can run; give "
                              "its file, such as lqi.py or lqi.py:LQI")
    return PythonFile(Path(file), name_of(given))


def name_of(given: Given) -> str:
    """Name of a block that was given: of its class, if it is a class or an object."""
    if isinstance(given, str | Path):
        return Path(given).name
    return (given if isinstance(given, type) else type(given)).__name__


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


def imported_names(text: str) -> Iterator[str]:
    """Names that a text takes from `math`; the module itself, where it imports that."""
    for node in ast.walk(parsed(text)):
        if isinstance(node, ast.ImportFrom) and node.module == "math":
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in LIBRARIES)
        elif isinstance(node, ast.ImportFrom) and node.module in LIBRARIES:
            yield node.module or ""


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
    SESSION.get(Loaded).modules.add(unique)
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
