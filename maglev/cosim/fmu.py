"""One FMU in a co-simulation: loaded by fmpy, called through its C functions with prepared buffers."""

import ctypes
import os
import re
import stat
import tempfile
import zipfile
from collections.abc import Callable, Iterable, Mapping, Sequence
from copy import copy
from ctypes import c_int, c_size_t, c_uint32, c_void_p
from functools import lru_cache, partial
from pathlib import Path
from threading import Lock
from typing import Any
from xml.etree.ElementTree import parse

import fmpy
from fmpy.fmi1 import FMICallException
from fmpy.model_description import ModelDescription, ScalarVariable, ValidationError
from fmpy.validation import validate_model_description

from maglev.cosim.clocks import PERIODIC, TRIGGERED, Ticking, clocks_of
from maglev.cosim.elements import elements_of, with_elements
from maglev.cosim.fmi_versions import DISCARD, FMI3, WARNING, Fmi, Listeners, Messages, fmi_of, function_of
from maglev.cosim.model_exchange import with_solver
from maglev.cosim.port_map import Scale
from maglev.files.cache import digest_at
from maglev.files.copies import original
from maglev.files.environment import MOST_UNPACKED, number_in
from maglev.files.errors import FmuError, few, in_one_line, nearest, nearest_file, option, shortened
from maglev.files.fmi_units import BASE_UNITS, exponents
from maglev.files.regular_file import regular
from maglev.files.scratch import naming_full, remove_scratch, scratch_folder
from maglev.files.session import SESSION
from maglev.files.units import known_unit, own_number
from maglev.fmi.parameter import REALS, expected_of
from maglev.user.source import FmuFile, Source

FATAL = 4   # fmi2Fatal, fmi3Fatal
STATUSES = {DISCARD: "discard", 3: "error", FATAL: "fatal error"}   # FMI's names of those beyond a warning
EXECUTABLE = 0o111       # bits of a file's mode
IDENTIFIER = re.compile(r"\w[\w.+-]*")   # as lenient as a name that is no path can be

UNIT_TOLERANCE = 1e-3   # of a factor: some write 0.01745 for a degree

NOT_NEEDED = ("binaries/", "documentation/", "extra/", "sources/", "terminalsAndIcons/")   # to run it, except for those
HERE = (f"binaries/{fmpy.platform}/", f"binaries/{fmpy.platform_tuple}/")                    # of this machine

# FMI 2.0's names of FMI 3.0 types; the last one by the way it is accessed.
OLDER_TYPES = {"Float64": "Real", "Int32": "Integer", "Enumeration": "Int64"}

LOADING = Lock()   # fmpy goes into the folder of a library while it loads it, and then back to where it was
# Paths that pythonfmu's binary loads from: of the escapes in a URI, it decodes the space alone.
LOADABLE = re.compile(r"[A-Za-z0-9/ ._~-]*" if os.name == "posix" else r"[A-Za-z]:[A-Za-z0-9/\\ ._~-]*")
# Where there is room instead of the temporary folder, as `tempfile` has it.
TEMPORARY = ("/tmp", "/var/tmp", "/usr/tmp") if os.name == "posix" else (
    os.path.expandvars(r"%SYSTEMROOT%\Temp"), r"C:\TEMP", r"C:\TMP")


# Faults of a model description, in fmpy's words, that do not matter to a run: many tools write them.
SMALL_FLAW = re.compile(r"attribute 'generationDateAndTime'|^The (display )?unit .* of variable .* is not defined\.$",
                        re.DOTALL)


class Buffer:
    """Values of variables of one FMI type, in memory that the FMU reads and writes directly."""

    def __init__(self, kind: str, variables: Sequence[ScalarVariable], fmi: Fmi):
        self.kind = kind
        self.names = [v.name for v in variables]
        self.references = (c_uint32 * len(variables))(*(v.valueReference for v in variables))
        self.values = (fmi.types[kind].value * len(variables))()

    def arguments(self) -> tuple[c_void_p, c_size_t, c_void_p]:
        return (c_void_p(ctypes.addressof(self.references)), c_size_t(len(self.names)),
                c_void_p(ctypes.addressof(self.values)))


