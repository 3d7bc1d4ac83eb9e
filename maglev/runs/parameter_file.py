"""Start values from parameter sets: SSV files of System Structure and Parameterization (SSP), 1.0 and 2.0."""

from collections.abc import Mapping, Sequence
from math import isclose, nan
from pathlib import Path
from typing import NamedTuple, Self
from xml.etree.ElementTree import Element, ParseError, fromstring

from fmpy.model_description import ScalarVariable

from maglev.files.errors import ScenarioError, nearest_file, one_of, option, shortened
from maglev.files.fmi_units import BASE_UNITS
from maglev.files.regular_file import regular
from maglev.files.units import WHOLE_NUMBER, Unit, exact_product, is_finite, known_unit, refused_as, unit_of_powers
from maglev.fmi.parameter import INTEGERS, REALS, expected_of
from maglev.fmi.parameter_set import SSC, SSV, parameters_in
from maglev.scenario.options import ParameterFiles
from maglev.scenario.run_plan import RunPlan, StartValue, read_start_value

BOOLEANS = {"true": True, "1": True, "false": False, "0": False}

SAME = 1e-9   # of two factors, relative


def files_given(given: ParameterFiles) -> list[tuple[str, Path]]:
    """Files with the names of the FMUs that each is for, empty where its names begin with one: of words "FMU=FILE"."""
    if given is None:
        return []
    if isinstance(given, Mapping):
        return [(name, Path(path)) for name, path in given.items()]
    files = []
    for word in [given] if isinstance(given, str | Path) else given:
        name, equals, path = str(word).partition("=")
        files.append((name, Path(path)) if equals and name.isidentifier() and not Path(word).exists() else
                     ("", Path(word)))
    return files


def parameter_values(given: ParameterFiles, known: Sequence[str]) -> dict[str, StartValue]:
    """Return start values of files, of which later ones override earlier ones; see `read_parameters`."""
    return {full: value for fmu, path in files_given(given)
            for full, value in read_parameters(path, fmu, known).items()}


def without_fed(plan: RunPlan, settings: Mapping[str, StartValue]) -> tuple[dict[str, StartValue], list[str]]:
    """Settings without those of parameter sets that a plan feeds anyway, and the names of these."""
    fed = {target for _, target in plan.wires.values()} | {
        port for signal in plan.signals for port in (signal.to, signal.rate_to)}
    left_out = [full for full, value in settings.items() if value.file and full in fed]
    return {full: value for full, value in settings.items() if full not in left_out}, left_out


def read_parameters(path: Path, fmu: str, known: Sequence[str]) -> dict[str, StartValue]:
    """Return the start values, by `fmu.variable`, in a parameter set of one FMU or, for "", of all FMUs by name.

    `known` are the names of the FMUs. ScenarioError, one line with file, parameter and value, for a file that is no
    parameter set, and for values and units that cannot be read.
    """
    if not regular(path).is_file():
        raise ScenarioError(f"there is no file {path}{nearest_file(path)}, expected a parameter set (SSV)")
    values: dict[str, StartValue] = {}
    parameters = ParameterSet.parsed(path.read_bytes(), str(path))
    for name in parameters.typed:
        full = f"{fmu}.{name}" if fmu else name
        if not fmu and name.partition(".")[0] not in known:
            raise ScenarioError(f"{path}: parameter {name}: no FMU {name.partition('.')[0]}, expected "
                                f"{' or '.join(f'{name}.…' for name in known)}, or the FMU given as in "
                                f"{option('parameters', {next(iter(known), 'plant'): path.name})}")
        values[full] = parameters.value(name)._replace(file=str(path))
    if not values:
        raise ScenarioError(f"{path}: has no parameters, expected at least one")
    return values


class ParameterSet(NamedTuple):
    """A parameter set (SSV): its place in messages, elements with a value by parameter, units by name."""

    place: str
    typed: Mapping[str, Element]
    units: Mapping[str, Element]

    @classmethod
    def parsed(cls, data: bytes, place: str) -> Self:
        """Return the parameter set of a file; ScenarioError with the place for another file, or a missing value."""
        try:
            root = fromstring(data)
        except (ParseError, ValueError, LookupError) as error:
            raise ScenarioError(f"{place}: {error}, expected a parameter set (SSV)") from None
        if root.tag != f"{{{SSV}}}ParameterSet":
            raise ScenarioError(f"{place}: the root element is {shortened(root.tag)}, expected ssv:ParameterSet")
        typed: dict[str, Element] = {}
        for name, element in parameters_in(root):
            if name in typed:
                raise ScenarioError(f"{place}: parameter {name} is there twice, expected it once")
            if element is None:
                raise ScenarioError(f"{place}: parameter {name} has no value, expected one")
            typed[name] = element
        return cls(place, typed, {unit.get("name", ""): unit for unit in root.iter(f"{{{SSC}}}Unit")})

    def value(self, name: str) -> StartValue:
        """Return the value of a parameter, in SI; ScenarioError for a value of another type, or a broken unit."""
        return parameter_value(self.typed[name], f"{self.place}: parameter {name}", self.units)


