"""Targets that a study sets in each run: parameters, inputs and references, with their values by sample."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np
from fmpy.model_description import ModelDescription

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError, nearest
from maglev.files.units import measures
from maglev.many.study_file import DISCRETE, Mode, Varied
from maglev.runs.preparation import Experiment
from maglev.scenario.run_plan import StartValue
from maglev.scenario.settings import REFERENCE, port_of, reference_unit, with_reference
from maglev.scenario.signals import Steps


@dataclass(frozen=True)
class Target:
    """One start value `fmu.variable`, or reference, that a study sets."""

    name: str
    column: int      # of the design, whose value it takes
    mode: Mode       # "value", "factor" of the nominal value, or "offset" to it
    nominal: float   # SI, of the scenario
    unit: str        # SI; empty text where the FMU gives none
    boolean: bool
    low: float       # end of its range
    high: float

    def values(self, column: Array) -> Array:
        """Its values, from those of the design's column: in decimals, so that 0.7 kg more than 6.9 kg are 7.6 kg."""
        if self.mode == "value":
            return column
        nominal = Decimal(repr(float(self.nominal)))
        changed = nominal.__mul__ if self.mode == "factor" else nominal.__add__
        return np.array([float(changed(Decimal(repr(each)))) for each in column.tolist()])


def targets_of(vary: Iterable[Varied], experiment: Experiment, origin: str, key: str = "vary") -> list[Target]:
    """Return the targets of a study, in the order of the file; ScenarioError if one cannot be set, or not to its
    values.
    """
    descriptions = experiment.check()
    targets = []
    for i, varied in enumerate(vary):
        entry = f"{origin}: {key}[{i}]"
        for name in varied.set:
            target = target_of(name, i, varied.mode, experiment, descriptions, f"{entry}.set = {name!r}")
            if target.boolean and (varied.kind not in DISCRETE or (varied.number or 2) > 2):   # any but 0 is true
                raise ScenarioError(f"{entry}: {name} is Boolean, expected no value between false and true")
            expected = "1" if varied.mode == "factor" else target.unit or "1"
            for quantity in varied.quantities:
                if quantity.unit is not None and not measures(quantity.unit, expected):
                    raise ScenarioError(f"{entry}: {quantity.written}: is in {quantity.unit}, expected a "
                                        f"{'factor' if varied.mode == 'factor' else f'quantity in {expected}'}")
                if target.boolean != isinstance(quantity.value, bool):
                    raise ScenarioError(f"{entry}: {quantity.written}: {name} is "
                                        f"{'Boolean, expected true or false' if target.boolean else 'a number'}")
            targets.append(target)
        if varied.mode == "factor" and not any(target.nominal for target in targets if target.column == i):
            raise ScenarioError(f"{entry}.set = {', '.join(varied.set)!r}: a factor on 0 varies nothing, expected "
                                "values, such as LOW:HIGH, or mode = 'offset'")
    return targets


def require_free(settings: Mapping[str, StartValue], vary: Iterable[Varied], origin: str) -> None:
    """Refuse to set `fmu.variable` that varies; the target of a factor or an offset may be set."""
    varied = {name for parameter in vary if parameter.mode == "value" for name in parameter.set}
    for name in settings.keys() & varied:
        raise ScenarioError(f"{origin}: {settings[name].origin}: {name} is set and varied, expected one of both")


def target_of(name: str, column: int, mode: Mode, experiment: Experiment, descriptions: dict[str, ModelDescription],
              key: str) -> Target:
    """Return one target by its name; `key` is the key that errors name."""
    fmu, _, own = name.partition(".")
    if fmu == REFERENCE:
        what = own.rpartition(".")[2]
        try:
            plan = with_reference(experiment.plan, own, experiment.plan.stop_time if what == "time" else 1.0)
        except ScenarioError as error:
            raise ScenarioError(f"{key}: {error}") from None
        to = port_of(plan, own.rpartition(".")[0])
        signal = next(signal for signal in experiment.plan.signals if signal.to == to)
        times = {"start": 0.0, "end": experiment.plan.stop_time}
        nominal = signal.value(times[what]) if what in times else 1.0
        if what == "time" and isinstance(signal, Steps):
            nominal = signal.times[-1]
        return Target(name, column, mode, nominal, reference_unit(plan, own), False, -np.inf, np.inf)
    if fmu not in descriptions:
        raise ScenarioError(f"{key}: there is no FMU {fmu!r}, {nearest(fmu, [*descriptions, REFERENCE])}")
    variables = {variable.name: variable for variable in descriptions[fmu].modelVariables}
    settable = [name for name, variable in variables.items() if variable.causality in ("parameter", "input")]
    if own not in variables:
        raise ScenarioError(f"{key}: {fmu} has no parameter {own!r}; {nearest(own, settable)}")
    variable = variables[own]
    if own not in settable:
        raise ScenarioError(f"{key}: is of causality {variable.causality}, expected a parameter or an input; "
                            f"{nearest(own, settable)}")
    if variable.type not in ("Real", "Boolean"):
        raise ScenarioError(f"{key}: is of type {variable.type}, expected Real or Boolean")
    plan = experiment.plan
    if own in plan.fmus[fmu].start_from:
        raise ScenarioError(f"{key}: comes from another run, expected what the scenario itself sets")
    if name in {*(end for _, end in plan.wires.values()), *(port for signal in plan.signals
                                                            for port in (signal.to, signal.rate_to))}:
        raise ScenarioError(f"{key}: is fed from the start, expected a parameter, an input that nothing feeds, or "
                            "reference.AXIS.amplitude, .start or .end")
    boolean = variable.type == "Boolean"
    if boolean and mode != "value":
        raise ScenarioError(f"{key}: is Boolean, expected mode = 'value'")
    return Target(name, column, mode, experiment.start_value(name, descriptions), variable.unit or "", boolean,
                  -np.inf if variable.min is None else float(variable.min),
                  np.inf if variable.max is None else float(variable.max))


def target_values(targets: Sequence[Target], design: Array, origin: str) -> Array:
    """Values of the targets, shape (number of samples, number of targets); ScenarioError if some are out of range."""
    values = np.column_stack([target.values(design[:, target.column]) for target in targets])
    for i, target in enumerate(targets):
        outside = np.flatnonzero(~((values[:, i] >= target.low) & (values[:, i] <= target.high)))
        if len(outside):
            raise ScenarioError(f"{origin}: {target.name}: {len(outside)} of {len(values)} samples are out of range, "
                                f"the first is {values[outside[0], i]:g}, expected {target.low:g} to {target.high:g} "
                                f"{target.unit}".rstrip())
    return values
