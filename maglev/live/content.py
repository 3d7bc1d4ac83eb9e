"""What the live page carries as data: the FMUs' descriptions, the runs' plans, and what the picture is drawn from."""

from collections.abc import Iterable
from pathlib import Path
from typing import Any

from fmpy.model_description import ModelDescription, ScalarVariable

from maglev.cosim.fmu import read_description
from maglev.errors import FmuError
from maglev.linear.parameters import BLOCKS
from maglev.schema.layers import packaged_files
from maglev.schema.loading import load_plans
from maglev.schema.run_plan import RunPlan
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.rig import Rig
from pmlsm.rigs import RIGS
from pmlsm.velocity_rows import GRAVITY

# Plant and controllers of a rig, these in the order in which they are offered.
PLANTS = {rig: plant.name for rig, (plant, *_) in BLOCKS.items() if rig in RIGS}
CONTROLLERS = {rig: tuple(each.name for each in BLOCKS[rig][1:]) for rig in PLANTS}
FLOWN = tuple(name for rig in PLANTS for name in (PLANTS[rig], *CONTROLLERS[rig]))
LAWS = {"Regulator": "nonlinear", "LinearRegulator": "linear", "ScheduledRegulator": "scheduled", "PID": "PID"}
SIGNALS = ("constant", "steps", "sinusoids")

GAPS = 65   # of the table of shape functions


def flies_live(plan: RunPlan) -> bool:
    """Whether the page can fly a run: a packaged experiment of one plant and one controller on references."""
    models = {name: fmu.model for name, fmu in plan.fmus.items()}
    return (plan.path in packaged_files().values() and not plan.check_only and plan.procedure is None and not plan.needs
            and list(models) == ["controller", "plant"]
            and any(models["plant"] == PLANTS[rig] and models["controller"] in CONTROLLERS[rig] for rig in PLANTS)
            and all(signal.kind in SIGNALS and signal.to.endswith(".reference") for signal in plan.signals))


def live_runs() -> list[RunPlan]:
    """Packaged runs that the page can fly."""
    return [plan for name in packaged_files() for plan in load_plans(name) if flies_live(plan)]


def page_data(fmus: Path) -> dict[str, Any]:
    """Everything but the modules, for JSON; the descriptions of the modules are in a folder.

    Raises
    ------
    FmuError
        If one is missing.
    """
    return {"fmus": {name: description_data(described(fmus, name)) for name in FLOWN},
            "runs": {plan.name: run_data(plan) for plan in live_runs()},
            "gravity": GRAVITY, "rigs": {name: rig_data(rig) for name, rig in RIGS.items()}}


def described(fmus: Path, name: str) -> ModelDescription:
    """Description of a module in a folder."""
    for path in (fmus / f"{name}.wasm", fmus / f"{name}.xml"):
        if not path.is_file():
            raise FmuError(f"{path}: there is no such file, expected the modules for the live page: "
                           "maglev build --native --target wasm")
    return read_description(name, fmus / f"{name}.xml")


def description_data(description: ModelDescription) -> dict[str, Any]:
    """What the page needs of a model description."""
    return {"name": description.modelName, "guid": description.guid,
            "variables": [variable_data(variable) for variable in description.modelVariables]}


def variable_data(variable: ScalarVariable) -> dict[str, Any]:
    """What the page needs of a variable; outputs are named alone."""
    boolean = variable.type == "Boolean"
    data = {"name": variable.name, "reference": variable.valueReference, "causality": variable.causality,
            "boolean": boolean}
    if variable.causality == "output":
        return data
    start: float | bool = variable.start == "true" if boolean else float(variable.start)
    data |= {"start": start, "fixed": variable.variability == "fixed"}
    if variable.causality == "parameter":
        data |= {"unit": variable.unit or "", "description": variable.description}
        data |= {} if boolean else {"min": float(variable.min), "max": float(variable.max)}
    return data


def run_data(plan: RunPlan) -> dict[str, Any]:
    """A run's plan as the page flies it, SI."""
    rig = next(rig for rig in RIGS.values() if PLANTS[rig.name] == plan.fmus["plant"].model)
    laws = {name: LAWS[name.removesuffix(rig.suffix)] for name in CONTROLLERS[rig.name]}
    return {"title": plan.title, "plant": PLANTS[rig.name], "step": plan.step, "stop": plan.stop_time,
            "axes": rig.axis_names, "vertical": rig.vertical.name, "motors": rig.motor_names,
            "drives": {motor.name: motor.drives for motor in rig.motors}, "rig": rig.name, "laws": laws,
            "fmus": {name: {"model": fmu.model, "start": {key: start.value for key, start in fmu.start.items()}}
                     for name, fmu in plan.fmus.items()},
            "wires": list(plan.wires.values()), "bands": plan.metrics.bands,
            "signals": [signal.model_dump() for signal in plan.signals]}


def rig_data(rig: Rig) -> dict[str, Any]:
    """Its data sheet, and what the forces in the picture are computed with, see `pmlsm.velocity_rows`."""
    motor = rig.motor()
    sheet = {name: getattr(motor, name) for name in ("slot_pitch", "slot_width", "pole_pitch", "magnet_height")}
    return {"title": rig.title, "sheet": sheet, "gap": gap_table(motor),
            "mass": {axis.name: axis.mass for axis in rig.axes}, "carrying": rig.carrying, "driving": rig.sharing,
            "vertical": rig.constants_of(rig.vertical.name),
            "thrust": {axis.name: rig.constants_of(axis.name)[0] for axis in rig.horizontal}}


def gap_table(motor: MotorGeometry) -> dict[str, Any]:
    """Shape functions f1 to f4 over the air gap (m)."""
    first = motor.field.lower
    step = (motor.field.upper - first) / (GAPS - 1)
    return {"first": first, "step": step, "values": rounded(gap_functions(motor, first + k * step)
                                                            for k in range(GAPS))}


def rounded(rows: Iterable[tuple[float, ...]]) -> list[list[float]]:
    """Numbers with as many digits as a picture needs."""
    return [[float(f"{value:.6g}") for value in row] for row in rows]