def read_description(name: str, path: Path) -> ModelDescription:
    """Model description of an FMU for co-simulation, FMI 2.0 or 3.0; FmuError names the fault of any other file."""
    if not regular(path).is_file():
        raise FmuError(f"{name}: there is no file {path}{other_kind(path) or nearest_file(path)}, expected an FMU; "
                       f"`maglev build` builds those of this project, with {option('stage', 'mine.toml')} those of "
                       "your own stage")
    # Who gives the variables other names and units does it on a list of their own.
    return copy(description_at(name, path, digest_at(path)))


@lru_cache(maxsize=64)
def description_at(name: str, path: Path, _sha256: str) -> ModelDescription:
    """Model description of a file, read once for each content."""
    description = checked_description(f"{name}: {original(path)}", path)
    if description.coSimulation is None:
        with_solver(description)
    require_known_units(f"{name}: {original(path)}", description)
    if fmi_of(description) is FMI3:
        description.modelVariables = [*map(copy, description.modelVariables)]
        for variable in description.modelVariables:
            variable.type = OLDER_TYPES.get(variable.type, variable.type)
            if variable.intervalVariability == TRIGGERED:
                variable.type = "Boolean"
        description.modelVariables = [*elements_of(description.modelVariables, FMI3.types)]
        other = [clock for clock in clocks_of(description) if clock.intervalVariability not in (*PERIODIC, TRIGGERED)]
        if other:
            raise FmuError(f"{name}: {original(path)} has the clock {other[0].name}, which is "
                           f"{other[0].intervalVariability}, expected a constant, fixed, tunable or triggered one")
    return description


def checked_description(place: str, path: Path) -> ModelDescription:
    """Model description of an FMU of FMI 2.0 or 3.0 that can be stepped or solved; the place begins an FmuError."""
    try:
        description = copy(described(path, digest_at(path))[0])
    except Exception as error:   # fmpy raises whatever zipfile, lxml and its own checks raise
        said = dangling_reference(path, error) if isinstance(error, KeyError) else ""
        raise FmuError(f"{place} cannot be read as an FMU: {said or in_one_line(error)}") from error
    if description.fmiVersion != "2.0" and not description.fmiVersion.startswith("3.0"):
        raise FmuError(f"{place} is an FMI {description.fmiVersion} FMU, expected FMI 2.0 or 3.0")
    kind = description.coSimulation or description.modelExchange
    if kind is None:
        raise FmuError(f"{place} is for scheduled execution only, expected co-simulation or model exchange")
    if IDENTIFIER.fullmatch(kind.modelIdentifier) is None:   # a path would load a library from outside the archive
        raise FmuError(f"{place} has modelIdentifier = {shortened(kind.modelIdentifier)}, expected letters, digits and "
                       "underscores")
    return description


@lru_cache(maxsize=64)
def described(path: Path, _sha256: str) -> tuple[ModelDescription, list[str]]:
    """Model description of a file and its small flaws, read once for each content; errors are those of fmpy."""
    try:
        return fmpy.read_model_description(str(regular(path))), []
    except (ValidationError, KeyError) as error:   # this one of a display unit whose unit is not defined
        return flawed_description(path, error)


def flawed_description(path: Path, error: Exception) -> tuple[ModelDescription, list[str]]:
    """Model description in which there are but small flaws, and these; otherwise the error is raised again."""
    description = fmpy.read_model_description(str(path), validate=False)
    defined = {unit.name for unit in description.unitDefinitions}
    for variable in description.modelVariables:
        if variable.unit not in defined:
            variable.displayUnit = None
    of_schema = error.problems if isinstance(error, ValidationError) else []
    problems = [*dict.fromkeys([*of_schema, *validate_model_description(description)])]
    if not all(map(SMALL_FLAW.search, problems)):
        raise error
    return description, problems


def dangling_reference(path: Path, error: KeyError) -> str:
    """Say which element of the model structure refers to a variable that there is not; empty if none does."""
    with zipfile.ZipFile(path) as archive, archive.open("modelDescription.xml") as file:
        structure = parse(file).find("ModelStructure")
    for element in structure.iter() if structure is not None else ():
        for attribute, value in element.attrib.items():
            if str(error.args[0]) in value.split():
                return (f"its model structure has <{element.tag} {attribute}={value!r}>, expected the value reference "
                        "of one of its variables")
    return ""


def flaw_note(path: Path) -> str:
    """Sentence about the flaws in the model description of an FMU that runs nevertheless; empty if there are none."""
    _, flaws = described(path, digest_at(path))
    return f"its model description is flawed: {in_one_line(few(flaws))}" if flaws else ""


