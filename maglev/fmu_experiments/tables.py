"""Tables of experiments that FMUs carry: CSV with arrays, Booleans and integers; tolerances; parameter sets."""

import csv
import io
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt
from fmpy.model_description import ScalarVariable

from fmi_export.parameter_set import parameters_in
from maglev.arrays import Array
from maglev.baselines.baseline import Tolerance, option_rows
from maglev.csv_table import is_finite
from maglev.errors import FmuError, nearest, shortened
from maglev.fmu_experiments.carried import File, parsed_xml
from maglev.parameter import REALS, require_parameter

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


def given_starts(file: File, variables: Mapping[str, ScalarVariable]) -> dict[str, str]:
    """Start values of a parameter set, as texts by name; FmuError for one that the FMU does not have."""
    options = {}
    for name, typed in parameters_in(parsed_xml(file)):
        require_parameter(name, variables, f"{file.place}: the FMU", FmuError)
        if typed is None:
            raise FmuError(f"{file.place}: parameter {name} has no value, expected one")
        value = typed.get("value", "")
        if variables[name].type in REALS and not is_finite(value):
            raise FmuError(f"{file.place}: parameter {name} = {shortened(value)}, expected a finite number")
        if variables[name].type == "Boolean" and value not in (*BOOLEANS, "0", "1"):
            raise FmuError(f"{file.place}: parameter {name} = {shortened(value)}, expected true or false")
        options[name] = value
    return options


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
