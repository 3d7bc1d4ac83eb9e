"""Regulators of the 3-DOF stage (4.15), (4.16), (5.13): output regulation, feedback-linearised or linearised."""

from math import pi

from controller_fmu.gain_point import GainPoint
from controller_fmu.gain_schedule import GainSchedule
from controller_fmu.gain_table import GainTable
from controller_fmu.internal_model import OscillatorStep
from controller_fmu.motor_command import MotorCommand
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import (
    BAD_GEOMETRY,
    INTERPOLATED,
    LINEAR,
    NO_EQUILIBRIUM,
    NONLINEAR,
    SCHEDULED,
    STEP_MISFIT,
    STEPPED,
)
from controller_fmu.velocity_observer import ObserverFilter
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.motor_geometry import MotorGeometry


class Regulator3DOF:
    """Samples positions and references, commands phase currents that hold until the next sample.

    The law is NONLINEAR: the motors are feedback-linearised at the measured gap (4.12), (5.7). Or LINEAR: they are
    linearised about the setpoint such that the closed loop has the same poles there (sections 4.6.1, 5.6.3).
    Or SCHEDULED: linear about the setpoint of the region that the measured gap lies in (Table 5.4).
    Or INTERPOLATED: about the equilibrium at the measured gap, from a fine table, with its current fed forward.
    All motors get the same direct current.
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
        self.geometry = MotorGeometry()
        self.y = OutputRegulator(-1274.0, -104.0, -50001.0, -3936.0, -7774.0, 1e-05, 0.025)
        self.x = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 0.00011, 0.0)
        self.z = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 0.000125, 0.0)
        self.observer = ObserverFilter()
        self.oscillator = OscillatorStep()
        self.vertical = VerticalLaw(law)
        self.schedule = GainSchedule(0.026, 0.024, 0.022, 0.027, 0.025, 0.023, 0.021)
        self.table = GainTable(0.018, 0.001)
        self.here = GainPoint()   # what counts at the gap
        self.scale = 1.0          # its gain, by that of the middle of the table
        self.clock = SampleClock()
        self.alpha = MotorCommand()
        self.beta = MotorCommand()
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
        if self.law == SCHEDULED and not self.schedule.prepare(self.geometry, vertical.attraction, vertical.coils,
                                                               vertical.iron):
            return NO_EQUILIBRIUM
        if self.law == INTERPOLATED and not self.table.prepare(self.geometry, vertical.attraction, vertical.coils,
                                                               vertical.iron):
            return NO_EQUILIBRIUM
        return STEPPED

    def take_constants(self) -> None:
        """Hand the constants to the vertical law: all motors attract, and one direct current flows in them."""
        self.vertical.take_constants(4.0 * self.C3, 4.0 * self.C4, 4.0 * self.C5)

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
        if self.law == INTERPOLATED:
            self.table.choose(y.measured, self.here)
            self.vertical.take(self.here)
            # Between samples ξ1 stands for a current: what it commands does not change with the gain.
            self.scale = self.table.scale(self.here)
            y.rescale(self.scale)
        if not self.started:
            # Not bumpless, it begins as though the mover rested at the setpoint.
            gap = y.measured if self.bumpless else self.setpoint
            error = y.measured - y.reference if self.bumpless else 0.0
            y.start(self.vertical.holding_demand(self.geometry, gap, error), error)
            x.start(0.0, x.measured - x.reference if self.bumpless else 0.0)
            z.start(0.0, z.measured - z.reference if self.bumpless else 0.0)
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
            self.feasible = True   # nothing is demanded any more
            return
        i_d, i_q_x, i_q_z = self.currents(y.demand(), x.demand(), z.demand())
        alpha.command(i_d, i_q_x, self.current_limit, self.geometry.electrical_angle(x.measured))
        beta.command(i_d, i_q_z, self.current_limit, self.geometry.electrical_angle(z.measured))
        self.saturated = alpha.limited or beta.limited
        antiwindup_time = self.sample_time if self.antiwindup else 0.0
        y.update(self.oscillator, antiwindup_time * alpha.excess_d)
        x.update(self.oscillator, antiwindup_time * alpha.excess_q)
        z.update(self.oscillator, antiwindup_time * beta.excess_q)
        if self.law == INTERPOLATED:
            y.rescale(1.0 / self.scale)

    def currents(self, demand_y: float, demand_x: float, demand_z: float) -> tuple[float, float, float]:
        """Currents i_d, i_q of x, i_q of z (A) for the demanded accelerations (m/s²), (4.12), (5.7) or linear."""
        vertical = self.vertical
        vertical.look(self.geometry, self.y.measured)
        i_q_x = -demand_x / (2.0 * self.C1 * vertical.f1)
        i_q_z = -demand_z / (2.0 * self.C2 * vertical.f1)
        i_d = vertical.direct_current(demand_y, self.y.error,
                                      2.0 * self.C5 * vertical.f4 * (i_q_x * i_q_x + i_q_z * i_q_z))
        self.feasible = vertical.feasible
        return i_d, i_q_x, i_q_z
