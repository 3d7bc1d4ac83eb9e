"""Descriptions of stages: TOML files, read into `pmlsm.stage_description.StageDescription` with one-line errors."""

import re
import types
from collections.abc import Iterator, Mapping
from dataclasses import MISSING, fields, is_dataclass
from math import inf
from pathlib import Path
from typing import Any, NoReturn, Union, cast, get_args, get_origin, get_type_hints

from maglev.descriptions.names import own_names
from maglev.files.errors import StageError, nearest
from maglev.files.toml_file import read_toml
from maglev.fmi.parameter import Parameter
from pmlsm.stage_description import ROTATION, StageDescription
from pmlsm.variables import GEOMETRY

# Packaged stages are in a folder next to the package in the repository, and in the package when installed.
HERE = Path(__file__).parents[1]
PACKAGED = next(folder for folder in (HERE / "stages", HERE.parent / "stages") if folder.is_dir())

LENGTHS = {"gains": 5, "pid": 3, "bounds": 3, "setpoints": 4}
LIST_UNITS = {"bounds": "m", "setpoints": "m", "gaps": "m", "B": "T", "coefficients": "T"}


def read_stage(path: Path) -> StageDescription:
    """Read a description.

    StageError, ScenarioError if the file cannot be read or describes no stage; the message names the key, its value,
    and the expected value.
    """
    reader = Reader(path)
    stage = cast(StageDescription, reader.read(StageDescription, read_toml(path), ""))
    reader.check(stage)
    return stage


class Reader:
    """Reads tables of a file into the dataclasses of `pmlsm.stage_description`."""

    def __init__(self, path: Path):
        self.path = path
        self.rotation = False   # true while an axis in rad is read

    def refuse(self, key: str, message: str) -> NoReturn:
        raise StageError(f"{self.path}: {key}: {message}" if key else f"{self.path}: {message}")

    def read(self, kind: type, table: Any, place: str, **known: Any) -> Any:
        """Dataclass of a table at a place of the file; `known` values are not in it."""
        if not isinstance(table, dict):
            self.refuse(place, f"{table!r}, expected a table")
        members = {member.name: member for member in fields(kind)
                   if member.name not in known and member.metadata.get("file", True)}
        hints = get_type_hints(kind)
        for key in table:
            if key not in members:
                self.refuse(f"{place}.{key}".lstrip("."), f"no such key; {nearest(key, members)}")
        values = dict(known)
        for name, member in members.items():
            key = f"{place}.{name}".lstrip(".")
            if name in table:
                values[name] = self.value(hints[name], table[name], key, member.metadata)
            elif member.default is MISSING and member.default_factory is MISSING:
                self.refuse(key, "missing")
        return kind(**values)

    def value(self, hint: Any, given: Any, key: str, metadata: Mapping[str, Any]) -> Any:
        """A value of the type that a field has."""
        if get_origin(hint) in (types.UnionType, Union):
            hint = next(kind for kind in get_args(hint) if kind is not type(None))
        if is_dataclass(hint):
            return self.read(cast(type, hint), given, key)
        if get_origin(hint) is tuple:
            inner = get_args(hint)[0]
            if is_dataclass(inner):
                return self.named(cast(type, inner), given, key)
            return self.numbers(given, key, metadata.get("low"), metadata.get("high"))
        if get_origin(hint) is not None:   # a mapping
            if key == "geometry":
                return self.geometry(key, given)
            if not isinstance(given, dict):
                self.refuse(key, f"{given!r}, expected a table")
            inner = get_args(hint)[1]
            return {name: self.value(inner, entry, f"{key}.{name}", metadata) for name, entry in given.items()}
        if hint is float:
            return self.number(given, key, metadata.get("unit"), metadata.get("low"), metadata.get("high"))
        if not isinstance(given, hint):
            self.refuse(key, f"{given!r}, expected {'true or false' if hint is bool else 'text'}")
        return given

    def named(self, kind: type, given: Any, key: str) -> tuple[Any, ...]:
        """Dataclasses of tables by their names, in the order of the file."""
        if not isinstance(given, dict) or not given:
            self.refuse(key, f"{given!r}, expected tables, such as [{key}.x]")
        for name in given:
            if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
                self.refuse(key, f"{name!r}, expected a name of lower-case letters, digits and _, a letter first")
        members = []
        for name, table in given.items():
            self.rotation = isinstance(table, dict) and table.get("rotation") is True
            members.append(self.read(kind, table, f"{key}.{name}", name=name))
        self.rotation = False
        return tuple(members)

    def numbers(self, given: Any, key: str, low: float | None, high: float | None) -> tuple[float, ...]:
        name = key.rpartition(".")[2]
        length = LENGTHS.get(name)
        if not isinstance(given, list) or length not in (None, len(given)):
            self.refuse(key, f"{given!r}, expected a list of {'' if length is None else f'{length} '}numbers")
        return tuple(self.number(number, key, LIST_UNITS.get(name), low, high) for number in given)

    def number(self, given: Any, key: str, unit: str | None = None, low: float | None = None,
               high: float | None = None) -> float:
        """A quantity in SI, within its range."""
        own = ROTATION.get(unit or "", unit) if self.rotation else unit
        parameter = Parameter(own, low=-inf if low is None else low, high=inf if high is None else high)
        return parameter.read(given, f"{self.path}: {key}", StageError)

    def geometry(self, place: str, given: Any) -> dict[str, float]:
        """Parameters of the geometry of a motor, by their paths."""
        if not isinstance(given, dict):
            self.refuse(place, f"{given!r}, expected a table")
        for name in given:
            if name not in GEOMETRY:
                self.refuse(f"{place}.{name}", f"no such key; {nearest(name, GEOMETRY)}")
        return {name: self.number(value, f"{place}.{name}", GEOMETRY[name][0] or "1", *GEOMETRY[name][3:])
                for name, value in given.items()}

    def check(self, stage: StageDescription) -> None:
        """Raise if settings do not fit together."""
        for part in (of_words, of_platform, of_names, of_whole_numbers, of_motors, of_axes, of_constants):
            for key, message in part(stage):
                self.refuse(key, message)


