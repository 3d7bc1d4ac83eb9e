"""A stage as data: axes, motors, constants, design. It describes blocks; no block reads it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from operator import attrgetter
from typing import Any

from pmlsm.motor_geometry import MotorGeometry

# Units of the constants.
THRUST = "m/(s2.A)"
ATTRACTION = "m/(s2.T2)"
COILS = "m/(s2.A.T)"
IRON = "m/(s2.A2)"

MOST_CYCLES = 0.1   # of a flexible mode in an integration step: its damping ratio is right to 0.0007 there

# Unit of a quantity of a rotation, by that of a translation.
ROTATION = {"m": "rad", "m/s": "rad/s", "m/s2": "rad/s2", "kg": "kg.m2", "N": "N.m", "N.s/m": "N.m.s", "N/m": "N.m/rad"}


def quantity(unit: str, low: float, high: float, default: float | tuple[float, ...] | None = None) -> Any:
    """Number in SI of a description, or several, with the unit and the range that a file is held to."""
    metadata = {"unit": unit, "low": low, "high": high}
    return field(metadata=metadata) if default is None else field(default=default, metadata=metadata)


@dataclass(frozen=True)
class Friction:
    """Guide friction of an axis, see `plant_fmu.guide`; of a rotation in N m, rad, N m s."""

    coulomb: float = quantity("N", 0.0, 1e4, 0.0)
    presliding: float = quantity("m", 0.0, 1.0, 0.5e-3)
    viscous: float = quantity("N.s/m", 0.0, 1e5, 0.0)
    variation: float = quantity("1", 0.0, 10.0, 0.0)
    correlation: float = quantity("m", 1e-5, 1.0, 4.0e-3)


@dataclass(frozen=True)
class Ripple:
    """Ripple of an axis, see `plant_fmu.ripple`."""

    amplitude: float = quantity("m/s2", 0.0, 1e3, 0.0)
    period: float = quantity("m", 0.0, 1.0, 5.0e-3)


@dataclass(frozen=True)
class Roughness:
    """Roughness of the guides of an axis, see `plant_fmu.roughness`; none where the rms is 0."""

    rms: float = quantity("m/s2", 0.0, 1e3, 0.0)
    correlation: float = quantity("m", 1e-5, 1.0, 2.0e-3)


@dataclass(frozen=True)
class Mode:
    """Flexible mode of an axis, see `plant_fmu.flexible_mode`; none where the frequency is 0."""

    frequency: float = quantity("Hz", 0.0, 1e5, 0.0)
    damping: float = quantity("1", 0.0, 1.0, 0.01)
    mass_share: float = quantity("1", 0.0, 0.8, 0.1)
    encoder_share: float = quantity("1", -10.0, 10.0, 0.0)


@dataclass(frozen=True)
class Stop:
    """End stops of an axis, see `plant_fmu.end_stop`."""

    lower: float = quantity("m", -10.0, 10.0)
    upper: float = quantity("m", -10.0, 10.0)
    stiffness: float = quantity("N/m", 0.0, 1e8, 4.0e5)
    damping: float = quantity("N.s/m", 0.0, 1e6, 1500.0)


@dataclass(frozen=True)
class AxisDesign:
    """Design of the controllers of an axis."""

    gains: tuple[float, ...]                                 # k1 to k5 of (4.16), SI
    pid: tuple[float, ...]   # poles of the PID, rad/s: the real one, then real and imaginary part of the pair
    bandwidth: float = quantity("rad/s", 1e-3, 1e6)          # of the controller that a user begins with
    antiwindup_gain: float = quantity("1", -1e3, 1e3, 0.0)   # each of the three gains of (5.13), SI
    prefilter: float = quantity("rad/s", 0.0, 1e4, 0.0)      # corner of the PID's, of the reference; 0 = off


@dataclass(frozen=True)
class StageAxis:
    """Axis of motion."""

    name: str
    meaning: str                                     # of its position
    design: AxisDesign
    # Nominal mass that moves along it; the constants are accelerations at it. Of a rotation the inertia, kg m².
    mass: float = quantity("kg", 1e-3, 1e6)
    # Initial position; of the air gap also where the linear laws are designed.
    start: float = quantity("m", -10.0, 10.0)
    stop: Stop | None = None                         # None if the stops are at the motors
    # True for a small tilt of the platform: all its quantities are in rad instead of m, N m instead of N.
    rotation: bool = False
    bias: float = quantity("m/s2", -1e3, 1e3, 0.0)   # constant acceleration
    friction: Friction = Friction()
    ripple: Ripple = Ripple()
    roughness: Roughness = Roughness()
    mode: Mode = Mode()

    def unit(self, of: str) -> str:
        """Unit of a quantity of this axis, by that of a translation."""
        return ROTATION.get(of, of) if self.rotation else of

    @property
    def external(self) -> str:
        """Name of the external force, or torque."""
        return f"{self.name}.{'torque' if self.rotation else 'force'}"


@dataclass(frozen=True)
class Amplifier:
    """Amplifiers of the phases of a motor, see `plant_fmu.current_amplifier`."""

    peak: float = quantity("A", 1e-3, 1000.0)
    continuous: float = quantity("A", 0.0, 1000.0)
    lag: float = quantity("s", 0.0, 0.1, 0.3e-3)


@dataclass(frozen=True)
class Winding:
    """A phase of a motor as its amplifier sees it, see `plant_fmu.winding`: of two in parallel half of one motor's."""

    resistance: float = quantity("Ohm", 1e-3, 1e4, 7.0)
    inductance: float = quantity("H", 1e-6, 10.0, 0.07)


