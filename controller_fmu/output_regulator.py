"""Output regulator of one axis: observer, internal model, state feedback and antiwindup (4.16), (5.11), (5.13)."""

from controller_fmu.internal_model import InternalModel, OscillatorStep
from controller_fmu.velocity_observer import ObserverFilter, VelocityObserver


class OutputRegulator:
    """Makes the position of one axis follow its reference, constant disturbances notwithstanding."""

    def __init__(self, k1: float, k2: float, k3: float, k4: float, k5: float, ec: float, position: float):
        self.k1 = k1                    # 1/s², parameter: gain of the error
        self.k2 = k2                    # 1/s, parameter: of its rate
        self.k3 = k3                    # 1/s⁵, parameter: of ξ1
        self.k4 = k4                    # 1/s⁴, parameter: of ξ2
        self.k5 = k5                    # 1/s³, parameter: of ξ3
        self.ec1 = ec                   # m s²/A, parameter: antiwindup gain on ξ1
        self.ec2 = ec                   # m s/A, parameter: on ξ2
        self.ec3 = ec                   # m/A, parameter: on ξ3
        self.friction_compensation = 0.0   # m/s², parameter: Coulomb friction over mass, 0 = none
        self.reference = position       # m, input
        self.reference_rate = 0.0       # m/s, input
        self.measured = position        # m, input
        self.observer = VelocityObserver()
        self.model = InternalModel()
        self.error = 0.0                # m, output: measured − reference
        self.error_rate = 0.0           # m/s

    def start(self, demand: float, error: float) -> None:
        """Begin at the measurement, with ξ1 such that the demand at an error (m) is this (m/s²), without its rate."""
        self.observer.seed(self.measured)
        self.model.xi1 = 0.0
        if self.k3 != -1.0:
            self.model.xi1 = (demand - self.k1 * error) / (self.k3 + 1.0)

    def sample(self, observer_filter: ObserverFilter, sample_time: float) -> None:
        """Take in measurement and reference."""
        self.observer.update(self.measured, observer_filter, sample_time)
        self.error = self.measured - self.reference
        self.error_rate = self.observer.velocity - self.reference_rate

    def demand(self) -> float:
        """Return the demanded acceleration v (m/s²), (4.16), with compensation of Coulomb friction at this speed."""
        model = self.model
        demand = (self.k1 * self.error + self.k2 * self.error_rate
                  + self.k3 * model.xi1 + self.k4 * model.xi2 + self.k5 * model.xi3 + model.xi1)
        if self.friction_compensation > 0.0:
            if self.observer.velocity > 0.0:
                demand += self.friction_compensation
            elif self.observer.velocity < 0.0:
                demand -= self.friction_compensation
        return demand

    def rescale(self, factor: float) -> None:
        """Multiply ξ1, which an interpolated law keeps as a current between samples."""
        self.model.xi1 = factor * self.model.xi1

    def update(self, oscillator: OscillatorStep, excess: float) -> None:
        """Advance the internal model by one sample (5.13).

        Parameters
        ----------
        oscillator : OscillatorStep
            The discretised internal model.
        excess : float
            Ts (sat(u) − u) of the command that serves this axis, A s; 0 without antiwindup.
        """
        self.model.update(self.error, oscillator, self.ec1 * excess, self.ec2 * excess, self.ec3 * excess)
