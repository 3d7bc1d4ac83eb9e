"""Variables that controllers share, part by part."""

from fmi_export.definition import Variable, flag, parameter, real_input, real_output, switch
from pmlsm.rigs import Rig, RigAxis, RigConstant

ANY_GAIN = 1e15

SETPOINT_WITHOUT_EQUILIBRIUM = ("setpoint = {setpoint} m, expected an air gap at which the model with these constants "
                                "has an equilibrium that a direct current controls")

REFUSED_STEP = ("communication step = {step} s, expected one that divides the controller's "
                "sample_time = {sample_time} s into a whole number of steps and does not step over a sample")


def axis_inputs(axis: RigAxis) -> tuple[Variable, ...]:
    """Inputs of one controlled axis."""
    return (real_input(f"{axis.name}.reference", "m", f"reference of the {axis.meaning}", 10.0, 0.01),
            real_input(f"{axis.name}.reference_rate", "m/s", f"rate of the reference of the {axis.meaning}", 1000.0,
                       0.1),
            measured_axis(axis))


def measured_axis(axis: RigAxis) -> Variable:
    """Measurement of one axis."""
    return real_input(f"{axis.name}.measured", "m", f"measured {axis.meaning}", 10.0, 0.01)


def commutation_variables(rig: Rig) -> tuple[Variable, ...]:
    """Variables of a commutation without a law, whose current references are inputs."""
    references = [v for motor in rig.motor_names for v in current_references(motor)]
    return (*(measured_axis(axis) for axis in rig.horizontal),
            *references,
            *(v for motor in rig.motors
              for v in motor_outputs(motor.name, (f"{motor.name}.i_d_reference",), (f"{motor.name}.i_q_reference",),
                                     f"{motor.drives}.measured")),
            flag("saturated", "a reference is beyond current_limit", tuple(v.name for v in references)),
            *sampling_and_limit(rig.sample_time_source, "assumed: none, the amplifiers have their own"))


def current_references(motor: str) -> tuple[Variable, ...]:
    """Currents that a motor is to be commanded."""
    return (real_input(f"{motor}.i_d_reference", "A", "direct current that is asked for", 1000.0, 1.0),
            real_input(f"{motor}.i_q_reference", "A", "quadrature current that is asked for", 1000.0, 1.0))


def input_names(*axes: str) -> tuple[str, ...]:
    """Names of the inputs of axes."""
    return tuple(f"{axis}.{name}" for axis in axes for name in ("reference", "reference_rate", "measured"))


def axis_error(axis: str) -> Variable:
    """Tracking error of one axis."""
    return real_output(f"{axis}.error", "m", "tracking error, measured minus reference", 1e-3, discrete=True,
                       depends_on=(f"{axis}.reference", f"{axis}.measured"))


def motor_outputs(motor: str, d_from: tuple[str, ...], q_from: tuple[str, ...], displacement: str
                  ) -> tuple[Variable, ...]:
    """Commands to one motor; the names say which inputs decide i_d, i_q and the commutation."""
    both = tuple(dict.fromkeys((*d_from, *q_from, displacement)))
    phases = tuple(real_output(f"{motor}.i_{phase}_cmd", "A", f"command to phase {phase}", 1.0, discrete=True,
                               depends_on=both) for phase in ("a", "b", "c"))
    return (*phases,
            real_output(f"{motor}.i_d_cmd", "A", "direct current that is commanded, after the limit", 1.0,
                        discrete=True, depends_on=d_from),
            real_output(f"{motor}.i_q_cmd", "A", "quadrature current that is commanded, after the limit", 1.0,
                        discrete=True, depends_on=q_from))


def flags(inputs: tuple[str, ...]) -> tuple[Variable, ...]:
    """Boolean outputs of a controller with the given inputs."""
    return (flag("saturated", "a command is at its limit", inputs),
            flag("feasible", "the demanded acceleration can be made by some current", inputs),
            flag("tripped", "the safety trip has shut the controller down", inputs))


def regulator_gains(axis: str, source: str, antiwindup_source: str) -> tuple[Variable, ...]:
    """Gains of the output regulator of one axis."""
    gains = (("k1", "1/s2", "error"), ("k2", "1/s", "rate of the error"), ("k3", "1/s5", "internal-model state 1"),
             ("k4", "1/s4", "internal-model state 2"), ("k5", "1/s3", "internal-model state 3"))
    corrections = (("ec1", "m.s2/A"), ("ec2", "m.s/A"), ("ec3", "m/A"))
    return (*(parameter(f"{axis}.{name}", unit, f"gain of the {of} in (4.16)", source, -ANY_GAIN, ANY_GAIN, 1e3)
              for name, unit, of in gains),
            *(parameter(f"{axis}.{name}", unit, f"antiwindup gain on internal-model state {name[-1]} (5.13)",
                        antiwindup_source, -1e3, 1e3, 1e-4) for name, unit in corrections),
            parameter(f"{axis}.friction_compensation", "m/s2", "acceleration that is demanded in the direction of "
                      "motion against Coulomb friction; 0 = off", "assumed: off; tried on p. 59", 0.0, 100.0, 1.0))


