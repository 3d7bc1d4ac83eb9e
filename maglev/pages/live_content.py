"""Data of the live page: the FMUs' descriptions, the runs' plans, and the data of the picture."""

import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any
from urllib.parse import quote

from fmpy.model_description import ScalarVariable

from maglev.cosim.fmu import read_description
from maglev.descriptions.own_fmus import stale
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import FmuError
from maglev.files.fmi_units import typeset_unit
from maglev.linear.parameters import linear_names
from maglev.pages.javascript import law_text, parts_text, python_law
from maglev.pages.panels import PANELS
from maglev.scenario.layers import is_packaged, packaged_files
from maglev.scenario.loading import load_plans
from maglev.scenario.run_plan import RunPlan
from maglev.user.adoption import know_stage
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.stage_description import StageDescription
from pmlsm.velocity_rows import GRAVITY

LAWS = {"Regulator": "nonlinear", "LinearRegulator": "linear", "ScheduledRegulator": "scheduled",
        "InterpolatedRegulator": "interpolated", "PID": "PID", "AdaptiveRegulator": "adaptive"}
# Numbers of lines of runs; a reader's law has 1.
LAW_COLOURS = {"nonlinear": 0, "linear": 2, "scheduled": 3, "PID": 4, "adaptive": 5, "interpolated": 6}
SIGNALS = ("constant", "steps", "sinusoids")
NAME = "live.html"   # the page of all runs, which others in its folder link to

ARM = 3.5   # pole pitches from the middle of a platform to its motors, where no description says so
GAPS = 65   # of the table of shape functions


def modules_of(stage: StageDescription) -> list[str]:
    """Return a plant, its controllers, and the measurement between its encoders and a controller."""
    return [*linear_names(stage), f"Measurement{stage.suffix}"]


def can_run_live(plan: RunPlan) -> bool:
    """Return True if the page of all runs has a run: a packaged experiment of one plant and one controller.

    A run for the check alone is in it if a disturbance acts on the stage, or on its measurements.
    """
    happens = "measurement" in plan.fmus or bool(plan.events)
    return plan.source in packaged_files().values() and (happens or not plan.check_only) and not why_not_live(plan)


def not_live() -> dict[str, list[str]]:
    """Packaged experiments that no page can run, by the reason."""
    reasons: dict[str, list[str]] = {}
    for plan in (plan for name in packaged_files() for plan in load_plans(name) if not plan.check_only):
        if why := why_not_live(plan):
            reasons.setdefault(why, []).append(plan.name)
    return reasons


def why_not_live(plan: RunPlan) -> str:
    """Return the reason why no page can make a run; empty if one can."""
    models, stage = {name: fmu.model for name, fmu in plan.fmus.items()}, plan.stage
    plant, *controllers = linear_names(stage) if stage is not None else [""]
    between = models.pop("measurement", None)
    if (list(models) != ["controller", "plant"] or models["plant"] != plant or models["controller"] not in controllers
            or stage is None or between not in (None, f"Measurement{stage.suffix}")):
        others = next((f" (a law without references of {' and '.join(tilt.name for tilt in stage.rotations)})"
                       for other in PACKAGED_STAGES.values()
                       if stage is not None and stage.rotations and not other.rotations
                       and models.get("controller") in linear_names(other)), "")
        run = ", ".join(dict.fromkeys(map(str, (fmu.model for fmu in plan.fmus.values()))))
        return f"it runs {run}{others}, expected a controller and then the plant of one stage"
    if plan.procedure is not None or plan.needs:
        return "it is part of a procedure or begins as another run ends, expected a run of its own"
    other = next((signal for signal in plan.signals if signal.kind not in SIGNALS or (
        signal.to.startswith("controller.") and not signal.to.endswith(".reference"))), None)
    return "" if other is None else (f"it has a signal {other.kind} to {other.to}, expected {', '.join(SIGNALS)} to "
                                     "references, to the plant or to measurements")


def require_live(plan: RunPlan) -> StageDescription:
    """Stage of a run that a page can run, whose stage this process knows from then on; FmuError of another run."""
    why = why_not_live(plan)
    if plan.stage is None or why:
        raise FmuError(f"{plan.name} cannot run in the live page: {why}")
    if plan.stage_file is not None:
        know_stage(plan.stage_file)
    return plan.stage


