"""Rows of the estimator: a horizontal axis with one constant, the vertical axis with three."""

from controller_fmu.symmetric3 import Symmetric3
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver
from estimator_fmu.constant_estimate import ConstantEstimate, ConvergenceRule
from estimator_fmu.matched_filter import MatchedFilter
from estimator_fmu.velocity_model import EstimatorLaw, VelocityModel


class ThrustAxis:
    """Horizontal axis, v' = A θ with one constant, its thrust."""

    def __init__(self) -> None:
        self.measured = 0.0         # m, input
        self.velocity = 0.0         # m/s, output: by the observer
        self.residual = 0.0         # m/s², output: (y − x̂)/ε
        self.converged = False      # whether the estimate has
        self.thrust = 0.0           # state: the estimate
        self.information = 1.0      # Σ, state
        self.weight = 1.0           # Q0
        self.observer = VelocityObserver()
        self.model = VelocityModel()
        self.filter = MatchedFilter()
        self.estimate = ConstantEstimate()

    def begin(self, thrust: float, weight: float) -> None:
        """Take in the start value and its weight in Σ."""
        self.thrust = thrust
        self.information = weight
        self.weight = weight

    def seed(self, a: float) -> None:
        """Begin at rest at the measurement, with a first column of A."""
        self.observer.seed(self.measured)
        self.model.seed(0.0)
        self.filter.seed(a)

    def sample(self, a: float, matched: bool, observer_filter: ObserverFilter, law: EstimatorLaw) -> None:
        """Take in the measurement, and the column of A that goes with it; matched, that is filtered as the velocity."""
        self.observer.update(self.measured, observer_filter, law.sample_time)
        self.velocity = self.observer.velocity
        filtered = self.filter.update(a, observer_filter)
        if matched:
            a = filtered
        u = a / self.information
        gain = 0.0 if law.held else a * u
        change = self.model.advance(self.velocity, a * self.thrust, gain, law)
        self.residual = self.model.error / law.epsilon
        if gain > 0.0:
            self.thrust += u * (change / gain)
        kept = (1.0 - law.forgotten) * self.information
        self.information = kept + law.forgotten * self.weight + law.added * a * a

    def watch(self, rule: ConvergenceRule, sample_time: float) -> None:
        """Judge the convergence."""
        self.estimate.watch(self.thrust, 1.0 / self.information, self.weight, rule, sample_time)
        self.converged = self.estimate.converged


class NormalAxis:
    """Vertical axis, v' = A θ + b with three constants: attraction, magnets on coils, coils on iron."""

    def __init__(self, gap: float):
        self.measured = gap         # m, input
        self.velocity = 0.0         # m/s, output: by the observer
        self.residual = 0.0         # m/s², output: (y − x̂)/ε
        self.converged1 = False     # whether the first estimate has
        self.converged2 = False
        self.converged3 = False
        self.attraction = 0.0       # state: the first estimate
        self.coils = 0.0            # state: magnets on coils
        self.iron = 0.0             # state: coils on iron
        self.information = Symmetric3()   # Σ
        self.weight1 = 1.0          # Q0
        self.weight2 = 1.0
        self.weight3 = 1.0
        self.observer = VelocityObserver()
        self.model = VelocityModel()
        self.filter1 = MatchedFilter()
        self.filter2 = MatchedFilter()
        self.filter3 = MatchedFilter()
        self.estimate1 = ConstantEstimate()
        self.estimate2 = ConstantEstimate()
        self.estimate3 = ConstantEstimate()

    def begin(self, attraction: float, coils: float, iron: float, weight1: float, weight2: float, weight3: float
              ) -> None:
        """Take in the start values and their weights in Σ."""
        self.attraction = attraction
        self.coils = coils
        self.iron = iron
        self.weight1 = weight1
        self.weight2 = weight2
        self.weight3 = weight3
        self.information.set_diagonal(weight1, weight2, weight3)

    def seed(self, a1: float, a2: float, a3: float) -> None:
        """Begin at rest at the measurement, with a first row of A."""
        self.observer.seed(self.measured)
        self.model.seed(0.0)
        self.filter1.seed(a1)
        self.filter2.seed(a2)
        self.filter3.seed(a3)

    def sample(self, a1: float, a2: float, a3: float, b: float, matched: bool, observer_filter: ObserverFilter,
               law: EstimatorLaw) -> None:
        """Take in the measurement, and the row of A and the b that go with it; matched, A is filtered as the velocity.

        b is constant, so that it is the same when it is filtered.
        """
        self.observer.update(self.measured, observer_filter, law.sample_time)
        self.velocity = self.observer.velocity
        filtered1 = self.filter1.update(a1, observer_filter)
        filtered2 = self.filter2.update(a2, observer_filter)
        filtered3 = self.filter3.update(a3, observer_filter)
        if matched:
            a1 = filtered1
            a2 = filtered2
            a3 = filtered3
        sigma = self.information
        sigma.factorise()
        u1, u2, u3 = sigma.solve(a1, a2, a3)
        gain = a1 * u1 + a2 * u2 + a3 * u3
        if law.held or gain < 0.0:
            gain = 0.0   # negative by rounding
        acceleration = a1 * self.attraction + a2 * self.coils + a3 * self.iron + b
        change = self.model.advance(self.velocity, acceleration, gain, law)
        self.residual = self.model.error / law.epsilon
        if gain > 0.0:
            self.attraction += u1 * (change / gain)
            self.coils += u2 * (change / gain)
            self.iron += u3 * (change / gain)
        sigma.decay(law.forgotten, self.weight1, self.weight2, self.weight3)
        sigma.add_square(law.added, a1, a2, a3)

    def watch(self, rule: ConvergenceRule, sample_time: float) -> None:
        """Judge the convergence."""
        q1, q2, q3 = self.information.inverse_diagonal()
        self.estimate1.watch(self.attraction, q1, self.weight1, rule, sample_time)
        self.estimate2.watch(self.coils, q2, self.weight2, rule, sample_time)
        self.estimate3.watch(self.iron, q3, self.weight3, rule, sample_time)
        self.converged1 = self.estimate1.converged
        self.converged2 = self.estimate2.converged
        self.converged3 = self.estimate3.converged