def ports(rig: Rig, by_all: bool = False, by_gap: bool = False) -> tuple[Variable, ...]:
    """Inputs and outputs of a controller.

    Parameters
    ----------
    rig : Rig
    by_all : bool
        Whether i_d follows from the inputs of all axes, not of the vertical one alone.
    by_gap : bool
        Whether the quadrature currents follow from the measured gap too.
    """
    d_from = input_names(*rig.axis_names) if by_all else input_names(rig.vertical.name)
    gap = (f"{rig.vertical.name}.measured",) if by_gap else ()
    return (*(v for axis in rig.axes for v in axis_inputs(axis)),
            *(v for motor in rig.motors for v in motor_outputs(motor.name, d_from, (*input_names(motor.drives), *gap),
                                                               f"{motor.drives}.measured")),
            *(axis_error(axis) for axis in rig.axis_names),
            *flags(input_names(*rig.axis_names)))


def model_constants(rig: Rig) -> tuple[Variable, ...]:
    """Constants of the controllers' model of a stage."""
    return tuple(constant(each, rig.model_source) for each in rig.constants)


def constant(of: RigConstant, source: str) -> Variable:
    """Constant of the controller's motor model; it divides, so that 0 is no value."""
    return parameter(of.name, of.unit, f"constant of the {of.meaning} in the controller's model", source, 1e-9, 1e6,
                     1.0)


def loop_parameters(rig: Rig, limit_source: str) -> tuple[Variable, ...]:
    """Parameters that every controller with a law has."""
    return (*sampling_and_limit(rig.sample_time_source, limit_source),
            parameter("observer.time1", "s", "time constant of the observer's derivative (Fig. 4.7)", "assumed",
                      0.0, 1.0, 1e-3, fixed=True),
            parameter("observer.time2", "s", "time constant of the observer's low-pass filter (Fig. 4.7)", "assumed",
                      0.0, 1.0, 1e-3, fixed=True),
            parameter("trip_error", "m", "tracking error that trips the controller; 0 = never",
                      "assumed: the thesis has a trip (section 4.3) and prints no threshold", 0.0, 1.0, 1e-3))


def sampling_and_limit(sample_time_source: str, limit_source: str) -> tuple[Variable, ...]:
    """Parameters of what samples and commands currents."""
    return (parameter("sample_time", "s", "sample time; the communication step must divide it", sample_time_source,
                      1e-6, 1.0, 1e-3, fixed=True),
            parameter("current_limit", "A", "limit on i_d and i_q commands; 0 = none", limit_source,
                      0.0, 1000.0, 1.0))


def internal_model_parameters(antiwindup_source: str) -> tuple[Variable, ...]:
    """Parameters of the internal models of an output regulator."""
    return (parameter("omega0", "rad/s", "frequency of the sinusoids that are tracked",
                      "corrected: 1.5 pi for every experiment, by which the printed gains have the printed poles",
                      0.0, 1e3, 1.0, fixed=True),
            switch("antiwindup", "correct the internal models while a command is limited", antiwindup_source))


def integral_hold() -> Variable:
    """Antiwindup of a PID."""
    return switch("antiwindup", "hold an axis's integral while its command is limited",
                  "assumed: the thesis uses none with the PID")


def setpoint(use: str, source: str) -> Variable:
    """Air gap about which a controller takes the motor as linear."""
    return parameter("setpoint", "m", f"air gap about which {use}", source, 8e-3, 40e-3, 0.01, fixed=True)


def bumpless_start() -> Variable:
    """How a linear regulator starts."""
    return switch("bumpless", "start with the current that holds the mover where it is; if false, with the one that "
                  "holds it at setpoint, fed forward, and no integral of an error",
                  "assumed: the thesis does not say how its runs start", fixed=True)


def pid_parameters(axis: str) -> tuple[Variable, ...]:
    """Gains, design poles and pre-filter of the PID of one axis."""
    gains = (("kp", "A/m", "error"), ("ki", "A/(m.s)", "integral of the error"), ("kd", "A.s/m", "rate of the error"))
    poles = (("pole", "real pole", -1e4, -1e-3), ("pair_real", "real part of the pair of poles", -1e4, -1e-3),
             ("pair_imaginary", "imaginary part of the pair of poles", 0.0, 1e4))
    return (*(parameter(f"{axis}.{name}", unit, f"gain of the {of}; while the three gains are as they start, they are "
                        "designed at the initialization", "assumed: by pole placement, the thesis prints none",
                        -ANY_GAIN, ANY_GAIN, 1e3) for name, unit, of in gains),
            *(parameter(f"{axis}.{name}", "rad/s", f"{meaning} of the design", "assumed", low, high, 10.0, fixed=True)
              for name, meaning, low, high in poles),
            parameter(f"{axis}.prefilter", "rad/s", "corner frequency of the reference pre-filter; 0 = off",
                      "assumed: off for steps and tracking", 0.0, 1e4, 10.0, fixed=True))