def live_runs() -> list[RunPlan]:
    return [plan for name in packaged_files() for plan in load_plans(name) if can_run_live(plan)]


def live_address(run: str, settings: Mapping[str, float | bool] | None = None) -> str:
    """Address of a run by its name, with start values by `fmu.variable`, SI, whose bits stay the same."""
    values = {name: str(value).lower() if isinstance(value, bool) else repr(value)
              for name, value in (settings or {}).items()}
    return f"{NAME}#" + "&".join(f"{quote(key)}={quote(value)}" for key, value in {"run": run, **values}.items())


def page_data(fmus: Path, plans: Iterable[RunPlan]) -> dict[str, Any]:
    """Return everything except the modules, for JSON; FmuError if a run cannot run in a page, or a module is unfit."""
    data: dict[str, Any] = {"fmus": {}, "runs": {}, "gravity": GRAVITY, "colours": LAW_COLOURS, "stages": {}}
    stages: list[StageDescription] = []
    for plan in plans:
        stage = require_live(plan)
        if stage.name not in data["stages"]:
            own = f"--stage {shlex.quote(str(plan.stage_file))} " if plan.stage_file is not None else ""
            again = f"maglev build {own}--kind native --target wasm"
            data["stages"][stage.name] = {**live_stage(stage), "law": law_text(stage)}
            stages.append(stage)
            data["fmus"] |= {name: module_data(fmus, name, again) for name in modules_of(stage)}
        data["runs"][plan.name] = live_run(plan, stage)
    return {**data, "parts": parts_text(map(python_law, stages))}


def module_data(fmus: Path, name: str, again: str) -> dict[str, Any]:
    """Return the page's data of a module in a folder, which must be of the present FMU."""
    path = fmus / f"{name}.xml"
    for file in (path.with_suffix(".wasm"), path):
        if not file.is_file():
            raise FmuError(f"{file}: there is no such file, expected the modules for the live page: {again}")
    if old := stale(name, path.with_suffix(".wasm")):
        raise FmuError(old)
    description = read_description(name, path)
    assert all(variable.valueReference == k for k, variable in enumerate(description.modelVariables))   # as pages count
    return {"name": name, "guid": description.guid, "variables": [*map(variable_data, description.modelVariables)]}


def variable_data(variable: ScalarVariable) -> dict[str, Any]:
    """Return the page's data of a variable; outputs have only names."""
    boolean = variable.type == "Boolean"
    data = {"name": variable.name, "causality": variable.causality, "boolean": boolean}
    if variable.causality == "output":
        return data
    start: float | bool = variable.start == "true" if boolean else float(variable.start)
    data |= {"start": start, "fixed": variable.variability == "fixed"}
    if variable.causality == "parameter":
        data |= {"unit": typeset_unit(variable.unit or ""), "description": variable.description}
        data |= {} if boolean else {"min": float(variable.min), "max": float(variable.max)}
    return data


def live_run(plan: RunPlan, stage: StageDescription) -> dict[str, Any]:
    """A run's plan as the page runs it, SI."""
    plant, *controllers = linear_names(stage)
    command = shlex.quote(str(plan.source)) if plan.own else plan.name if is_packaged(plan.source) else ""
    return {"title": plan.title, "plant": plant, "measurement": f"Measurement{stage.suffix}",
            "step": plan.step, "stop": plan.stop_time, "axes": stage.axis_names, "vertical": stage.vertical.name,
            "motors": stage.motor_names, "rotations": [axis.name for axis in stage.rotations],
            "external": [axis.external for axis in stage.axes],
            "drives": {motor.name: motor.drives for motor in stage.motors}, "stage": stage.name,
            "laws": {name: LAWS[name.removesuffix(stage.suffix)] for name in controllers},
            "command": command,
            "fmus": {name: {"model": fmu.model, "start": {key: start.value for key, start in fmu.start.items()}}
                     for name, fmu in plan.fmus.items()},
            "wires": list(plan.wires.values()), "bands": plan.metrics.bands,
            "signals": [signal.model_dump() for signal in plan.signals]}


