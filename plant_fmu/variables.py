"""Variables that every stage has, part by part."""

from fmi_export.definition import Variable, flag, parameter, real_input, real_output, switch


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


def axis_variables(axis: str, meaning: str) -> tuple[tuple[Variable, ...], tuple[Variable, ...], tuple[Variable, ...]]:
    """Inputs, outputs and parameters of one axis; `meaning` says what its position is."""
    start = f"{axis}.position_start"
    inputs = (real_input(f"{axis}.force", "N", f"external force along {axis}", 1e5, 1.0),)
    outputs = (
        real_output(f"{axis}.encoder", "m", f"measured {meaning}", 0.01, discrete=True,
                    starts_from=(start, "encoder.resolution")),
        real_output(f"{axis}.position", "m", f"true {meaning}", 0.01, starts_from=(start,)),
        real_output(f"{axis}.velocity", "m/s", f"rate of the {meaning}", 0.1))
    parameters = (
        parameter(f"{axis}.mass", "kg", f"mass that moves along {axis}", "stated, Table 4.1 or 5.1", 1e-3, 1e6, 1.0),
        parameter(f"{axis}.bias", "m/s2", "constant acceleration, such as by misaligned bearings", "assumed",
                  -1e3, 1e3, 0.1),
        parameter(f"{axis}.friction.coulomb", "N", "sliding friction of the guide; 0 = none", "assumed", 0.0, 1e4, 1.0),
        parameter(f"{axis}.friction.presliding", "m", "displacement over which friction builds up; 0 = no friction",
                  "assumed", 0.0, 1.0, 1e-3),
        parameter(f"{axis}.friction.viscous", "N.s/m", "viscous friction of the guide", "assumed", 0.0, 1e5, 1.0),
        parameter(f"{axis}.stop.lower", "m", "place of the lower end stop", "assumed", -10.0, 10.0, 0.01, fixed=True),
        parameter(f"{axis}.stop.upper", "m", "place of the upper end stop", "assumed", -10.0, 10.0, 0.01, fixed=True),
        parameter(f"{axis}.stop.stiffness", "N/m", "stiffness of the end stops", "assumed", 0.0, 1e8, 1e5),
        parameter(f"{axis}.stop.damping", "N.s/m", "damping of the end stops", "assumed", 0.0, 1e6, 1e3),
        parameter(start, "m", f"initial {meaning}, at rest", "mid-range", -10.0, 10.0, 0.01, fixed=True),
        switch(f"{axis}.locked", f"whether brackets hold the {meaning} at its start", "off; stated, section 5.1.2",
               fixed=True))
    return inputs, outputs, parameters


def ripple_parameters(axis: str) -> tuple[Variable, ...]:
    """Parameters of the guide ripple of an axis."""
    return (parameter(f"{axis}.ripple.amplitude", "m/s2", "amplitude of the guide's ripple; 0 = none", "assumed",
                      0.0, 1e3, 0.1),
            parameter(f"{axis}.ripple.period", "m", "period of the guide's ripple; 0 = no ripple", "assumed",
                      0.0, 1.0, 1e-3))


REFUSED_LENGTH = "communication step = {step} s, expected at most 1000 s"

AT_STOP = flag("at_stop", "an axis was beyond an end stop during the step")

MODULATION = parameter("attraction_modulation", "", "modulation of the attraction along the slots; 0 = none",
                       "assumed", 0.0, 1.0, 0.01)

ENCODER_RESOLUTION = parameter("encoder.resolution", "m", "resolution of the encoders; 0 = they measure exactly",
                               "stated, sections 4.1.2 and 5.1.2", 0.0, 1.0, 1e-5)


def constant(name: str, unit: str, meaning: str, source: str) -> Variable:
    """Constant of the motion's equations; positive, so that every motor keeps its sign."""
    return parameter(name, unit, f"constant of the {meaning}", source, 0.0, 1e6, 1.0)


def stage_variables(constants: tuple[Variable, ...], axes: tuple[tuple[str, str], ...], motors: tuple[str, ...],
                    extra: tuple[Variable, ...] = ()) -> tuple[Variable, ...]:
    """Variables of a stage: inputs, outputs, then parameters.

    Parameters
    ----------
    constants : tuple of Variable
        C1, C2, … of its equations.
    axes : tuple of (str, str)
        Name and meaning of each axis.
    motors : tuple of str
        Names of the motors.
    extra : tuple of Variable
        Parameters that only this stage has.
    """
    parts = [motor_variables(motor) for motor in motors] + [axis_variables(*axis) for axis in axes]
    inputs = [v for part in parts for v in part[0]]
    outputs = [v for part in parts for v in part[1]]
    parameters = [v for part in parts for v in part[2]]
    return (*inputs, *outputs, AT_STOP, *constants, MODULATION, ENCODER_RESOLUTION, *extra, *parameters)
