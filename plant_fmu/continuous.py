"""The stage as a continuous model, for Model Exchange: its states, their rates, and the dependencies of each."""

from dataclasses import dataclass

from maglev.fmi.definition import ContinuousModel, State, Variable
from plant_fmu.places import placed
from pmlsm.stage_description import StageAxis, StageDescription, StageMotor

PHASES = ("a", "b", "c")


@dataclass(frozen=True)
class Reach:
    """Motion that a motor sees: names of the positions in its gap and in its displacement, and of their rates."""

    gap: tuple[str, ...]
    displacement: tuple[str, ...]
    gap_rate: tuple[str, ...]
    rate: tuple[str, ...]   # of the displacement


def local(name: str, unit: str, description: str, nominal: float) -> Variable:
    """Variable of the continuous model alone."""
    return Variable(name, "local", "continuous", description, unit, nominal=nominal)


def rate(of: str, unit: str, nominal: float) -> Variable:
    """Derivative of a state that is no variable otherwise."""
    return local(f"der({of})", unit, f"rate of {of}", nominal)


def reach(stage: StageDescription, motor: StageMotor) -> Reach:
    """Return the motion that a motor sees; on a tilting platform it depends on the motor's place."""
    gap, along = [stage.vertical.name], [motor.drives]
    if stage.rotations:
        gap += [axis.name for axis in stage.rotations]
        if len(stage.rotations) == 2:   # a lever of the magnets, along the axis that the motor drives
            along.append(gap[2] if motor.drives == stage.horizontal[0].name else gap[1])
    return Reach(*(tuple(f"{axis}.{what}" for axis in axes) for axes, what in (
        (gap, "position"), (along, "position"), (gap, "velocity"), (along, "velocity"))))


def currents(motor: StageMotor) -> tuple[str, ...]:
    """Names of the phase currents."""
    return tuple(f"{motor.name}.i_{phase}" for phase in PHASES)


def axis_states(stage: StageDescription, axis: StageAxis) -> tuple[tuple[State, ...], tuple[Variable, ...]]:
    """States of an axis, and the variables that only the continuous model has."""
    name, unit = axis.name, axis.unit
    position, velocity, deflection = f"{name}.position", f"{name}.velocity", f"{name}.friction.deflection"
    swing, swing_rate = f"{name}.mode.deflection", f"{name}.mode.rate"
    size = 1e-3 if axis.rotation else 0.01
    variables = (
        rate(velocity, unit("m/s2"), 1.0),
        local(deflection, "", "relative deflection of the presliding friction, within ±1", 1.0),
        rate(deflection, "1/s", 1.0),
        local(swing, unit("m"), "deflection of the flexible mode", 0.1 * size),
        local(swing_rate, unit("m/s"), "rate of the flexible mode's deflection", 10.0 * size),
        rate(swing_rate, unit("m/s2"), 1.0))
    shaken = () if axis.rotation else (f"{name}.floor_acceleration",)
    swung = unique((position, velocity, deflection, swing, swing_rate, *pulled(stage, axis), axis.external))
    states = (
        State(position, velocity, (velocity,)),
        State(velocity, f"der({velocity})", (*swung, *shaken)),
        State(deflection, f"der({deflection})", (velocity, deflection)),
        State(swing, swing_rate, (swing_rate,)),
        State(swing_rate, f"der({swing_rate})", swung))   # the floor shakes both parts of the mover alike
    return states, variables


def pulled(stage: StageDescription, axis: StageAxis) -> tuple[str, ...]:
    """Return the names on which the acceleration of an axis by motors, and by the stops at them, depends."""
    names: list[str] = []
    for motor in stage.motors:
        seen = reach(stage, motor)
        lifts = axis is stage.vertical or axis.rotation
        if not lifts and motor.drives != axis.name:
            continue
        names += [*seen.gap, *seen.displacement, *currents(motor)]
        if lifts:   # next to the gap, where the stops are, or where the attraction changes
            names += seen.gap_rate if stage.rotations else (f"{stage.horizontal[0].name}.position",)
    return tuple(names)


