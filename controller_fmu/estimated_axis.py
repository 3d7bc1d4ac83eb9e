"""Rows of the estimator: a horizontal axis with one constant, the vertical axis with three."""

from controller_fmu.constant_estimate import ConstantEstimate, ConvergenceRule
from controller_fmu.matched_filter import MatchedFilter
from controller_fmu.symmetric3 import Symmetric3
from controller_fmu.velocity_model import EstimatorLaw, VelocityModel
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver


class ThrustAxis:
    """Horizontal axis, v' = A θ with one constant, its thrust."""

    def __init__(self, guess: float, weight: float):
        self.measured = 0.0         # m, input
        self.velocity = 0.0         # m/s, output: by the observer
        self.residual = 0.0         # m/s², output: (y − x̂)/ε
        self.thrust = ConstantEstimate(guess, weight)
        self.information = 1.0      # Σ, state
        self.observer = VelocityObserver()
        self.model = VelocityModel()
        self.filter = MatchedFilter()

    def begin(self) -> None:
        """Begin at the guess, with its weight in Σ."""
        self.thrust.begin()
        self.information = self.thrust.weight

    def seed(self, a: float) -> None:
        """Begin at rest at the measurement, with a first column of A."""
        self.observer.seed(self.measured)
        self.model.seed(0.0)
        self.filter.seed(a)

    def sample(self, a: float, matched: bool, observer_filter: ObserverFilter, law: EstimatorLaw,
               rule: ConvergenceRule) -> None:
        """Take in the measurement, and the column of A that goes with it; matched, that is filtered as the velocity."""
        self.observer.update(self.measured, observer_filter, law.sample_time)
        self.velocity = self.observer.velocity
        filtered = self.filter.update(a, observer_filter)
        if matched:
            a = filtered
        u = a / self.information
        gain = 0.0 if law.held else a * u
        change = self.model.advance(self.velocity, a * self.thrust.value, gain, law)
        self.residual = self.model.error / law.epsilon
        if gain > 0.0:
            self.thrust.value += u * (change / gain)
        kept = (1.0 - law.forgotten) * self.information
        self.information = kept + law.forgotten * self.thrust.weight + law.added * a * a
        self.thrust.watch(1.0 / self.information, rule, law.sample_time)


class NormalAxis:
    """Vertical axis, v' = A θ + b with three constants: attraction, magnets on coils, coils on iron."""

    def __init__(self, gap: float, attraction: float, coils: float, iron: float, attraction_weight: float,
                 coils_weight: float, iron_weight: float):
        self.measured = gap         # m, input
        self.velocity = 0.0         # m/s, output: by the observer
        self.residual = 0.0         # m/s², output: (y − x̂)/ε
        self.attraction = ConstantEstimate(attraction, attraction_weight)
        self.coils = ConstantEstimate(coils, coils_weight)
        self.iron = ConstantEstimate(iron, iron_weight)
        self.information = Symmetric3()   # Σ
        self.observer = VelocityObserver()
        self.model = VelocityModel()
        self.filter1 = MatchedFilter()
        self.filter2 = MatchedFilter()
        self.filter3 = MatchedFilter()

    def begin(self) -> None:
        """Begin at the guesses, with their weights in Σ."""
        self.attraction.begin()
        self.coils.begin()
        self.iron.begin()
        self.information.set_diagonal(self.attraction.weight, self.coils.weight, self.iron.weight)

    def seed(self, a1: float, a2: float, a3: float) -> None:
        """Begin at rest at the measurement, with a first row of A."""
        self.observer.seed(self.measured)
        self.model.seed(0.0)
        self.filter1.seed(a1)
        self.filter2.seed(a2)
        self.filter3.seed(a3)

    def sample(self, a1: float, a2: float, a3: float, b: float, matched: bool, observer_filter: ObserverFilter,
               law: EstimatorLaw, rule: ConvergenceRule) -> None:
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
        attraction = self.attraction
        coils = self.coils
        iron = self.iron
        sigma = self.information
        sigma.factorise()
        u1, u2, u3 = sigma.solve(a1, a2, a3)
        gain = a1 * u1 + a2 * u2 + a3 * u3
        if law.held or gain < 0.0:
            gain = 0.0   # negative by rounding
        acceleration = a1 * attraction.value + a2 * coils.value + a3 * iron.value + b
        change = self.model.advance(self.velocity, acceleration, gain, law)
        self.residual = self.model.error / law.epsilon
        if gain > 0.0:
            attraction.value += u1 * (change / gain)
            coils.value += u2 * (change / gain)
            iron.value += u3 * (change / gain)
        sigma.decay(law.forgotten, attraction.weight, coils.weight, iron.weight)
        sigma.add_square(law.added, a1, a2, a3)
        q1, q2, q3 = sigma.inverse_diagonal()
        attraction.watch(q1, rule, law.sample_time)
        coils.watch(q2, rule, law.sample_time)
        iron.watch(q3, rule, law.sample_time)
