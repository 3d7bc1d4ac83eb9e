"""L1 adaptive augmentation of the thesis's regulator of the 3-DOF stage, with the piecewise constant law.

    maglev run 3dof-thrust-loss-fixed --controller examples/adapting/l1_adaptive.py
    maglev linearise Plant3DOF examples/adapting/l1_adaptive.py --at y=25mm --open y

Each axis has a predictor of its velocity, v̂' = −a (v̂ − v) + u + σ̂. Here u is the acceleration by the limited currents
in the regulator's model, and σ̂ the correction with which the next prediction would have no error. The demand is
reduced by σ̂ behind a low-pass filter C(s) = ω/(s + ω). The margins of the loop depend on ω alone, not on the speed of
the adaptation, which is the purpose of the method. With ω = 0 the regulator has no adaptation.

C. Cao, N. Hovakimyan, Design and analysis of a novel L1 adaptive control architecture with guaranteed transient
performance, IEEE Trans. Autom. Control 53(2), 2008: predictor and filter.
N. Hovakimyan, C. Cao, L1 Adaptive Control Theory, SIAM, 2010, chapter 3: the piecewise constant law.
"""

from math import pi

from motors_3dof import Motors3DOF

from controller_fmu.internal_model import OscillatorStep
from controller_fmu.matched_filter import MatchedFilter
from controller_fmu.motor_command import MotorCommand
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver  # noqa: F401 - an axis has one
from pmlsm.exponential import exponential


class Uncertainty:
    """Motion of one axis that the commands do not explain, and the part of it that is compensated."""

    def __init__(self, cutoff: float):
        self.cutoff = cutoff         # ω, rad/s, parameter
        self.rate = 10.0             # a, 1/s, of the prediction's error
        self.velocity = 0.0          # v̂, m/s, state
        self.found = 0.0             # σ̂, m/s²
        self.compensated = 0.0       # C σ̂, m/s², state
        self.kept = 1.0              # share of the prediction's error that a sample keeps
        self.share = 0.0             # share of the way to σ̂ that the filter goes in a sample
        self.delay = MatchedFilter()   # the measured velocity is filtered: so is the acceleration next to it

    def start(self, sample_time: float) -> None:
        """Compute what follows from a sample time (s)."""
        self.kept = exponential(-self.rate * sample_time)
        self.share = 1.0 - exponential(-self.cutoff * sample_time)

    def update(self, velocity: float, acceleration: float, observer: ObserverFilter) -> None:
        """Take in a measured velocity (m/s), and the acceleration (m/s²) that was commanded until now."""
        matched = self.delay.update(acceleration, observer)
        weight = (1.0 - self.kept) / self.rate   # s
        # One sample of the predictor from the velocity before it; the difference is the error.
        error = self.velocity + weight * matched - velocity
        self.found = -self.kept / weight * error
        self.compensated += self.share * (self.found - self.compensated)
        # The next prediction: its error is the kept share of this one, minus the correction by σ̂.
        self.velocity = velocity + self.kept * error + weight * self.found


class L1Regulator:
    """The thesis's regulator with (5.14), and a compensation of its model errors up to a frequency."""

    inputs = {f"{axis}.{port}": unit for axis in ("y", "x", "z")
              for port, unit in (("reference", "m"), ("reference_rate", "m/s"), ("measured", "m"))}
    outputs = {f"{motor}.i_{current}_cmd": "A" for motor in ("alpha", "beta") for current in ("a", "b", "c", "d", "q")}
    parameters = {**{f"{axis}_uncertainty.cutoff": "rad/s" for axis in ("y", "x", "z")},
                  **{f"{axis}.k{k}": "" for axis in ("y", "x", "z") for k in range(1, 6)}, "motors.limit": "A"}

    def __init__(self) -> None:
        self.sample_time = 0.2e-3       # s
        self.y = OutputRegulator(-1274.0, -104.0, -50001.0, -3936.0, -7774.0, 1e-05, 0.025)
        self.x = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 0.00011, 0.0)
        self.z = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 0.000125, 0.0)
        self.y_uncertainty = Uncertainty(40.0)
        self.x_uncertainty = Uncertainty(40.0)
        self.z_uncertainty = Uncertainty(40.0)
        self.observer = ObserverFilter()
        self.oscillator = OscillatorStep()
        self.motors = Motors3DOF()
        self.alpha = MotorCommand()
        self.beta = MotorCommand()
        self.started = False

    def start(self) -> None:
        """Compute what follows from the parameters."""
        self.motors.start()
        self.observer.prepare(self.sample_time)
        self.oscillator.prepare(1.5 * pi, self.sample_time)
        self.y_uncertainty.start(self.sample_time)
        self.x_uncertainty.start(self.sample_time)
        self.z_uncertainty.start(self.sample_time)

    def step(self, t: float) -> None:
        """Step one sample of the regulator, with the compensation subtracted from its demands."""
        y = self.y
        x = self.x
        z = self.z
        if not self.started:
            if y.measured <= 0.0:
                return   # in another tool: nothing has been measured yet
            y.start(0.0, y.measured - y.reference)
            x.start(0.0, x.measured - x.reference)
            z.start(0.0, z.measured - z.reference)
            self.started = True
        dt = self.sample_time
        motors = self.motors
        y.sample(self.observer, dt)
        x.sample(self.observer, dt)
        z.sample(self.observer, dt)
        self.y_uncertainty.update(y.observer.velocity, motors.y, self.observer)
        self.x_uncertainty.update(x.observer.velocity, motors.x, self.observer)
        self.z_uncertainty.update(z.observer.velocity, motors.z, self.observer)
        motors.command(self.alpha, self.beta, y.demand() - self.y_uncertainty.compensated,
                       x.demand() - self.x_uncertainty.compensated, z.demand() - self.z_uncertainty.compensated,
                       y.measured, x.measured, z.measured)
        y.update(self.oscillator, dt * self.alpha.excess_d)
        x.update(self.oscillator, dt * self.alpha.excess_q)
        z.update(self.oscillator, dt * self.beta.excess_q)
