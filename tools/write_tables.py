"""Put the tables of stages and of capability flags into docs/stages.md and docs/fmi.md, between their markers.

    python tools/write_tables.py
"""

import xml.etree.ElementTree as ElementTree
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from maglev.descriptions.own_fmus import DEFINITIONS, definition
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.marked import with_part
from maglev.fmi.definition import FmuDefinition
from maglev.fmi.model_description import model_description, model_description_3
from pmlsm.stage_description import StageDescription

DOCS = Path(__file__).parents[1] / "docs"
YES_NO = {"false": "no", "true": "yes"}
INTERFACES = {"CoSimulation": "co-simulation", "ModelExchange": "model exchange"}
IN_FMI_3 = {"canGetAndSetFMUstate": "canGetAndSetFMUState", "canSerializeFMUstate": "canSerializeFMUState",
            "providesDirectionalDerivative": "providesDirectionalDerivatives"}

# Kinds of FMU that share all their flags, each with the beginnings of its names.
GROUPS = {"plants": ("Plant",), "closed loops": ("ClosedLoop",),
          "controllers, estimators, measurements, commutations": ("",)}


def markdown(head: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    lines = [" | ".join(cells) for cells in (head, ["---"] * len(head), *rows)]
    return "\n".join(f"| {line} |" for line in lines) + "\n"


def short(stage: StageDescription) -> str:
    return stage.title.removesuffix(" stage")


def axes_table() -> str:
    rows = []
    for stage in PACKAGED_STAGES.values():
        for axis in stage.axes:
            length, mass, force = ("mrad", "kg m²", "N m") if axis.rotation else ("mm", "kg", "N")
            stop, place = (axis.stop, "") if axis.stop else (stage.motor_stop, ", at the motors")
            ends = "–" if axis.rotation or not stop else f"{1e3 * stop.lower:g} to {1e3 * stop.upper:g} mm{place}"
            friction = axis.friction
            rows.append((short(stage), f"`{axis.name}`", axis.meaning, f"{axis.mass:g} {mass}",
                         f"{1e3 * axis.start:g} {length}", ends,
                         f"{friction.coulomb:g} {force}", f"{1e3 * friction.presliding:g} {length}",
                         f"{friction.viscous:g} {force} s" + ("" if axis.rotation else "/m")))
    return markdown(("stage", "axis", "meaning", "mass, inertia", "start", "end stops", "Coulomb friction",
                     "presliding", "viscous friction"), rows)


def motors_table() -> str:
    rows = []
    for stage in PACKAGED_STAGES.values():
        for motor in stage.motors:
            amplifier, winding = motor.amplifier, motor.winding
            place = f"x = {1e3 * motor.x:g}, z = {1e3 * motor.z:g} mm" if stage.rotations else ""
            rows.append((short(stage), f"`{motor.name}`", f"{stage.sharing:g}", f"`{motor.drives}`", place,
                         f"{amplifier.peak:g} A", f"{amplifier.continuous:g} A", f"{1e3 * amplifier.lag:g} ms",
                         f"{winding.resistance:g} Ω", f"{1e3 * winding.inductance:g} mH"))
    return markdown(("stage", "motor", "motors in it", "drives", "place", "peak current", "continuous current", "lag",
                     "resistance", "inductance"), rows)


def constants_table() -> str:
    rows = [(short(stage), f"`{each.name}`", each.meaning, f"{each.plant:g}", f"{each.model:g}", each.unit)
            for stage in PACKAGED_STAGES.values() for each in stage.constants]
    return markdown(("stage", "constant", "meaning", "plant", "controllers' model", "unit"), rows)


def limits_table() -> str:
    rows = []
    for stage in PACKAGED_STAGES.values():
        design = stage.design
        rows.append((short(stage), f"{1e3 * stage.sample_time:g} ms", f"{1e3 * stage.longest_step:g} ms",
                     f"{1e6 * stage.resolution:g} µm", f"{design.current_limit:g} A",
                     f"{design.pid_current_limit:g} A" if design.pid_current_limit else "no limit",
                     YES_NO[str(design.antiwindup).lower()], f"{1e3 * design.observer_time:g} ms"))
    return markdown(("stage", "sample time", "longest integration step", "encoder resolution",
                     "limit of the regulators", "limit of the PID", "anti-windup", "velocity observer"), rows)


def flags_of(model: FmuDefinition) -> dict[str, dict[str, str]]:
    """Values of each flag, by its interface and its name in FMI 3.0, then by the kinds of FMU that have it."""
    texts = {"native FMI 2.0": model_description(model, "", "", 0, ("all.c",)),
             "FMI 3.0": model_description_3(model, "", "", 0),
             "Python": model_description(model, "", "", 0)}
    found: dict[str, dict[str, str]] = {}
    for kind, text in texts.items():
        for interface in ElementTree.fromstring(text):
            for name, value in interface.attrib.items() if interface.tag in INTERFACES else ():
                if name not in ("modelIdentifier", "fixedInternalStepSize"):   # the one is a name, the other a time
                    row = f"{INTERFACES[interface.tag]} | `{IN_FMI_3.get(name, name)}`"
                    found.setdefault(row, {})[kind] = YES_NO.get(value, value)
    return found


def flag_cell(values: dict[str, str]) -> str:
    """Value of a flag; with the kinds of FMU that have it, where they differ or FMI 3.0 alone knows it."""
    if len({*values.values()}) == 1 and list(values) != ["FMI 3.0"]:
        return next(iter(values.values()))
    if values.get("native FMI 2.0") == values.get("FMI 3.0", values.get("native FMI 2.0")) and "Python" in values:
        return f"{values['native FMI 2.0']}; Python: {values['Python']}"
    return ", ".join(f"{kind}: {value}" for kind, value in values.items())


def flags_table() -> str:
    """Flags that a group's FMUs agree in, one row a flag; ValueError if they do not agree."""
    columns: dict[str, dict[str, dict[str, str]]] = {}
    for name in DEFINITIONS:
        group = next(group for group, beginnings in GROUPS.items() if name.startswith(beginnings))
        flags = flags_of(definition(name))
        if columns.setdefault(group, flags) != flags:
            raise ValueError(f"{name}: its capability flags differ from those of the other {group}")
    names = sorted({name for flags in columns.values() for name in flags})
    rows = [(name, *(flag_cell(flags[name]) if name in flags else "–" for flags in map(columns.__getitem__, GROUPS)))
            for name in names]
    return markdown(("interface", "flag", *GROUPS), rows)


PARTS: dict[str, dict[str, Callable[[], str]]] = {
    "stages.md": {"axes": axes_table, "motors": motors_table, "constants": constants_table, "limits": limits_table},
    "fmi.md": {"flags": flags_table}}


if __name__ == "__main__":
    for name, parts in PARTS.items():
        for part, made in parts.items():
            (DOCS / name).write_text(with_part(DOCS / name, part, made()), encoding="utf-8")
