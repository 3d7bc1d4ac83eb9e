"""The modules that make FMUs of the blocks of a rig, and its description as a module."""

from dataclasses import fields, is_dataclass
from typing import Any

from maglev.rig.text import LONGEST, each, module
from pmlsm.rig import Rig

LAWS = {"NONLINEAR": ("REGULATOR", "nonlinear"), "LINEAR": ("LINEAR_REGULATOR", "linear"),
        "SCHEDULED": ("SCHEDULED_REGULATOR", "scheduled")}


def laws(rig: Rig) -> list[str]:
    """Laws of the regulators of a rig."""
    return [law for law in LAWS if law != "SCHEDULED" or rig.design.schedule is not None]


def description(rig: Rig) -> str:
    """Text of `pmlsm/rig_NAME.py`."""
    names = sorted({type(part).__name__ for part in parts(rig)})
    return module(f'''
"""Description of the {rig.title}, from its file in `rigs`."""

{imported("pmlsm.rig", names)}

RIG = {literal(rig, 0)}
''')


def imported(name: str, members: list[str]) -> str:
    """Import of members of a module, a line for each where they are too many for one."""
    line = f"from {name} import {', '.join(members)}"
    return line if len(line) <= LONGEST else f"from {name} import (\n" + each(members, "    {0},") + "\n)"


def parts(value: Any) -> list[Any]:
    """Dataclasses of a description, itself first."""
    if is_dataclass(value):
        return [value, *(inner for each_field in fields(value) for inner in parts(getattr(value, each_field.name)))]
    return [inner for item in value for inner in parts(item)] if isinstance(value, tuple) else []


def literal(value: Any, depth: int) -> str:
    """Text of a value of a description, a line for each of its members."""
    inner = " " * (4 * depth + 4)
    if is_dataclass(value):
        members = [f"{each_field.name}={literal(getattr(value, each_field.name), depth + 1)}"
                   for each_field in fields(value)]
        short = f"{type(value).__name__}({', '.join(members)})"
        if "\n" not in short and len(short) < 100 - 4 * depth:
            return short
        return f"{type(value).__name__}(\n" + ",\n".join(inner + member for member in members) + ")"
    if isinstance(value, tuple) and value and is_dataclass(value[0]):
        return "(\n" + "".join(f"{inner}{literal(item, depth + 1)},\n" for item in value) + f"{inner[4:]})"
    if isinstance(value, dict) and len(repr(value)) > 90:
        return "{\n" + ",\n".join(f"{inner}{key!r}: {item!r}" for key, item in value.items()) + "}"
    return repr(value)


def plant(rig: Rig) -> str:
    """Text of `plant_fmu/plant_NAME.py`."""
    return module(f'''
"""The FMU Plant{rig.suffix}."""

from plant_fmu.definition import plant
from plant_fmu.stage_{rig.name} import Stage{rig.suffix}
from pmlsm.rig_{rig.name} import RIG

PLANT = plant(RIG, Stage{rig.suffix})
''')


def regulators(rig: Rig) -> str:
    """Text of `controller_fmu/regulator_NAME_fmu.py`."""
    lines = "\n".join(f"{LAWS[law][0]} = regulator(RIG, Regulator{rig.suffix}, {law})" for law in laws(rig))
    return module(f'''
"""The FMUs of the regulators of the {rig.title}."""

from controller_fmu.definitions import regulator
from controller_fmu.regulator_{rig.name} import Regulator{rig.suffix}
from controller_fmu.status import {", ".join(sorted(laws(rig)))}
from pmlsm.rig_{rig.name} import RIG

{lines}
''')


def single(package: str, name: str, function: str) -> Any:
    """Text of a module that makes one FMU of one block, as a function of the rig."""
    def text(rig: Rig) -> str:
        parts = {f"{package}.{name.lower()}_{rig.name}": f"{name}{rig.suffix}",
                 f"{package}.definition{'s' if package == 'controller_fmu' else ''}": function}
        imports = [f"from {place} import {part}" for place, part in sorted(parts.items())]
        return module(f'''
"""The FMU {name}{rig.suffix}."""

{each(imports, "{0}")}
from pmlsm.rig_{rig.name} import RIG

{name.upper()} = {function}(RIG, {name}{rig.suffix})
''')
    return text


def closed_loops(rig: Rig) -> str:
    """Text of `closed_loop_fmu/closed_loop_NAME_fmu.py`."""
    suffix = rig.suffix
    lines = [f"CLOSED_LOOP_{LAWS[law][1].upper()} = closed_loop(RIG, ClosedLoop{suffix}, \"{LAWS[law][1]}\", "
             f"{LAWS[law][0]}, PLANT)" for law in laws(rig)]
    regulators_of = ", ".join(sorted(LAWS[law][0] for law in laws(rig)))
    return module(f'''
"""The FMUs ClosedLoop… of the {rig.title}: one for each controller."""

from closed_loop_fmu.closed_loop_{rig.name} import ClosedLoop{suffix}, ClosedLoopPID{suffix}
from closed_loop_fmu.definition import closed_loop
from controller_fmu.pid_{rig.name}_fmu import PID
from controller_fmu.regulator_{rig.name}_fmu import {regulators_of}
from plant_fmu.plant_{rig.name} import PLANT
from pmlsm.rig_{rig.name} import RIG

{each(lines, "{0}")}
CLOSED_LOOP_PID = closed_loop(RIG, ClosedLoopPID{suffix}, "PID", PID, PLANT)
''')
