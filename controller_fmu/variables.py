"""Variables that controllers share, part by part."""

from maglev.fmi.definition import Variable, flag, parameter, real_input, real_output, switch
from pmlsm.stage_description import StageAxis, StageConstant, StageDescription

ANY_GAIN = 1e15

TRIP = "assumed: the thesis has a trip (section 4.3) and prints no threshold"

SETPOINT_WITHOUT_EQUILIBRIUM = ("setpoint = {setpoint} m, expected an air gap at which the model with these constants "
                                "has an equilibrium that a direct current controls")

REFUSED_STEP = ("communication step = {step} s, expected one that divides the controller's "
                "sample_time = {sample_time} s into a whole number of steps and does not step over a sample")


def axis_inputs(stage: StageDescription, axis: StageAxis) -> tuple[Variable, ...]:
    """Inputs of one controlled axis."""
    return (real_input(f"{axis.name}.reference", axis.unit("m"), f"reference of the {axis.meaning}", 10.0, 0.01),
            real_input(f"{axis.name}.reference_rate", axis.unit("m/s"), f"rate of the {axis.meaning} reference",
                       1000.0, 0.1),
            *(() if by_gaps(stage, axis.name) else (measured_axis(axis),)))


def measured_axis(axis: StageAxis) -> Variable:
    """Measurement of one axis."""
    return real_input(f"{axis.name}.measured", "m", f"measured {axis.meaning}", 10.0, 0.01)


def by_gaps(stage: StageDescription, axis: str) -> bool:
    """Return True if an axis is measured by the gaps at the motors."""
    return bool(stage.rotations) and axis not in [horizontal.name for horizontal in stage.horizontal]


def gap_names(stage: StageDescription) -> tuple[str, ...]:
    """Names of the gaps at the motors, where they are measured."""
    return tuple(f"{motor}.gap_measured" for motor in stage.motor_names) if stage.rotations else ()


def gap_inputs(stage: StageDescription) -> tuple[Variable, ...]:
    """Gaps at the motors, where they are measured."""
    return tuple(real_input(name, "m", "measured air gap at the motor", 10.0, 0.01) for name in gap_names(stage))


def measurements(stage: StageDescription, axis: str) -> tuple[str, ...]:
    """Names of the inputs that measure an axis."""
    return gap_names(stage) if by_gaps(stage, axis) else (f"{axis}.measured",)


def place_parameters(stage: StageDescription) -> tuple[Variable, ...]:
    """Places of the motors on a platform that tilts."""
    first, *others = (axis.name for axis in stage.horizontal)
    directions = {"x": first, "z": next(iter(others), f"the platform across {first}")}
    return tuple(parameter(f"{motor}.{spot}", "m",
                           f"position of the motor along {directions[spot]}, from the centre of mass",
                           stage.source(f"motors.{motor}.{spot}"), -10.0, 10.0, 0.1, fixed=True)
                 for motor in stage.motor_names for spot in stage.spots if stage.rotations)


def height(stage: StageDescription) -> Variable:
    """Lever of the thrusts."""
    return parameter("height", "m", "distance of the magnets' faces below the centre of mass",
                     stage.source("height"), -1.0, 1.0, 0.1)


def platform_parameters(stage: StageDescription) -> tuple[Variable, ...]:
    """The controllers' model of a platform that tilts."""
    if not stage.rotations:
        return ()
    axes = (stage.vertical, *stage.horizontal, *stage.rotations)
    inertias = [parameter(f"{axis.name}.inertia", "kg.m2", f"moment of inertia of the {axis.meaning} in the model",
                          stage.source(f"axes.{axis.name}.mass"), 1e-3, 1e6, 1.0) if axis.rotation else
                parameter(f"{axis.name}.mass", "kg", f"mass that moves along {axis.name} in the controller's model, "
                          "for which its motor constants hold", stage.source(f"axes.{axis.name}.mass"), 1e-3, 1e6,
                          1.0)
                for axis in axes]
    return (*inertias, height(stage), *place_parameters(stage))


def bad_places(stage: StageDescription) -> str:
    """Refusal of motors that cannot make every force and torque."""
    places = ", ".join(f"{motor}.{along} = {{{motor}.{along}}} m"
                       for motor in stage.motor_names for along in stage.spots)
    line = "one line" if stage.spots == "xz" else f"one line along {stage.horizontal[0].name}"
    return f"{places}, expected motors that are not all on {line}"


