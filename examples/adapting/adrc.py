"""Active disturbance rejection for the 3-DOF stage: extended-state observers instead of the thesis's regulator.

    maglev run 3dof-thrust-loss-fixed --controller examples/adapting/adrc.py
    maglev linearise Plant3DOF examples/adapting/adrc.py --at y=25mm --open y

With feedback-linearised motors each axis is p'' = u + d. The disturbance d is the sum of all unknown accelerations, by
friction, bias, ripple, a payload or weaker magnets. An observer with three equal poles estimates p, p' and d from the
measured position and the acceleration u of the limited currents. The demand subtracts d and places two poles. The
controller has no integral that could wind up, and estimates no constants.

J. Han, From PID to active disturbance rejection control, IEEE Trans. Ind. Electron. 56(3), 2009: the method.
Z. Gao, Scaling and bandwidth-parameterization based controller tuning, American Control Conference, 2003: one
bandwidth for the observer, and one for the loop.
R. Miklosovic, A. Radke, Z. Gao, Discrete implementation and generalization of the extended state observer, American
Control Conference, 2006: gains of the sampled observer, which corrects before it predicts.
"""

from motors_3dof import Motors3DOF

from controller_fmu.motor_command import MotorCommand
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from pmlsm.exponential import exponential


class ExtendedStateObserver:
    """Position, velocity and disturbance of an axis p'' = u + d, d' = 0, from sampled positions."""

    def __init__(self, bandwidth: float):
        self.bandwidth = bandwidth   # rad/s, parameter: of its three poles
        self.position = 0.0          # m, state
        self.velocity = 0.0          # m/s, state
        self.disturbance = 0.0       # m/s², state
        self.to_position = 0.0       # gains of the surprise
        self.to_velocity = 0.0       # 1/s
        self.to_disturbance = 0.0    # 1/s²

    def start(self, sample_time: float) -> None:
        """Place the poles at exp(−ω T), for a sample time (s)."""
        pole = exponential(-self.bandwidth * sample_time)
        faster = 1.0 - pole
        self.to_position = 1.0 - pole * pole * pole
        self.to_velocity = 1.5 * faster * faster * (1.0 + pole) / sample_time
        self.to_disturbance = faster * faster * faster / (sample_time * sample_time)

    def correct(self, measured: float) -> None:
        """Take in a measured position (m)."""
        surprise = measured - self.position
        self.position += self.to_position * surprise
        self.velocity += self.to_velocity * surprise
        self.disturbance += self.to_disturbance * surprise

    def predict(self, acceleration: float, sample_time: float) -> None:
        """Go on by a sample time (s) with a commanded acceleration (m/s²)."""
        change = sample_time * (acceleration + self.disturbance)
        self.position += sample_time * (self.velocity + 0.5 * change)
        self.velocity += change


class Axis:
    """One axis: ports, the loop's bandwidth and the observer."""

    def __init__(self, position: float, bandwidth: float, observed: float):
        self.reference = position       # m, input
        self.reference_rate = 0.0       # m/s, input
        self.measured = position        # m, input
        self.bandwidth = bandwidth      # rad/s, parameter: of the loop's two poles
        self.observer = ExtendedStateObserver(observed)
        self.ahead = VelocityObserver()   # its rate is the acceleration of the reference

    def start(self) -> None:
        """Begin at rest at the measurement."""
        self.observer.position = self.measured
        self.ahead.seed(self.reference_rate)

    def demand(self, differentiator: ObserverFilter, feedforward: bool, sample_time: float) -> float:
        """Acceleration (m/s²) that the commanded currents shall make."""
        self.observer.correct(self.measured)
        self.ahead.update(self.reference_rate, differentiator, sample_time)
        error = self.observer.position - self.reference
        rate = self.observer.velocity - self.reference_rate
        demand = -self.bandwidth * (self.bandwidth * error + 2.0 * rate) - self.observer.disturbance
        if feedforward:
            demand += self.ahead.velocity
        return demand


class ADRC:
    """Extended-state observers and two poles for each axis, on the feedback-linearised motors of the 3-DOF stage."""

    inputs = {f"{axis}.{port}": unit for axis in ("y", "x", "z")
              for port, unit in (("reference", "m"), ("reference_rate", "m/s"), ("measured", "m"))}
    outputs = {f"{motor}.i_{current}_cmd": "A" for motor in ("alpha", "beta") for current in ("a", "b", "c", "d", "q")}
    parameters = {**{f"{axis}.bandwidth": "rad/s" for axis in ("y", "x", "z")},
                  **{f"{axis}.observer.bandwidth": "rad/s" for axis in ("y", "x", "z")},
                  "feedforward": "", "motors.limit": "A"}

    def __init__(self) -> None:
        self.sample_time = 0.2e-3       # s
        self.feedforward = True         # parameter: true to feed the reference's acceleration forward
        self.y = Axis(25e-3, 50.0, 200.0)
        self.x = Axis(0.0, 35.0, 140.0)
        self.z = Axis(0.0, 35.0, 140.0)
        self.differentiator = ObserverFilter()
        self.motors = Motors3DOF()
        self.alpha = MotorCommand()
        self.beta = MotorCommand()
        self.started = False

    def start(self) -> None:
        """Compute what follows from the parameters."""
        self.motors.as_limited = True
        self.motors.start()
        self.differentiator.prepare(self.sample_time)
        self.y.observer.start(self.sample_time)
        self.x.observer.start(self.sample_time)
        self.z.observer.start(self.sample_time)

    def step(self, t: float) -> None:
        """Step one sample: correct, demand, command, and predict with the limited command."""
        if not self.started:
            if self.y.measured <= 0.0:
                return   # in another tool: nothing has been measured yet
            self.y.start()
            self.x.start()
            self.z.start()
            self.started = True
        dt = self.sample_time
        self.motors.command(self.alpha, self.beta, self.y.demand(self.differentiator, self.feedforward, dt),
                            self.x.demand(self.differentiator, self.feedforward, dt),
                            self.z.demand(self.differentiator, self.feedforward, dt), self.y.measured, self.x.measured,
                            self.z.measured)
        self.y.observer.predict(self.motors.y, dt)
        self.x.observer.predict(self.motors.x, dt)
        self.z.observer.predict(self.motors.z, dt)
