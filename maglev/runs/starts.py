"""Start values of the FMUs of a run: the plan's, then settings, then values that follow from others.

Settings may stand in parameter sets: SSV files of System Structure and Parameterization (SSP), 1.0 and 2.0.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from math import isclose, nan
from pathlib import Path
from typing import NamedTuple, Self
from xml.etree.ElementTree import Element, ParseError, fromstring

from fmpy.model_description import ScalarVariable

from maglev.cosim.open import describe
from maglev.cosim.port_map import declared_units
from maglev.descriptions.own_fmus import definition
from maglev.files.errors import ScenarioError, key_path, nearest_file, one_of, option, shortened
from maglev.files.fmi_units import BASE_UNITS
from maglev.files.regular_file import regular
from maglev.files.units import (
    UNITS,
    WHOLE_NUMBER,
    Unit,
    exact_product,
    is_finite,
    known_unit,
    like,
    refused_as,
    unit_of_powers,
)
from maglev.fmi.parameter import INTEGERS, REALS, Parameter, expected_of
from maglev.fmi.parameter_set import SSC, SSV, parameters_in
from maglev.runs.replacement import Replacement, given_and_left_out
from maglev.scenario.options import ParameterFiles
from maglev.scenario.run_plan import RunOutput, RunPlan, StartValue, read_start_value
from maglev.user.source import Source
from pmlsm.stage_description import StageDescription

Own = Callable[[str], float | None]   # what a variable of an FMU is that runs, or None if it has none
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


@dataclass(frozen=True)
class Following:
    """The constants of a controller's model at the nominal masses, and the parameters of the plant's mass."""

    stage: StageDescription
    # constants, and of a platform that tilts masses and inertias, by the names of the controller
    model: Mapping[str, float]
    masses: Mapping[str, float]   # parameters of the plant, SI

    def settings(self, changes: Mapping[str, float | bool]) -> dict[str, float]:
        """Return `controller.C1` … at the plant's masses, with other values `plant.y.mass` … of some.

        The constants are accelerations at the nominal masses: the same forces make them, times nominal over present
        mass. The plant's own block computes that mass, payload included.
        """
        plant = definition(f"Plant{self.stage.suffix}")
        block = plant.new_block()
        for variable in plant.variables:
            if variable.name in self.masses:
                value = changes.get(full := f"plant.{variable.name}", self.masses[variable.name])
                variable.write(block, Parameter.of(variable).read(value, full, ScenarioError))
        block.start()
        block.step(0.0, self.stage.sample_time)
        axes = {axis.name: block.axes[self.stage.axis_number(axis.name)] for axis in self.stage.axes}
        rows = {constant.name: constant.axis for constant in self.stage.constants}
        return {f"controller.{name}": value * axes[rows[name]].mass_ratio if name in rows else
                axes[name.partition(".")[0]].present_mass for name, value in self.model.items()}


def following(stage: StageDescription | None, plant: Own, controller: Own, asked: Collection[str]) -> Following:
    """Return the model of a controller that follows its plant, except for given constants; ScenarioError if it has
    none.
    """
    if stage is None:
        raise ScenarioError(f"{option('model', 'plant')}: expected a stage with a description, which has the nominal "
                            "masses")
    variables = definition(f"Plant{stage.suffix}").variables
    axes = {axis.name: f"{axis.name}.{'inertia' if axis.rotation else 'mass'}" for axis in stage.axes}
    masses = [*axes.values(), *(variable.name for variable in variables if variable.name.startswith("payload."))]
    model = [*(constant.name for constant in stage.constants), *(axes.values() if stage.rotations else ())]
    model = [name for name in model if f"controller.{name}" not in asked]
    return Following(stage, values("controller", controller, model), values("plant", plant, masses))


def values(fmu: str, own: Own, names: list[str]) -> dict[str, float]:
    own_values = {name: own(name) for name in names}
    lacking = [name for name, value in own_values.items() if value is None]
    if lacking:
        raise ScenarioError(f"{option('model', 'plant')}: the {fmu} has no {', '.join(lacking)}, expected masses or a "
                            "model, as this project's FMUs have")
    return {name: value for name, value in own_values.items() if value is not None}


@dataclass
class Starts:
    """Start values of the FMUs of a run, by their names in it."""

    given: dict[str, dict[str, StartValue]]
    taken: dict[str, dict[str, RunOutput]]   # those that other runs come to
    # why others of the plan, `fmu.variable`, are not given to the FMU that takes the place of the plan's
    left_out: dict[str, str]

    @classmethod
    def planned(cls, plan: RunPlan, replaced: Mapping[str, Replacement], put_in: Iterable[str]) -> "Starts":
        """Return the plan's start values, as far as replaced FMUs get them; `put_in` are the user's FMUs."""
        starts = cls({name: {**fmu.inherited, **fmu.start} for name, fmu in plan.fmus.items()},
                     {name: dict(fmu.start_from) for name, fmu in plan.fmus.items()}, {})
        for name, replacement in replaced.items():
            starts.given[name], why = given_and_left_out(plan, name, replacement, name in put_in)
            starts.taken[name] = {variable: source for variable, source in starts.taken[name].items()
                                  if variable not in why}
            starts.left_out |= {f"{name}.{variable}": reason for variable, reason in why.items()}
        return starts

    def ask(self, plan: RunPlan, settings: Mapping[str, StartValue]) -> list[str]:
        """Take what is asked for, `fmu.variable`; returns a sentence for each value that another run would come to."""
        overruled = []
        for full, value in settings.items():
            name, _, variable = full.partition(".")
            known_participant(plan, value.origin, name)
            self.give(full, value)
            source = self.taken[name].pop(variable, None)
            if source is not None:
                overruled.append(f"{plan.name}: {full} is set by {value.file or option('set')}, not by the result of "
                                 f"{source.run}")
        return overruled

    def give(self, full: str, value: StartValue) -> None:
        """Give a value, also where the plan's was left out."""
        name, _, variable = full.partition(".")
        self.given[name][variable] = value
        self.left_out.pop(full, None)

    def follow(self, plan: RunPlan, sources: Mapping[str, Source], asked: set[str]) -> Following:
        """Let the controller's model follow the plant, except for the values asked for: add its constants to these."""
        origin = option("model", "plant")

        def own(name: str) -> Own:
            known_participant(plan, origin, name)
            return lambda variable: (float(self.given[name][variable].value) if variable in self.given[name] else
                                     known_start(name, sources[name], variable))

        followed = following(plan.stage, own("plant"), own("controller"), asked)
        for full, value in followed.settings({}).items():
            source = self.taken["controller"].get(full.removeprefix("controller."))
            if source is not None:
                raise ScenarioError(f"{origin}: {plan.name} takes {full} from {source.run}, expected only runs that "
                                    "take no constants from others")
            self.give(full, StartValue(value, None, repr(value), origin))
            asked.add(full)
        return followed

    def of(self, plan: RunPlan) -> RunPlan:
        return plan.model_copy(update={"fmus": {
            name: fmu.model_copy(update={"start": self.given[name], "start_from": self.taken[name], "inherited": {}})
            for name, fmu in plan.fmus.items()}})