Misfits = Iterator[tuple[str, str]]   # keys that do not fit with others, and the error of each


def of_words(stage: StageDescription) -> Misfits:
    """Texts that could not stand in code."""
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9_]*", stage.name):
        yield "name", f"{stage.name!r}, expected letters, digits and _"
    for key, text in (("title", stage.title), ("equation", stage.equation)):
        if not text.isprintable() or set('"\\') & set(text) or "*/" in text or "/*" in text:
            yield key, f"{text!r}, expected words on one line without \", \\, /* and */"


def of_platform(stage: StageDescription) -> Misfits:
    """Yield axes that make no platform, and settings that do not fit their platform."""
    if len(stage.axes) < 2:
        yield "axes", f"{', '.join(stage.axis_names)}, expected the air gap, then one or two horizontal axes"
    field, table = stage.motor().field, stage.design.table
    if table is not None and not field.lower <= table.lower < table.gaps[-1] <= field.upper:
        yield "design.table", (f"{table.gaps[0]:g} to {table.gaps[-1]:g} m, expected fifteen gaps within "
                               f"{field.lower:g} to {field.upper:g} m, where the field is known")
    if stage.rotations:
        yield from of_tilting_platform(stage)
    elif stage.motor_stop is not None:
        yield "motor_stop", "expected only where the platform tilts"


