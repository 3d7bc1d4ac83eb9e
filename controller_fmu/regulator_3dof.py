"""Regulators of the 3-DOF stage with antiwindup (5.10), (5.11), (5.13): feedback-linearised, linearised, scheduled."""

from math import pi

from controller_fmu.gain_schedule import GainSchedule
from controller_fmu.internal_model import OscillatorStep
from controller_fmu.motor_command import MotorCommand
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import LINEAR, NO_EQUILIBRIUM, NONLINEAR, SCHEDULED, STEP_MISFIT, STEPPED
from controller_fmu.velocity_observer import ObserverFilter
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.data_sheet import MOTORS_3DOF, MOTORS_IN_PAIR, SAMPLE_TIME_3DOF


class Regulator3DOF:
    """Samples positions and references, commands phase currents that hold until the next sample.

    The law is NONLINEAR, with the motors feedback-linearised at the measured gap (5.7); LINEAR, with the motors
    linearised about the set-point such that the closed loop has the same poles there (section 5.6.3); or SCHEDULED,
    linear about the set-point of the region that the measured gap lies in (Table 5.4). Both pairs get the same direct
    current, which takes the redundancy out of (5.2).
    """

    def __init__(self, law: int = NONLINEAR):
        self.law = law
        self.C1 = 0.6135        # m/(s² A), parameter: thrust along x
        self.C2 = 0.8224        # m/(s² A), parameter: thrust along z
        self.C3 = 327.50        # m/(s² T²), parameter: attraction
        self.C4 = 8.48          # m/(s² A T), parameter: magnets on coils
        self.C5 = 0.0070        # m/(s² A²), parameter: coils on iron
        self.sample_time = SAMPLE_TIME_3DOF   # s, parameter
        self.omega0 = 1.5 * pi  # rad/s, parameter
        self.setpoint = 25.0e-3               # m, parameter of the linear law: gap of its linearisation
        self.bumpless = True                  # parameter of the linear law
        self.current_limit = 4.0              # A, parameter, 0 = none
        self.antiwindup = True                # parameter
        self.trip_error = 0.0                 # m, parameter, 0 = never
        self.y = OutputRegulator(-1274.0, -104.0, -50001.0, -3936.0, -7774.0, 1.0e-5, 25.0e-3)
        self.x = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 1.1e-4, 0.0)
        self.z = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 1.25e-4, 0.0)
        self.observer = ObserverFilter()
        self.oscillator = OscillatorStep()
        self.vertical = VerticalLaw(law)
        self.schedule = GainSchedule()
        self.clock = SampleClock()
        self.alpha = MotorCommand()
        self.beta = MotorCommand()
        self.started = False    # state: a measurement has come in
        self.saturated = False  # output
        self.feasible = True    # output
        self.tripped = False    # state and output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        self.observer.prepare(self.sample_time)
        self.oscillator.prepare(self.omega0, self.sample_time)
        self.take_constants()
        vertical = self.vertical
        if self.law == LINEAR and not vertical.linearise(self.setpoint):
            return NO_EQUILIBRIUM
        if self.law == SCHEDULED and not self.schedule.prepare(vertical.attraction, vertical.coils, vertical.iron):
            return NO_EQUILIBRIUM
        return STEPPED

    def take_constants(self) -> None:
        """Hand the constants to the vertical law: four motors attract, and one direct current flows in all."""
        self.vertical.take_constants(MOTORS_3DOF * self.C3, MOTORS_3DOF * self.C4, MOTORS_3DOF * self.C5)

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
        if not self.started and y.measured <= 0.0:
            return   # an importer that has not exchanged values yet: this is no measurement
        self.take_constants()
        if self.law == SCHEDULED:
            self.schedule.choose(y.measured, self.vertical.linear)
        if not self.started:
            # Not bumpless, it begins as though the mover rested at the set-point.
            gap = y.measured if self.bumpless else self.setpoint
            error = y.measured - y.reference if self.bumpless else 0.0
            y.start(self.vertical.holding_demand(gap, error), error)
            x.start(0.0, x.measured - x.reference if self.bumpless else 0.0)
            z.start(0.0, z.measured - z.reference if self.bumpless else 0.0)
            self.started = True
        y.sample(self.observer, self.sample_time)
        x.sample(self.observer, self.sample_time)
        z.sample(self.observer, self.sample_time)
        if (exceeds(y.error, self.trip_error) or exceeds(x.error, self.trip_error)
                or exceeds(z.error, self.trip_error)):
            self.tripped = True
        if self.tripped:
            self.alpha.release()
            self.beta.release()
            self.saturated = False
            self.feasible = True   # nothing is demanded any more
            return
        i_d, i_qa, i_qb = self.currents(y.demand(), x.demand(), z.demand())
        alpha = self.alpha
        beta = self.beta
        alpha.command(i_d, i_qa, self.current_limit, x.measured)
        beta.command(i_d, i_qb, self.current_limit, z.measured)
        self.saturated = alpha.limited or beta.limited
        antiwindup_time = self.sample_time if self.antiwindup else 0.0
        # With the model's sign of i_d the thesis's antiwindup on y acts in the wrong direction; its gain is so small
        # that nothing follows from it.
        y.update(self.oscillator, antiwindup_time * alpha.excess_d)
        x.update(self.oscillator, antiwindup_time * alpha.excess_q)
        z.update(self.oscillator, antiwindup_time * beta.excess_q)

    def currents(self, demand_y: float, demand_x: float, demand_z: float) -> tuple[float, float, float]:
        """Currents i_d, i_qα, i_qβ (A) for the demanded accelerations (m/s²), equation (5.7) or its linearisation."""
        vertical = self.vertical
        vertical.look(self.y.measured)
        i_qa = -demand_x / (MOTORS_IN_PAIR * self.C1 * vertical.f1)
        i_qb = -demand_z / (MOTORS_IN_PAIR * self.C2 * vertical.f1)
        i_d = vertical.direct_current(demand_y, self.y.error,
                                      MOTORS_IN_PAIR * self.C5 * vertical.f4 * (i_qa * i_qa + i_qb * i_qb))
        self.feasible = vertical.feasible
        return i_d, i_qa, i_qb
