"""Variables that every stage has, part by part."""

from maglev.fmi.definition import Variable, flag, parameter, real_input, real_output, switch
from plant_fmu.places import placed
from plant_fmu.stage import NO_SEED, NO_SUCH_MOTOR, RUN_AWAY, STEP_TOO_LONG
from pmlsm.stage_description import StageAxis, StageConstant, StageDescription
from pmlsm.variables import CONSTANTS, bad_geometry, motor_geometry

NONE = "assumed: none"   # of payload and guides
NO_FAULT = "off"


def motor_variables(stage: StageDescription, motor: str) -> tuple[tuple[Variable, ...], tuple[Variable, ...],
                                                                  tuple[Variable, ...]]:
    """Inputs, outputs and parameters of one motor's supply."""
    source = stage.source(f"motors.{motor}.amplifier")
    phases = ("a", "b", "c")
    inputs = tuple(real_input(f"{motor}.i_{phase}_cmd", "A", f"commanded current of phase {phase}", 1000.0, 1.0)
                   for phase in phases)
    outputs = (*(real_output(f"{motor}.i_{phase}", "A", f"delivered current of phase {phase}", 1.0)
                 for phase in phases),
               real_output(f"{motor}.i_d", "A", "delivered direct current", 1.0),
               real_output(f"{motor}.i_q", "A", "delivered quadrature current", 1.0),
               real_output(f"{motor}.voltage", "V", "largest phase voltage; 0 if bus_voltage is 0", 10.0),
               real_output(f"{motor}.winding.rise", "K", "rise of the winding temperature since the start", 10.0),
               flag(f"{motor}.saturated", "true while a phase is limited by its amplifier's clamp or by bus_voltage"))
    rating, winding = f"{motor}.amplifier", f"{motor}.winding"
    parameters = (
        parameter(f"{rating}.peak", "A", "peak current of each phase; 1000 A, the largest command, never clamps",
                  source, 1e-3, 1000.0, 1.0, hint="1000 A never clamps"),
        parameter(f"{rating}.continuous", "A", "continuous current of each phase; 0 = no continuous limit",
                  source, 0.0, 1000.0, 1.0),
        parameter(f"{rating}.thermal_time", "s", "time constant of the continuous limit; 0 = no continuous limit",
                  "assumed", 0.0, 1000.0, 1.0, fixed=True),
        parameter(f"{rating}.lag", "s", "time constant of the first-order lag after the clamp; 0 = no lag",
                  "assumed", 0.0, 1.0, 1e-3, fixed=True),
        switch(f"{rating}.off", "fault: the amplifier takes every command as 0", NO_FAULT),
        switch(f"{rating}.stuck", "fault: the currents keep their present values", NO_FAULT),
        *(switch(f"{motor}.phase_{phase}.open", f"fault: phase {phase} carries no current", NO_FAULT)
          for phase in phases),
        parameter(f"{winding}.resistance", "Ohm", "resistance of a cold phase at its amplifier; used only if "
                  "bus_voltage > 0", stage.source(f"motors.{winding}"), 1e-3, 1e4, 1.0),
        parameter(f"{winding}.inductance", "H", "inductance of a phase at its amplifier; used only if "
                  "bus_voltage > 0", stage.source(f"motors.{winding}"), 1e-6, 10.0, 1e-2),
        parameter(f"{winding}.thermal_resistance", "K/W", "thermal resistance of the windings; 0 = their temperature "
                  "does not change", "assumed: off", 0.0, 1e3, 1.0),
        parameter(f"{winding}.thermal_time", "s", "time constant of the winding temperature", "assumed", 0.0, 1e5,
                  100.0))
    return inputs, outputs, parameters