def kind_of(variable: ScalarVariable) -> str:
    return "Integer" if variable.type == "Enumeration" else str(variable.type)


def other_kind(path: Path) -> str:
    """Return where a missing FMU exists in another kind, as the end of a message; empty if nowhere."""
    own = path.parent.name if path.parent.name in ("native", "fmi3", "clocked") else ""
    root = path.parent.parent if own else path.parent
    folders = {"": f"without {option('kind')}", "native": f"with {option('kind', 'native')}",
               "fmi3": f"with {option('fmi', 3)}", "clocked": f"with {option('fmus', str(root / 'clocked'))}"}
    for folder, chosen in folders.items():
        other = root / folder / path.name
        if folder != own and other.is_file():
            return f", but {other} ({chosen})"
    return ""


def require_known_units(place: str, description: ModelDescription) -> None:
    """Raise for an FMU that defines a unit otherwise than its name means."""
    for unit in description.unitDefinitions:
        known = known_unit(unit.name) if unit.baseUnit is not None else None
        if known is None:
            continue
        powers = dict.fromkeys(BASE_UNITS, 0) | exponents(known.si)
        for key, expected in {"factor": known.factor, "offset": 0.0, **powers}.items():
            given = getattr(unit.baseUnit, key)   # some leave out the radian
            if key != "rad" and not abs(given - expected) <= UNIT_TOLERANCE * abs(expected):
                raise FmuError(f"{place} defines the unit {unit.name!r} with {key} = {given:g}, expected {expected:g}")


