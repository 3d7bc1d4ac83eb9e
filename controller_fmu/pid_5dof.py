"""PID controller of the 5-DOF stage (Figs. 4.6, 5.6): one PID for each axis, on the currents that move it."""

from controller_fmu.feedback_linearisation import equilibrium_current
from controller_fmu.force_allocation import ForceAllocation
from controller_fmu.linearisation import Linearisation
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_place import MotorPlace
from controller_fmu.pid_axis import PIDAxis
from controller_fmu.platform_5dof import measure_tilts, prepare_platform
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, BAD_PLACES, NO_EQUILIBRIUM, PREFILTER_TOO_FAST, STEP_MISFIT, STEPPED
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from controller_fmu.velocity_observer import ObserverFilter
from pmlsm.motor_geometry import MotorGeometry


class PID5DOF:
    """Samples positions, gaps and references, commands phase currents that hold until the next sample.

    y, roll and pitch follow from the gaps at the motors. The PID of y commands a direct current that
    all motors get, those of roll and pitch how it changes over the platform, in A/m.
    """

    def __init__(self) -> None:
        self.C1 = 0.6135                 # m/(s² A), parameter: thrust along x
        self.C2 = 0.8224                 # m/(s² A), parameter: thrust along z
        self.C3 = 327.5                  # m/(s² T²), parameter: attraction between magnets and iron
        self.C4 = 8.48                   # m/(s² A T), parameter: normal force between magnets and coils
        self.C5 = 0.007                  # m/(s² A²), parameter: normal force between coils and iron
        self.sample_time = 0.0002        # s, parameter
        self.setpoint = 0.025            # m, parameter: gap of the design
        self.current_limit = 0.0         # A, parameter, 0 = none
        self.antiwindup = False          # parameter
        self.trip_error = 0.0            # m, parameter, 0 = never
        self.trip_tilt = 0.0             # rad, parameter, 0 = never
        self.geometry = MotorGeometry()
        self.y = PIDAxis(-7.0, -10.0, 42.0, 0.025)
        self.x = PIDAxis(-2.0, -7.0, 15.0, 0.0)
        self.z = PIDAxis(-2.0, -7.0, 15.0, 0.0)
        self.roll = PIDAxis(-7.0, -10.0, 42.0, 0.0)
        self.pitch = PIDAxis(-7.0, -10.0, 42.0, 0.0)
        self.observer = ObserverFilter()
        self.linear = Linearisation()
        self.platform = TiltingPlatform(-0.03)
        self.tilts = TiltMeasurement()
        self.alpha1_place = MotorPlace(0.0, 0.2, 0.025)
        self.alpha2_place = MotorPlace(0.0, -0.2, 0.025)
        self.beta1_place = MotorPlace(0.2, 0.0, 0.025)
        self.beta2_place = MotorPlace(-0.2, 0.0, 0.025)
        self.allocation = ForceAllocation(6.9, 10.6, 8.6, 0.2, 0.2)
        self.clock = SampleClock()
        self.alpha1 = MotorCommand()
        self.alpha2 = MotorCommand()
        self.beta1 = MotorCommand()
        self.beta2 = MotorCommand()
        self.started = False    # state: a measurement has come in
        self.saturated = False  # output
        self.feasible = True    # output; a current is always commanded
        self.tripped = False    # state and output
        self.start()            # the gains of the design are start values

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        self.observer.prepare(self.sample_time)
        if not prepare_platform(self.platform, self.alpha1_place, self.alpha2_place, self.beta1_place,
                                self.beta2_place):
            return BAD_PLACES
        if not (self.y.filterable(self.sample_time) and self.x.filterable(self.sample_time)
                and self.z.filterable(self.sample_time) and self.roll.filterable(self.sample_time)
                and self.pitch.filterable(self.sample_time)):
            return PREFILTER_TOO_FAST
        if not self.linear.prepare(self.geometry, 4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5, self.setpoint):
            return NO_EQUILIBRIUM
        stiffness = self.linear.stiffness
        gain = self.linear.gain
        roll_ratio = self.allocation.roll_ratio(self.platform)
        pitch_ratio = self.allocation.pitch_ratio(self.platform)
        self.y.design(stiffness, gain)
        self.x.design(0.0, -2.0 * self.C1 * self.linear.f1)
        self.z.design(0.0, -2.0 * self.C2 * self.linear.f1)
        self.roll.design(roll_ratio * stiffness, roll_ratio * gain)
        self.pitch.design(pitch_ratio * stiffness, pitch_ratio * gain)
        return STEPPED

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
        if not self.started:
            tilts.clear()
            tilts.add(alpha1_place, self.holding_current(alpha1_place))
            tilts.add(alpha2_place, self.holding_current(alpha2_place))
            tilts.add(beta1_place, self.holding_current(beta1_place))
            tilts.add(beta2_place, self.holding_current(beta2_place))
            y.start(tilts.y)
            x.start(0.0)
            z.start(0.0)
            roll.start(tilts.roll)
            pitch.start(tilts.pitch)
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
            return
        along_x = platform.along_x(x.measured, pitch.measured)
        along_z = platform.along_z(z.measured, roll.measured)
        self.drive(alpha1, alpha1_place, x.current(), along_x)
        self.drive(alpha2, alpha2_place, x.current(), along_x)
        self.drive(beta1, beta1_place, z.current(), along_z)
        self.drive(beta2, beta2_place, z.current(), along_z)
        self.saturated = alpha1.limited or alpha2.limited or beta1.limited or beta2.limited
        held = alpha1.excess_d != 0.0 or alpha2.excess_d != 0.0 or beta1.excess_d != 0.0 or beta2.excess_d != 0.0
        y.update(self.sample_time, self.antiwindup and held)
        x.update(self.sample_time, self.antiwindup and (alpha1.excess_q != 0.0 or alpha2.excess_q != 0.0))
        z.update(self.sample_time, self.antiwindup and (beta1.excess_q != 0.0 or beta2.excess_q != 0.0))
        roll.update(self.sample_time, self.antiwindup and held)
        pitch.update(self.sample_time, self.antiwindup and held)

    def holding_current(self, place: MotorPlace) -> float:
        """Direct current (A) by which a motor carries its part at its gap."""
        current, found = equilibrium_current(self.geometry, 4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5,
                                             place.gap_measured)
        return current

    def drive(self, motor: MotorCommand, place: MotorPlace, i_q: float, displacement: float) -> None:
        """Command a motor its direct current, a quadrature current (A) and a displacement (m) at the magnets' faces."""
        i_d = place.moved(self.y.current(), self.roll.current(), self.pitch.current())
        motor.command(i_d, i_q, self.current_limit, self.geometry.electrical_angle(displacement))
