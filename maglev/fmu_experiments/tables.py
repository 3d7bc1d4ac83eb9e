"""Tables of experiments that FMUs carry: CSV with arrays, Booleans and integers; tolerances; parameter sets."""

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from fmpy.model_description import ModelDescription, ScalarVariable

from fmi_export.units import BASE_UNITS
from maglev.arrays import Array
from maglev.baselines.baseline import Tolerance, option_rows
from maglev.cosim.port_map import declared_unit, declared_units
from maglev.csv_table import is_finite
from maglev.errors import FmuError, nearest, shortened
from maglev.experiment.ports.parameter_file import ParameterSet
from maglev.fmu_experiments.carried import File
from maglev.parameter import expected_of, require_parameter
from maglev.schema.run_plan import StartValue
from maglev.units import exact_product, exact_quotient, known_unit, unit_of_powers

TEXTS = ("String", "Binary", "Clock")   # fmpy records none of these
BOOLEANS = {"true": 1.0, "false": 0.0}

TOLERANCE = 1e-3   # of the largest value of a Real result, where nothing says how close it has to be


def read_columns(file: File) -> dict[str, list[str]]:
    """Columns of a CSV file as texts: "time" first, then names; full rows, one at least."""
    try:
        text = file.data.decode("utf-8-sig")
        rows = [row for row in csv.reader(io.StringIO(text, newline=""), skipinitialspace=True, strict=True) if row]
    except (UnicodeDecodeError, csv.Error) as error:
        raise FmuError(f"{file.place}: {error}, expected comma-separated values") from None
    if not rows:
        raise FmuError(f"{file.place}: the file is empty, expected a header and rows")
    header = [name.strip() for name in rows[0]]
    if header[0] != "time" or len(header) < 2:
        raise FmuError(f"{file.place}: row 1 is {shortened(','.join(header))}, expected time and other columns")
    for name in header:
        if header.count(name) > 1:
            raise FmuError(f"{file.place}: row 1 has the column {name!r} {header.count(name)} times, expected it once")
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(header):
            raise FmuError(f"{file.place}: row {number} has {len(row)} values, expected {len(header)}")
    if len(rows) < 2:
        raise FmuError(f"{file.place}: has a header only, expected rows of numbers")
    return {name: [row[k] for row in rows[1:]] for k, name in enumerate(header)}


def column_values(file: File, name: str, texts: Sequence[str]) -> Array:
    """Values of a column, shape (n, m): m is 1, or the number of elements of an array; all finite."""
    values: list[list[float]] = []
    for number, text in enumerate(texts, 2):
        parts = text.lower().split()   # fmpy writes True, others true
        if not parts or not all(part in BOOLEANS or is_finite(part) for part in parts):
            raise FmuError(f"{file.place}: row {number}, column {name} is {shortened(text)}, expected finite numbers")
        row = [BOOLEANS[part] if part in BOOLEANS else float(part) for part in parts]
        if values and len(row) != len(values[0]):
            raise FmuError(f"{file.place}: row {number}, column {name} has {len(row)} elements, expected "
                           f"{len(values[0])} as in row 2")
        values.append(row)
    return np.array(values)


def table_times(file: File, columns: Mapping[str, list[str]]) -> Array:
    """Times of a table, s; FmuError if one is before the one above it."""
    instants: Array = column_values(file, "time", columns["time"])[:, 0]
    back = np.flatnonzero(np.diff(instants) < 0.0)
    if len(back):
        k = int(back[0]) + 1
        raise FmuError(f"{file.place}: row {k + 2}, column time is {instants[k]:.9g}, expected no time before "
                       f"{instants[k - 1]:.9g}")
    return instants


def input_array(file: File, variables: Mapping[str, ScalarVariable]) -> npt.NDArray[Any]:
    """Inputs as fmpy takes them; a column has to be an input or a tunable parameter of the FMU."""
    columns = read_columns(file)
    by_name = {"time": table_times(file, columns)}
    for name, texts in columns.items():
        if name == "time":
            continue
        variable = variables.get(name)
        if variable is None or not (variable.causality == "input" or variable.variability == "tunable"):
            known = [other.name for other in variables.values() if other.causality == "input"]
            raise FmuError(f"{file.place}: column {name} is no input of the FMU, nearest is {nearest(name, known)}"
                           if known else f"{file.place}: column {name}: the FMU has no inputs, expected no file")
        if variable.type in TEXTS:
            raise FmuError(f"{file.place}: column {name} is of type {variable.type}, expected numbers or Booleans")
        values = column_values(file, name, texts)
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
        variable, text = variables[name], typed.get("value", "").strip()
        if variable.type in (*TEXTS, "Enumeration"):
            options[name] = text
            continue
        value = given.value(name)
        if expected := expected_of(variable.type, value.value):
            raise FmuError(f"{value.origin}: is {variable.type} in the FMU, expected {expected}")
        options[name] = str(value.value).lower() if isinstance(value.value, bool) else (
            text if value.unit is None else repr(in_unit_of(variable, value, description)))
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
    for line, key, signal, value in option_rows(file.place, file.data.decode("utf-8-sig", "replace")):
        if signal is None:
            run[key] = value
        elif value < 0.0:
            raise FmuError(f"{file.place}, line {line}: {key} of {signal} = {value}, expected zero or more")
        else:
            before = signals.get(signal, Tolerance(0.0, 0.0))
            signals[signal] = before._replace(**{"absolute" if key == "AbsTol" else "relative": value})
    return run, signals
