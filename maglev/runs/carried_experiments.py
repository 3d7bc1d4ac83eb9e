"""The experiments that an FMU carries: by the layered standard FMI-LS-REF, or in files next to it.

The drafts FMI-LS-REF 1.0.0-beta.1 and MA-HS-Experiments are read as they stand, also in the form with the times in the
element `Experiment` itself. A result that no experiment refers to is that of the default experiment.

Their tables are CSV with arrays, Booleans and integers; further files have tolerances, or are parameter sets.
"""

import csv
import io
import zlib
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from posixpath import normpath
from typing import Any, NamedTuple
from urllib.parse import unquote, urlsplit
from xml.etree.ElementTree import Element, ParseError, fromstring
from zipfile import BadZipFile, ZipFile

import numpy as np
import numpy.typing as npt
from fmpy.model_description import ModelDescription, ScalarVariable

from maglev.cosim.port_map import declared_unit, declared_units
from maglev.files.arrays import Array
from maglev.files.errors import CsvError, FmuError, nearest, nearest_file, shortened
from maglev.files.fmi_units import BASE_UNITS
from maglev.files.regular_file import regular
from maglev.files.table import DataTable, table_of
from maglev.files.table_columns import split_name
from maglev.files.table_times import require_time, times_of
from maglev.files.units import exact_product, exact_quotient, is_finite, known_unit, unit_of_powers
from maglev.fmi.experiment_files import CSV_TYPE, FOLDER, MANIFEST, SSV_TYPE
from maglev.fmi.parameter import expected_of, require_parameter
from maglev.runs.baseline_file import Tolerance
from maglev.runs.starts import ParameterSet, of_type
from maglev.scenario.run_plan import StartValue

MOST = 50_000_000   # bytes of a file

EXPERIMENT_TYPES = ("application/x-ma-hs-experiments", "application/x-ma-ls-experiments")   # the latter in older drafts

TEXTS = ("String", "Binary", "Clock")   # fmpy records none of these
BOOLEANS = {"true": 1.0, "false": 0.0}

SIGNAL_KEYS = ("AbsTol", "RelTol")
OPTION_FORM = "expected KEY,NUMBER or AbsTol,SIGNAL,NUMBER or RelTol,SIGNAL,NUMBER"

TOLERANCE = 1e-3   # of the largest value of a Real result, by default


class File(NamedTuple):
    """A file of an experiment: its name for messages, and its bytes."""

    place: str
    data: bytes


@dataclass(frozen=True)
class CarriedExperiment:
    """An experiment in an FMU: its inputs and expected results; None for each part that is missing."""

    name: str
    start_time: float | None = None   # s
    stop_time: float | None = None    # s
    step: float | None = None         # s
    tolerance: float | None = None    # relative, of a solver
    parameters: File | None = None    # SSV
    inputs: File | None = None        # CSV
    results: File | None = None       # CSV
    options: File | None = None       # the tolerances of the results
    problem: str = ""                 # why it cannot be run; empty if it can


def carried_experiments(path: Path) -> list[CarriedExperiment]:
    """Experiments of an FMU, also with a `problem`; FmuError if it carries none, or cannot be read."""
    try:
        with ZipFile(regular(path)) as archive:
            sizes = {entry.filename: entry.file_size for entry in archive.infolist()}
            if "modelDescription.xml" not in sizes:
                raise FmuError(f"{path}: has no modelDescription.xml, expected an FMU")
            wanted = [name for name in sizes if name.startswith("extra/") or name == MANIFEST]
            for name in wanted:
                if sizes[name] > MOST:
                    raise FmuError(f"{path}: {name} has {sizes[name]} bytes, expected at most {MOST}")
            files = {name: archive.read(name) for name in wanted}
    except FileNotFoundError:
        raise FmuError(f"{path}: there is no such file{nearest_file(path)}, expected an FMU") from None
    except (OSError, BadZipFile, zlib.error, NotImplementedError, RuntimeError) as error:
        raise FmuError(f"{path}: cannot be read as an FMU: {error}") from error
    carried = [*(in_manifest(path, files) if MANIFEST in files else ()), *beside(path)]
    if not carried:
        raise FmuError(f"{path}: contains no experiments, expected {MANIFEST} with some in it, or {path.stem}_ref.csv "
                       "next to it")
    return carried


def beside(path: Path) -> Iterator[CarriedExperiment]:
    """The experiment in files next to an FMU, as in the FMI cross-check: NAME_ref.csv, NAME_in.csv and NAME_ref.opt."""
    results = path.with_name(f"{path.stem}_ref.csv")
    if not results.is_file():
        return
    def file(*names: str) -> File | None:
        places = [path.with_name(name) for name in names]
        return next((File(str(place), place.read_bytes()) for place in places if place.is_file()), None)

    yield CarriedExperiment(results.name, inputs=file(f"{path.stem}_in.csv"), results=file(results.name),
                            options=file(f"{path.stem}_ref.opt", f"{path.stem}.opt"))