@dataclass(frozen=True)
class MotorKind:
    """Kind of a motor that differs from the others: geometry, and constants and limit relative to those of the stage.
    """

    geometry: Mapping[str, float]
    thrust: float
    attraction: float
    coils: float
    iron: float
    limit: float


@dataclass(frozen=True)
class StageMotor:
    """Motor, or motors with one current, and the horizontal axis that it drives; all carry the vertical axis.

    Where the platform tilts, x and z (m) are its place on the platform, from the centre of mass along the two
    horizontal axes. Its kind is None where geometry and constants of the stage are its own; no file says it.
    """

    name: str
    drives: str
    amplifier: Amplifier
    x: float = quantity("m", -10.0, 10.0, 0.0)
    z: float = quantity("m", -10.0, 10.0, 0.0)
    winding: Winding = Winding()
    kind: MotorKind | None = field(default=None, metadata={"file": False})

    @property
    def ratios(self) -> tuple[float, float, float, float]:
        """Thrust, attraction, coils and iron by those of the stage."""
        of = self.kind
        return (1.0, 1.0, 1.0, 1.0) if of is None else (of.thrust, of.attraction, of.coils, of.iron)


@dataclass(frozen=True)
class Constants:
    """Constants of the velocity rows: thrust by horizontal axis, and attraction, coils, iron of the vertical one."""

    thrust: Mapping[str, float] = quantity("1", 1e-9, 1e6)
    attraction: float = quantity("1", 1e-9, 1e6)
    coils: float = quantity("1", 1e-9, 1e6)
    iron: float = quantity("1", 1e-9, 1e6)


@dataclass(frozen=True)
class StageConstant:
    """Constant as the FMUs have it."""

    name: str      # C1, C2, …
    axis: str      # in whose row it stands
    unit: str
    meaning: str
    plant: float   # of the stage itself
    model: float   # of the controllers' model of it
    guess: float   # the estimator's first
    weight: float  # and its diagonal element of Q0


@dataclass(frozen=True)
class Schedule:
    """Gain schedule (Table 5.4)."""

    bounds: tuple[float, ...]      # air gaps between the regions, the largest first, m; three
    setpoints: tuple[float, ...]   # air gaps of the linearisations, the largest first, m; four


@dataclass(frozen=True)
class Table:
    """Grid of air gaps of an interpolated law, see `controller_fmu.gain_table`."""

    lower: float = quantity("m", 1e-4, 1.0)     # of the first
    spacing: float = quantity("m", 1e-5, 0.1)   # of two neighbours

    @property
    def gaps(self) -> tuple[float, ...]:
        """Air gaps of its points, m."""
        return tuple(self.lower + place * self.spacing for place in range(15))


@dataclass(frozen=True)
class Estimator:
    """First guesses of the constants, and their weights, the diagonal of Q0 in (3.8)."""

    guess: Constants
    weight: Constants


