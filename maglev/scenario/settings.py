"""Settings of the user: start values `fmu.variable=value`, and references `reference.x.amplitude=1.2`."""

from collections.abc import Iterable, Mapping

from maglev.files.errors import ScenarioError, nearest, option
from maglev.files.units import measures, number_or_text, refused_as
from maglev.scenario.run_plan import RunPlan, StartValue, read_open_value
from maglev.scenario.signals import Constant, Signal, Sinusoids, Steps
from pmlsm.stage_description import ROTATION

REFERENCE = "reference"   # in the place of an FMU's name
UNITS = {"amplitude": "1", "start": "m", "end": "m", "time": "s"}

Settings = Mapping[str, float | int | bool | str | StartValue] | Iterable[str] | None


def start_values(given: Settings) -> dict[str, StartValue]:
    """Return start values by `fmu.variable`, as text with a unit if need be; ScenarioError for any other setting.

    Of words of a command line, `fmu.variable=value`, the last one for a name counts.
    """
    if isinstance(given, Mapping):
        return {name: value if isinstance(value, StartValue) else start_value(name, value)
                for name, value in given.items()}
    words = [given] if isinstance(given, str) else () if given is None else [*given]
    for word in words:
        if not isinstance(word, str):
            raise ScenarioError(f"set: {word!r}, expected a table, values by name, or texts such as 'plant.y.mass=7.2'")
    pairs = (word.partition("=") for word in words)
    return {name.strip(): start_value(name.strip() if equals else "", text, "" if equals else name)
            for name, equals, text in pairs}


def start_value(name: str, value: float | bool | str, written: str = "") -> StartValue:
    """Return one start value; `written` is a word without a name."""
    text = str(value).strip()
    origin = option("set", written or {name: value})
    if not isinstance(name, str) or not all(name.strip().partition(".")):
        raise ScenarioError(f"{origin}: expected FMU.variable=value, such as plant.y.mass=7.2")
    if text.lower() in ("true", "false"):
        return StartValue(text.lower() == "true", None, text if isinstance(value, str) else text.lower(), origin)
    with refused_as(ScenarioError, origin):
        start = read_open_value(number_or_text(text) if isinstance(value, str) else value)
    return start._replace(origin=origin, written=value)


def with_references(plan: RunPlan, settings: Mapping[str, StartValue]
                    ) -> tuple[RunPlan, dict[str, StartValue], list[str]]:
    """Return the plan with the references of the settings, and the settings by kind: those of FMUs, those of
    references.
    """
    others, about_fmus = [], {}
    for name, value in settings.items():
        if name.partition(".")[0] != REFERENCE or REFERENCE in plan.fmus:
            about_fmus[name] = value
            continue
        variable = name.partition(".")[2]
        unit = reference_unit(plan, variable)
        if (value.unit is not None and not measures(value.unit, unit)) or isinstance(value.given, bool | str):
            raise ScenarioError(f"{value.origin}: expected a number, or a quantity in {unit}")
        changed_plan = with_reference(plan, variable, float(value.value))
        if changed_plan.signals != plan.signals:
            others.append(f"{name} = {value.written}")
        plan = changed_plan
    return plan, about_fmus, others


def reference_unit(plan: RunPlan, setting: str) -> str:
    """Return the SI unit of a setting of a reference, such as `AXIS.start`; "1" for an unknown axis or setting."""
    name, _, what = setting.rpartition(".")
    unit, axis = UNITS.get(what, "1"), plan.axes.get(name)
    if axis is None and what != "time":
        return "1"
    return ROTATION.get(unit, unit) if axis is not None and axis.rotation else unit


def port_of(plan: RunPlan, name: str) -> str:
    """Return the port that a signal leads to, by the name of an axis or by its own."""
    return plan.axes[name].reference if name in plan.axes else name


def with_reference(plan: RunPlan, setting: str, value: float) -> RunPlan:
    """Return the plan with another reference of an axis, by a setting and its value (SI).

    "AXIS.amplitude" multiplies the motion of the reference about its first value, or about its offset, by the value.
    "AXIS.start" and "AXIS.end" are the first and the last value of steps, or the value of a constant. "AXIS.time" is
    the time of the last step. AXIS can also be the input of another signal, as in "plant.y.mass.end". Raises
    ScenarioError if there is no such axis or signal, or its kind does not have the setting.
    """
    axis, _, what = setting.rpartition(".")
    if what not in UNITS:
        raise ScenarioError(f"reference.{setting}: expected reference.AXIS.{', .'.join(UNITS)}; {nearest(what, UNITS)}")
    driven = [signal.to for signal in plan.signals]
    if axis not in plan.axes and axis not in driven:
        raise ScenarioError(f"reference.{setting}: {plan.name} has no axis {axis!r}, "
                            f"{nearest(axis, [*plan.axes, *driven])}")
    to = port_of(plan, axis)
    if to not in driven:
        raise ScenarioError(f"reference.{setting}: {plan.name} has no signal to {to}, expected one to change")
    return plan.model_copy(update={"signals": [changed(signal, setting, what, value) if signal.to == to else signal
                                               for signal in plan.signals]})


def changed(signal: Signal, setting: str, what: str, value: float) -> Signal:
    if isinstance(signal, Steps) and what == "time":
        before = signal.times[-2] if len(signal.times) > 1 else value
        if not before < value:
            raise ScenarioError(f"reference.{setting} = {value:g} s, expected a time after the step before, at "
                                f"{before:g} s")
        return signal.model_copy(update={"times": [*signal.times[:-1], value]})
    if isinstance(signal, Steps):
        values = list(signal.values)
        if what == "amplitude":
            values = [level if value == 1.0 else values[0] + value * (level - values[0]) for level in values]
        else:
            values[0 if what == "start" else -1] = value
        return signal.model_copy(update={"values": values})
    if isinstance(signal, Constant) and what != "amplitude":
        return signal.model_copy(update={"level": value})
    if isinstance(signal, Sinusoids) and what == "amplitude":
        terms = [term.model_copy(update={"amplitude": value * term.amplitude}) for term in signal.terms]
        return signal.model_copy(update={"terms": terms})
    raise ScenarioError(f"reference.{setting}: {signal.to} is of kind {signal.kind}, which has no {what} to change")
