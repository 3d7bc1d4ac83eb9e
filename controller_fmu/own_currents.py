"""Currents of a level stage whose motors differ: each has its own direct current."""

from controller_fmu.level_platform import LevelPlatform
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_model import MotorModel
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.stage_description import StageDescription


class OwnCurrents:
    """A vertical law for each motor. Under a nonlinear one all carry the same, else they share changes evenly."""

    def __init__(self, stage: StageDescription, law: int):
        self.laws = [VerticalLaw(law) for _ in stage.motors]
        self.demands = [0.0 for _ in stage.axes]   # m/s², with which the axes begin
        self.short = [0.0 for _ in stage.axes]     # A s: share of an axis's current that the limit cuts off
        self.share = 1.0 / len(stage.motors)
        # of one of an axis's motors
        self.shares = [1.0 / len(stage.motors_of(axis.name)) for axis in stage.horizontal]

    def prepare(self) -> None:
        """Make ready for a start."""

    def take_constants(self, model: MotorModel) -> None:
        """Hand the constants to the law of each motor, as though all motors were like it."""
        for number, law in enumerate(self.laws):
            attraction, coils, iron = model.carried(model.layout.kind[number])
            law.take_constants(attraction, coils, iron)

    def linearise(self, model: MotorModel, setpoint: float) -> bool:
        """Linearise the motors about a setpoint (m); return True if there is an equilibrium for each."""
        for law, kind in zip(self.laws, model.layout.kind, strict=True):
            if not law.linearise(model.layout.kinds[kind].geometry, setpoint):
                return False
        return True

    def tabulate(self, model: MotorModel) -> bool:
        """Return True: motors that differ have no schedule and no table."""
        return True

    def look(self, gap: float) -> float:
        """Return 1: the laws have the same gains at every gap (m)."""
        return 1.0

    def hold(self, axes: list[OutputRegulator], model: MotorModel, platform: LevelPlatform, setpoint: float,
             bumpless: bool) -> None:
        """Compute the demands by which the mover is held where it is; not bumpless, at the setpoint (m)."""
        gap = axes[0].measured if bumpless else setpoint
        error = axes[0].measured - axes[0].reference if bumpless else 0.0
        demand = 0.0
        for law, kind in zip(self.laws, model.layout.kind, strict=True):
            demand += law.holding_demand(model.layout.kinds[kind].geometry, gap, error)
        self.demands[0] = self.share * demand

    def command(self, axes: list[OutputRegulator], motors: list[MotorCommand], model: MotorModel,
                platform: LevelPlatform, limit: float) -> bool:
        """Command the currents that the axes demand, within a limit (A, 0 = none).

        Return True if the demand is feasible.
        """
        layout = model.layout
        gap = axes[0]
        demand = gap.demand()
        feasible = True
        for number, motor in enumerate(motors):
            law = self.laws[number]
            kind = layout.kinds[layout.kind[number]]
            k = layout.drives[number]
            axis = axes[k + 1]
            law.look(kind.geometry, gap.measured)
            i_q = -axis.demand() / (kind.ratio.thrust * model.driving[k] * model.thrust[k] * law.f1)
            i_d = law.direct_current(demand, gap.error, law.iron * law.f4 * i_q * i_q)
            motor.command(i_d, i_q, kind.ratio.limit * limit, kind.geometry.electrical_angle(axis.measured))
            if not law.feasible:
                feasible = False
        return feasible

    def compare(self, motors: list[MotorCommand], model: MotorModel, platform: LevelPlatform, time: float) -> bool:
        """Compute the currents cut off by the limit, times the time of a sample (s); return True if it cut off any.

        The time is 0 without antiwindup.
        """
        short = self.short
        limited = False
        for k in range(len(short)):
            short[k] = 0.0
        for number, motor in enumerate(motors):
            short[0] += motor.excess_d
            short[model.layout.drives[number] + 1] += motor.excess_q
            if motor.limited:
                limited = True
        short[0] = time * self.share * short[0]
        for k, share in enumerate(self.shares):
            short[k + 1] = time * share * short[k + 1]
        return limited