@dataclass(frozen=True)
class Design:
    """Settings of a stage's controllers next to the gains of each axis."""

    current_limit: float = quantity("A", 0.0, 1000.0)       # of the regulators; 0 = none
    pid_current_limit: float = quantity("A", 0.0, 1000.0)   # of the PID
    antiwindup: bool = False                                # of the regulators
    # Both time constants of the observers of velocities, of the regulators and the PID.
    observer_time: float = quantity("s", 0.0, 1.0, 1.0e-3)
    schedule: Schedule | None = None
    table: Table | None = None


@dataclass(frozen=True)
class StageDescription:
    """A stage, as a file of the folder `stages` describes it."""

    name: str                   # as in the names of experiments; its FMUs have it behind theirs, see `suffix`
    title: str                  # such as "3-DOF stage"
    text: str                   # its guides and motors, in words
    axes: tuple[StageAxis, ...]   # the air gap first
    motors: tuple[StageMotor, ...]
    plant: Constants            # the true ones
    model: Constants            # those that the controllers take for them
    estimator: Estimator
    design: Design
    sample_time: float = quantity("s", 1e-6, 1.0)              # of its controllers
    longest_step: float = quantity("s", 1e-6, 1e-2)            # of an integration
    sharing: float = quantity("1", 1.0, 100.0, 1.0)            # motors that share each current
    resolution: float = quantity("m", 0.0, 1.0, 10.0e-6)       # of the encoders
    modulation: float = quantity("1", 0.0, 1.0, 0.0)           # k of the attraction along the slots
    guide_seed: float = quantity("1", 0.0, 4294967295.0, 1.0)   # of roughness and varying friction, whole
    # Distance of the magnets' faces below the centre of mass; used if the platform tilts.
    height: float = quantity("m", -1.0, 1.0, 0.0)
    motor_stop: Stop | None = None   # on the motors' air gaps, where the platform tilts; otherwise the axes have stops
    equation: str = ""               # number of its equations of motion on the page, in parentheses; empty without one
    # Whose loop a file of controller and plant has, with the start values of the FMUs; empty if there is none.
    experiment: str = ""
    geometry: Mapping[str, float] = field(default_factory=dict)   # differences from `pmlsm.motor_geometry`, by path
    sources: Mapping[str, str] = field(default_factory=dict)      # where values come from, by the beginning of a path

    @property
    def suffix(self) -> str:
        """End of the names of its FMUs and classes, such as "3DOF"."""
        return self.name.upper() if self.name[0].isdigit() else self.name[0].upper() + self.name[1:]

    @property
    def vertical(self) -> StageAxis:
        """The air gap."""
        return self.axes[0]

    @property
    def horizontal(self) -> tuple[StageAxis, ...]:
        """The axes that motors drive."""
        return tuple(axis for axis in self.axes[1:] if not axis.rotation)

    @property
    def rotations(self) -> tuple[StageAxis, ...]:
        """The tilts of the platform: about the first horizontal axis, then about the second; none that guides hold."""
        return tuple(axis for axis in self.axes if axis.rotation)

    @property
    def spots(self) -> str:
        """Directions in which motors of a platform have a place: "xz", with one horizontal axis "z", across it."""
        return "xz" if len(self.horizontal) == 2 else "z"

    @property
    def gap_stop(self) -> Stop:
        """Stops of the air gap, those at the motors where the platform tilts."""
        stop = self.vertical.stop or self.motor_stop
        assert stop is not None   # as the reader of descriptions sees to
        return stop

    @property
    def arm(self) -> float:
        """Distance of the outermost motor from the centre of mass, m: a tilt moves its gap by the tilt times it."""
        return max(max(abs(motor.x), abs(motor.z)) for motor in self.motors)

    @property
    def measured(self) -> tuple[StageAxis, ...]:
        """The axes that have an encoder; where the platform tilts, each motor has one of its air gap instead."""
        return self.horizontal if self.rotations else self.axes

    @property
    def encoders(self) -> tuple[str, ...]:
        """Names of the values that encoders read: positions of axes, and gaps at the motors of a tilting platform."""
        gaps = self.motors if self.rotations else ()
        return (*(f"{axis.name}.encoder" for axis in self.measured), *(f"{motor.name}.gap_encoder" for motor in gaps))

    @property
    def axis_names(self) -> tuple[str, ...]:
        """Names of all axes, the vertical one first."""
        return tuple(axis.name for axis in self.axes)

    @property
    def ordered_axes(self) -> tuple[StageAxis, ...]:
        """All axes in the order that blocks have: the air gap, the horizontal axes, the tilts."""
        return (self.vertical, *self.horizontal, *self.rotations)

    def axis_number(self, name: str) -> int:
        """Number of an axis in blocks."""
        return [axis.name for axis in self.ordered_axes].index(name)

    @property
    def motor_names(self) -> tuple[str, ...]:
        """Names of the motors."""
        return tuple(motor.name for motor in self.motors)

    @property
    def dq_names(self) -> tuple[str, ...]:
        """Direct and quadrature current of each motor in turn."""
        return tuple(f"{motor}.i_{component}" for motor in self.motor_names for component in ("d", "q"))

    @property
    def phase_names(self) -> tuple[str, ...]:
        """Three phase currents of each motor in turn."""
        return tuple(f"{motor}.i_{phase}" for motor in self.motor_names for phase in ("a", "b", "c"))

    @property
    def driven(self) -> tuple[int, ...]:
        """Number, among the axes, of that which each motor drives."""
        return tuple(self.axis_names.index(motor.drives) for motor in self.motors)

    @property
    def carrying(self) -> float:
        """Motors that carry the mover."""
        return self.sharing * len(self.motors)

    def axis(self, name: str) -> StageAxis:
        """Axis of a name."""
        return self.axes[self.axis_names.index(name)]

    def motors_of(self, axis: str) -> tuple[StageMotor, ...]:
        """Motors that drive a horizontal axis."""
        return tuple(motor for motor in self.motors if motor.drives == axis)

    @property
    def constants(self) -> tuple[StageConstant, ...]:
        """Constants, C1 first: the thrust of each horizontal axis, then attraction, coils, iron."""
        cited = f" {self.equation}" if self.equation else ""
        vertical = self.vertical.name
        rows = [(axis.name, THRUST, f"thrust along {axis.name}{cited}", [
            motor.thrust[axis.name] for motor in self.constant_sets]) for axis in self.horizontal]
        rows += [(vertical, ATTRACTION, f"attraction between magnets and iron{cited}",
                  [motor.attraction for motor in self.constant_sets]),
                 (vertical, COILS, f"normal force between magnets and coils{cited}",
                  [motor.coils for motor in self.constant_sets]),
                 (vertical, IRON, f"normal force between coils and iron{cited}",
                  [motor.iron for motor in self.constant_sets])]
        return tuple(StageConstant(f"C{k}", axis, unit, meaning, *values)
                     for k, (axis, unit, meaning, values) in enumerate(rows, 1))

    @property
    def constant_sets(self) -> tuple[Constants, ...]:
        """Sets of constants: of plant and model, and the estimator's guess and weight."""
        return self.plant, self.model, self.estimator.guess, self.estimator.weight

    @property
    def unlike(self) -> tuple[StageMotor, ...]:
        """Motors of another kind than the stage's geometry and constants are of."""
        return tuple(motor for motor in self.motors if motor.kind is not None)

    def motor(self, of: StageMotor | None = None) -> MotorGeometry:
        """Geometry of a motor of the stage, without one of those that are of no kind of their own."""
        motor = MotorGeometry()
        geometry = self.geometry if of is None or of.kind is None else of.kind.geometry
        for path, value in geometry.items():
            part, _, name = path.rpartition(".")
            setattr(attrgetter(part)(motor) if part else motor, name, value)
        motor.prepare()
        return motor

    def constants_of(self, axis: str) -> tuple[str, ...]:
        """Names of the constants in the row of an axis."""
        return tuple(constant.name for constant in self.constants if constant.axis == axis)

    @property
    def largest_mode(self) -> float:
        """Largest frequency of a flexible mode that the integration follows, Hz."""
        return MOST_CYCLES / self.longest_step

    def source(self, path: str) -> str:
        """Return the source of the value at a path: the one with the longest key that begins the path."""
        parts = path.split(".")
        for length in range(len(parts), 0, -1):
            cited = self.sources.get(".".join(parts[:length]))
            if cited is not None:
                return cited
        return "assumed"
