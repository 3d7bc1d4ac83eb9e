"""Controller of the 2-DOF stage: state feedback with an integral on each axis.

    maglev run 2dof-setpoints --controller FILE --set controller.v.bandwidth=40
    maglev build FILE                   # the same as an FMU; with --native one that needs no Python

Everything from `Axis` on is yours to change. What has to stay: the tables, and a `step` that gives the phase currents.
"""

from controller_fmu.feedback_linearisation import demanded_current
from controller_fmu.motor_command import MotorCommand
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from pmlsm.gap_functions import gap_functions

# The motor model: accelerations of the stage (docs/model.md).
THRUST = 14.20        # m/(s² A), along h by the quadrature current
ATTRACTION = 796.99   # m/(s² T²), magnets on iron
COILS = 31.04         # m/(s² A T), magnets on coils: the direct current
IRON = 0.07           # m/(s² A²), coils on iron


class Axis:
    """One axis: from reference and measurement to the acceleration that is asked for."""

    def __init__(self, position: float, bandwidth: float):
        self.reference = position       # m, input
        self.reference_rate = 0.0       # m/s, input
        self.measured = position        # m, input
        self.bandwidth = bandwidth      # rad/s, parameter: three poles lie there
        self.velocity = VelocityObserver()
        self.integral = 0.0             # m s, state

    def demand(self, observer: ObserverFilter, dt: float) -> float:
        """Acceleration (m/s²) by which the error has its poles at (s + w)(s² + 1.8 w s + w²)."""
        self.velocity.update(self.measured, observer, dt)
        error = self.measured - self.reference
        rate = self.velocity.velocity - self.reference_rate
        w = self.bandwidth
        return -2.8 * w * rate - 2.8 * w * w * error - w * w * w * self.integral

    def integrate(self, dt: float, limited: bool) -> None:
        """Take the error into the integral, but not while the current is at its limit (antiwindup)."""
        if not limited:
            self.integral += dt * (self.measured - self.reference)


class Controller:
    """State feedback with an integral on each axis, on the feedback-linearised motor of the 2-DOF stage."""

    # Ports and parameters, and their units. "v.measured" is self.v.measured, or self.v_measured if you have no self.v.
    inputs = {"v.reference": "m", "v.reference_rate": "m/s", "v.measured": "m",   # v is the air gap: larger is lower
              "h.reference": "m", "h.reference_rate": "m/s", "h.measured": "m"}
    outputs = {"motor.i_a_cmd": "A", "motor.i_b_cmd": "A", "motor.i_c_cmd": "A", "motor.i_d_cmd": "A",
               "motor.i_q_cmd": "A"}
    parameters = {"v.bandwidth": "rad/s", "h.bandwidth": "rad/s", "limit": "A"}

    def __init__(self) -> None:
        self.sample_time = 0.5e-3       # s: step is called this often
        self.limit = 4.0                # A, parameter: of i_d and i_q
        self.v = Axis(20.0e-3, 30.0)
        self.h = Axis(0.0, 25.0)
        self.observer = ObserverFilter()
        self.motor = MotorCommand()     # limits, commutates, and holds the outputs
        self.started = False

    def start(self) -> None:
        """Compute what follows from the parameters, when all are set."""
        self.observer.prepare(self.sample_time)

    def step(self, t: float) -> None:
        """Read the inputs, set the outputs; t is the time (s)."""
        v = self.v
        h = self.h
        if not self.started:
            if v.measured <= 0.0:
                return          # in another tool: nothing has been measured yet
            v.velocity.seed(v.measured)
            h.velocity.seed(h.measured)
            self.started = True
        f1, f2, f3, f4 = gap_functions(v.measured)
        i_q = -h.demand(self.observer, self.sample_time) / (THRUST * f1)
        i_d, feasible = demanded_current(v.demand(self.observer, self.sample_time), IRON * f4 * i_q * i_q, ATTRACTION,
                                         COILS, IRON, f2, f3, f4)
        motor = self.motor
        motor.command(i_d, i_q, self.limit, h.measured)
        v.integrate(self.sample_time, motor.excess_d != 0.0)
        h.integrate(self.sample_time, motor.excess_q != 0.0)
