"""Tables of experiments that FMUs carry: CSV with arrays, Booleans and integers; tolerances; parameter sets."""

import csv
import io
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
from fmpy.model_description import ModelDescription, ScalarVariable

from maglev.cosim.port_map import declared_unit, declared_units
from maglev.files.arrays import Array
from maglev.files.errors import CsvError, FmuError, nearest, shortened
from maglev.files.fmi_units import BASE_UNITS
from maglev.files.table import DataTable, table_of
from maglev.files.table_columns import split_name
from maglev.files.table_times import require_time, times_of
from maglev.files.units import exact_product, exact_quotient, is_finite, known_unit, unit_of_powers
from maglev.fmi.parameter import expected_of, require_parameter
from maglev.runs.baseline_file import Tolerance
from maglev.runs.carried_experiments import File
from maglev.runs.parameter_file import ParameterSet, of_type
from maglev.scenario.run_plan import StartValue

TEXTS = ("String", "Binary", "Clock")   # fmpy records none of these
BOOLEANS = {"true": 1.0, "false": 0.0}

SIGNAL_KEYS = ("AbsTol", "RelTol")
OPTION_FORM = "expected KEY,NUMBER or AbsTol,SIGNAL,NUMBER or RelTol,SIGNAL,NUMBER"

TOLERANCE = 1e-3   # of the largest value of a Real result, by default


class FmuTable(NamedTuple):
    """A table of values of an FMU: its times (s), and its columns by the variables that they are of."""

    table: DataTable
    time: Array
    columns: dict[str, str]

    @property
    def names(self) -> list[str]:
        """Return the names of all columns, also of those that belong to no variable."""
        return list(self.columns)

    def values(self, variable: ScalarVariable) -> Array:
        """Values of a variable, shape (n, m): m is 1, or the number of elements of an array; all finite.

        FmuError or CsvError, which names row, column and value. A unit in the header is converted to that of the FMU.
        """
        column = self.columns[variable.name]
        said, own = self.table.unit(column, variable.name), declared_unit(variable)
        unit = said and (own or "1")
        try:
            return self.table.column(column, unit, variable.name)[:, None]
        except CsvError:
            if said:
                raise
        return self.elements(column)

    def elements(self, column: str) -> Array:
        """Values of a column with arrays, or with Booleans."""
        values: list[list[float]] = []
        for k, text in enumerate(self.table.texts(column)):
            parts = text.lower().split()   # fmpy writes True, others true
            if not parts or not all(part in BOOLEANS or is_finite(part) for part in parts):
                raise FmuError(f"{self.table.path}: row {self.table.line(k)}, column {column} is {shortened(text)}, "
                               "expected finite numbers")
            row = [BOOLEANS[part] if part in BOOLEANS else float(part) for part in parts]
            if values and len(row) != len(values[0]):
                raise FmuError(f"{self.table.path}: row {self.table.line(k)}, column {column} has {len(row)} elements, "
                               f"expected {len(values[0])} as in row {self.table.line(0)}")
            values.append(row)
        return np.array(values)


def read_columns(file: File, variables: Iterable[str]) -> FmuTable:
    """Table of a file with times that do not go back; its columns are called as variables, or with a unit."""
    table = table_of(file.data, Path(file.place))
    name = require_time(table)
    times = times_of(table, name).seconds
    back = np.flatnonzero(np.diff(times) < 0.0)
    if len(back):
        k = int(back[0]) + 1
        raise FmuError(f"{file.place}: row {table.line(k)}, column {name} is {times[k]:.9g}, expected no time before "
                       f"{times[k - 1]:.9g}")
    known = set(variables)
    columns = {}
    for own in table.names:
        if own and own != name:
            bare = split_name(own)[0]
            columns[own if own in known or bare not in known else bare] = own
    return FmuTable(table, times, columns)


def input_array(file: File, variables: Mapping[str, ScalarVariable]) -> npt.NDArray[Any]:
    """Inputs as fmpy takes them; a column has to be an input or a tunable parameter of the FMU."""
    table = read_columns(file, variables)
    by_name = {"time": table.time}
    for name in table.names:
        variable = variables.get(name)
        if variable is None or not (variable.causality == "input" or variable.variability == "tunable"):
            known = [other.name for other in variables.values() if other.causality == "input"]
            raise FmuError(f"{file.place}: column {name} is no input of the FMU, {nearest(name, known)}"
                           if known else f"{file.place}: column {name}: the FMU has no inputs, expected no file")
        if variable.type in TEXTS:
            raise FmuError(f"{file.place}: column {name} is of type {variable.type}, expected numbers or Booleans")
        values = table.values(variable)
        by_name[name] = values[:, 0] if values.shape[1] == 1 else values
    result = np.zeros(len(by_name["time"]), [(name, np.float64, values.shape[1:]) for name, values in by_name.items()])
    for name, values in by_name.items():
        result[name] = values
    return result