def stop_parameters(owner: str, source: str) -> tuple[Variable, ...]:
    """End stops of an axis or a motor."""
    rows = (("lower", "m", "position of the lower end stop", -10.0, 10.0, 0.01),
            ("upper", "m", "position of the upper end stop", -10.0, 10.0, 0.01),
            ("stiffness", "N/m", "stiffness of the end stops", 0.0, 1e8, 1e5),
            ("damping", "N.s/m", "damping of the end stops", 0.0, 1e6, 1e3))
    return tuple(parameter(f"{owner}.stop.{name}", unit, text, source, low, high, nominal,
                           fixed=name in ("lower", "upper")) for name, unit, text, low, high, nominal in rows)


def axis_variables(stage: StageDescription, of: StageAxis) -> tuple[tuple[Variable, ...], tuple[Variable, ...],
                                                                    tuple[Variable, ...]]:
    """Inputs, outputs and parameters of one axis."""
    axis, meaning, unit = of.name, of.meaning, of.unit
    start = f"{axis}.position_start"
    inertia = "inertia" if of.rotation else "mass"
    reach, nominal = (0.1, 1e-3) if of.rotation else (10.0, 0.01)
    push = f"external torque on the {meaning}" if of.rotation else f"external force along {axis}"
    moved = (f"moment of inertia of the {meaning}" if of.rotation else
             f"mass that moves along {axis}; the motor constants hold for {of.mass:g} kg")
    inputs = [real_input(of.external, unit("N"), push, 1e5, 1.0)]
    if not of.rotation:
        shaking = f"acceleration of the floor along {axis}; the mover feels it in the opposite direction"
        inputs.append(real_input(f"{axis}.floor_acceleration", "m/s2", shaking, 1e3, 1.0))
    outputs = [
        real_output(f"{axis}.position", unit("m"), f"true {meaning}", nominal, starts_from=(start,)),
        real_output(f"{axis}.velocity", unit("m/s"), f"rate of the {meaning}", 10.0 * nominal)]
    if of in stage.measured:
        outputs.insert(0, real_output(f"{axis}.encoder", "m", f"measured {meaning}", nominal, discrete=True,
                                      starts_from=(start, "encoder.resolution")))
    rows = (
        ("bias", "m/s2", "constant disturbing acceleration, for example by misaligned bearings", -1e3, 1e3, 0.1),
        ("friction.coulomb", "N", "Coulomb friction of the guide; 0 = no friction", 0.0, 1e4, 1.0),
        ("friction.presliding", "m", "displacement over which friction builds up; 0 = no friction", 0.0, 1.0, 1e-3),
        ("friction.viscous", "N.s/m", "viscous friction of the guide", 0.0, 1e5, 1.0),
        ("friction.variation", "", "standard deviation of the Coulomb friction along the guide, relative; 0 = constant "
                                   "friction", 0.0, 10.0, 0.1),
        ("friction.correlation", "m", "correlation length of the Coulomb friction along the guide", 1e-5, 1.0, 1e-3),
        ("ripple.amplitude", "m/s2", "amplitude of the ripple by guide or slots, at the nominal "
                                     f"{axis}.{inertia}; 0 = no ripple", 0.0, 1e3, 0.1),
        ("ripple.period", "m", "period of the ripple; 0 = no ripple", 0.0, 1.0, 1e-3),
        ("roughness.rms", "m/s2", f"rms acceleration by the rough guide, at the nominal {axis}.{inertia}; 0 = smooth",
         0.0, 1e3, 0.1),
        ("roughness.correlation", "m", "correlation length of the guide's roughness", 1e-5, 1.0, 1e-3))
    parameters = (
        parameter(f"{axis}.{inertia}", unit("kg"), moved, stage.source(f"axes.{axis}.mass"), 1e-3, 1e6, 1.0),
        *(parameter(f"{axis}.{name}", unit(of_way), text, stage.source(f"axes.{axis}.{name}"), low, high, size,
                    fixed=name.endswith(".correlation")) for name, of_way, text, low, high, size in rows),
        *(stop_parameters(axis, stage.source(f"axes.{axis}.stop")) if of.stop is not None else ()),
        *mode_parameters(stage, of),
        parameter(start, unit("m"), f"initial {meaning}, at rest", "mid-range", -reach, reach, nominal, fixed=True),
        switch(f"{axis}.locked", f"true if brackets hold the {meaning} at its initial value", "off" if of.rotation else
               "off; stated, section 5.1.2", fixed=True))
    return tuple(inputs), tuple(outputs), parameters


