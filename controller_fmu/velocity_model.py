"""One velocity row of the estimator (3.8) over a sample: the model's velocity follows the measured one."""

from math import sqrt

from pmlsm.exponential import exponential
from pmlsm.logarithm import logarithm_one_plus
from pmlsm.sine_cosine import LARGEST_REDUCED, sine_cosine, sine_of_turns
from pmlsm.whole_numbers import fraction

LARGEST_GROWTH = 0.05        # of Σ, in the direction of the regressor, over one part of a sample
ONE_OVER_TWO_PI = 0.15915494309189535
NEARLY_CRITICAL = 1.0e-8     # (r τ)² below which the two rates of the filter count as one


class EstimatorLaw:
    """Settings of the estimator, and the quantities of a sample that follow from them."""

    def __init__(self) -> None:
        self.sample_time = 1.0e-3   # s
        self.epsilon = 0.01         # ε, s
        self.growth = 0.0           # 1 − γ⁻², of Σ' = AᵀA − γ⁻² AᵀA
        self.forgotten = 0.0        # share of Σ that a sample forgets
        self.added = 0.0            # s, weight of a sample's AᵀA in Σ
        self.held = False           # true if the estimates and Σ do not change

    def prepare(self, sample_time: float, epsilon: float, gamma: float, forgetting: float) -> None:
        """Take in the parameters: sample time (s), ε (s), γ, rate of forgetting (1/s)."""
        self.sample_time = sample_time
        self.epsilon = epsilon
        self.growth = 1.0 - 1.0 / (gamma * gamma)
        self.held = False
        self.forgotten = 0.0
        self.added = self.growth * sample_time
        if forgetting > 0.0:
            self.forgotten = 1.0 - exponential(-forgetting * sample_time)
            self.added = self.growth * self.forgotten / forgetting

    def hold(self) -> None:
        """Ignore this sample, except for the velocity, which the model continues to follow."""
        self.held = True
        self.forgotten = 0.0
        self.added = 0.0


class VelocityModel:
    """x̂' = A θ̂ + b + (y − x̂)/ε of one row, together with the θ̂' that acts on it.

    With y, A and b held over a sample, Σ⁻¹Aᵀ keeps its direction and only shrinks, since Σ grows by AᵀA alone. This
    leaves two numbers, the error e = y − x̂ and the model's acceleration w = A θ̂ + b:

        e' = −w − e/ε,   w' = s e/ε,   s = A Σ⁻¹ Aᵀ,   s' = −(1 − γ⁻²) s²

    They are advanced by the exact solution for the mean s, over parts of the sample in which s changes little. An
    undamped or a stiff error, which Euler's method would let grow, therefore needs no shorter sample time.
    """

    def __init__(self) -> None:
        self.error = 0.0       # e, m/s, state
        self.velocity = 0.0    # x̂, m/s, state

    def seed(self, measured: float) -> None:
        """Begin at a measured velocity (m/s)."""
        self.velocity = measured
        self.error = 0.0

    def advance(self, measured: float, acceleration: float, gain: float, law: EstimatorLaw) -> float:
        """Advance by one sample; returns the change of the model's acceleration over it, m/s².

        Parameters
        ----------
        measured : float
            y, m/s, held over the sample.
        acceleration : float
            w at the start of the sample, m/s².
        gain : float
            s at the start of the sample, 1/s.
        law : EstimatorLaw
        """
        error = measured - self.velocity
        w = acceleration
        remaining = law.sample_time
        while remaining > 0.0:
            tau = remaining
            if law.growth * gain * remaining > LARGEST_GROWTH:
                tau = LARGEST_GROWTH / (law.growth * gain)
            remaining = remaining - tau if tau < remaining else 0.0
            x = law.growth * gain * tau
            mean = gain
            if x > 0.0:
                mean = logarithm_one_plus(x) / (law.growth * tau)
            to_error, by_w, to_w, kept = two_states(mean, law.epsilon, tau)
            error, w = to_error * error - by_w * w, to_w * error + kept * w
            gain = gain / (1.0 + x)
        self.error = error
        self.velocity = measured - error
        return w - acceleration


def two_states(gain: float, epsilon: float, tau: float) -> tuple[float, float, float, float]:
    """Exact solution of e' = −w − e/ε, w' = s e/ε over τ (s), as p, q, r, k: e ← p e − q w, w ← r e + k w."""
    damping = 0.5 / epsilon
    stiffness = gain / epsilon
    discriminant = damping * damping - stiffness
    if discriminant * tau * tau > NEARLY_CRITICAL:
        root = sqrt(discriminant)
        fast = exponential(-(damping + root) * tau)
        slow = exponential(-stiffness / (damping + root) * tau)
        c = 0.5 * (slow + fast)
        s = 0.5 * (slow - fast) / root
    elif discriminant * tau * tau < -NEARLY_CRITICAL:
        root = sqrt(-discriminant)
        left = exponential(-damping * tau)
        angle = root * tau
        if angle > LARGEST_REDUCED:   # as close as the angle is, whose own rounding is the larger part by far
            turns = fraction(ONE_OVER_TWO_PI * angle)
            sine = sine_of_turns(turns)
            cosine = sine_of_turns(turns + 0.25)
        else:
            sine, cosine = sine_cosine(angle)
        c = left * cosine
        s = left * sine / root
    else:
        c = exponential(-damping * tau)
        s = c * tau
    return c - damping * s, s, stiffness * s, c + damping * s
