"""PID controller of the 2-DOF stage (Figs. 4.6, 5.6): one PID for each axis, on the current that drives it."""

from controller_fmu.feedback_linearisation import equilibrium_current
from controller_fmu.linearisation import Linearisation
from controller_fmu.motor_command import MotorCommand
from controller_fmu.pid_axis import PIDAxis
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, NO_EQUILIBRIUM, PREFILTER_TOO_FAST, STEP_MISFIT, STEPPED
from controller_fmu.velocity_observer import ObserverFilter
from pmlsm.motor_geometry import MotorGeometry


class PID2DOF:
    """Samples positions and references, commands phase currents that hold until the next sample.

    All motors get the direct current of the v-axis.
    """

    def __init__(self) -> None:
        self.C1 = 14.2                   # m/(s² A), parameter: thrust along h
        self.C2 = 796.99                 # m/(s² T²), parameter: attraction between magnets and iron
        self.C3 = 31.04                  # m/(s² A T), parameter: normal force between magnets and coils
        self.C4 = 0.07                   # m/(s² A²), parameter: normal force between coils and iron
        self.sample_time = 0.0005        # s, parameter
        self.setpoint = 0.02             # m, parameter: gap of the design
        self.current_limit = 4.0         # A, parameter, 0 = none
        self.antiwindup = False          # parameter
        self.trip_error = 0.0            # m, parameter, 0 = never
        self.geometry = MotorGeometry()
        self.v = PIDAxis(-8.0, -12.0, 50.0, 0.02)
        self.h = PIDAxis(-6.0, -16.0, 46.0, 0.0)
        self.observer = ObserverFilter()
        self.linear = Linearisation()
        self.clock = SampleClock()
        self.motor = MotorCommand()
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
        if not (self.v.filterable(self.sample_time) and self.h.filterable(self.sample_time)):
            return PREFILTER_TOO_FAST
        if not self.linear.prepare(self.geometry, self.C2, self.C3, self.C4, self.setpoint):
            return NO_EQUILIBRIUM
        self.v.design(self.linear.stiffness, self.linear.gain)
        self.h.design(0.0, -self.C1 * self.linear.f1)
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
        v = self.v
        h = self.h
        if not self.started:
            if v.measured <= 0.0:
                return   # an importer that has not exchanged values yet: this is no measurement
            current, found = equilibrium_current(self.geometry, self.C2, self.C3, self.C4, v.measured)
            v.start(current)
            h.start(0.0)
            self.started = True
        v.sample(self.observer, self.sample_time)
        h.sample(self.observer, self.sample_time)
        if exceeds(v.error, self.trip_error) or exceeds(h.error, self.trip_error):
            self.tripped = True
        motor = self.motor
        if self.tripped:
            motor.release()
            self.saturated = False
            return
        i_d = v.current()
        motor.command(i_d, h.current(), self.current_limit, self.geometry.electrical_angle(h.measured))
        self.saturated = motor.limited
        v.update(self.sample_time, self.antiwindup and motor.excess_d != 0.0)
        h.update(self.sample_time, self.antiwindup and motor.excess_q != 0.0)
