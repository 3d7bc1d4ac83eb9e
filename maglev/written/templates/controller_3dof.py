"""Controller of the 3-DOF stage: state feedback with an integral on each axis.

    maglev run 3dof-setpoints --controller FILE --set controller.y.bandwidth=25
    maglev build FILE                   # the same as an FMU; with --native one that needs no Python

Everything from `Axis` on is yours to change. What has to stay: the tables, and a `step` that gives the phase currents.
"""

from controller_fmu.feedback_linearisation import demanded_current
from controller_fmu.motor_command import MotorCommand
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from pmlsm.gap_functions import gap_functions

# The motor model: accelerations of the stage, two motors in each of the pairs alpha and beta (docs/model.md).
THRUST_X = 2.0 * 0.6135     # m/(s² A), along x by a quadrature current in alpha
THRUST_Z = 2.0 * 0.8224     # m/(s² A), along z by one in beta
ATTRACTION = 4.0 * 327.50   # m/(s² T²), magnets on iron
COILS = 4.0 * 8.48          # m/(s² A T), magnets on coils: the direct currents
IRON = 4.0 * 0.0070         # m/(s² A²), coils on iron


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
    """State feedback with an integral on each axis, on the feedback-linearised motors of the 3-DOF stage."""

    # Ports and parameters, and their units. "y.measured" is self.y.measured, or self.y_measured if you have no self.y.
    inputs = {"y.reference": "m", "y.reference_rate": "m/s", "y.measured": "m",   # y is the air gap: larger is lower
              "x.reference": "m", "x.reference_rate": "m/s", "x.measured": "m",
              "z.reference": "m", "z.reference_rate": "m/s", "z.measured": "m"}
    outputs = {"alpha.i_a_cmd": "A", "alpha.i_b_cmd": "A", "alpha.i_c_cmd": "A", "alpha.i_d_cmd": "A",
               "alpha.i_q_cmd": "A", "beta.i_a_cmd": "A", "beta.i_b_cmd": "A", "beta.i_c_cmd": "A",
               "beta.i_d_cmd": "A", "beta.i_q_cmd": "A"}
    parameters = {"y.bandwidth": "rad/s", "x.bandwidth": "rad/s", "z.bandwidth": "rad/s", "limit": "A"}

    def __init__(self) -> None:
        self.sample_time = 0.2e-3       # s: step is called this often
        self.limit = 4.0                # A, parameter: of i_d and i_q
        self.y = Axis(25.0e-3, 25.0)
        self.x = Axis(0.0, 12.0)
        self.z = Axis(0.0, 12.0)
        self.observer = ObserverFilter()
        self.alpha = MotorCommand()     # limits, commutates, and holds the outputs
        self.beta = MotorCommand()
        self.started = False

    def start(self) -> None:
        """Compute what follows from the parameters, when all are set."""
        self.observer.prepare(self.sample_time)

    def step(self, t: float) -> None:
        """Read the inputs, set the outputs; t is the time (s)."""
        y = self.y
        x = self.x
        z = self.z
        if not self.started:
            if y.measured <= 0.0:
                return          # in another tool: nothing has been measured yet
            y.velocity.seed(y.measured)
            x.velocity.seed(x.measured)
            z.velocity.seed(z.measured)
            self.started = True
        f1, f2, f3, f4 = gap_functions(y.measured)
        i_qa = -x.demand(self.observer, self.sample_time) / (THRUST_X * f1)
        i_qb = -z.demand(self.observer, self.sample_time) / (THRUST_Z * f1)
        by_quadrature = 0.5 * IRON * f4 * (i_qa * i_qa + i_qb * i_qb)
        i_d, feasible = demanded_current(y.demand(self.observer, self.sample_time), by_quadrature, ATTRACTION, COILS,
                                         IRON, f2, f3, f4)
        alpha = self.alpha
        beta = self.beta
        alpha.command(i_d, i_qa, self.limit, x.measured)
        beta.command(i_d, i_qb, self.limit, z.measured)
        y.integrate(self.sample_time, alpha.excess_d != 0.0)
        x.integrate(self.sample_time, alpha.excess_q != 0.0)
        z.integrate(self.sample_time, beta.excess_q != 0.0)