def commutation_variables(stage: StageDescription) -> tuple[Variable, ...]:
    """Variables of a commutation without a law, whose current references are inputs."""
    references = [real_input(f"{motor}.i_{current}_reference", "A", f"reference of the {text} current", 1000.0, 1.0)
                  for motor in stage.motor_names for current, text in (("d", "direct"), ("q", "quadrature"))]
    return (*(measured_axis(axis) for axis in stage.horizontal),
            *gap_inputs(stage),
            *references,
            *(v for motor in stage.motors
              for v in motor_outputs(motor.name, (f"{motor.name}.i_d_reference",), (f"{motor.name}.i_q_reference",),
                                     (f"{motor.drives}.measured", *gap_names(stage)))),
            flag("saturated", "true while a reference exceeds current_limit", tuple(v.name for v in references)),
            *sampling_and_limit(stage.source("sample_time"), "assumed: none, the amplifiers have their own"),
            *((height(stage), *place_parameters(stage)) if stage.rotations else ()))


def input_names(stage: StageDescription, *axes: str) -> tuple[str, ...]:
    """Names of the inputs of axes."""
    return tuple(dict.fromkeys(name for axis in axes for name in (f"{axis}.reference", f"{axis}.reference_rate",
                                                                  *measurements(stage, axis))))


def motor_outputs(motor: str, d_from: tuple[str, ...], q_from: tuple[str, ...], displacement: tuple[str, ...]
                  ) -> tuple[Variable, ...]:
    """Commands to one motor; the names say which inputs decide i_d, i_q and the commutation."""
    both = tuple(dict.fromkeys((*d_from, *q_from, *displacement)))
    phases = tuple(real_output(f"{motor}.i_{phase}_cmd", "A", f"commanded current of phase {phase}", 1.0, discrete=True,
                               depends_on=both) for phase in ("a", "b", "c"))
    return (*phases,
            real_output(f"{motor}.i_d_cmd", "A", "commanded direct current, after the limit", 1.0,
                        discrete=True, depends_on=d_from),
            real_output(f"{motor}.i_q_cmd", "A", "commanded quadrature current, after the limit", 1.0,
                        discrete=True, depends_on=q_from))


def flags(inputs: tuple[str, ...]) -> tuple[Variable, ...]:
    """Boolean outputs of a controller with the given inputs."""
    return (flag("saturated", "true while a command is at its limit", inputs),
            flag("feasible", "true if some current gives the demanded acceleration", inputs),
            flag("tripped", "true once the safety trip has shut the controller down", inputs))


def regulator_gains(stage: StageDescription, of: StageAxis) -> tuple[Variable, ...]:
    """Gains of the output regulator of one axis; of a tilt, the command that serves it is a slope of the current."""
    axis = of.name
    source = stage.source(f"axes.{axis}.design.gains")
    antiwindup_source = stage.source(f"axes.{axis}.design.antiwindup_gain")
    gains = (("k1", "1/s2", "error"), ("k2", "1/s", "rate of the error"), ("k3", "1/s5", "first internal-model state"),
             ("k4", "1/s4", "second internal-model state"), ("k5", "1/s3", "third internal-model state"))
    corrected = "rad.m" if of.rotation else "m"
    corrections = (("ec1", f"{corrected}.s2/A"), ("ec2", f"{corrected}.s/A"), ("ec3", f"{corrected}/A"))
    return (*(parameter(f"{axis}.{name}", unit, f"gain of the {what} in (4.16)", source, -ANY_GAIN, ANY_GAIN, 1e3)
              for name, unit, what in gains),
            *(parameter(f"{axis}.{name}", unit, f"anti-windup gain on internal-model state {name[-1]} (5.13)",
                        antiwindup_source, -1e3, 1e3, 1e-4) for name, unit in corrections),
            parameter(f"{axis}.friction_compensation", of.unit("m/s2"), "acceleration added in the direction of "
                      "motion to compensate Coulomb friction; 0 = off", "assumed: off; tried on p. 59", 0.0, 100.0,
                      1.0))


def ports(stage: StageDescription, by_all: bool = False, by_gap: bool = False) -> tuple[Variable, ...]:
    """Inputs and outputs of a controller.

    Parameters
    ----------
    stage : Stage
    by_all : bool
        True if i_d depends on the inputs of all axes, not only on those of the vertical one and the tilts.
    by_gap : bool
        True if the quadrature currents depend on the measured gap too.
    """
    vertical = stage.vertical.name
    d_from = input_names(stage, *(stage.axis_names if by_all else (vertical, *(axis.name for axis in stage.rotations))))
    gap = measurements(stage, vertical) if by_gap else ()
    return (*(v for axis in stage.axes for v in axis_inputs(stage, axis)),
            *gap_inputs(stage),
            *(v for motor in stage.motors
              for v in motor_outputs(motor.name, d_from, (*input_names(stage, motor.drives), *gap),
                                     (f"{motor.drives}.measured", *gap_names(stage)))),
            *(real_output(f"{axis.name}.error", axis.unit("m"), "tracking error, measured minus reference", 1e-3,
                          discrete=True, depends_on=(f"{axis.name}.reference", *measurements(stage, axis.name)))
              for axis in stage.axes),
            *flags(input_names(stage, *stage.axis_names)))


