"""Variables that every stage has, part by part."""

from fmi_export.definition import Variable, flag, parameter, real_input, real_output, switch
from pmlsm.rigs import Rig, RigAxis, RigConstant


def motor_variables(motor: str) -> tuple[tuple[Variable, ...], tuple[Variable, ...], tuple[Variable, ...]]:
    """Inputs, outputs and parameters of one motor's supply."""
    phases = ("a", "b", "c")
    inputs = tuple(real_input(f"{motor}.i_{phase}_cmd", "A", f"commanded current of phase {phase}", 1000.0, 1.0)
                   for phase in phases)
    outputs = (*(real_output(f"{motor}.i_{phase}", "A", f"delivered current of phase {phase}", 1.0)
                 for phase in phases),
               real_output(f"{motor}.i_d", "A", "delivered direct current", 1.0),
               real_output(f"{motor}.i_q", "A", "delivered quadrature current", 1.0),
               flag(f"{motor}.saturated", "a phase of the motor is at its amplifier's clamp"))
    rating = f"{motor}.amplifier"
    parameters = (
        parameter(f"{rating}.peak", "A", "peak current of each phase; 0 = no clamp at all",
                  "stated, sections 4.1.3 and 5.1.3", 0.0, 1000.0, 1.0),
        parameter(f"{rating}.continuous", "A", "continuous current of each phase; 0 = no continuous limit",
                  "stated, sections 4.1.3 and 5.1.3", 0.0, 1000.0, 1.0),
        parameter(f"{rating}.thermal_time", "s", "time constant of the continuous limit; 0 = no continuous limit",
                  "assumed", 0.0, 1000.0, 1.0, fixed=True),
        parameter(f"{rating}.lag", "s", "first-order lag after the clamp; 0 = none",
                  "assumed", 0.0, 1.0, 1e-3, fixed=True))
    return inputs, outputs, parameters


def axis_variables(of: RigAxis) -> tuple[tuple[Variable, ...], tuple[Variable, ...], tuple[Variable, ...]]:
    """Inputs, outputs and parameters of one axis."""
    axis, meaning = of.name, of.meaning
    start = f"{axis}.position_start"
    inputs = (real_input(f"{axis}.force", "N", f"external force along {axis}", 1e5, 1.0),)
    outputs = (
        real_output(f"{axis}.encoder", "m", f"measured {meaning}", 0.01, discrete=True,
                    starts_from=(start, "encoder.resolution")),
        real_output(f"{axis}.position", "m", f"true {meaning}", 0.01, starts_from=(start,)),
        real_output(f"{axis}.velocity", "m/s", f"rate of the {meaning}", 0.1))
    parameters = (
        parameter(f"{axis}.mass", "kg", f"mass that moves along {axis}; the constants are accelerations at "
                  f"{of.mass:g} kg", "stated, Table 4.1 or 5.1", 1e-3, 1e6, 1.0),
        parameter(f"{axis}.bias", "m/s2", "constant acceleration, such as by misaligned bearings", "assumed",
                  -1e3, 1e3, 0.1),
        parameter(f"{axis}.friction.coulomb", "N", "sliding friction of the guide; 0 = none", "assumed", 0.0, 1e4, 1.0),
        parameter(f"{axis}.friction.presliding", "m", "displacement over which friction builds up; 0 = no friction",
                  "assumed", 0.0, 1.0, 1e-3),
        parameter(f"{axis}.friction.viscous", "N.s/m", "viscous friction of the guide", "assumed", 0.0, 1e5, 1.0),
        parameter(f"{axis}.ripple.amplitude", "m/s2", f"amplitude of the ripple, of the guide or by the slots, at the "
                  f"nominal {axis}.mass; 0 = none", "assumed", 0.0, 1e3, 0.1),
        parameter(f"{axis}.ripple.period", "m", "period of the ripple; 0 = no ripple",
                  "assumed for the guide; the slot pitch is stated, Tables 4.1 and 5.1", 0.0, 1.0, 1e-3),
        parameter(f"{axis}.stop.lower", "m", "place of the lower end stop", "assumed", -10.0, 10.0, 0.01, fixed=True),
        parameter(f"{axis}.stop.upper", "m", "place of the upper end stop", "assumed", -10.0, 10.0, 0.01, fixed=True),
        parameter(f"{axis}.stop.stiffness", "N/m", "stiffness of the end stops", "assumed", 0.0, 1e8, 1e5),
        parameter(f"{axis}.stop.damping", "N.s/m", "damping of the end stops", "assumed", 0.0, 1e6, 1e3),
        parameter(start, "m", f"initial {meaning}, at rest", "mid-range", -10.0, 10.0, 0.01, fixed=True),
        switch(f"{axis}.locked", f"whether brackets hold the {meaning} at its start", "off; stated, section 5.1.2",
               fixed=True))
    return inputs, outputs, parameters


AT_STOP = flag("at_stop", "an axis was beyond an end stop during the step")

MODULATION = parameter("attraction_modulation", "", "modulation of the attraction along the slots; 0 = none",
                       "assumed", 0.0, 1.0, 0.01)

ENCODER_RESOLUTION = parameter("encoder.resolution", "m", "resolution of the encoders; 0 = they measure exactly",
                               "stated, sections 4.1.2 and 5.1.2", 0.0, 1.0, 1e-5)


def constant(of: RigConstant, source: str) -> Variable:
    """Constant of the motion's equations; positive, so that every motor keeps its sign."""
    return parameter(of.name, of.unit, f"constant of the {of.meaning}, at the nominal {of.axis}.mass", source, 0.0, 1e6,
                     1.0)


def stage_variables(rig: Rig) -> tuple[Variable, ...]:
    """Variables of a stage: inputs, outputs, then parameters."""
    parts = [motor_variables(motor) for motor in rig.motor_names] + [axis_variables(axis) for axis in rig.axes]
    inputs = [v for part in parts for v in part[0]]
    outputs = [v for part in parts for v in part[1]]
    parameters = [v for part in parts for v in part[2]]
    constants = [constant(each, f"{rig.stage_source}; assumed to be the true stage") for each in rig.constants]
    return (*inputs, *outputs, AT_STOP, *constants, MODULATION, ENCODER_RESOLUTION, *parameters)


def stage_refusals(rig: Rig, beyond_stop: tuple[int, ...], run_away: int, step_too_long: int) -> dict[int, str]:
    """Messages of a stage by its status; `beyond_stop` has a status for each axis."""
    places = ", ".join(f"{axis}.position = {{{axis}.position}} m" for axis in rig.axis_names)
    every = "both" if len(rig.axes) == 2 else "all"
    return {
        **{status: f"{axis}.position_start = {{{axis}.position_start}} m, expected a place between the stops "
                   f"{axis}.stop.lower = {{{axis}.stop.lower}} m and {axis}.stop.upper = {{{axis}.stop.upper}} m"
           for status, axis in zip(beyond_stop, rig.axis_names, strict=True)},
        run_away: f"the mover has run away in the step from {{time}} s: {places}, "
                  f"expected {every} within 1000 m and slower than 1e6 m/s",
        step_too_long: "communication step = {step} s, expected at most 1000 s"}
