"""Regulators of the 2-DOF stage: output regulation (4.15), (4.16) on the motor, feedback-linearised or linearised."""

from math import pi

from controller_fmu.internal_model import OscillatorStep
from controller_fmu.motor_command import MotorCommand
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import LINEAR, NO_EQUILIBRIUM, NONLINEAR, STEP_MISFIT, STEPPED
from controller_fmu.velocity_observer import ObserverFilter
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.data_sheet import SAMPLE_TIME_2DOF


class Regulator2DOF:
    """Samples positions and references, commands phase currents that hold until the next sample.

    The law is NONLINEAR, with the motor feedback-linearised at the measured gap (4.12), or LINEAR, with the motor
    linearised about the set-point such that the closed loop has the same poles there (section 4.6.1).
    """

    def __init__(self, law: int = NONLINEAR):
        self.law = law
        self.C1 = 14.20         # m/(s² A), parameter: thrust
        self.C2 = 796.99        # m/(s² T²), parameter: attraction
        self.C3 = 31.04         # m/(s² A T), parameter: magnets on coils
        self.C4 = 0.07          # m/(s² A²), parameter: coils on iron
        self.sample_time = SAMPLE_TIME_2DOF   # s, parameter
        self.omega0 = 1.5 * pi  # rad/s, parameter
        self.setpoint = 20.0e-3               # m, parameter of the linear law: gap of its linearisation
        self.bumpless = True                  # parameter of the linear law
        self.current_limit = 4.0              # A, parameter, 0 = none
        self.antiwindup = False               # parameter
        self.trip_error = 0.0                 # m, parameter, 0 = never
        self.v = OutputRegulator(-1662.0, -65.0, -360360.0, -103350.0, -20332.0, 0.0, 20.0e-3)
        self.h = OutputRegulator(-1182.0, -55.0, -154440.0, -45128.0, -11924.0, 0.0, 0.0)
        self.observer = ObserverFilter()
        self.oscillator = OscillatorStep()
        self.vertical = VerticalLaw(law)
        self.clock = SampleClock()
        self.motor = MotorCommand()
        self.started = False    # state: a measurement has come in
        self.saturated = False  # output
        self.feasible = True    # output
        self.tripped = False    # state and output

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        self.observer.prepare(self.sample_time)
        self.oscillator.prepare(self.omega0, self.sample_time)
        self.vertical.take_constants(self.C2, self.C3, self.C4)
        if self.law == LINEAR and not self.vertical.linearise(self.setpoint):
            return NO_EQUILIBRIUM
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
        self.vertical.take_constants(self.C2, self.C3, self.C4)
        if not self.started:
            if v.measured <= 0.0:
                return   # an importer that has not exchanged values yet: this is no measurement
            # Not bumpless, it begins as though the mover rested at the set-point.
            gap = v.measured if self.bumpless else self.setpoint
            error = v.measured - v.reference if self.bumpless else 0.0
            v.start(self.vertical.holding_demand(gap, error), error)
            h.start(0.0, h.measured - h.reference if self.bumpless else 0.0)
            self.started = True
        v.sample(self.observer, self.sample_time)
        h.sample(self.observer, self.sample_time)
        if exceeds(v.error, self.trip_error) or exceeds(h.error, self.trip_error):
            self.tripped = True
        if self.tripped:
            self.motor.release()
            self.saturated = False
            self.feasible = True   # nothing is demanded any more
            return
        i_d, i_q = self.currents(v.demand(), h.demand())
        motor = self.motor
        motor.command(i_d, i_q, self.current_limit, h.measured)
        self.saturated = motor.limited
        antiwindup_time = self.sample_time if self.antiwindup else 0.0
        v.update(self.oscillator, antiwindup_time * motor.excess_d)
        h.update(self.oscillator, antiwindup_time * motor.excess_q)

    def currents(self, demand_v: float, demand_h: float) -> tuple[float, float]:
        """Currents i_d, i_q (A) for the demanded accelerations (m/s²), equation (4.12) or its linearisation."""
        vertical = self.vertical
        vertical.look(self.v.measured)
        i_q = -demand_h / (self.C1 * vertical.f1)
        i_d = vertical.direct_current(demand_v, self.v.error, self.C4 * vertical.f4 * i_q * i_q)
        self.feasible = vertical.feasible
        return i_d, i_q