def known_start(name: str, source: Source, variable: str) -> float | None:
    """Start value that an FMU itself has for a variable; None where it has none, or cannot be read yet."""
    if not source.exists:
        return None
    text = next((v.start for v in describe(name, source).modelVariables if v.name == variable), None)
    try:
        return {"true": 1.0, "false": 0.0}.get(str(text)) if text in ("true", "false") else float(str(text))
    except ValueError:
        return None


def known_participant(plan: RunPlan, key: str, name: str) -> None:
    if name not in plan.fmus:
        raise ScenarioError(f"{key}: scenario {plan.name} has no FMU {name}, expected "
                            f"{one_of(name, plan.fmus)}")


def of_declared_types(plan: RunPlan, start: Mapping[str, Mapping[str, StartValue]],
                      sources: Mapping[str, Source]) -> dict[str, dict[str, StartValue]]:
    """Start values by FMU and variable: of String variables the text, of an Enumeration the number of its item.

    ScenarioError of a text for a variable that takes none; of one that is not there check_names says so.
    """
    typed = {name: dict(values) for name, values in start.items()}
    for name, values in start.items():
        texts = {variable: value for variable, value in values.items() if isinstance(value.written, str)}
        known = sources[name].exists
        variables = {variable.name: variable for variable in
                     describe(name, sources[name]).modelVariables} if texts and known else {}
        for variable, value in texts.items():
            key = key_path(["fmus", name, "start", variable])
            place = value.origin or f"{plan.source}: {key} = {value.written!r}"
            if variable in variables or not known:
                typed[name][variable] = of_type(variables.get(variable), value, place)
    return typed


def in_declared_units(plan: RunPlan, start: Mapping[str, Mapping[str, StartValue]],
                      sources: Mapping[str, Source]) -> tuple[RunPlan, dict[str, dict[str, StartValue]]]:
    """Plan with signals in SI, and start values by FMU and variable in SI, of FMUs with files by name.

    ScenarioError if one is in a unit that neither is known nor declared by its FMU.
    """
    def declared(unit: str, name: str, where: str) -> Unit:
        """Return the unit that an FMU declares; empty for an unknown variable, which fails later."""
        units = declared_units(describe(name, sources[name])) if sources[name].exists else {}
        if unit not in units:
            raise ScenarioError(f"{where}: unknown unit {unit!r}, which {name} does not declare by SI base units "
                                f"either; {like(unit, [*UNITS, *units])}")
        return units[unit]

    converted = {name: dict(values) for name, values in start.items()}
    for name, values in start.items():
        for variable, value in values.items():
            if value.unit is not None and known_unit(value.unit) is None:
                place = f"{plan.source}: {key_path(['fmus', name, 'start', variable])} = {value.written!r}"
                unit = declared(value.unit, name, value.origin or place)
                converted[name][variable] = value._replace(value=value.value * unit.factor, unit=unit.si)
    signals = [signal if signal.unit is None or known_unit(signal.unit) is not None else signal.in_si(
        declared(signal.unit, signal.to.partition(".")[0], f"{plan.source}: signals[{i}].unit = {signal.unit!r}"))
        for i, signal in enumerate(plan.signals)]
    return plan.model_copy(update={"signals": signals}), converted
