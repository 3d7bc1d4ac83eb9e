"""A mover that its guides hold level: all motors have its air gap, and act on it as on a point."""

from plant_fmu.attraction import attraction_factor
from plant_fmu.axis import Axis
from plant_fmu.encoder import Encoder
from plant_fmu.magnetics import Magnetics
from plant_fmu.magnets import magnet_strength
from plant_fmu.motor_mount import MotorMount
from plant_fmu.motor_supply import MotorSupply
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import StageDescription
from pmlsm.velocity_rows import GRAVITY, normal_acceleration, normal_terms, thrust_term


class LevelMover:
    """Accelerations of the axes by gravity and the motors, (4.3) and (5.3). See `TiltingMover` for one that tilts."""

    def __init__(self, stage: StageDescription):
        self.alike = not stage.unlike   # true if all motors are of one kind
        self.accelerations = [0.0 for _ in stage.axes]   # m/s², by axis
        self.displacements = [0.0 for _ in stage.axes]   # m, of the motors that drive an axis, by axis
        self.driven = list(range(1, len(stage.axes)))    # numbers of the horizontal axes
        self.mounts: list[MotorMount] = []             # no motor has an air gap of its own

    def push(self, axes: list[Axis], motors: list[MotorSupply], magnetics: Magnetics) -> None:
        """Compute the accelerations at the present point: the currents of motors of one kind add up."""
        if not self.alike:
            self.push_unlike(axes, motors, magnetics)
            return
        accelerations = self.accelerations
        geometry = magnetics.kinds[0].geometry
        gap = axes[0]
        f1, f2, f3, f4 = gap_functions(geometry, gap.position)
        f2 *= attraction_factor(magnetics.modulation, axes[1].position, geometry.slot_pitch)
        strength = magnet_strength(magnetics.magnet_rise)
        f1 *= strength
        f2 *= strength * strength
        f3 *= strength
        for k in self.driven:
            accelerations[k] = 0.0
        direct = 0.0    # Σ i_d, A
        squares = 0.0   # Σ(i_q² + i_d²), A²
        for motor in motors:
            i_d = motor.i_d
            i_q = motor.i_q
            direct += i_d
            squares = squares + i_q * i_q + i_d * i_d
            accelerations[motor.axis] += i_q   # A so far
        sharing = magnetics.sharing
        share = gap.mass_ratio
        accelerations[0] = normal_acceleration(
            magnetics.carrying * share * magnetics.attraction, sharing * share * magnetics.coils,
            sharing * share * magnetics.iron, f2, f3, f4, direct, squares)
        for k in self.driven:
            accelerations[k] = thrust_term(
                sharing * axes[k].mass_ratio * magnetics.thrust[k - 1], f1, accelerations[k])

    def push_unlike(self, axes: list[Axis], motors: list[MotorSupply], magnetics: Magnetics) -> None:
        """Compute the accelerations by motors of several kinds."""
        accelerations = self.accelerations
        strength = magnet_strength(magnetics.magnet_rise)
        gap = axes[0]
        sharing = magnetics.sharing
        share = sharing * gap.mass_ratio
        accelerations[0] = GRAVITY
        for k in self.driven:
            accelerations[k] = 0.0
        for motor in motors:
            kind = magnetics.kinds[magnetics.groups[motor.group].kind]
            geometry = kind.geometry
            ratio = kind.ratio
            f1, f2, f3, f4 = gap_functions(geometry, gap.position)
            f2 *= attraction_factor(magnetics.modulation, axes[1].position, geometry.slot_pitch)
            attraction, coils, iron = normal_terms(
                ratio.attraction * share * magnetics.attraction, ratio.coils * share * magnetics.coils,
                ratio.iron * share * magnetics.iron, f2 * strength * strength, f3 * strength, f4,
                motor.i_d, motor.i_q * motor.i_q + motor.i_d * motor.i_d)
            accelerations[0] += attraction + coils + iron
            driven = motor.axis
            accelerations[driven] += thrust_term(
                ratio.thrust * sharing * axes[driven].mass_ratio * magnetics.thrust[driven - 1], f1 * strength,
                motor.i_q)

    def induce(self, axes: list[Axis], motors: list[MotorSupply], magnetics: Magnetics, ahead: float) -> None:
        """Compute the voltages that the motion induces in the windings a time ahead (s)."""
        gap = axes[0]
        ahead_gap = gap.position + ahead * gap.velocity
        gap_rate = gap.velocity + ahead * gap.acceleration
        strength = magnet_strength(magnetics.magnet_rise)
        sharing = magnetics.sharing
        coils = sharing * gap.nominal_mass * magnetics.coils * strength
        iron = sharing * gap.nominal_mass * magnetics.iron
        for motor in motors:
            kind = magnetics.kinds[magnetics.groups[motor.group].kind]
            geometry = kind.geometry
            ratio = kind.ratio
            axis = axes[motor.axis]
            f1, f2, f3, f4 = gap_functions(geometry, ahead_gap)
            motor.induce(
                geometry.electrical_angle(axis.position + ahead * axis.velocity), gap_rate,
                axis.velocity + ahead * axis.acceleration,
                ratio.thrust * sharing * axis.nominal_mass * magnetics.thrust[motor.axis - 1] * strength * f1,
                ratio.coils * coils * f3, ratio.iron * iron * f4)

    def start(self) -> None:
        """Nothing: a level mover keeps no state of its own from step to step. See `TiltingMover.start`."""

    def begin(self, axes: list[Axis]) -> None:
        """Nothing: axes have all that a step begins with."""

    def resume(self, axes: list[Axis]) -> None:
        """Nothing, as in `begin`."""

    def place(self, axes: list[Axis]) -> None:
        """Put the motors where the mover has them."""
        for k in self.driven:
            self.displacements[k] = axes[k].position

    def deliver(self, axes: list[Axis], motors: list[MotorSupply], magnetics: Magnetics) -> None:
        """Nothing: only a mover that tilts has outputs."""

    def measure(self, axes: list[Axis], encoder: Encoder) -> None:
        """Nothing: the encoder of the axis measures the air gap."""

    def report(self) -> None:
        """Nothing: only a mover that tilts has outputs."""

    def first_beyond(self) -> int:
        """Number, from 1, of the first motor beyond an end stop of its own: 0, none has one."""
        return 0

    def time_to_stop(self, axes: list[Axis], dt: float) -> float:
        """Return the time (s) in which a motor meets such a stop: dt."""
        return dt

    def settle(self) -> bool:
        """Return True if a motor is at such a stop at an event."""
        return False