def model_constants(stage: StageDescription) -> tuple[Variable, ...]:
    """Constants of the controllers' model of a stage."""
    return tuple(model_constant(entry, stage.source("model")) for entry in stage.constants)


def model_constant(of: StageConstant, source: str) -> Variable:
    """Constant of the controller's motor model; it divides, so that 0 is no value."""
    return parameter(of.name, of.unit, f"constant of the {of.meaning} in the controller's model", source, 1e-9, 1e6,
                     1.0)


def loop_parameters(stage: StageDescription, limit_source: str) -> tuple[Variable, ...]:
    """Parameters that every controller with a law has."""
    return (*sampling_and_limit(stage.source("sample_time"), limit_source),
            *observer_times(),
            parameter("trip_error", "m", "tracking error above which the controller trips; 0 = never",
                      TRIP, 0.0, 1.0, 1e-3),
            *((parameter("trip_tilt", "rad", "tilt error above which the controller trips; 0 = never", TRIP, 0.0, 1.0,
                         1e-3),) if stage.rotations else ()))


def sampling_and_limit(sample_time_source: str, limit_source: str) -> tuple[Variable, ...]:
    """Parameters of the sampling and of the limit of commanded currents."""
    return (sample_time(sample_time_source),
            parameter("current_limit", "A", "limit of the commanded i_d and i_q; 0 = no limit", limit_source,
                      0.0, 1000.0, 1.0))


def sample_time(source: str) -> Variable:
    """Interval of the samples."""
    return parameter("sample_time", "s", "sample time; the communication step must divide it", source, 1e-6, 1.0, 1e-3,
                     fixed=True)


def observer_times() -> tuple[Variable, ...]:
    """Time constants of the observer of velocities."""
    return tuple(parameter(f"observer.{name}", "s", f"time constant of the observer's {part} (Fig. 4.7)", "assumed",
                           0.0, 1.0, 1e-3, fixed=True)
                 for name, part in (("time1", "derivative"), ("time2", "low-pass filter")))


def internal_model_parameters(antiwindup_source: str) -> tuple[Variable, ...]:
    """Parameters of the internal models of an output regulator."""
    return (parameter("omega0", "rad/s", "frequency of the sinusoids that the regulator can track",
                      "corrected: 1.5 pi for every experiment, which gives the printed gains the printed poles",
                      0.0, 1e3, 1.0, fixed=True),
            switch("antiwindup", "true to correct the internal models while a command is limited", antiwindup_source))


def integral_hold() -> Variable:
    """Antiwindup of a PID."""
    return switch("antiwindup", "true to stop the integral of an axis while its command is limited",
                  "assumed: the thesis has no anti-windup for the PID")


def setpoint(stage: StageDescription, use: str, source: str) -> Variable:
    """Air gap about which a controller takes the motor as linear."""
    field = stage.motor().field
    return parameter("setpoint", "m", f"air gap at which {use}", source, field.lower, field.upper, 0.01, fixed=True)


def bumpless_start() -> Variable:
    """Return the switch of the start of a linear regulator."""
    return switch("bumpless", "true to start with the current that holds the mover at its initial position; false to "
                  "start with the current that holds it at setpoint, and with no integral of the error",
                  "assumed: the thesis does not say how its runs start", fixed=True)


def pid_parameters(of: StageAxis) -> tuple[Variable, ...]:
    """Gains, design poles and pre-filter of the PID of one axis; that of a tilt commands a slope of the current."""
    axis = of.name
    units = ("A/(m.rad)", "A/(m.rad.s)", "A.s/(m.rad)") if of.rotation else ("A/m", "A/(m.s)", "A.s/m")
    gains = zip(("kp", "ki", "kd"), units, ("error", "integral of the error", "rate of the error"), strict=True)
    poles = (("pole", "real pole", -1e4, -1e-3), ("pair_real", "real part of the pair of poles", -1e4, -1e-3),
             ("pair_imaginary", "imaginary part of the pair of poles", 0.0, 1e4))
    return (*(parameter(f"{axis}.{name}", unit, f"gain of the {what}; designed from the poles at the initialization "
                        "unless a gain is set", "assumed: by pole placement, the thesis prints no gains",
                        -ANY_GAIN, ANY_GAIN, 1e3) for name, unit, what in gains),
            *(parameter(f"{axis}.{name}", "rad/s", f"{meaning} of the gain design", "assumed", low, high, 10.0,
                        fixed=True) for name, meaning, low, high in poles),
            parameter(f"{axis}.prefilter", "rad/s", "corner frequency of the reference pre-filter; 0 = off",
                      "assumed: off for steps and tracking", 0.0, 1e4, 10.0, fixed=True))
