"""PID controller of the 3-DOF stage (Figs. 4.6, 5.6): one PID for each axis, on the current that drives it."""

from controller_fmu.feedback_linearisation import equilibrium_current
from controller_fmu.linearisation import Linearisation
from controller_fmu.motor_command import MotorCommand
from controller_fmu.pid_axis import PIDAxis
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, NO_EQUILIBRIUM, PREFILTER_TOO_FAST, STEP_MISFIT, STEPPED
from controller_fmu.velocity_observer import ObserverFilter
from pmlsm.motor_geometry import MotorGeometry


class PID3DOF:
    """Samples positions and references, commands phase currents that hold until the next sample.

    All motors get the direct current of the y-axis.
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
        self.geometry = MotorGeometry()
        self.y = PIDAxis(-7.0, -10.0, 42.0, 0.025)
        self.x = PIDAxis(-2.0, -7.0, 15.0, 0.0)
        self.z = PIDAxis(-2.0, -7.0, 15.0, 0.0)
        self.observer = ObserverFilter()
        self.linear = Linearisation()
        self.clock = SampleClock()
        self.alpha = MotorCommand()
        self.beta = MotorCommand()
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
        if not (self.y.filterable(self.sample_time) and self.x.filterable(self.sample_time)
                and self.z.filterable(self.sample_time)):
            return PREFILTER_TOO_FAST
        if not self.linear.prepare(self.geometry, 4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5, self.setpoint):
            return NO_EQUILIBRIUM
        self.y.design(self.linear.stiffness, self.linear.gain)
        self.x.design(0.0, -2.0 * self.C1 * self.linear.f1)
        self.z.design(0.0, -2.0 * self.C2 * self.linear.f1)
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
        if not self.started:
            if y.measured <= 0.0:
                return   # an importer that has not exchanged values yet: this is no measurement
            current, found = equilibrium_current(self.geometry, 4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5, y.measured)
            y.start(current)
            x.start(0.0)
            z.start(0.0)
            self.started = True
        y.sample(self.observer, self.sample_time)
        x.sample(self.observer, self.sample_time)
        z.sample(self.observer, self.sample_time)
        if exceeds(y.error, self.trip_error) or exceeds(x.error, self.trip_error) or exceeds(z.error, self.trip_error):
            self.tripped = True
        alpha = self.alpha
        beta = self.beta
        if self.tripped:
            alpha.release()
            beta.release()
            self.saturated = False
            return
        i_d = y.current()
        alpha.command(i_d, x.current(), self.current_limit, self.geometry.electrical_angle(x.measured))
        beta.command(i_d, z.current(), self.current_limit, self.geometry.electrical_angle(z.measured))
        self.saturated = alpha.limited or beta.limited
        y.update(self.sample_time, self.antiwindup and alpha.excess_d != 0.0)
        x.update(self.sample_time, self.antiwindup and alpha.excess_q != 0.0)
        z.update(self.sample_time, self.antiwindup and beta.excess_q != 0.0)