def given_starts(file: File, description: ModelDescription) -> dict[str, str]:
    """Start values of a parameter set, as texts by name, in the units of the FMU.

    A value without a unit is in that of its variable. FmuError or ScenarioError of a parameter that the FMU does not
    have, and of a value that is not of its type or its dimension.
    """
    variables = {variable.name: variable for variable in description.modelVariables}
    given = ParameterSet.parsed(file.data, file.place)
    options = {}
    for name, typed in given.typed.items():
        require_parameter(name, variables, f"{file.place}: the FMU", FmuError)
        variable, text = variables[name], typed.get("value", "")
        if variable.type in TEXTS:
            options[name] = text
            continue
        value = given.value(name)
        value = of_type(variable, value, value.origin)
        if expected := expected_of(variable.type, value.given):
            raise FmuError(f"{value.origin}: is {variable.type} in the FMU, expected {expected}")
        if isinstance(value.value, bool):
            options[name] = str(value.value).lower()
        elif value.unit is not None:
            options[name] = repr(in_unit_of(variable, value, description))
        else:
            options[name] = str(value.value) if variable.type == "Enumeration" else text.strip()
    return options


def in_unit_of(variable: ScalarVariable, value: StartValue, description: ModelDescription) -> float:
    """A value in the unit that a variable of an FMU declares; FmuError if it cannot be converted."""
    number, _, unit = str(value.written).partition(" ")
    own = declared_unit(variable)
    if unit == own and value.unit == unit:
        return float(number)   # neither is known here
    base = next((each.baseUnit for each in description.unitDefinitions if each.name == own), None)
    own_unit, offset = known_unit(own or "1"), 0.0
    if own_unit is None and base is not None and base.factor:
        own_unit = unit_of_powers({name: getattr(base, name) for name in BASE_UNITS}, base.factor)
        offset = base.offset
    given = known_unit(value.unit)
    if given is None and (declared := declared_units(description).get(unit)) is not None:
        given, value = declared, value._replace(value=exact_product(float(number), declared.factor))
    if given is None or own_unit is None or given.dimension != own_unit.dimension:
        raise FmuError(f"{value.origin}: expected a value in {own or '1'}, as the FMU declares it")
    return exact_quotient(float(value.value) - offset, own_unit.factor)


def run_options(file: File | None) -> tuple[dict[str, float], dict[str, Tolerance]]:
    """Options of the run by key, and tolerances by signal; no negative ones."""
    run: dict[str, float] = {}
    signals: dict[str, Tolerance] = {}
    if file is None:
        return run, signals
    for place, key, signal, value in option_rows(file):
        if signal is None:
            run[key] = value
        elif value < 0.0:
            raise FmuError(f"{place}: {key} of {signal} = {value}, expected zero or more")
        else:
            before = signals.get(signal, Tolerance(0.0, 0.0))
            signals[signal] = before._replace(**{"absolute" if key == "AbsTol" else "relative": value})
    return run, signals


def option_rows(file: File) -> Iterator[tuple[str, str, str | None, float]]:
    """Yield the values of an options file: place, key, signal of a tolerance, and value.

    FmuError names a line that is no option.
    """
    reader = csv.reader(io.StringIO(file.data.decode("utf-8-sig", "replace"), newline=""), skipinitialspace=True,
                        strict=True)
    try:
        for cells in filter(None, reader):
            place = f"{file.place}, line {reader.line_num}"
            key, *names, written = map(str.strip, cells if len(cells) > 1 else [*cells, ""])
            if len(cells) == 1 or len(names) > 1 or (names and key not in SIGNAL_KEYS):
                raise FmuError(f"{place}: row = {shortened(','.join(cells))}: {OPTION_FORM}")
            if not is_finite(written):
                raise FmuError(f"{place}: {','.join([key, *names])} = {shortened(written)}: expected a finite number")
            yield place, key, names[0] if names else None, float(written)
    except csv.Error as error:
        raise FmuError(f"{file.place}, line {reader.line_num}: {error}, expected comma-separated values") from None
