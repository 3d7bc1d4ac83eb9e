"""Regulators of the 2-DOF stage (4.15), (4.16), (5.13): output regulation, feedback-linearised or linearised."""

from math import pi

from controller_fmu.internal_model import OscillatorStep
from controller_fmu.motor_command import MotorCommand
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, LINEAR, NO_EQUILIBRIUM, NONLINEAR, STEP_MISFIT, STEPPED
from controller_fmu.velocity_observer import ObserverFilter
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.motor_geometry import MotorGeometry


class Regulator2DOF:
    """Samples positions and references, commands phase currents that hold until the next sample.

    The law is NONLINEAR: the motors are feedback-linearised at the measured gap (4.12), (5.7). Or LINEAR: they are
    linearised about the setpoint such that the closed loop has the same poles there (sections 4.6.1, 5.6.3).
    All motors get the same direct current.
    """

    def __init__(self, law: int = NONLINEAR):
        self.law = law
        self.C1 = 14.2                   # m/(s² A), parameter: thrust along h
        self.C2 = 796.99                 # m/(s² T²), parameter: attraction between magnets and iron
        self.C3 = 31.04                  # m/(s² A T), parameter: normal force between magnets and coils
        self.C4 = 0.07                   # m/(s² A²), parameter: normal force between coils and iron
        self.sample_time = 0.0005        # s, parameter
        self.omega0 = 1.5 * pi           # rad/s, parameter
        self.setpoint = 0.02             # m, parameter of the linear law: gap of its linearisation
        self.bumpless = True             # parameter of the linear law
        self.current_limit = 4.0         # A, parameter, 0 = none
        self.antiwindup = False          # parameter
        self.trip_error = 0.0            # m, parameter, 0 = never
        self.geometry = MotorGeometry()
        self.v = OutputRegulator(-1662.0, -65.0, -360360.0, -103350.0, -20332.0, 0.0, 0.02)
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
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        self.observer.prepare(self.sample_time)
        self.oscillator.prepare(self.omega0, self.sample_time)
        self.take_constants()
        vertical = self.vertical
        if self.law == LINEAR and not vertical.linearise(self.geometry, self.setpoint):
            return NO_EQUILIBRIUM
        return STEPPED

    def take_constants(self) -> None:
        """Hand the constants to the vertical law: all motors attract, and one direct current flows in them."""
        self.vertical.take_constants(self.C2, self.C3, self.C4)

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
        if not self.started and v.measured <= 0.0:
            return   # an importer that has not exchanged values yet: this is no measurement
        self.take_constants()
        if not self.started:
            # Not bumpless, it begins as though the mover rested at the setpoint.
            gap = v.measured if self.bumpless else self.setpoint
            error = v.measured - v.reference if self.bumpless else 0.0
            v.start(self.vertical.holding_demand(self.geometry, gap, error), error)
            h.start(0.0, h.measured - h.reference if self.bumpless else 0.0)
            self.started = True
        v.sample(self.observer, self.sample_time)
        h.sample(self.observer, self.sample_time)
        if exceeds(v.error, self.trip_error) or exceeds(h.error, self.trip_error):
            self.tripped = True
        motor = self.motor
        if self.tripped:
            motor.release()
            self.saturated = False
            self.feasible = True   # nothing is demanded any more
            return
        i_d, i_q_h = self.currents(v.demand(), h.demand())
        motor.command(i_d, i_q_h, self.current_limit, self.geometry.electrical_angle(h.measured))
        self.saturated = motor.limited
        antiwindup_time = self.sample_time if self.antiwindup else 0.0
        v.update(self.oscillator, antiwindup_time * motor.excess_d)
        h.update(self.oscillator, antiwindup_time * motor.excess_q)

    def currents(self, demand_v: float, demand_h: float) -> tuple[float, float]:
        """Currents i_d, i_q of h (A) for the demanded accelerations (m/s²), (4.12), (5.7) or linear."""
        vertical = self.vertical
        vertical.look(self.geometry, self.v.measured)
        i_q_h = -demand_h / (self.C1 * vertical.f1)
        i_d = vertical.direct_current(demand_v, self.v.error,
                                      self.C4 * vertical.f4 * i_q_h * i_q_h)
        self.feasible = vertical.feasible
        return i_d, i_q_h