def motor_states(stage: StageDescription, motor: StageMotor) -> tuple[tuple[State, ...], tuple[Variable, ...]]:
    """States of a motor's supply, and the variables that only the continuous model has."""
    name, rise = motor.name, f"{motor.name}.winding.rise"
    states: list[State] = []
    variables: list[Variable] = []
    for phase, current in zip(PHASES, currents(motor), strict=True):
        part = f"{name}.phase_{phase}"
        heat, command = f"{part}.heat", f"{current}_cmd"
        variables += [rate(current, "A/s", 1e3),
                      local(heat, "A2", f"low-passed square of the current of phase {phase}", 1.0),
                      rate(heat, "A2/s", 1.0),
                      local(f"{part}.margin", "", "margin to the clamp (A) or to bus_voltage (V); an event where it "
                            "becomes negative", 1.0)]
        states += [State(current, f"der({current})", unique((current, heat, command, *induced(stage, motor))),
                         jumps=True),
                   State(heat, f"der({heat})", (heat, command, current))]
    variables.append(rate(rise, "K/s", 0.1))
    states.append(State(rise, f"der({rise})", (*currents(motor), rise)))
    return tuple(states), tuple(variables)


def induced(stage: StageDescription, motor: StageMotor) -> tuple[str, ...]:
    """Return the names on which the voltages of a motor depend, except for its commands."""
    seen = reach(stage, motor)
    return (*currents(motor), *seen.gap, *seen.displacement, *seen.gap_rate, *seen.rate, f"{motor.name}.winding.rise")


def margins(stage: StageDescription, motor: StageMotor) -> dict[str, tuple[str, ...]]:
    """Return the names on which the margin of each phase of a motor to the clamp or the bus depends."""
    return {f"{motor.name}.phase_{phase}.margin": (
        *induced(stage, motor), f"{motor.name}.phase_{phase}.heat", f"{current}_cmd")
        for phase, current in zip(PHASES, currents(motor), strict=True)}


def stop_ways(owner: str) -> tuple[Variable, ...]:
    """Ways to the stops of an axis or a motor, which change their sign where it meets or leaves them."""
    return tuple(local(f"{owner}.stop.to_{side}", "m", f"distance to the {side} end stop, 1 without a stop; event at 0",
                       0.01) for side in ("lower", "upper"))


def output_dependencies(stage: StageDescription) -> dict[str, tuple[str, ...]]:
    """States and inputs that decide each output."""
    depends: dict[str, tuple[str, ...]] = {}
    motion = tuple(f"{axis.name}.{what}" for axis in stage.axes for what in ("position", "velocity"))
    depends |= {name: (name,) for name in motion}
    for axis in stage.measured:
        depends[f"{axis.name}.encoder"] = (f"{axis.name}.position", f"{axis.name}.mode.deflection")
    for motor in stage.motors:
        seen, name = reach(stage, motor), motor.name
        depends |= {current: (current,) for current in (*currents(motor), f"{name}.winding.rise")}
        depends |= {f"{name}.i_{part}": (*currents(motor), *seen.displacement) for part in "dq"}
        every = unique(tuple(known for knowns in margins(stage, motor).values() for known in knowns))
        depends |= {f"{name}.{what}": every for what in ("voltage", "saturated")}
        if stage.rotations:
            swings = tuple(place.replace(".position", ".mode.deflection") for place in seen.gap)
            depends |= {f"{name}.gap": seen.gap, f"{name}.gap_encoder": (*seen.gap, *swings)}
    if stage.rotations:
        depends["yaw_moment"] = unique(tuple(signal for motor in stage.motors for seen in [reach(stage, motor)]
                                             for signal in (*seen.gap, *seen.displacement,
                                                            *currents(motor))))
    return depends | {"at_stop": motion}


def unique(names: tuple[str, ...]) -> tuple[str, ...]:
    """Names without those that come again."""
    return tuple(dict.fromkeys(names))


def continuous_stage(stage: StageDescription) -> ContinuousModel:
    """States, rates and event indicators of a stage."""
    parts = [axis_states(stage, axis) for axis in stage.axes] + [motor_states(stage, motor) for motor in stage.motors]
    ways: dict[Variable, tuple[str, ...]] = {
        way: (f"{axis.name}.position",) for axis in stage.axes if axis.stop is not None for way in stop_ways(axis.name)}
    ways |= {way: reach(stage, motor).gap for motor in stage.motors if stage.rotations for way in stop_ways(motor.name)}
    return ContinuousModel(
        states=tuple(state for states, _ in parts for state in states),
        variables=placed(stage, (*(v for _, more in parts for v in more), *ways)),
        indicators={way.name: knowns for way, knowns in ways.items()} | {
            name: knowns for motor in stage.motors for name, knowns in margins(stage, motor).items()},
        outputs=output_dependencies(stage))
