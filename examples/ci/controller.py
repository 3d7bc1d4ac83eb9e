"""The controller of this repository: state feedback with an integral on both axes of the 2-DOF stage."""

from controller_fmu.feedback_linearisation import demanded_current
from controller_fmu.motor_command import MotorCommand
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry

THRUST, ATTRACTION, COILS, IRON = 14.2, 796.99, 31.04, 0.07   # C1, C3, C4, C5 of the 2-DOF stage, SI


class Axis:
    """Acceleration that puts three poles near the bandwidth."""

    def __init__(self, position: float, bandwidth: float):
        self.reference = position    # m, input
        self.measured = position     # m, input
        self.bandwidth = bandwidth   # rad/s, parameter
        self.velocity = VelocityObserver()
        self.integral = 0.0          # m s

    def demand(self, observer: ObserverFilter, dt: float) -> float:
        """Acceleration, m/s²."""
        self.velocity.update(self.measured, observer, dt)
        error = self.measured - self.reference
        self.integral += dt * error
        w = self.bandwidth
        return -w * (3.0 * self.velocity.velocity + 3.0 * w * error + w * w * self.integral)


class Hover:
    """Holds the gap v and the place h at their references."""

    inputs = {"v.reference": "m", "v.measured": "m", "h.reference": "m", "h.measured": "m"}
    outputs = {f"motor.i_{name}_cmd": "A" for name in ("a", "b", "c", "d", "q")}
    parameters = {"v.bandwidth": "rad/s", "h.bandwidth": "rad/s", "limit": "A"}

    def __init__(self) -> None:
        self.sample_time = 0.0005   # s
        self.limit = 4.0            # A
        self.v = Axis(0.02, 30.0)
        self.h = Axis(0.0, 20.0)
        self.observer = ObserverFilter()
        self.geometry = MotorGeometry()
        self.motor = MotorCommand()

    def start(self) -> None:
        self.geometry.prepare()
        self.observer.prepare(self.sample_time)
        self.started = False

    def step(self, t: float) -> None:
        if not self.started:
            self.v.velocity.seed(self.v.measured)
            self.h.velocity.seed(self.h.measured)
            self.started = True
        f1, f2, f3, f4 = gap_functions(self.geometry, self.v.measured)
        i_q = -self.h.demand(self.observer, self.sample_time) / (THRUST * f1)
        i_d, _ = demanded_current(self.v.demand(self.observer, self.sample_time), IRON * f4 * i_q * i_q,
                                  ATTRACTION, COILS, IRON, f2, f3, f4)
        self.motor.command(i_d, i_q, self.limit, self.geometry.electrical_angle(self.h.measured))
