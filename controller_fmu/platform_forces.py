"""Currents of a platform that tilts: its motors split forces and torques evenly, each at its own air gap."""

from controller_fmu.described_platform import allocation_of
from controller_fmu.fixed_gains import FixedGains
from controller_fmu.gain_schedule import GainSchedule
from controller_fmu.gain_table import GainTable
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_model import MotorModel
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.status import INTERPOLATED, NONLINEAR
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.stage_description import StageDescription
from pmlsm.velocity_rows import GRAVITY


class PlatformForces:
    """A vertical law for each motor, and the allocation of the forces."""

    def __init__(self, stage: StageDescription, law: int, gains: FixedGains | GainSchedule | GainTable):
        self.law = law
        self.laws = [VerticalLaw(law) for _ in stage.motors]
        self.centre = VerticalLaw(law)                    # of a motor at the centre of the platform
        self.gains = gains
        self.allocation = allocation_of(stage)
        self.unlike = len(stage.unlike) > 0
        # Values of y, x, z, roll, pitch; directions that guides hold stay 0.
        self.places = [0, 1, 2, 3, 4] if len(stage.horizontal) == 2 else [0, 1, 3]   # of each axis among them
        self.wanted = [0.0, 0.0, 0.0, 0.0, 0.0]           # m/s², rad/s², demands
        self.goal = [0.0, 0.0, 0.0, 0.0, 0.0]             # m, rad, references
        self.held = TiltMeasurement()
        self.missing = TiltMeasurement()                  # of the direct currents
        self.demands = [0.0 for _ in stage.axes]            # m/s², rad/s², with which the axes begin
        self.short = [0.0 for _ in stage.axes]              # A s: share of an axis's current cut off by the limit
        # of one of an axis's motors
        self.shares = [1.0 / len(stage.motors_of(axis.name)) for axis in stage.horizontal]

    def prepare(self) -> None:
        """Make ready for a start: the demands of a law about an equilibrium are about it."""
        if self.law != NONLINEAR:
            self.allocation.weight = 0.0

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
        """Linearise the motors at the gaps of a table; return True if there is an equilibrium at each."""
        law = self.laws[0]
        return self.gains.prepare(model.layout.kinds[0].geometry, law.attraction, law.coils, law.iron)

    def look(self, gap: float) -> float:
        """Choose what a law has at the centre's gap (m); returns its gain by that of the middle of a table."""
        return self.gains.choose(gap, self.centre)

    def hold(self, axes: list[OutputRegulator], model: MotorModel, platform: TiltingPlatform, setpoint: float,
             bumpless: bool) -> None:
        """Compute the demands by which the platform is held where it is; not bumpless, at the setpoint (m)."""
        allocation = self.allocation
        held = self.held
        held.clear()
        goal = self.goal
        for axis, number in zip(axes, self.places, strict=True):
            goal[number] = axis.reference
        if self.unlike:
            allocation.demand(platform, 0.0, 0.0, 0.0, 0.0, 0.0)
        for place, law, kind in zip(platform.places, self.laws, model.layout.kind, strict=True):
            geometry = model.layout.kinds[kind].geometry
            gap = place.gap_measured if bumpless else setpoint
            error = gap - place.moved(goal[0], goal[3], goal[4]) if bumpless else 0.0
            if self.unlike:   # each carries its share of the level platform
                left = GRAVITY - platform.motors * place.share_y * GRAVITY
                allocation.gather(held, place, law.carrying_demand(geometry, gap, error, left))
            else:
                held.add(place, law.holding_demand(geometry, gap, error))
        self.demands[0] = held.y
        if self.unlike:
            first = platform.horizontal + 1
            self.demands[first] = held.roll
            if platform.horizontal == 2:
                self.demands[first + 1] = held.pitch

    def command(self, axes: list[OutputRegulator], motors: list[MotorCommand], model: MotorModel,
                platform: TiltingPlatform, limit: float) -> bool:
        """Command the currents that the axes demand, within a limit (A, 0 = none).

        Return True if the demand is feasible.
        """
        layout = model.layout
        allocation = self.allocation
        wanted = self.wanted
        goal = self.goal
        for k, axis in enumerate(axes):
            number = self.places[k]
            wanted[number] = axis.demand()
            goal[number] = axis.reference
        allocation.demand(platform, wanted[0], wanted[1], wanted[2], wanted[3], wanted[4])
        y = goal[0]
        roll = goal[3]
        pitch = goal[4]
        feasible = True
        for number, motor in enumerate(motors):
            law = self.laws[number]
            place = platform.places[number]
            kind = layout.kinds[layout.kind[number]]
            k = layout.drives[number]
            gap = place.gap_measured
            if self.law == INTERPOLATED:
                self.gains.choose(gap, law)
            law.look(kind.geometry, gap)
            i_q = -wanted[k + 1] / (kind.ratio.thrust * model.driving[k] * model.thrust[k] * law.f1)
            i_d = law.direct_current(allocation.demand_at(place), gap - place.moved(y, roll, pitch),
                                     law.iron * law.f4 * i_q * i_q)
            motor.command(i_d, i_q, kind.ratio.limit * limit,
                          kind.geometry.electrical_angle(platform.along(k, axes[k + 1].measured)))
            if not law.feasible:
                feasible = False
        return feasible

    def compare(self, motors: list[MotorCommand], model: MotorModel, platform: TiltingPlatform, time: float) -> bool:
        """Compute the currents cut off by the limit, times the time of a sample (s); return True if it cut off any.

        The time is 0 without antiwindup.
        """
        short = self.short
        limited = False
        missing = self.missing
        missing.clear()
        for k in range(len(short)):
            short[k] = 0.0
        for number, motor in enumerate(motors):
            missing.add(platform.places[number], motor.excess_d)
            short[model.layout.drives[number] + 1] += motor.excess_q
            if motor.limited:
                limited = True
        for k, share in enumerate(self.shares):
            short[k + 1] = time * share * short[k + 1]
        short[0] = time * missing.y
        first = platform.horizontal + 1
        short[first] = time * missing.roll
        if platform.horizontal == 2:
            short[first + 1] = time * missing.pitch
        return limited
