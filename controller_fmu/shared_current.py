"""Currents of a level stage whose motors are alike: all get the same direct current (4.12), (5.7)."""

from controller_fmu.fixed_gains import FixedGains
from controller_fmu.gain_schedule import GainSchedule
from controller_fmu.gain_table import GainTable
from controller_fmu.level_platform import LevelPlatform
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_model import MotorModel
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.stage_description import StageDescription


class SharedCurrent:
    """One vertical law for all motors, and the quadrature current of each axis for the motors that drive it."""

    def __init__(self, stage: StageDescription, law: int, gains: FixedGains | GainSchedule | GainTable):
        self.vertical = VerticalLaw(law)
        self.gains = gains
        self.i_q = [0.0 for _ in stage.horizontal]         # A, by axis
        self.demands = [0.0 for _ in stage.axes]           # m/s², with which the axes begin
        self.short = [0.0 for _ in stage.axes]             # A s: share of an axis's current that the limit cuts off
        horizontal = [axis.name for axis in stage.horizontal]
        motors = [motor.drives for motor in stage.motors]
        self.first = [motors.index(axis) for axis in horizontal]   # motor of each axis: the others do as it does
        self.driven = [k for k, axis in enumerate(horizontal) for _ in stage.motors_of(axis)]   # axes, for each motor

    def prepare(self) -> None:
        """Make ready for a start."""

    def take_constants(self, model: MotorModel) -> None:
        """Hand the constants to the vertical law: all motors attract, and one direct current flows in them."""
        carrying = model.carrying
        self.vertical.take_constants(carrying * model.attraction, carrying * model.coils, carrying * model.iron)

    def linearise(self, model: MotorModel, setpoint: float) -> bool:
        """Linearise the motors about a setpoint (m); return True if there is an equilibrium."""
        return self.vertical.linearise(model.layout.kinds[0].geometry, setpoint)

    def tabulate(self, model: MotorModel) -> bool:
        """Linearise the motors at the gaps of a schedule or a table; return True if there is an equilibrium at each."""
        vertical = self.vertical
        return self.gains.prepare(model.layout.kinds[0].geometry, vertical.attraction, vertical.coils, vertical.iron)

    def look(self, gap: float) -> float:
        """Choose what the law has at the measured gap (m); returns its gain by that of the middle of a table."""
        return self.gains.choose(gap, self.vertical)

    def hold(self, axes: list[OutputRegulator], model: MotorModel, platform: LevelPlatform, setpoint: float,
             bumpless: bool) -> None:
        """Compute the demands by which the mover is held where it is; not bumpless, at the setpoint (m)."""
        gap = axes[0].measured if bumpless else setpoint
        error = axes[0].measured - axes[0].reference if bumpless else 0.0
        self.demands[0] = self.vertical.holding_demand(model.layout.kinds[0].geometry, gap, error)

    def command(self, axes: list[OutputRegulator], motors: list[MotorCommand], model: MotorModel,
                platform: LevelPlatform, limit: float) -> bool:
        """Command the currents that the axes demand, within a limit (A, 0 = none).

        Return True if the demand is feasible.
        """
        vertical = self.vertical
        layout = model.layout
        geometry = layout.kinds[0].geometry
        i_q = self.i_q
        gap = axes[0]
        vertical.look(geometry, gap.measured)
        for k, thrust in enumerate(model.thrust):
            i_q[k] = -axes[k + 1].demand() / (model.driving[k] * thrust * vertical.f1)
        iron = layout.sharing * model.iron * vertical.f4
        if len(motors) == 1:
            taken = iron * i_q[0] * i_q[0]
        else:
            squares = 0.0
            for k in self.driven:
                squares += i_q[k] * i_q[k]
            taken = iron * squares
        i_d = vertical.direct_current(gap.demand(), gap.error, taken)
        for number, motor in enumerate(motors):
            k = layout.drives[number]
            motor.command(i_d, i_q[k], limit, geometry.electrical_angle(axes[k + 1].measured))
        return vertical.feasible

    def compare(self, motors: list[MotorCommand], model: MotorModel, platform: LevelPlatform, time: float) -> bool:
        """Compute the currents cut off by the limit, times the time of a sample (s); return True if it cut off any.

        The time is 0 without antiwindup.
        """
        short = self.short
        limited = False
        short[0] = time * motors[0].excess_d
        for k, first in enumerate(self.first):
            motor = motors[first]
            short[k + 1] = time * motor.excess_q
            if motor.limited:
                limited = True
        return limited
