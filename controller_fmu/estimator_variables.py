"""Variables that the estimators share, part by part."""

from collections.abc import Iterable
from dataclasses import replace

import controller_fmu.status as status
import controller_fmu.variables as control
from controller_fmu.places import axis_number, placed
from maglev.fmi.definition import Variable, flag, parameter, real_input, real_output, switch
from pmlsm.stage_description import ATTRACTION, COILS, IRON, THRUST, StageConstant, StageDescription
from pmlsm.variables import CONSTANTS, bad_geometry, motor_geometry

REFUSED_STEP = ("communication step = {step} s, expected one that divides the estimator's "
                "sample_time = {sample_time} s into a whole number of steps and does not step over a sample")


# Unit of the diagonal element of Σ for a constant, by its own.
WEIGHT = {THRUST: "A2.s", ATTRACTION: "T4.s", COILS: "A2.T2.s", IRON: "A4.s"}
# And where its row has it.
PLACE = {THRUST: "thrust", ATTRACTION: "attraction", COILS: "coils", IRON: "iron"}


def row_place(stage: StageDescription, axis: str) -> str:
    """Path of the row of an axis."""
    number = axis_number(stage, axis)
    return f"horizontal[{number - 1}]" if number else "vertical"


def estimated(stage: StageDescription, of: StageConstant, variable: Variable, part: str, above: str = "") -> Variable:
    """A variable of a constant, which lies in a part of its estimate."""
    return replace(variable, path=f"{above}{row_place(stage, of.axis)}.{PLACE[of.unit]}.{part}")


def in_rows(stage: StageDescription, variables: Iterable[Variable]) -> tuple[Variable, ...]:
    """Variables with their paths in an estimator, whose axes are rows; those of constants have theirs."""
    names = {axis.name: row_place(stage, axis.name) for axis in (stage.vertical, *stage.horizontal)}
    return tuple(replace(v, path=f"{names[owner]}.{v.name.partition('.')[2]}") if owner in names else
                 v if v.path and owner == v.name else placed(stage, (v,), "layout")[0]
                 for v in variables for owner in [v.name.partition(".")[0]])


def refusals(stage: StageDescription) -> dict[int, str]:
    """Refusals of an estimator, by the status of the block."""
    return {status.STEP_MISFIT: REFUSED_STEP, status.BAD_GEOMETRY: bad_geometry(stage),
            **({status.BAD_PLACES: control.bad_places(stage)} if stage.rotations else {})}


def estimator_variables(stage: StageDescription) -> tuple[Variable, ...]:
    """Variables of an estimator; the tilts have no row."""
    rows = (stage.vertical, *stage.horizontal)
    inputs = {axis.name: row_inputs(stage, axis.name) for axis in rows}
    return in_rows(stage, (
            *(control.measured_axis(axis) for axis in rows if not control.by_gaps(stage, axis.name)),
            *control.gap_inputs(stage),
            *(real_input(f"{motor}.i_{current}", "A", f"delivered {text} current", 1000.0, 1.0)
              for motor in stage.motor_names for current, text in (("d", "direct"), ("q", "quadrature"))),
            *(v for constant in stage.constants for v in estimate_variables(stage, constant, inputs[constant.axis])),
            *(v for axis in inputs for v in axis_outputs(axis, control.measurements(stage, axis), inputs[axis])),
            *(v for constant in stage.constants
              for v in guess(stage, constant, stage.source("estimator.guess"), stage.source("estimator.weight"))),
            *estimator_parameters(stage.source("sample_time")),
            *control.place_parameters(stage),
            *motor_geometry(stage, *CONSTANTS)))


def row_inputs(stage: StageDescription, axis: str) -> tuple[str, ...]:
    """Inputs that the row of an axis takes in."""
    gap = control.measurements(stage, stage.vertical.name)
    if axis == stage.vertical.name:
        return (*gap, *(f"{motor}.{current}" for motor in stage.motor_names for current in ("i_d", "i_q")))
    return (f"{axis}.measured", *gap, *(f"{motor.name}.i_q" for motor in stage.motors if motor.drives == axis))


def axis_outputs(axis: str, measured: tuple[str, ...], inputs: tuple[str, ...]) -> tuple[Variable, ...]:
    """Outputs of the estimator for one axis; `measured` are the inputs that measure it, `inputs` those of its row."""
    return (real_output(f"{axis}.velocity", "m/s", "observed velocity (Fig. 4.7)", 0.1, discrete=True,
                        depends_on=measured),
            real_output(f"{axis}.residual", "m/s2", "acceleration that the model with the estimates does not explain, "
                        "low-passed with time constant epsilon", 0.1, discrete=True, depends_on=inputs))


def estimate_variables(stage: StageDescription, of: StageConstant, inputs: tuple[str, ...]) -> tuple[Variable, ...]:
    """Estimate of a constant; `inputs` are those of its row."""
    name = of.name
    return (estimated(stage, of,
                      real_output(name, of.unit, f"estimated constant of the {of.meaning}", 1.0, discrete=True,
                                           depends_on=inputs, starts_from=(f"{name}_start",)), "value"),
            estimated(stage, of, flag(f"{name}_converged", f"true if data determine {name} and it has stayed within "
                                    "convergence.tolerance for convergence.time", inputs), "converged"))


def guess(stage: StageDescription, of: StageConstant, source: str, weight_source: str) -> tuple[Variable, ...]:
    """Start value of a constant and its weight."""
    name = of.name
    return (estimated(stage, of, parameter(f"{name}_start", of.unit, f"first guess of {name}", source, -1e6, 1e6, 1.0,
                                 fixed=True), "guess"),
            estimated(stage, of, parameter(f"{name}_weight", WEIGHT[of.unit], "diagonal element of Q0 = Σ(0) in (3.8) "
                                         f"for {name}: the larger, the more data it takes to change the first guess",
                                 weight_source, 1e-20, 1e20, of.weight, fixed=True), "weight"))


def estimator_parameters(sample_time_source: str) -> tuple[Variable, ...]:
    """Parameters that every estimator has."""
    stated = "stated, section 4.3.3"
    return (parameter("epsilon", "s", "ε of (3.8), confidence in the measured velocity: time constant with which the "
                      "model's velocity follows it", stated, 1e-5, 10.0, 0.01),
            parameter("gamma", "", "γ of (3.8), attenuation level: the smaller, the sooner new data outweigh old; "
                      "if it is 1, Σ does not grow", stated, 1.0, 1e3, 1.0),
            parameter("forgetting", "1/s", "rate at which Σ forgets; estimates follow a change with the rate "
                      "forgetting / (1 - 1/gamma²); 0 = off", "assumed: off, as in (3.8)", 0.0, 1e3, 0.1),
            switch("matched_filter", "true to filter the columns of A(y, u) as the observer filters the velocity",
                   "assumed: off, the thesis does not mention it"),
            switch("held", "true to keep estimates and Σ constant while the data are unreliable",
                   "assumed: the thesis does not mention it"),
            control.sample_time(sample_time_source),
            *control.observer_times(),
            parameter("convergence.tolerance", "", "relative band within which a converged estimate stays", "assumed",
                      0.0, 1.0, 0.01),
            parameter("convergence.time", "s", "time for which a converged estimate has stayed in its band", "assumed",
                      0.0, 1e6, 1.0))
