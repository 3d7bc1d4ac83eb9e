"""Variables of an adaptive regulator, composed from those of its parts."""

from dataclasses import replace

from controller_fmu.estimator_variables import estimated
from controller_fmu.places import axis_number, constant_place
from maglev.fmi.definition import FmuDefinition, Variable, flag, parameter, real_output, switch
from pmlsm.stage_description import IRON, StageAxis, StageConstant, StageDescription, Stop

ASSUMED = "assumed"
ESTIMATOR = "estimator."   # part of the block


def adaptive_variables(stage: StageDescription, regulator: FmuDefinition, estimator: FmuDefinition) -> tuple[Variable,
                                                                                                             ...]:
    """Variables of the regulator, whose constants are only first values, of the estimator and of the adaptation.

    Both parts have one motor, one sample time and one observer; the estimator's inputs are within the block.
    """
    own = {constant.name for constant in stage.constants}
    inputs = tuple(v.name for v in regulator.variables if v.causality == "input")
    shared = {v.name for v in regulator.variables}
    held = {"held", *(f"{constant.name}_weight" for constant in stage.constants if constant.unit == IRON)}
    starts = {f"{constant.name}_start" for constant in stage.constants}
    kept = [replace(v, path=f"regulator.{v.place}") for v in regulator.variables if v.name not in own]
    settings = [replace(v, path=f"estimator.{v.place}") for v in estimator.variables
                if v.causality == "parameter" and v.name not in shared | held | starts]
    return (*(v for v in kept if v.causality != "parameter"),
            *(v for constant in stage.constants for v in outcome(stage, constant, inputs)),
            flag("adaptation.frozen", "true while the constants do not change: during and after a limit or a stop, "
                                      "after a trip, or if adaptation.active is false", inputs),
            *(estimated(stage, constant, parameter(constant.name, constant.unit,
                                         f"constant of the {constant.meaning} in the controller's model, "
                                         f"{'not adapted' if constant.unit == IRON else 'before adaptation'}",
                                         stage.source("model"), 1e-9, 1e6, 1.0, fixed=True), "guess", ESTIMATOR)
              for constant in stage.constants),
            *adaptation_parameters(),
            *(v for axis in stage.axes if axis.stop is not None
              for v in travel(axis.name, axis.stop, travel_place(stage, axis))),
            *(travel("gap", stage.motor_stop, "gap_travel")
              if stage.motor_stop is not None and stage.rotations else ()),
            *settings,
            *(v for v in kept if v.causality == "parameter"))


def outcome(stage: StageDescription, of: StageConstant, inputs: tuple[str, ...]) -> tuple[Variable, ...]:
    """Return the variables of a constant: its present value and its estimate; none for a constant that is not adapted.
    """
    if of.unit == IRON:
        return ()
    name = of.name
    return (replace(real_output(f"adapted.{name}", of.unit, f"constant of the {of.meaning} that the regulator uses",
                                1.0, discrete=True, depends_on=inputs, starts_from=(name,)),
                    path=f"regulator.{constant_place(stage, name)}"),
            estimated(stage, of,
                      real_output(f"estimated.{name}", of.unit, f"estimated constant of the {of.meaning}", 1.0,
                                   discrete=True, depends_on=inputs, starts_from=(name,)), "value", ESTIMATOR),
            estimated(stage, of, flag(f"{name}_converged", f"true if data determine {name} and its estimate has stayed "
                            "within convergence.tolerance for convergence.time", inputs), "converged", ESTIMATOR))


def adaptation_parameters() -> tuple[Variable, ...]:
    """When and how the constants follow their estimates."""
    return (switch("adaptation.active", "true to let the constants follow their estimates", ASSUMED),
            parameter("adaptation.range", "", "largest relative change of a constant from its start value", ASSUMED,
                      0.0, 0.99, 0.1),
            parameter("adaptation.time", "s", "time constant with which the constants follow their estimates", ASSUMED,
                      1e-3, 1e6, 1.0),
            parameter("adaptation.pause", "s", "time for which the constants do not change after a limit or a stop",
                      ASSUMED, 0.0, 1e6, 1.0))


def travel(name: str, stop: Stop, place: str) -> tuple[Variable, ...]:
    """Return the parameters of the stops of an axis, or of the gap at each motor."""
    return tuple(replace(parameter(f"{name}.travel.{end}", "m", f"{end} stop of {name}, at which estimation pauses",
                                   ASSUMED, -10.0, 10.0, 1e-2), path=f"{place}.{end}")
                 for end in ("lower", "upper"))


def travel_place(stage: StageDescription, axis: StageAxis) -> str:
    """Path of where an axis meets its stops."""
    stopped = [axis_number(stage, each.name) for each in stage.axes if each.stop is not None]
    return f"travels[{sorted(stopped).index(axis_number(stage, axis.name))}]"
