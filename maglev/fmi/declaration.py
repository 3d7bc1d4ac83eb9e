"""Definition of an FMU from the declarations of a user's class.

A port or parameter "y.measured" is the attribute `self.y.measured`, or `self.y_measured` where there is no such part.
"""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from inspect import isasyncgenfunction, iscoroutinefunction, isgeneratorfunction
from math import isfinite
from numbers import Real
from operator import attrgetter
from typing import Any

from maglev.files.fmi_units import SYMBOLS, UnknownUnit, exponents
from maglev.fmi.definition import SAMPLE_TIME, DefaultExperiment, Drawing, FmuDefinition, Variable
from maglev.fmi.trouble import RAISED, error_text
from maglev.fmi.user_block import FIRST_PORT, STEP_MISFIT, block_of
from maglev.language.errors import ExportError

TABLES = {"inputs": "input", "outputs": "output", "parameters": "parameter"}

MOST_NAMES = 2000   # in the tables of a class: an FMU lists for each output all that it depends on
DEFAULT_STEP = 0.5e-3   # s, of the default experiment of a class without samples

REFUSED_STEP = ("communication step = {step} s, expected one that divides its sample_time = {sample_time} s into a "
                "whole number of steps and does not step over a sample")


class Undeclared(ExportError):
    """A declaration of a class cannot be used; `word` is the wrong port, parameter or table."""

    def __init__(self, text: str, word: str):
        super().__init__(text)
        self.word = word


@dataclass(frozen=True)
class WrittenDefinition(FmuDefinition):
    """An FMU of a user's class, which may take long to make an object: start values are those of one object."""

    starts: Mapping[str, float | bool] = field(default_factory=dict)

    def start_value(self, variable: Variable) -> float | bool:
        return self.starts[variable.name]


def definition_of(written: type, clock: type, icon: Drawing, sketch: Drawing,
                  requires: tuple[str, ...] = ()) -> WrittenDefinition:
    """Definition of the FMU that steps a class at its samples.

    The class has tables `inputs`, `outputs` and, if it has any, `parameters`, from a name to a unit, "" for none. It
    has `step(self, t)` with an attribute `sample_time` (s), or `step(self, t, dt)`, called at every communication step;
    perhaps `start(self)`, called when the parameters are set. ExportError if it lacks something, or these do not fit
    each other. The `clock` of the samples has `fits` and `due`. The sketch is drawn for 1 if the class has samples,
    else for 0. `requires` are packages of the importer's Python; the module that is written for an FMU gives them.
    """
    name = written.__name__
    require_steps(written)
    law = new_object(written)
    tables = {table: read_table(written, table) for table in TABLES}
    if not tables["outputs"]:
        raise ExportError(f"class {name}: it has no outputs, expected a table such as "
                          "outputs = {\"alpha.i_a_cmd\": \"A\", ...}")
    if (count := sum(map(len, tables.values()))) > MOST_NAMES:
        raise ExportError(f"class {name}: it has {count} inputs, outputs and parameters, expected at most {MOST_NAMES}")
    sampled = not takes(written.step, 3)   # type: ignore[attr-defined]  # it has one
    if sampled:
        tables["parameters"].setdefault(SAMPLE_TIME, "s")
    inputs = tuple(tables["inputs"])
    known = (*inputs, *tables["parameters"])
    variables = []
    starts: dict[str, float | bool] = {}
    ports: dict[str, str] = {}   # by attribute path
    for table, causality in TABLES.items():
        for port, unit in tables[table].items():
            if port in starts:
                raise Undeclared(f"class {name}: {table} has {port!r}, expected a name that no other table has", port)
            path = attribute_path(law, port, f"class {name}: {table} has {port!r}")
            if (other := ports.setdefault(path, port)) != port:
                raise Undeclared(f"class {name}: {other} and {port} are both self.{path}, expected an attribute for "
                                 "each", port)
            value = attrgetter(path)(law)
            if not (isinstance(value, Real) and isfinite(value)):
                raise Undeclared(f"class {name}: {port} starts as {value!r}, expected a finite number, or True or "
                                 "False", port)
            boolean = isinstance(value, bool)
            starts[port] = bool(value) if boolean else float(value)
            variables.append(Variable(
                port, causality, variability(causality, port, written, boolean),
                f"{causality} of the class {name}",
                "" if boolean else unit, depends_on=inputs if causality == "output" else (),
                starts_from=known if causality == "output" else (), boolean=boolean, path=f"law.{path}"))
    step = float(starts[SAMPLE_TIME]) if sampled else DEFAULT_STEP
    if not step > 0.0:
        raise ExportError(f"class {name}: sample_time = {step} s, expected a time above 0 s")
    outputs = tuple(v for v in variables if v.causality == "output" and not v.boolean)
    return WrittenDefinition(
        name=name,
        block=block_of(written, sampled),
        description=(inspect.getdoc(written) or f"class {name}").split("\n\n")[0].replace("\n", " "),
        variables=tuple(variables),
        refusals={**({STEP_MISFIT: REFUSED_STEP} if sampled else {}), **{
            number: f"{v.name} = {{{v.name}}}{f' {v.unit}' if v.unit else ''} at t = {{time}} s, expected a finite "
                    f"number from {name}" for number, v in enumerate(outputs, FIRST_PORT)}},
        experiment=DefaultExperiment(stop_time=500 * step, step=step),
        variable_step=not sampled,
        sampled=sampled,
        icon=icon,
        sketch=replace(sketch, arguments=(int(sampled),)),
        arguments=(written, clock),
        finite=tuple((number, v.place) for number, v in enumerate(outputs, FIRST_PORT)),
        slave=("maglev.fmi.user_slave", "WrittenSlave"),
        author="",
        requires=requires,
        starts=starts)