class Fmu:
    """An instance of an FMU; a context manager that frees it and the folder it was unpacked to.

    `scales` converts the variables, by name, that the FMU does not count in SI units.
    """

    def __init__(self, name: str, source: Source, description: ModelDescription,
                 scales: Mapping[str, Scale] | None = None):
        self.name = name
        self.source = source
        self.description = description
        self.scales = scales or {}
        self.variables: dict[str, ScalarVariable] = {v.name: v for v in description.modelVariables}
        self.messages = Messages()
        self.fatal = False
        self.folder = unpacking_folder(isinstance(source, FmuFile) and runs_python(source.path))
        self.instance: Any = None   # fmpy's object
        self.key = SESSION.get(Listeners).key(name)
        self.fmi = fmi_of(description)
        self.set_functions: dict[str, Any] = {}
        self.get_functions: dict[str, Any] = {}
        self.ticking: Ticking | None = None   # with clocks
        self.started: dict[str, float | bool | str] = {}   # start values of the last run, and their places
        self.start_buffers: list[Buffer] = []
        self.start_places: dict[str, tuple[Any, int]] = {}
        try:
            self.load()
        except Exception as error:
            self.close()
            shown = original(source.path) if isinstance(source, FmuFile) else source
            raise FmuError(f"{name}: {shown} cannot be loaded: {self.said() or error}") from error

    def load(self) -> None:
        """Unpack, load and instantiate the FMU, with its messages going to `messages`."""
        assert isinstance(self.source, FmuFile)
        unpack(self.source.path, self.folder)
        with LOADING:
            instance = self.fmi.instantiated(self.description, self.folder, self.key, self.take_message)
        self.instance = instance
        instance._call = partial(self.heard, instance._call)   # which fmpy calls for each function that it knows
        setters, getters = (self.fmi.functions(instance, verb) for verb in ("Set", "Get"))
        self.get_functions, self.set_functions = with_elements(self.description, self.fmi.types, getters, setters)
        self.do_step = self.fmi.do_step(instance, self.description, self.messages.add)
        self.terminate = function_of(instance, f"{self.fmi.prefix}Terminate")
        if clocks_of(self.description):
            self.ticking = Ticking(instance, self.folder, self.description, self.fmi.types, self.get_functions,
                                   self.set_functions, self.do_step, self.messages.add)
            self.get_functions, self.set_functions = self.ticking.getters, self.ticking.setters
            self.do_step = self.ticking

    def heard(self, call: Callable[..., Any], name: str, *arguments: Any) -> Any:
        """Call a function of fmpy, which raises an error for a status beyond a warning; a negative status is an error,
        too.
        """
        status = call(name, *arguments)
        if type(status) is int:
            self.require(name, c_uint32(status).value)
        return status

    def take_message(self, status: int, message: bytes) -> None:
        self.fatal = self.fatal or status == FATAL
        self.messages.told(status, message)

    def __enter__(self) -> "Fmu":
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        # After fmi2Fatal FMI forbids every call. The FMUs of this project can be freed all the same, and should be:
        # pythonfmu's binary reads freed memory at the end of a process in which it is still loaded.
        if self.instance is not None and (not self.fatal or self.source.built_here):
            self.instance.freeInstance()
        self.instance = None
        SESSION.get(Listeners).by_name.pop(self.key, None)
        remove_scratch(self.folder)

    def said(self) -> str:
        """Return the latest messages of the FMU, and forget them."""
        return self.messages.take()

    def note(self) -> str:
        """Sentence about the messages of the FMU in a run that continued; empty if there are none."""
        summary = self.messages.summary()
        flaws = flaw_note(self.source.path) if isinstance(self.source, FmuFile) else ""
        return "; ".join([*([f"{self.name} ({self.source.name}) says: {summary}"] if summary else []),
                          *([f"{self.name} ({self.source.name}) runs, but {flaws}"] if flaws else [])])

    def require(self, call: str, status: int) -> None:
        """Raise for a call that returned a status beyond a warning; count one that returned a warning."""
        if status > WARNING:
            raise self.failed(call, status)
        if status == WARNING:
            self.messages.warned(call)

    def failed(self, call: str, status: int) -> FmuError:
        """Error for a call that returned a status beyond a warning, or one below zero."""
        status = c_int(status).value
        self.fatal = self.fatal or status == FATAL
        word = STATUSES.get(status, f"status {status}")
        what = f"the step ({call}: {word})" if call == f"{self.fmi.prefix}DoStep" else f"{call} ({word})"
        return FmuError(f"{self.name} ({self.source.name}) refused {what}: {self.said() or 'it gave no message'}")

    def variable(self, name: str) -> ScalarVariable:
        """A variable by its name; FmuError with the nearest name if there is none."""
        if name not in self.variables:
            raise FmuError(f"{self.name} ({self.source.name}) has no variable {name}; {nearest(name, self.variables)}")
        return self.variables[name]

    def reset(self) -> None:
        self.instance.reset()
        if self.ticking is not None:
            self.ticking.reset()

    def initialise(self, start: Mapping[str, float | bool | str], start_time: float, stop_time: float,
                   give_inputs: Callable[[], None] = lambda: None) -> None:
        """Set start values and go through the initialization, in which it is given inputs."""
        self.take_start(start)
        texts = {name: value for name, value in start.items() if isinstance(value, str)}
        try:
            def set_values() -> None:
                for name, text in texts.items():
                    self.set_text(name, text)
                for buffer in self.start_buffers:
                    self.set(buffer)

            self.fmi.initialised(self.instance, start_time, stop_time, set_values, give_inputs, self.ticking)
        except FmuError:
            raise
        except Exception as error:
            raise FmuError(f"{self.name} ({self.source.name}) refused its initialization: "
                           f"{self.said() or error}") from error

    def take_start(self, start: Mapping[str, float | bool | str]) -> None:
        """Put start values into their buffers; FmuError for one that does not fit.

        In repeated runs most values are the same objects as in the run before, which are in their places already.
        """
        last, self.started = self.started, {}
        if [*last] != [*start]:
            last = {}
            self.start_buffers = self.buffers([self.variable(name) for name in start])
            self.start_places = {name: (buffer.values, place) for buffer in self.start_buffers
                                 for place, name in enumerate(buffer.names)}
        for name, value in start.items():
            if value is last.get(name, self):
                continue
            self.require_start(name, value)
            if not isinstance(value, str):
                values, place = self.start_places[name]
                own = self.scales[name].to_own(value) if name in self.scales else value
                values[place] = type(values[place])(own)
        self.started = {**start}

    def set_text(self, name: str, text: str) -> None:
        """Set a String variable."""
        try:
            self.instance.setString([self.variable(name).valueReference], [text])
        except FMICallException as error:
            raise self.failed(f"{self.fmi.prefix}SetString of {name}", error.status) from error

    def require_start(self, name: str, value: object) -> None:
        """Raise for a start value that does not fit the variable's type; in a row of a study all are floats."""
        kind, number = kind_of(self.variable(name)), own_number(value)
        if isinstance(number, int | float) and kind not in REALS and number % 1 == 0:
            number = bool(number) if kind == "Boolean" and number in (0, 1) else int(number)
        if expected := expected_of(kind, number):
            raise FmuError(f"{self.name}.{name} = {shortened(value)}: it is {kind}, expected {expected}")

    def buffers(self, variables: Sequence[ScalarVariable]) -> list[Buffer]:
        """Buffers for variables, one for each FMI type that occurs, in the order of the variables."""
        by_kind = {kind: [v for v in variables if kind_of(v) == kind] for kind in self.fmi.types}
        return [Buffer(kind, chosen, self.fmi) for kind, chosen in by_kind.items() if chosen]

    def handle(self) -> c_void_p:
        return c_void_p(self.instance.component)

    def set(self, buffer: Buffer) -> None:
        status = self.set_functions[buffer.kind](self.handle(), *buffer.arguments())
        self.require(f"{self.fmi.name('Set', buffer.kind)} of {few(buffer.names)}", status)

    def get(self, buffer: Buffer) -> None:
        status = self.get_functions[buffer.kind](self.handle(), *buffer.arguments())
        self.require(f"{self.fmi.name('Get', buffer.kind)} of {few(buffer.names)}", status)


