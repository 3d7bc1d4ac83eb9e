"""Values in units that an FMU of somebody else's declares itself: converted, once the FMU is known."""

from collections.abc import Mapping
from pathlib import Path

from maglev.cosim.open import read_description
from maglev.cosim.port_map import declared_units
from maglev.errors import ScenarioError, key_path
from maglev.schema.run_plan import RunPlan, StartValue
from maglev.units import UNITS, Unit, known_unit, like


def in_declared_units(plan: RunPlan, start: Mapping[str, Mapping[str, StartValue]],
                      files: Mapping[str, Path]) -> tuple[RunPlan, dict[str, dict[str, StartValue]]]:
    """Plan with signals in SI, and start values by FMU and variable in SI, of FMUs with files by name.

    ScenarioError if one is in a unit that neither is known nor declared by its FMU.
    """
    def declared(unit: str, name: str, where: str) -> Unit:
        """Unit that an FMU declares, none of one that is not there, which is refused later."""
        units = declared_units(read_description(name, files[name])) if files[name].is_file() else {}
        if unit not in units:
            raise ScenarioError(f"{where}: unknown unit {unit!r}, which {name} does not declare by SI base units "
                                f"either; {like(unit, [*UNITS, *units])}")
        return units[unit]

    converted = {name: dict(values) for name, values in start.items()}
    for name, values in start.items():
        for variable, value in values.items():
            if value.unit is not None and known_unit(value.unit) is None:
                place = f"{plan.path}: {key_path(['fmus', name, 'start', variable])} = {value.written!r}"
                unit = declared(value.unit, name, value.origin or place)
                converted[name][variable] = value._replace(value=value.value * unit.factor, unit=unit.si)
    signals = [signal if signal.unit is None or known_unit(signal.unit) is not None else signal.in_si(
        declared(signal.unit, signal.to.partition(".")[0], f"{plan.path}: signals[{i}].unit = {signal.unit!r}"))
        for i, signal in enumerate(plan.signals)]
    return plan.model_copy(update={"signals": signals}), converted
