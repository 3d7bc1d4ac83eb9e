"""The thesis's regulator of the 3-DOF stage, with constants from recursive least squares with directional forgetting.

    maglev run 3dof-thrust-loss-fixed --controller examples/adapting/directional_rls.py

A row of the model is v' = φ θ. For x and z, θ has the thrust, Coulomb friction and a bias. For y it has the attraction,
the constant of magnets on coils and a bias. Both sides pass the same low-pass filter, so that v' needs no derivative.
With usual forgetting the information matrix R decays in all directions that the motion does not excite, and the
estimates drift. Here R forgets the excited direction only: it loses a share of R φ φᵀ R / (φᵀ R φ) before φ φᵀ is
added. Estimates of friction and bias keep these effects out of the thrust. The regulator gets only the constants,
slowly and within bounds. The method needs no supervision of the excitation.

L. Cao, H. M. Schwartz, A directional forgetting algorithm based on the decomposition of the information matrix,
Automatica 36(11), 2000.
R. Kulhavý, Restricted exponential forgetting in real-time identification, Automatica 23(5), 1987: the method.
"""

from math import pi

from motors_3dof import Motors3DOF

from controller_fmu.adaptation import Adaptation
from controller_fmu.internal_model import OscillatorStep
from controller_fmu.matched_filter import MatchedFilter
from controller_fmu.motor_command import MotorCommand
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.symmetric3 import Symmetric3
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver  # noqa: F401 - an axis has one
from pmlsm.exponential import exponential
from pmlsm.velocity_rows import GRAVITY


class DirectionalRLS:
    """Estimates of a row of three: two factors of the start values, or one factor and friction; and a bias."""

    def __init__(self, second: float, second_weight: float):
        self.first = 1.0                # state
        self.second = second            # state: a share, or Coulomb friction (m/s²)
        self.bias = 0.0                 # m/s², state
        self.second_weight = second_weight
        self.information = Symmetric3()   # R
        self.smooth = 0.0               # m/s, states of the low-pass filter, of the velocity and of φ
        self.phi1 = 0.0
        self.phi2 = 0.0
        self.known = 0.0                # m/s²
        self.delay1 = MatchedFilter()
        self.delay2 = MatchedFilter()
        self.delay_known = MatchedFilter()

    def start(self, velocity: float, a1: float, a2: float, known: float, weight: float) -> None:
        """Begin at rest, with the weight of the first guesses (samples of 1 m/s²)."""
        self.information.set_diagonal(weight, weight * self.second_weight, weight)
        self.smooth = velocity
        self.delay1.seed(a1)
        self.delay2.seed(a2)
        self.delay_known.seed(known)
        self.phi1 = a1
        self.phi2 = a2
        self.known = known

    def update(self, velocity: float, a1: float, a2: float, known: float, observer: ObserverFilter, corner: float,
               share: float, forgotten: float, held: bool) -> None:
        """Take in a velocity (m/s) and a row, v' = a1 θ1 + a2 θ2 + θ3 + known; `held` keeps the estimates."""
        self.phi1 += share * (self.delay1.update(a1, observer) - self.phi1)
        self.phi2 += share * (self.delay2.update(a2, observer) - self.phi2)
        self.known += share * (self.delay_known.update(known, observer) - self.known)
        self.smooth += share * (velocity - self.smooth)
        if held:
            return
        p1 = self.phi1
        p2 = self.phi2
        surprise = corner * (velocity - self.smooth) - self.known - (p1 * self.first + p2 * self.second + self.bias)
        R = self.information
        w1 = R.s11 * p1 + R.s21 * p2 + R.s31
        w2 = R.s21 * p1 + R.s22 * p2 + R.s32
        w3 = R.s31 * p1 + R.s32 * p2 + R.s33
        R.add_square(-forgotten / (p1 * w1 + p2 * w2 + w3), w1, w2, w3)
        R.add_square(1.0, p1, p2, 1.0)
        R.factorise()
        g1, g2, g3 = R.solve(p1, p2, 1.0)
        self.first += g1 * surprise
        self.second += g2 * surprise
        self.bias += g3 * surprise


def moved(value: float, nominal: float, share: float, target: float, largest: float) -> float:
    """A constant after a share of the way to its estimate, relative, or to the bound that this is beyond."""
    if target < 1.0 - largest:
        target = 1.0 - largest
    elif target > 1.0 + largest:
        target = 1.0 + largest
    return value + share * (nominal * target - value)


def drag(velocity: float, slow: float) -> float:
    """Return the direction of Coulomb friction, −1 to 1; a fraction below a slow velocity (m/s), where it is a spring.
    """
    if velocity > slow:
        return -1.0
    if velocity < -slow:
        return 1.0
    return -velocity / slow