def live_stage(stage: StageDescription) -> dict[str, Any]:
    """Return its data sheet, the room that it takes, and the constants of the forces in the picture."""
    motor, place = stage.motor(), PANELS["position"]
    sheet = {name: getattr(motor, name) for name in ("slot_pitch", "slot_width", "pole_pitch", "magnet_height")}
    gap = stage.vertical.stop or stage.motor_stop
    assert gap is not None   # on the axis or at the motors
    along = max(max(-axis.stop.lower, axis.stop.upper) for axis in stage.horizontal if axis.stop is not None)
    return {"title": stage.title, "home": stage.experiment, "sheet": sheet, "gap": gap_table(motor),
            "unlike": {motor.name: gap_table(stage.motor(motor), motor.ratios) for motor in stage.unlike},
            "room": {"along": along, "ends": [gap.lower, gap.upper]}, "sharing": stage.sharing, "places": places(stage),
            "mass": {axis.name: axis.mass for axis in stage.axes}, "tilts": visible_tilts(stage),
            "vertical": stage.constants_of(stage.vertical.name),
            "thrust": {axis.name: stage.constants_of(axis.name)[0] for axis in stage.horizontal},
            "shown": {axis.name: {"name": place.words(axis.name, axis is stage.vertical),
                                  **place.reading(axis.unit("m"))} for axis in stage.axes},
            "strips": list(strips(stage))}


def strips(stage: StageDescription) -> Iterator[dict[str, Any]]:
    """Panels that roll next to the stage: axes of a kind share one, and all motors."""
    together = (("position", stage.vertical.name, [stage.vertical]), ("position", "displacement", stage.horizontal),
                ("position", "tilt", stage.rotations), ("error", "axes", stage.axes))
    for kind, shown, axes in together:
        if axes:
            panel = PANELS[kind].data(shown, axes[0].unit("m"), axes[0] is stage.vertical and len(axes) == 1)
            yield {"kind": kind, "axes": [axis.name for axis in axes], **panel}
    yield {"kind": "currents", "axes": [], **PANELS["currents"].data("motor")}


def visible_tilts(stage: StageDescription) -> dict[str, Any]:
    """Return by horizontal axis the tilt seen from its side, and the plant's name for the motors' places along it.

    With a tilt the gap grows along the axis (sign 1) or shrinks (−1), see `plant_fmu.motor_mount`.
    """
    seen = zip(stage.horizontal, reversed(stage.rotations), (1, -1), ("x", "z"), strict=False)
    return {along.name: {"axis": tilt.name, "sign": sign, "place": place} for along, tilt, sign, place in seen
            if len(stage.horizontal) == 2}   # with one, the tilt is about the direction of view from the side


def places(stage: StageDescription) -> dict[str, list[tuple[float, float]]]:
    """Return by motor the places of its drawn motors above the platform, along the horizontal axes from its middle, m.

    A stage whose guides hold the tilts has no places. There the motors of an axis lie evenly on both sides, so far out
    that those of the two axes pass each other. A single one is in the middle. These places are free choices of the
    drawing.
    """
    if stage.rotations:
        return {motor.name: [(motor.x, motor.z)] for motor in stage.motors}
    arm, corners = ARM * stage.motor().pole_pitch, dict[str, list[tuple[float, float]]]()
    for axis in stage.horizontal:
        motors = stage.motors_of(axis.name)
        count = int(stage.sharing) * len(motors)
        alone = count == 1 and len(stage.horizontal) == 1
        spread = [0.0] if alone else [arm * (1.0 - 2.0 * k / max(1, count - 1)) for k in range(count)]
        for k, motor in enumerate(motors):
            corners[motor.name] = [(0.0, at) if axis is stage.horizontal[0] else (at, 0.0)
                                   for at in spread[k::len(motors)]]
    return corners


def gap_table(motor: MotorGeometry, ratios: Sequence[float] = (1.0, 1.0, 1.0, 1.0)) -> dict[str, Any]:
    """Shape functions f1 to f4 over the air gap (m), times the ratios of a motor's constants."""
    first = motor.field.lower
    step = (motor.field.upper - first) / (GAPS - 1)
    return {"first": first, "step": step, "values": [
        [float(f"{ratio * f:.6g}") for ratio, f in zip(ratios, gap_functions(motor, first + k * step), strict=True)]
        for k in range(GAPS)]}
