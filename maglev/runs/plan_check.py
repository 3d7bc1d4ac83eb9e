"""Check of a run before it starts: its names, types and units against its FMUs, its references against the stops."""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError, key_path, nearest, shortened
from maglev.files.units import known_unit, measures
from maglev.fmi.parameter import REALS, Described, expected_of
from maglev.linear.places import MotorPlaces
from maglev.scenario.run_plan import RunPlan
from maglev.scenario.signals import Steps
from maglev.user.source import PythonClass, PythonFile, Source
from pmlsm.stage_description import StageDescription

Descriptions = Mapping[str, Mapping[str, Described]]

Start = Callable[[str], float | None]   # start value of a variable `fmu.variable`; None where there is none


class PortCheck:
    """The check of one scenario; refusals name its file."""

    def __init__(self, plan: RunPlan, descriptions: Descriptions, sources: Mapping[str, Source]):
        self.plan = plan
        self.sources = sources
        self.descriptions = descriptions
        self.fed: dict[str, str] = {}   # input: key that feeds it
        self.origin = ""                # of the value that is looked at, if it is not the file

    def refuse(self, key: str, value: object, expectation: str) -> ScenarioError:
        if self.origin:
            return ScenarioError(f"{self.origin}: {expectation}")
        return ScenarioError(f"{self.plan.source}: {key} = {shortened(value)}: {expectation}")

    def variable(self, key: str, port: str, *causalities: str) -> Described:
        """Return the variable of "fmu.variable"; raise an error if it does not exist or has another causality."""
        fmu, _, name = port.partition(".")
        if fmu not in self.plan.fmus:
            raise self.refuse(key, port, f"there is no FMU {fmu!r}; {nearest(fmu, self.plan.fmus)}")
        return self.variable_of(key, port, fmu, name, *causalities)

    def variable_of(self, key: str, value: object, fmu: str, name: str, *causalities: str) -> Described:
        """Return a variable of an FMU; `value` is the file's value at the key."""
        variables = self.descriptions[fmu]
        wanted = " or ".join(causalities)
        if name not in variables:
            fitting = [known for known, variable in variables.items() if variable.causality in causalities]
            raise self.refuse(key, value, f"missing port: {fmu} has no {wanted} {name!r}; {nearest(name, fitting)}")
        variable = variables[name]
        if variable.causality not in causalities:
            raise self.refuse(key, value, f"{name!r} is of causality {variable.causality}, expected {wanted}")
        return variable

    def settable(self, key: str, value: object, fmu: str, name: str) -> Described:
        """Return a parameter, an input, or another variable that takes an exact start value."""
        variable = self.descriptions[fmu].get(name)
        if variable is not None and variable.initial == "exact" and variable.variability != "constant":
            return variable
        return self.variable_of(key, value, fmu, name, "parameter", "input")

    def feed(self, key: str, port: str, *causalities: str) -> Described:
        """Return the input, or a variable of another causality; raise an error if it is connected already."""
        variable = self.variable(key, port, "input", *causalities)
        if port in self.fed:
            raise self.refuse(key, port, f"the input is fed by {self.fed[port]} already, expected one source")
        if variable.causality == "parameter" and variable.variability != "tunable":
            raise self.refuse(key, port, f"{variable.name!r} is a {variable.variability} parameter, expected an "
                                         "input or a tunable parameter")
        self.fed[port] = key
        return variable

    def connections(self) -> None:
        """Check that connections run from outputs to inputs, or tunable parameters, of the same type and unit."""
        for key, (start, end) in self.plan.wires.items():
            ends = (f"{key}[0]", f"{key}[1]") if key.startswith("connections") else (key, key)
            output = self.variable(ends[0], start, "output")
            target = self.feed(ends[1], end, "parameter")
            if output.type != target.type and not {output.type, target.type} <= {*REALS}:
                raise self.refuse(key, [start, end], f"connects {output.type} to {target.type}, expected the same type"
                                                     f"{self.declared(start, end)}")
            if output.unit and target.unit and not compatible(output.unit, target.unit):
                raise self.refuse(key, [start, end], f"connects {output.unit} to {target.unit}, expected the same unit"
                                                     f"{self.declared(start, end)}")

    def declared(self, *ports: str) -> str:
        """Return the place that declares the ports of users' files, and the way to override it."""
        said = ""
        for port in ports:
            fmu, _, name = port.partition(".")
            source, variable = self.sources.get(fmu), self.descriptions.get(fmu, {}).get(name)
            if isinstance(source, PythonFile | PythonClass):
                said += f"; {name} stands in {source.place_of(name)}"
            elif source is not None and variable is not None and source.path.stem != self.plan.fmus[fmu].model:
                unit = f" in {variable.unit}" if variable.unit else ""
                said += (f"; {name} is {variable.type}{unit} in {source.name}, for which a port map (ports, --map) can "
                         "name another port or unit")
        return said

    def signals(self) -> None:
        """Check that signals feed inputs of their type and dimension."""
        for i, signal in enumerate(self.plan.signals):
            key = f"signals[{i}].to"
            target = self.feed(key, signal.to, "parameter")
            values = signal.values if isinstance(signal, Steps) else []
            if target.type == "Boolean" and signal.rate_to is None and signal.unit is None:
                if not values or not {*values} <= {False, True}:
                    raise self.refuse(key, signal.to, f"{target.name!r} is Boolean, expected steps of true and false")
            elif any(isinstance(value, bool) for value in values):
                raise self.refuse(key, signal.to, f"{target.name!r} is {target.type}, expected numbers as values")
            else:
                self.real(key, signal.to, target)
            if signal.unit is not None:
                self.dimension(key, signal.to, signal.unit, target)
            if signal.rate_to is not None:
                key = f"signals[{i}].rate_to"
                self.real(key, signal.rate_to, self.feed(key, signal.rate_to))

    def real(self, key: str, port: str, variable: Described) -> None:
        if variable.type not in REALS:
            raise self.refuse(key, port, f"{variable.name!r} is {variable.type}, expected Real{self.declared(port)}")

    def dimension(self, key: str, value: object, unit: str, variable: Described) -> None:
        """Refuse a unit of another dimension than the variable's."""
        own = variable.unit or "1"
        if not measures(unit, own):
            raise self.refuse(key, value, f"{unit} given, expected a quantity in {own}{self.declared(str(value))}")
        # The value has been converted to SI, which this FMU does not use.
        known = known_unit(own)
        if known is not None and known.factor != 1.0:
            raise self.refuse(key, value, f"the FMU uses {own}, expected a plain number of {own} without a unit")

    def start_values(self) -> None:
        """Check that start values are of parameters or inputs, and of their type and dimension."""
        for fmu, entry in self.plan.fmus.items():
            for name, start in entry.start.items():
                key = key_path(["fmus", fmu, "start", name])
                self.origin = start.origin
                variable = self.settable(key, start.written, fmu, name)
                if start.origin and variable.causality == "input" and f"{fmu}.{name}" in self.fed:
                    raise self.refuse(key, start.written, f"{name!r} is fed by {self.fed[f'{fmu}.{name}']} from "
                                      "the start, expected a parameter, an input that nothing feeds, or "
                                      "reference.AXIS.amplitude, .start or .end")
                if expected := expected_of(variable.type, start.given):
                    raise self.refuse(key, start.written, f"{name!r} is {variable.type}, expected {expected}")
                if start.unit is not None:
                    self.dimension(key, start.written, start.unit, variable)
            self.origin = ""
            for name, source in entry.start_from.items():
                key = key_path(["fmus", fmu, "start_from", name])
                self.real(key, name, self.variable_of(key, source.output, fmu, name, "parameter", "input"))

    def recorded(self) -> None:
        """Check the variables that metrics are computed from."""
        numbers = {f"axes.{name}.{what}": getattr(axis, what) for name, axis in self.plan.axes.items()
                   for what in ("position", "reference")}
        numbers |= {f"motors.{name}.{what}[{i}]": port for name, motor in self.plan.motors.items()
                    for what in ("currents", "commands") for i, port in enumerate(getattr(motor, what))}
        for key, port in numbers.items():
            self.real(key, port, self.variable(key, port, "output", "local", "input"))
        for key, flag in (("stop_flag", self.plan.stop_flag), ("trip_flag", self.plan.trip_flag)):
            if flag is not None and self.variable(key, flag, "output", "local").type != "Boolean":
                raise self.refuse(key, flag, "expected a Boolean variable")

    def checked(self) -> None:
        """Check the signals that are compared with a baseline."""
        for signal, tolerance in self.plan.check.signals.items():
            key, allowed = key_path(["check", "signals", signal]), tolerance.allowed
            variable = self.variable(key, signal, "output", "local", "input")
            if allowed.unit is not None:
                self.dimension(f"{key}.absolute", allowed.written, allowed.unit, variable)