def of_tilting_platform(stage: StageDescription) -> Misfits:
    """Axes, stops and places of motors by which no platform can tilt."""
    if (len(stage.horizontal), len(stage.rotations)) not in ((1, 1), (2, 2)):
        yield "axes", (f"{', '.join(stage.axis_names)}, expected the air gap, one or two horizontal axes, and the "
                       "tilts about them")
    if stage.design.schedule is not None:
        yield "design.schedule", "not allowed where the platform tilts"
    if stage.motor_stop is None:
        yield "motor_stop", "missing, expected stops at the motors of a platform that tilts"
    if stage.sharing != 1.0:
        yield "sharing", f"{stage.sharing:g}, expected 1 where the platform tilts: each motor has a place"
    first, *others = stage.motors
    for motor in stage.motors if stage.spots == "z" else ():
        if motor.x != 0.0:
            yield f"motors.{motor.name}.x", (f"{motor.x:g} m, expected 0 with one horizontal axis, along which guides "
                                             "hold the platform level: a place z across it")
    if stage.spots == "z" and all(motor.z == first.z for motor in others):
        yield "motors", f"all at z = {first.z:g} m, expected places side by side"
    if stage.spots == "xz" and not any(
            abs((a.x - first.x) * (b.z - first.z) - (a.z - first.z) * (b.x - first.x)) > 1e-9
            for a in others for b in others):
        places = ", ".join(f"{motor.name} at x = {motor.x:g} m, z = {motor.z:g} m" for motor in stage.motors)
        yield "motors", f"{places}, expected motors that are not all on one line"


def of_names(stage: StageDescription) -> Misfits:
    """Names that blocks have for something else."""
    for place, names in (("axes", stage.axis_names), ("motors", stage.motor_names)):
        for name in names:
            if name in own_names() or (name in stage.axis_names and place == "motors"):
                yield f"{place}.{name}", f"{name!r}, expected another name: blocks use this one"


def of_whole_numbers(stage: StageDescription) -> Misfits:
    """Numbers that count something."""
    for key, value in (("sharing", stage.sharing), ("guide_seed", stage.guide_seed)):
        if value != round(value):
            yield key, f"{value:g}, expected a whole number{' of motors' if key == 'sharing' else ''}"


def of_motors(stage: StageDescription) -> Misfits:
    """Motors that drive nothing, and kinds of motors where they cannot be."""
    horizontal = [axis.name for axis in stage.horizontal]
    for motor in stage.unlike:
        for key, given in (("schedule", stage.design.schedule), ("table", stage.design.table)):
            if given is not None:
                yield f"design.{key}", f"not allowed next to motors.{motor.name}, which has its own constants"
    for motor in stage.motors:
        if motor.drives not in horizontal:
            yield f"motors.{motor.name}.drives", f"{motor.drives!r}, expected one of {', '.join(horizontal)}"


def of_axes(stage: StageDescription) -> Misfits:
    """Axes without stops or motors, a start outside the stops, modes that no step follows."""
    for axis in stage.axes:
        if axis.stop is None and (axis in stage.horizontal or not stage.rotations):
            yield f"axes.{axis.name}.stop", "missing"
        stop = axis.stop or (stage.motor_stop if axis is stage.vertical else None)
        if stop is not None and not stop.lower < axis.start < stop.upper:
            yield f"axes.{axis.name}.start", (f"{axis.start:g} m, expected a place between its stops at "
                                              f"{stop.lower:g} and {stop.upper:g} m")
        if axis.mode.frequency > stage.largest_mode:
            yield f"axes.{axis.name}.mode.frequency", (
                f"{axis.mode.frequency:g} Hz, expected at most {stage.largest_mode:g} Hz, as far as longest_step = "
                f"{stage.longest_step:g} s follows it")
    for axis in stage.horizontal:
        if not stage.motors_of(axis.name):
            yield f"axes.{axis.name}", "no motor drives it, expected at least one"


def of_constants(stage: StageDescription) -> Misfits:
    """Constants of other axes than those that motors drive."""
    horizontal = [axis.name for axis in stage.horizontal]
    for place, constants in zip(("plant", "model", "estimator.guess", "estimator.weight"), stage.constant_sets,
                                strict=True):
        if list(constants.thrust) != horizontal:
            yield f"{place}.thrust", (f"for {', '.join(constants.thrust) or 'no axis'}, expected for "
                                      f"{', '.join(horizontal)}")
