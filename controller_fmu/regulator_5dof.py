"""Regulators of the 5-DOF stage (4.15), (4.16), (5.13): output regulation, feedback-linearised or linearised."""

from math import pi

from controller_fmu.force_allocation import ForceAllocation
from controller_fmu.gain_point import GainPoint
from controller_fmu.gain_table import GainTable
from controller_fmu.internal_model import OscillatorStep
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_place import MotorPlace
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.platform_5dof import measure_tilts, prepare_platform
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import (
    BAD_GEOMETRY,
    BAD_PLACES,
    INTERPOLATED,
    LINEAR,
    NO_EQUILIBRIUM,
    NONLINEAR,
    STEP_MISFIT,
    STEPPED,
)
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from controller_fmu.velocity_observer import ObserverFilter
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.motor_geometry import MotorGeometry


class Regulator5DOF:
    """Samples positions, gaps and references, commands phase currents that hold until the next sample.

    The law is NONLINEAR: each motor is feedback-linearised at its own gap (4.12), (5.7). Or LINEAR: the motors are
    linearised about the setpoint without tilt such that the closed loop has the same poles there (sections 4.6.1,
    5.6.3). Or INTERPOLATED: each motor about the equilibrium at its own gap, from a fine table, with its current fed
    forward. y, roll and pitch follow from the gaps at the motors; what they demand is split evenly over the motors.
    """

    def __init__(self, law: int = NONLINEAR):
        self.law = law
        self.C1 = 0.6135                 # m/(s² A), parameter: thrust along x
        self.C2 = 0.8224                 # m/(s² A), parameter: thrust along z
        self.C3 = 327.5                  # m/(s² T²), parameter: attraction between magnets and iron
        self.C4 = 8.48                   # m/(s² A T), parameter: normal force between magnets and coils
        self.C5 = 0.007                  # m/(s² A²), parameter: normal force between coils and iron
        self.sample_time = 0.0002        # s, parameter
        self.omega0 = 1.5 * pi           # rad/s, parameter
        self.setpoint = 0.025            # m, parameter of the linear law: gap of its linearisation
        self.bumpless = True             # parameter of the linear law
        self.current_limit = 4.0         # A, parameter, 0 = none
        self.antiwindup = True           # parameter
        self.trip_error = 0.0            # m, parameter, 0 = never
        self.trip_tilt = 0.0             # rad, parameter, 0 = never
        self.geometry = MotorGeometry()
        self.y = OutputRegulator(-1274.0, -104.0, -50001.0, -3936.0, -7774.0, 1e-05, 0.025)
        self.x = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 0.00011, 0.0)
        self.z = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 0.000125, 0.0)
        self.roll = OutputRegulator(-1274.0, -104.0, -50001.0, -3936.0, -7774.0, 1e-05, 0.0)
        self.pitch = OutputRegulator(-1274.0, -104.0, -50001.0, -3936.0, -7774.0, 1e-05, 0.0)
        self.observer = ObserverFilter()
        self.oscillator = OscillatorStep()
        self.platform = TiltingPlatform(-0.03)
        self.tilts = TiltMeasurement()
        self.alpha1_place = MotorPlace(0.0, 0.2, 0.025)
        self.alpha2_place = MotorPlace(0.0, -0.2, 0.025)
        self.beta1_place = MotorPlace(0.2, 0.0, 0.025)
        self.beta2_place = MotorPlace(-0.2, 0.0, 0.025)
        self.allocation = ForceAllocation(6.9, 10.6, 8.6, 0.2, 0.2)
        self.short = TiltMeasurement()   # of the direct currents
        self.table = GainTable(0.018, 0.001)
        self.here = GainPoint()   # what counts at the gap
        self.scale = 1.0          # its gain, by that of the middle of the table
        self.clock = SampleClock()
        self.alpha1 = MotorCommand()
        self.alpha2 = MotorCommand()
        self.beta1 = MotorCommand()
        self.beta2 = MotorCommand()
        self.alpha1_law = VerticalLaw(law)
        self.alpha2_law = VerticalLaw(law)
        self.beta1_law = VerticalLaw(law)
        self.beta2_law = VerticalLaw(law)
        self.started = False    # state: a measurement has come in
        self.saturated = False  # output
        self.feasible = True    # output
        self.tripped = False    # state and output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        self.observer.prepare(self.sample_time)
        self.oscillator.prepare(self.omega0, self.sample_time)
        if not prepare_platform(self.platform, self.alpha1_place, self.alpha2_place, self.beta1_place,
                                self.beta2_place):
            return BAD_PLACES
        self.take_constants()
        if self.law != NONLINEAR:
            self.allocation.weight = 0.0   # the demands are about the equilibrium
        if self.law == LINEAR and not (self.alpha1_law.linearise(self.geometry, self.setpoint)
                                       and self.alpha2_law.linearise(self.geometry, self.setpoint)
                                       and self.beta1_law.linearise(self.geometry, self.setpoint)
                                       and self.beta2_law.linearise(self.geometry, self.setpoint)):
            return NO_EQUILIBRIUM
        law = self.alpha1_law
        if self.law == INTERPOLATED and not self.table.prepare(self.geometry, law.attraction, law.coils, law.iron):
            return NO_EQUILIBRIUM
        return STEPPED

    def take_constants(self) -> None:
        """Hand the constants to the law of each motor, as though all motors were like it."""
        self.alpha1_law.take_constants(4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5)
        self.alpha2_law.take_constants(4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5)
        self.beta1_law.take_constants(4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5)
        self.beta2_law.take_constants(4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5)

    def step(self, t: float, dt: float) -> int:
        """Sample if the sampling grid has a point at t; the commands hold over t to t + dt (s)."""
        if not self.clock.fits(dt, self.sample_time):
            return STEP_MISFIT
        if self.clock.due(dt, self.sample_time):
            self.sample()
        return STEPPED

    def sample(self) -> None:
        """Run the law once."""
        y = self.y
        x = self.x
        z = self.z
        roll = self.roll
        pitch = self.pitch
        platform = self.platform
        tilts = self.tilts
        alpha1_place = self.alpha1_place
        alpha2_place = self.alpha2_place
        beta1_place = self.beta1_place
        beta2_place = self.beta2_place
        seen = measure_tilts(tilts, alpha1_place, alpha2_place, beta1_place, beta2_place)
        if not (self.started or seen):
            return   # an importer that has not exchanged values yet: this is no measurement
        y.measured = tilts.y
        roll.measured = tilts.roll
        pitch.measured = tilts.pitch
        self.take_constants()
        if self.law == INTERPOLATED:
            self.table.choose(y.measured, self.here)
            # Between samples ξ1 stands for a current: what it commands does not change with the gain.
            self.scale = self.table.scale(self.here)
            y.rescale(self.scale)
            roll.rescale(self.scale)
            pitch.rescale(self.scale)
        if not self.started:
            # Not bumpless, it begins as though the platform rested at the setpoint.
            y.start(self.holding_demand(), y.measured - y.reference if self.bumpless else 0.0)
            x.start(0.0, x.measured - x.reference if self.bumpless else 0.0)
            z.start(0.0, z.measured - z.reference if self.bumpless else 0.0)
            roll.start(0.0, roll.measured - roll.reference if self.bumpless else 0.0)
            pitch.start(0.0, pitch.measured - pitch.reference if self.bumpless else 0.0)
            self.started = True
        y.sample(self.observer, self.sample_time)
        x.sample(self.observer, self.sample_time)
        z.sample(self.observer, self.sample_time)
        roll.sample(self.observer, self.sample_time)
        pitch.sample(self.observer, self.sample_time)
        if (exceeds(y.error, self.trip_error) or exceeds(x.error, self.trip_error)
                or exceeds(z.error, self.trip_error) or exceeds(roll.error, self.trip_tilt)
                or exceeds(pitch.error, self.trip_tilt)):
            self.tripped = True
        alpha1 = self.alpha1
        alpha2 = self.alpha2
        beta1 = self.beta1
        beta2 = self.beta2
        if self.tripped:
            alpha1.release()
            alpha2.release()
            beta1.release()
            beta2.release()
            self.saturated = False
            self.feasible = True   # nothing is demanded any more
            return
        x_demand = x.demand()
        z_demand = z.demand()
        self.allocation.demand(platform, y.demand(), x_demand, z_demand, roll.demand(), pitch.demand())
        along_x = platform.along_x(x.measured, pitch.measured)
        along_z = platform.along_z(z.measured, roll.measured)
        self.drive(alpha1, alpha1_place, self.alpha1_law, x_demand, 2.0 * self.C1, along_x)
        self.drive(alpha2, alpha2_place, self.alpha2_law, x_demand, 2.0 * self.C1, along_x)
        self.drive(beta1, beta1_place, self.beta1_law, z_demand, 2.0 * self.C2, along_z)
        self.drive(beta2, beta2_place, self.beta2_law, z_demand, 2.0 * self.C2, along_z)
        self.feasible = (self.alpha1_law.feasible and self.alpha2_law.feasible and self.beta1_law.feasible
                         and self.beta2_law.feasible)
        self.saturated = alpha1.limited or alpha2.limited or beta1.limited or beta2.limited
        short = self.short
        short.clear()
        short.add(alpha1_place, alpha1.excess_d)
        short.add(alpha2_place, alpha2.excess_d)
        short.add(beta1_place, beta1.excess_d)
        short.add(beta2_place, beta2.excess_d)
        antiwindup_time = self.sample_time if self.antiwindup else 0.0
        y.update(self.oscillator, antiwindup_time * short.y)
        x.update(self.oscillator, antiwindup_time * 0.5 * (alpha1.excess_q + alpha2.excess_q))
        z.update(self.oscillator, antiwindup_time * 0.5 * (beta1.excess_q + beta2.excess_q))
        roll.update(self.oscillator, antiwindup_time * short.roll)
        pitch.update(self.oscillator, antiwindup_time * short.pitch)
        if self.law == INTERPOLATED:
            y.rescale(1.0 / self.scale)
            roll.rescale(1.0 / self.scale)
            pitch.rescale(1.0 / self.scale)

    def holding_demand(self) -> float:
        """Demand of y (m/s²) by which the currents hold the platform where it is, or without tilt at the setpoint."""
        tilts = self.tilts
        tilts.clear()
        tilts.add(self.alpha1_place, self.held(self.alpha1_place, self.alpha1_law))
        tilts.add(self.alpha2_place, self.held(self.alpha2_place, self.alpha2_law))
        tilts.add(self.beta1_place, self.held(self.beta1_place, self.beta1_law))
        tilts.add(self.beta2_place, self.held(self.beta2_place, self.beta2_law))
        return tilts.y

    def held(self, place: MotorPlace, law: VerticalLaw) -> float:
        """Demand (m/s²) of a motor by which it carries its part."""
        if not self.bumpless:
            return law.holding_demand(self.geometry, self.setpoint, 0.0)
        return law.holding_demand(self.geometry, place.gap_measured, self.gap_error(place))

    def gap_error(self, place: MotorPlace) -> float:
        """Error of the gap at a motor, m."""
        return place.gap_measured - place.moved(self.y.reference, self.roll.reference, self.pitch.reference)

    def drive(self, motor: MotorCommand, place: MotorPlace, law: VerticalLaw, demand: float, thrust: float,
              displacement: float) -> None:
        """Command a motor.

        Parameters
        ----------
        motor, place, law : MotorCommand, MotorPlace, VerticalLaw
            Of the motor.
        demand : float
            Acceleration of the axis that it drives, m/s².
        thrust : float
            Constant of all motors that drive it, m/(s² A).
        displacement : float
            At the faces of the magnets, m.
        """
        if self.law == INTERPOLATED:
            self.table.choose(place.gap_measured, self.here)
            law.take(self.here)
        law.look(self.geometry, place.gap_measured)
        i_q = -demand / (thrust * law.f1)
        i_d = law.direct_current(self.allocation.demand_at(place), self.gap_error(place), law.iron * law.f4 * i_q * i_q)
        motor.command(i_d, i_q, self.current_limit, self.geometry.electrical_angle(displacement))
