"""Values in units that an FMU of somebody else's declares itself: converted, once the FMU is known."""

from collections.abc import Callable, Mapping

from maglev.errors import ScenarioError, key_path
from maglev.schema.run_plan import StartValue
from maglev.schema.signals.kinds import Signal
from maglev.units import UNITS, Unit, known_unit, like

Declared = Callable[[str], Mapping[str, Unit]]   # units by name, from the name of an FMU in the run


def known_start_values(start: Mapping[str, Mapping[str, StartValue]], place: str,
                       declared: Declared) -> dict[str, dict[str, StartValue]]:
    """Start values by FMU and variable, in SI; `place` is the file that refusals name.

    Raises
    ------
    ScenarioError
        If one is in a unit that neither is known nor declared by its FMU.
    """
    return {name: {variable: known_start(value, key_path(["fmus", name, "start", variable]), name, place, declared)
                   for variable, value in values.items()} for name, values in start.items()}


def known_start(value: StartValue, key: str, name: str, place: str, declared: Declared) -> StartValue:
    """One of them."""
    if value.unit is None or known_unit(value.unit) is not None:
        return value
    unit = unit_of(value.unit, value.origin or f"{place}: {key} = {value.written!r}", name, declared)
    return value._replace(value=value.value * unit.factor, unit=unit.si)


def known_signal(signal: Signal, i: int, place: str, declared: Declared) -> Signal:
    """A signal in SI, likewise."""
    if signal.unit is None or known_unit(signal.unit) is not None:
        return signal
    where = f"{place}: signals[{i}].unit = {signal.unit!r}"
    return signal.in_si(unit_of(signal.unit, where, signal.to.partition(".")[0], declared))


def unit_of(unit: str, where: str, name: str, declared: Declared) -> Unit:
    """Unit that an FMU declares; `where` begins the refusal."""
    units = declared(name)
    if unit not in units:
        raise ScenarioError(f"{where}: unknown unit {unit!r}, which {name} does not declare by SI base units either; "
                            f"{like(unit, [*UNITS, *units])}")
    return units[unit]