def mode_parameters(stage: StageDescription, of: StageAxis) -> tuple[Variable, ...]:
    """Flexible mode of an axis; its frequency as far as a Runge–Kutta step of the stage follows it."""
    inertia = "inertia" if of.rotation else "mass"
    rows = (("frequency", "Hz", "frequency of the flexible mode of the free mover; 0 = rigid", 0.0, stage.largest_mode,
             100.0, f"the integration step, {1e3 * stage.longest_step:g} ms, is too long for a faster mode"),
            ("damping", "", "damping ratio of the flexible mode", 0.0, 1.0, 0.01, ""),
            ("mass_share", "", f"share of the {inertia} that swings in the flexible mode", 0.0, 0.8, 0.1, ""),
            ("encoder_share", "", "share of the flexible mode's deflection that the encoder measures",
             -10.0, 10.0, 1.0, ""))
    source = stage.source(f"axes.{of.name}.mode")
    return tuple(parameter(f"{of.name}.mode.{name}", unit, text, source, low, high, nominal, fixed=True, hint=hint)
                 for name, unit, text, low, high, nominal, hint in rows)


def platform_place(stage: StageDescription, what: str, way: str, source: str, fixed: bool) -> Variable:
    """Place of something on a platform that tilts, along x or z."""
    axes = [axis.name for axis in stage.horizontal]
    along = f"across {axes[0]}" if len(axes) == 1 else f"along {axes['xz'.index(way)]}"
    return parameter(f"{what}.{way}", "m", f"position on the platform {along}, from its centre of mass",
                     source, -10.0, 10.0, 0.1, fixed)


def mount_variables(stage: StageDescription, motor: str) -> tuple[tuple[Variable, ...], tuple[Variable, ...]]:
    """Outputs and parameters of a motor at its place on a platform that tilts."""
    decides = (*(f"{axis.name}.position_start" for axis in (stage.vertical, *stage.rotations)),
               *(f"{motor}.{way}" for way in stage.spots))
    outputs = (
        real_output(f"{motor}.gap_encoder", "m", "measured air gap at the motor", 0.01, discrete=True,
                    starts_from=(*decides, "encoder.resolution")),
        real_output(f"{motor}.gap", "m", "true air gap at the motor", 0.01, starts_from=decides))
    parameters = (platform_place(stage, motor, way, stage.source(f"motors.{motor}.{way}"), fixed=True)
                  for way in stage.spots)
    return outputs, (*parameters, *stop_parameters(motor, stage.source("motor_stop")))


def platform_variables(stage: StageDescription) -> tuple[Variable, ...]:
    """Variables of a tilting platform next to those of axes and motors: an output, then parameters."""
    yaw = f"moment of the motors about {stage.vertical.name}, which the guides take up"
    guides = [v for axis in stage.rotations for v in (
        parameter(f"{axis.name}.guide.stiffness", "N.m/rad", f"stiffness of the guides against {axis.name}; 0 = off",
                  NONE, 0.0, 1e6, 1e3),
        parameter(f"{axis.name}.guide.play", "rad", f"{axis.meaning} in either direction before the guides act", NONE,
                  0.0, 1.0, 1e-3))]
    return (real_output("yaw_moment", "N.m", yaw, 1.0),
            parameter("height", "m", "distance of the magnets' faces below the centre of mass",
                      stage.source("height"), -1.0, 1.0, 0.01, fixed=True),
            parameter("payload.mass", "kg", "mass of a payload on the platform", NONE, 0.0, 1e6, 1.0),
            *(platform_place(stage, "payload", way, NONE, fixed=False) for way in stage.spots), *guides)