def require_steps(written: type) -> None:
    """Raise for a class without `step(self, t)` or `step(self, t, dt)`, or with a `start` that has arguments."""
    name = written.__name__
    if not name.isascii():
        raise ExportError(f"class {name}: expected a name of ASCII letters, digits and underscores")
    for method, numbers, expected in (("step", (2, 3), "step(self, t) or step(self, t, dt)"),
                                      ("start", (1,), "start(self)")):
        function = getattr(written, method, None)
        if function is None and method == "start":
            continue
        if not callable(function):
            raise ExportError(f"class {name}: it has no step, expected a method step(self, t), which is called every "
                              "sample_time, or step(self, t, dt)")
        if iscoroutinefunction(function) or isgeneratorfunction(function) or isasyncgenfunction(function):
            raise ExportError(f"class {name}: {method} has async or yield, so that a call of it computes nothing, "
                              "expected a plain def without them")
        if not any(takes(function, number) for number in numbers):
            raise ExportError(f"class {name}: {method}{inspect.signature(function)}, expected {expected}")


def takes(function: Callable[..., Any], number: int) -> bool:
    """Return True if a function can be called with this number of values."""
    try:
        inspect.signature(function).bind(*range(number))
    except TypeError:
        return False
    return True


def new_object(written: type) -> Any:
    """Object of a user's class; ExportError says where it fails."""
    if not takes(written, 0):
        raise ExportError(f"class {written.__name__}: {written.__name__}{inspect.signature(written)}, expected that "
                          "it can be made without arguments")
    try:
        return written()
    except RAISED as error:
        raise ExportError(f"{written.__name__}() failed: {error_text(error, written)}") from error


def read_table(written: type, table: str) -> dict[str, str]:
    """A table of a class: units by name."""
    units = getattr(written, table, {})
    place = f"class {written.__name__}: {table}"
    if not isinstance(units, Mapping):
        raise Undeclared(f"{place} = {units!r}, expected a table from names to units, such as {{\"y.measured\": "
                         "\"m\"}", table)
    for port, unit in units.items():
        if not isinstance(port, str) or not all(part.isidentifier() for part in port.split(".")):
            raise Undeclared(f"{place} has {port!r}, expected a name such as \"y.measured\"", port)
        try:
            exponents("1" if unit == "" else unit)
        except (UnknownUnit, TypeError, AttributeError):
            raise Undeclared(f"{place} has {port!r} in {unit!r}, expected one that is made of SI units without "
                             f"prefixes, such as \"m/s2\" or \"V.s/rad\", or \"\"; symbols are {', '.join(SYMBOLS)}",
                             port) from None
    return dict(units)


def attribute_path(law: Any, port: str, place: str) -> str:
    """Attribute path of a port: its name, or its name with underscores for dots."""
    flat = port.replace(".", "_")
    for path in (port, flat):
        try:
            attrgetter(path)(law)
        except AttributeError:
            continue
        return path
    either = f"self.{port}" + (f" or self.{flat}" if flat != port else "")
    raise Undeclared(f"{place}, expected an attribute {either} that __init__ sets", port)


def variability(causality: str, port: str, written: type, boolean: bool) -> str:
    """Variability of a variable; fixed for the parameters from which `start` may compute."""
    if causality != "parameter":
        return "discrete" if causality == "output" or boolean else "continuous"
    return "fixed" if port == SAMPLE_TIME or hasattr(written, "start") else "tunable"