def unpack(path: Path, folder: Path) -> None:
    """Unpack what it takes to run an FMU on this machine; FmuError if the archive is a bomb, or for other machines."""
    try:
        most = number_in(MOST_UNPACKED)
    except ValueError as error:
        raise FmuError(str(error)) from None
    with zipfile.ZipFile(path) as archive:   # it extracts all files below the folder, whatever their names
        names, size = archive.namelist(), sum(entry.file_size for entry in archive.infolist())
        if size > most:
            raise FmuError(f"{original(path)} unpacks to {1e-6 * size:.0f} MB, expected at most {1e-6 * most:.0f} MB; "
                           f"the environment variable {MOST_UNPACKED} sets another number of bytes")
        if illegal := [name for name in names if "\\" in name or ":" in name or name.startswith("/")]:
            raise FmuError(f"it has the file {illegal[0]!r}, expected a relative path with forward slashes")
        if not any(name.startswith(HERE) for name in names):
            there = sorted({name.split("/")[1] for name in names if re.match("binaries/.+/.", name)})
            raise FmuError(f"it has binaries for {', '.join(there) or 'no platform'}, expected {fmpy.platform} or "
                           f"{fmpy.platform_tuple}")
        needed = [entry for entry in archive.infolist()
                  if entry.filename.startswith(HERE) or not entry.filename.startswith(NOT_NEEDED)]
        with naming_full(folder):
            archive.extractall(folder, needed)
    make_links(folder, needed)


def make_links(folder: Path, entries: Iterable[zipfile.ZipInfo]) -> None:
    """Restore links and executable files of an archive; FmuError for a link that leads out of the folder."""
    links = []
    for entry in entries:
        mode, path = entry.external_attr >> 16, folder / entry.filename
        if stat.S_ISLNK(mode):
            links.append((path, os.fsdecode(path.read_bytes())))
            path.unlink()
        elif mode & EXECUTABLE and path.is_file():
            path.chmod(path.stat().st_mode | mode & EXECUTABLE)
    for path, target in links:
        path.symlink_to(target)
    for path, target in links:   # as soon as all are there: one may lead through another
        try:
            inside = path.resolve().is_relative_to(folder.resolve())
        except (OSError, RuntimeError):   # they lead round
            inside = False
        if not inside:
            raise FmuError(f"it has the link {path.relative_to(folder).as_posix()!r} to {shortened(target)}, expected "
                           "one to a file in it")


def runs_python(path: Path) -> bool:
    """Return True if a file is an FMU that has Python in it."""
    try:
        with zipfile.ZipFile(path) as archive:
            return any(name.startswith("resources/") and name.endswith(".py") for name in archive.namelist())
    except (OSError, zipfile.BadZipFile):
        return False   # which is said where it is read


def unpacking_folder(python: bool = True) -> Path:
    """New temporary folder; of an FMU that has `python` in it one whose path pythonfmu's binary can load from."""
    inside = tempfile.gettempdir()
    for place in (inside, *TEMPORARY):
        if not python or LOADABLE.fullmatch(place):
            try:
                return scratch_folder(place)
            except OSError:
                if not python:
                    raise
    raise FmuError(f"temporary folder {inside}: expected one that can be written to, with a path of ASCII letters, "
                   "digits, spaces and - . _ ~ alone, as FMUs that run Python need; TMPDIR sets it")