class DirectionalRegulator:
    """The thesis's regulator with (5.14), whose constants follow least squares with directional forgetting."""

    inputs = {f"{axis}.{port}": unit for axis in ("y", "x", "z")
              for port, unit in (("reference", "m"), ("reference_rate", "m/s"), ("measured", "m"))}
    outputs = {**{f"{motor}.i_{current}_cmd": "A" for motor in ("alpha", "beta")
                  for current in ("a", "b", "c", "d", "q")},
               "motors.C1": "m/(s2.A)", "motors.C2": "m/(s2.A)", "motors.C3": "m/(s2.T2)", "motors.C4": "m/(s2.A.T)"}
    parameters = {**{f"{axis}.k{k}": "" for axis in ("y", "x", "z") for k in range(1, 6)},
                  "memory": "s", "corner": "rad/s", "weight": "", "adaptation.active": "", "motors.limit": "A"}

    def __init__(self) -> None:
        self.sample_time = 0.2e-3       # s
        self.memory = 3.0               # s, parameter: memory in the excited direction
        self.corner = 20.0              # rad/s, parameter: of the low-pass filter
        self.weight = 500.0             # parameter: of the first guesses
        self.y = OutputRegulator(-1274.0, -104.0, -50001.0, -3936.0, -7774.0, 1e-05, 0.025)
        self.x = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 0.00011, 0.0)
        self.z = OutputRegulator(-463.0, -35.0, -15121.0, -997.0, -2548.0, 0.000125, 0.0)
        self.y_row = DirectionalRLS(1.0, 1.0)
        self.x_row = DirectionalRLS(0.0, 1.0)
        self.z_row = DirectionalRLS(0.0, 1.0)
        self.adaptation = Adaptation()
        self.observer = ObserverFilter()
        self.oscillator = OscillatorStep()
        self.first = Motors3DOF()       # start values of the constants
        self.motors = Motors3DOF()
        self.alpha = MotorCommand()
        self.beta = MotorCommand()
        self.share = 0.0
        self.started = False

    def start(self) -> None:
        """Compute what follows from the parameters."""
        self.motors.start()
        self.observer.prepare(self.sample_time)
        self.oscillator.prepare(1.5 * pi, self.sample_time)
        self.share = 1.0 - exponential(-self.corner * self.sample_time)

    def learn(self) -> None:
        """Show the rows what the currents did until now, and let the constants follow."""
        y = self.y
        first = self.first
        motors = self.motors
        alpha = self.alpha
        beta = self.beta
        held = self.adaptation.judge(alpha.limited or beta.limited, self.sample_time)
        attraction = -4.0 * first.C3 * motors.f2
        coils = 4.0 * first.C4 * motors.f3 * alpha.i_d_cmd
        squares = alpha.i_d_cmd * alpha.i_d_cmd + 0.5 * (alpha.i_q_cmd * alpha.i_q_cmd + beta.i_q_cmd * beta.i_q_cmd)
        known = GRAVITY - 4.0 * first.C5 * motors.f4 * squares
        thrust_x = -2.0 * first.C1 * motors.f1 * alpha.i_q_cmd
        thrust_z = -2.0 * first.C2 * motors.f1 * beta.i_q_cmd
        forgotten = 1.0 - exponential(-self.sample_time / self.memory)
        vx = self.x.observer.velocity
        vz = self.z.observer.velocity
        self.y_row.update(y.observer.velocity, attraction, coils, known, self.observer, self.corner, self.share,
                          forgotten, held)
        self.x_row.update(vx, thrust_x, drag(vx, 2e-3), 0.0, self.observer, self.corner, self.share, forgotten,
                          held)
        self.z_row.update(vz, thrust_z, drag(vz, 2e-3), 0.0, self.observer, self.corner, self.share, forgotten,
                          held)
        if not held:
            share = self.adaptation.share(self.sample_time)
            largest = self.adaptation.range
            motors.C1 = moved(motors.C1, first.C1, share, self.x_row.first, largest)
            motors.C2 = moved(motors.C2, first.C2, share, self.z_row.first, largest)
            motors.C3 = moved(motors.C3, first.C3, share, self.y_row.first, largest)
            motors.C4 = moved(motors.C4, first.C4, share, self.y_row.second, largest)

    def step(self, t: float) -> None:
        """Step one sample: learn from the commands until now, then step the regulator."""
        y = self.y
        x = self.x
        z = self.z
        motors = self.motors
        if not self.started and y.measured <= 0.0:
            return   # in another tool: nothing has been measured yet
        dt = self.sample_time
        if not self.started:
            y.start(0.0, y.measured - y.reference)
            x.start(0.0, x.measured - x.reference)
            z.start(0.0, z.measured - z.reference)
        y.sample(self.observer, dt)
        x.sample(self.observer, dt)
        z.sample(self.observer, dt)
        if self.started:
            self.learn()
        motors.command(self.alpha, self.beta, y.demand(), x.demand(), z.demand(), y.measured, x.measured, z.measured)
        if not self.started:
            self.y_row.start(y.observer.velocity, -4.0 * motors.C3 * motors.f2,
                             4.0 * motors.C4 * motors.f3 * self.alpha.i_d_cmd, GRAVITY, self.weight)
            self.x_row.start(x.observer.velocity, 0.0, 0.0, 0.0, self.weight)
            self.z_row.start(z.observer.velocity, 0.0, 0.0, 0.0, self.weight)
            self.started = True
        y.update(self.oscillator, dt * self.alpha.excess_d)
        x.update(self.oscillator, dt * self.alpha.excess_q)
        z.update(self.oscillator, dt * self.beta.excess_q)