def in_manifest(path: Path, files: Mapping[str, bytes]) -> Iterator[CarriedExperiment]:
    """Experiments that the manifest lists, and the default experiment for results that none of them refers to."""
    root = parsed_xml(File(f"{path}: {MANIFEST}", files[MANIFEST]), "fmiReferences")
    listed: dict[str, list[tuple[str, Element]]] = {"experiment": [], "result": []}
    for related in root.iter("Related"):
        role = related.get("role", "")
        kind = related.get("type", "application/octet-stream")
        source = related.get("source")
        if source is None:
            raise FmuError(f"{path}: {MANIFEST}: an element Related has no source, expected the name of a file")
        fits = kind == CSV_TYPE if role == "result" else kind in EXPERIMENT_TYPES or source.endswith(".exp")
        if fits and role.partition("/")[0] in listed and role != "experiment/uncertainty-analysis":
            listed[role.partition("/")[0]].append((source, related))
    used: set[str | None] = set()
    for source, _ in listed["experiment"]:
        try:
            elements = list(parsed_xml(carried_file(path, source, MANIFEST, files), "Experiments").iter("Experiment"))
        except FmuError as error:
            yield CarriedExperiment(source, problem=str(error).removeprefix(f"{path}: "))
            continue
        place = str(place_of(source, MANIFEST))
        for element in elements:
            references = element.find("References")   # of this experiment, also where it cannot be run
            used.add(None if references is None else place_of(references.get("source", ""), place))
            try:
                found = experiment(path, place, element, files)
            except FmuError as error:
                found = CarriedExperiment(element.get("name", ""), problem=str(error))
            yield found
    for source, related in listed["result"]:
        if place_of(source, MANIFEST) in used - {None}:
            continue
        label = related.get("description") or source
        try:
            results = carried_file(path, source, MANIFEST, files)
        except FmuError as error:
            yield CarriedExperiment(label, problem=str(error))
        else:
            yield CarriedExperiment(label, results=results, options=options_beside(path, results, files))


def experiment(path: Path, place: str, element: Element, files: Mapping[str, bytes]) -> CarriedExperiment:
    """An experiment of an experiments file; FmuError where it cannot be run."""
    label = element.get("name", "")
    kinds = [child.tag for child in element if child.tag[0].isupper()]
    transient = element.find("TransientSimulation")
    analyses = [kind for kind in kinds if kind not in ("TransientSimulation", "Parameters", "Stimuli", "References",
                                                       "Annotations")]
    if analyses:
        raise FmuError(f"{place}: {analyses[0]}, expected TransientSimulation: no other kind of experiment is run")
    times = {**element.attrib, **(transient.attrib if transient is not None else {})}
    by_tag: dict[str, File] = {}
    for tag, kind in (("Parameters", SSV_TYPE), ("Stimuli", CSV_TYPE), ("References", CSV_TYPE)):
        child = element.find(tag)
        if child is None:
            continue
        if (given := child.get("type", kind)) != kind:
            raise FmuError(f"{place}: {tag} are of type {given}, expected {kind}")
        by_tag[tag] = carried_file(path, child.get("source", ""), place, files)
    if "References" not in by_tag:
        raise FmuError(f"{place}: experiment {label} has no References, expected some to compare with")
    numbers = {key: finite_number(place, key, times[key]) for key in ("startTime", "stopTime", "stepSize", "tolerance")
               if key in times}
    return CarriedExperiment(label, numbers.get("startTime"), numbers.get("stopTime"), numbers.get("stepSize"),
                             numbers.get("tolerance"), by_tag.get("Parameters"), by_tag.get("Stimuli"),
                             by_tag["References"], options_beside(path, by_tag["References"], files))


def finite_number(place: str, key: str, text: str) -> float:
    """A number of an experiments file: finite, and positive except for times."""
    positive = key in ("stepSize", "tolerance")
    if not is_finite(text) or (positive and float(text) <= 0.0):
        raise FmuError(f"{place}: {key} = {shortened(text)}, expected a finite number"
                       f"{', more than zero' if positive else ''}")
    return float(text)


def options_beside(path: Path, results: File, files: Mapping[str, bytes]) -> File | None:
    """Tolerances next to results, NAME_ref.opt next to NAME_ref.csv, if there are any."""
    name = f"{results.place.removeprefix(f'{path}: ').removesuffix('.csv')}.opt"
    return File(f"{path}: {name}", files[name]) if name in files else None


def place_of(source: str, base: str) -> str | None:
    """Return the name in the archive for a URI of the file `base`; None if there is none."""
    parts = urlsplit(source)
    if parts.scheme or parts.netloc or not parts.path:
        return None
    name = normpath(f"{base.rpartition('/')[0]}/{unquote(parts.path)}")
    return None if name.startswith(("..", "/")) else name


def carried_file(path: Path, source: str, base: str, files: Mapping[str, bytes]) -> File:
    """File of an FMU that a URI in the file `base` means; FmuError if there is none."""
    name = place_of(source, base)
    if name is not None and name in files:
        return File(f"{path}: {name}", files[name])
    others = [name.removeprefix(FOLDER) for name in files if name != MANIFEST]
    hint = f"; {nearest(source, others)}" if others else ""
    raise FmuError(f"{base}: names the file {shortened(source)}, which is not in the FMU{hint}")


def parsed_xml(file: File, tag: str | None = None) -> Element:
    """Root of an XML file, which may have to be a certain element."""
    try:
        root = fromstring(file.data)
    except (ParseError, ValueError, LookupError) as error:
        raise FmuError(f"{file.place}: {error}, expected XML") from None
    if tag not in (None, root.tag):
        raise FmuError(f"{file.place}: the root element is {root.tag}, expected {tag}")
    return root


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