def parameter_value(typed: Element, place: str, units: Mapping[str, Element]) -> StartValue:
    """Value of a parameter, in SI; a unit that is unknown here and in the file may be one of the FMU."""
    kind, text, unit = typed.tag.rpartition("}")[2], typed.get("value", ""), typed.get("unit")
    text = text if kind == "String" else text.strip()
    origin = f"{place} = {shortened(text)[1:-1]}{f' {unit}' if unit else ''}"
    if kind == "Boolean" and text in BOOLEANS:
        return StartValue(BOOLEANS[text], None, text, origin)
    if kind in (*INTEGERS, "Enumeration") and WHOLE_NUMBER.fullmatch(text):
        return StartValue(int(text), None, text, origin)
    if kind in ("String", "Enumeration"):   # of this one the name of an item
        return StartValue(nan, None, text, origin, text=text)
    if kind not in REALS or not is_finite(text):
        expected = {"Boolean": "true or false", **dict.fromkeys(INTEGERS, "a whole number"), **dict.fromkeys(
            REALS, "a finite number")}.get(kind, f"Real, Integer, Boolean, String or Enumeration, not {kind}")
        raise ScenarioError(f"{origin}: expected {expected}")
    if not unit:
        return StartValue(float(text), None, text, origin)
    known, offset = unit_in_file(unit, units.get(unit), origin)
    if known is None:
        return StartValue(float(text), unit, f"{text} {unit}", origin)
    return StartValue(exact_product(float(text), known.factor) + offset, known.si, f"{text} {unit}", origin)


def of_type(variable: ScalarVariable | None, value: StartValue, place: str) -> StartValue:
    """A start value that was written as a text, for a variable; None is one that takes numbers or Booleans."""
    kind = "Real" if variable is None else variable.type
    if kind == "String":
        return value._replace(value=nan, unit=None, text=str(value.written))
    if value.text is None:
        return value
    items = variable.declaredType.items if variable is not None and variable.declaredType is not None else None
    numbers = {item.name: int(item.value) for item in items or ()}
    if value.text in numbers:
        return value._replace(value=numbers[value.text], text=None)
    if numbers:
        raise ScenarioError(f"{place}: expected {one_of(value.text, numbers)}")
    with refused_as(ScenarioError, place):
        read_start_value(value.text)
    raise ScenarioError(f"{place}: is {kind} in the FMU, expected {expected_of(kind, value.text)}")


def unit_in_file(name: str, element: Element | None, place: str) -> tuple[Unit | None, float]:
    """Return a unit as the file declares it, or as the table has it if both are equal; and its offset in SI."""
    known = known_unit(name)
    base = None if element is None else element.find(f"{{{SSC}}}BaseUnit")
    if base is None:
        return known, 0.0
    texts = {key: base.get(key, default) for key, default in {**dict.fromkeys(BASE_UNITS, "0"), "factor": "1",
                                                              "offset": "0"}.items()}
    wrong = next((key for key, text in texts.items() if not is_finite(text)
                  or (key in BASE_UNITS and not float(text).is_integer())), None)
    if wrong is not None or float(texts["factor"]) == 0.0:
        raise ScenarioError(f"{place}: the file declares the unit {name} with {wrong or 'factor'} = "
                            f"{texts[wrong or 'factor']}, expected a number")
    declared = unit_of_powers({key: int(float(texts[key])) for key in BASE_UNITS}, float(texts["factor"]))
    offset = float(texts["offset"])
    # Some leave out the radian, and all count cycles as 1/s.
    same = known is not None and offset == 0.0 and isclose(known.factor, declared.factor, rel_tol=SAME) and (
        without_angles(known) == without_angles(declared))
    return (known if same else declared), offset


def without_angles(unit: Unit) -> dict[str, int]:
    """Exponents of the SI base units except for angles and cycles."""
    return {base: power for base, power in unit.dimension if base not in ("rad", "cycle")}