def motion_constant(of: StageConstant, source: str) -> Variable:
    """Constant of the motion's equations; positive, so that every motor keeps its sign."""
    return parameter(of.name, of.unit, f"constant of the {of.meaning}, at the nominal {of.axis}.mass", source, 0.0, 1e6,
                     1.0)


def stage_variables(stage: StageDescription) -> tuple[Variable, ...]:
    """Variables of a stage: inputs, outputs, then parameters."""
    parts = [motor_variables(stage, motor) for motor in stage.motor_names]
    parts += [axis_variables(stage, axis) for axis in stage.axes]
    tilted = platform_variables(stage) if stage.rotations else ()
    parts += [((), *mount_variables(stage, motor)) for motor in stage.motor_names if stage.rotations]
    parts.append(((), tilted[:1], tilted[1:]))
    inputs = [v for part in parts for v in part[0]]
    outputs = [v for part in parts for v in part[1]]
    parameters = [v for part in parts for v in part[2]]
    constants = [motion_constant(entry, stage.source("plant")) for entry in stage.constants]
    stopped = "an axis or a motor" if stage.rotations else "an axis"
    at_stop = flag("at_stop", f"true if {stopped} was beyond an end stop during the step")
    return placed(stage, (
            *inputs, *outputs, at_stop, *constants,
            parameter("attraction_modulation", "", "relative modulation of the attraction along the slots; 0 = off",
                      stage.source("modulation"), 0.0, 1.0, 0.01),
            parameter("guide_seed", "", "seed of the guides' random roughness and friction, a whole number",
                      stage.source("guide_seed"), 0.0, 4294967295.0, 1.0, fixed=True),
            parameter("magnet_rise", "K", "rise of the magnets' temperature above that of the motor constants",
                      "assumed: none", -100.0, 200.0, 10.0),
            parameter("bus_voltage", "V", "supply voltage of the amplifiers, which limits each phase voltage; 0 = no "
                      "limit", "assumed: no limit", 0.0, 1e5, 10.0),
            parameter("encoder.resolution", "m", "resolution of the encoders; 0 = exact",
                      stage.source("resolution"), 0.0, 1.0, 1e-5),
            *parameters, *motor_geometry(stage, *CONSTANTS)))


def stage_refusals(stage: StageDescription) -> dict[int, str]:
    """Messages of a stage by its status: one for each axis or motor that has a stop, then the others."""
    beyond = [f"{axis.name}.position_start = {{{axis.name}.position_start}} m, expected a place between the stops "
              f"{stops(axis.name)}" for axis in stage.ordered_axes if axis.stop is not None]
    beyond += [f"{motor}.gap = {{{motor}.gap}} m at the start, expected one between the stops {stops(motor)}"
               for motor in stage.motor_names if stage.rotations]
    others = len(beyond)   # their numbers begin after this
    places = ", ".join(f"{axis.name}.position = {{{axis.name}.position}} {axis.unit('m')}" for axis in stage.axes)
    every = "both" if len(stage.axes) == 2 else "all"
    bounds = "1000 m or rad and slower than 1e6 m/s or rad/s" if stage.rotations else "1000 m and slower than 1e6 m/s"
    return {
        **dict(enumerate(beyond, 1)),
        others + RUN_AWAY: f"the mover has run away in the step from {{time}} s: {places}, expected {every} within "
                           f"{bounds}",
        others + STEP_TOO_LONG: "communication step = {step} s, expected at most 1000 s",
        others + NO_SUCH_MOTOR: bad_geometry(stage),
        others + NO_SEED: "guide_seed = {guide_seed}, expected a whole number"}


def stops(owner: str) -> str:
    """The stops of an axis or a motor, as a refusal names them."""
    return f"{owner}.stop.lower = {{{owner}.stop.lower}} m and {owner}.stop.upper = {{{owner}.stop.upper}} m"