def compatible(one: str, other: str) -> bool:
    """Return True if a number means the same in both units."""
    known, and_known = known_unit(one), known_unit(other)
    return one == other or (known is not None and and_known is not None
                            and (known.dimension, known.factor) == (and_known.dimension, and_known.factor))


def check_names(plan: RunPlan, descriptions: Descriptions, sources: Mapping[str, Source]) -> None:
    """Check the names in a run against the variables, by FMU and name, with the sources of its FMUs; ScenarioError.
    """
    check = PortCheck(plan, descriptions, sources)
    check.connections()
    check.signals()
    check.start_values()
    check.recorded()
    check.checked()


def require_reachable(plan: RunPlan, times: Array, references: Mapping[str, Array], start: Start) -> None:
    """Refuse references that are known before the run, (n,), SI, if they go beyond the end stops of the stage.

    `start` has the initial positions of the plant, and its stops. ScenarioError with the file, the reference, its first
    value that is out of reach and its time, the stops, and the initial position.
    """
    known = {axis.position: references[axis.reference] for axis in plan.axes.values() if axis.reference in references}
    vertical = next((axis.position for axis in plan.axes.values() if axis.vertical), None)
    begin = None if vertical is None else start(f"{vertical.rpartition('.')[0]}.position_start")
    gap = "" if begin is None else f", for a stage that begins with a gap of {in_mm(begin)}"
    for name, axis in plan.axes.items():
        if axis.position in known:
            place = axis.position.rpartition(".")[0]
            require_between(f"{plan.source}: reference of {name}", times, known[axis.position], place, start, gap)
    stage = plan.stage
    if stage is not None and stage.rotations and f"plant.{stage.vertical.name}.position" in known:
        # If tilts are not known, the platform counts as level: in a tilted one, one of its motors would only be further
        # out.
        positions = np.array([known.get(f"plant.{axis}.position", np.zeros(len(times))) for axis in stage.axis_names])
        for motor, gaps in zip(stage.motor_names, gaps_of(stage, start) @ positions, strict=True):
            place = f"{plan.source}: gap at {motor} by the references"
            require_between(place, times, gaps, f"plant.{motor}", start, gap)


def gaps_of(stage: StageDescription, start: Start) -> Array:
    """Derivatives of the motors' gaps with respect to the positions, shape (motors, axes), with motors as in a run."""
    spots = []
    for motor in stage.motors:
        x, z = start(f"plant.{motor.name}.x"), start(f"plant.{motor.name}.z")
        spots.append(replace(motor, x=motor.x if x is None else x, z=motor.z if z is None else z))
    return MotorPlaces.at(stage, spots, stage.height).gaps


def require_between(what: str, times: Array, values: Array, place: str, start: Start, gap: str) -> None:
    """Refuse values (m) beyond the stops that a plant has at a place, `fmu.place`."""
    lower, upper = start(f"{place}.stop.lower"), start(f"{place}.stop.upper")
    if lower is None or upper is None:
        return
    beyond = np.flatnonzero((values < lower) | (values > upper))
    if len(beyond):
        k = int(beyond[0])
        raise ScenarioError(f"{what} = {in_mm(float(values[k]))} at t = {times[k]:g} s: out of reach, expected "
                            f"between the stops at {in_mm(lower)} and {in_mm(upper)}{gap}")


def in_mm(value: float) -> str:
    return f"{1e3 * value:g} mm"
