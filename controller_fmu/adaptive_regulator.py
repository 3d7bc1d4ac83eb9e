"""Adaptive regulator of any stage: output regulation with the constants that are estimated while it runs."""

from controller_fmu.adaptation import Adaptation, Travel, followed
from controller_fmu.estimator import Estimator
from controller_fmu.regulator import Regulator
from controller_fmu.status import NONLINEAR, STEP_MISFIT, STEPPED
from pmlsm.stage_description import StageDescription


class AdaptiveRegulator:
    """The nonlinear regulator, and the estimator (3.8) whose constants it takes over where data decide them.

    The estimator sees what the regulator measures and commands. The constant of the iron is not adapted: its effect is
    too small.
    """

    def __init__(self, stage: StageDescription):
        self.regulator = Regulator(stage, NONLINEAR)
        self.estimator = Estimator(stage)
        self.estimator.forgetting = 0.2              # 1/s, parameter
        self.estimator.matched_filter = True         # parameter
        self.estimator.convergence.tolerance = 0.05  # parameter
        self.estimator.convergence.time = 0.5        # s, parameter
        self.estimator.vertical.iron.weight = 1e12   # holds it
        self.adaptation = Adaptation()
        # Parameters: the constants that the regulator begins with.
        for axis, thrust in zip(self.estimator.horizontal, self.regulator.model.thrust, strict=True):
            axis.thrust.guess = thrust
        self.estimator.vertical.attraction.guess = stage.model.attraction
        self.estimator.vertical.coils.guess = stage.model.coils
        self.estimator.vertical.iron.guess = stage.model.iron
        stops = [axis.stop for axis in (stage.vertical, *stage.horizontal, *stage.rotations)]
        self.stopped = [k for k, stop in enumerate(stops) if stop is not None]   # axes that have stops
        self.travels = [Travel(stop.lower, stop.upper) for stop in stops if stop is not None]
        # of every motor, where it has a gap
        self.gap_travel = Travel(stage.gap_stop.lower, stage.gap_stop.upper)

    def start(self) -> int:
        """Begin with the constants that are given, and the same measurement in both parts."""
        regulator = self.regulator
        estimator = self.estimator
        model = regulator.model
        estimator.sample_time = regulator.sample_time
        estimator.observer.time1 = regulator.observer.time1
        estimator.observer.time2 = regulator.observer.time2
        for own, place in zip(estimator.platform.places, regulator.platform.places, strict=True):
            own.x = place.x
            own.z = place.z
        for k, axis in enumerate(estimator.horizontal):
            model.thrust[k] = axis.thrust.guess
        model.attraction = estimator.vertical.attraction.guess
        model.coils = estimator.vertical.coils.guess
        model.iron = estimator.vertical.iron.guess
        status = estimator.start()
        if status != STEPPED:
            return status
        return regulator.start()

    def step(self, t: float, dt: float) -> int:
        """Sample if the sampling grid has a point at t; the commands hold over t to t + dt (s)."""
        regulator = self.regulator
        if not regulator.clock.fits(dt, regulator.sample_time):
            return STEP_MISFIT
        if regulator.clock.due(dt, regulator.sample_time):
            self.sample()
        return STEPPED

    def sample(self) -> None:
        """Estimate by the commands that held until now, adapt, and run the law once."""
        if self.regulator.started:
            self.estimate()
            if not self.adaptation.frozen:
                self.adapt()
        self.regulator.sample()

    def estimate(self) -> None:
        """Show the estimator a sample, unless what happened in it misleads."""
        regulator = self.regulator
        estimator = self.estimator
        estimator.vertical.measured = regulator.axes[0].measured
        for k, axis in enumerate(estimator.horizontal):
            axis.measured = regulator.axes[k + 1].measured
        for own, place in zip(estimator.platform.places, regulator.platform.places, strict=True):
            own.gap_measured = place.gap_measured
        for motor, command in zip(estimator.motors, regulator.motors, strict=True):
            motor.i_d = command.i_d_cmd
            motor.i_q = command.i_q_cmd
        limited = regulator.saturated or regulator.tripped or not regulator.feasible
        estimator.held = self.adaptation.judge(limited or self.at_stop(), regulator.sample_time)
        estimator.take(regulator.model.layout)

    def at_stop(self) -> bool:
        """Return True if an axis or a motor's gap is at a stop."""
        for k, travel in zip(self.stopped, self.travels, strict=True):
            if travel.ends(self.regulator.axes[k].measured):
                return True
        return any(self.gap_travel.ends(place.gap_measured) for place in self.regulator.platform.places)

    def adapt(self) -> None:
        """Let the constants of a row follow their estimates, if these have converged."""
        model = self.regulator.model
        share = self.adaptation.share(self.regulator.sample_time)
        largest = self.adaptation.range
        for k, axis in enumerate(self.estimator.horizontal):
            if axis.thrust.converged:
                model.thrust[k] = followed(model.thrust[k], axis.thrust, share, largest)
        vertical = self.estimator.vertical
        if vertical.attraction.converged and vertical.coils.converged:
            model.attraction = followed(model.attraction, vertical.attraction, share, largest)
            model.coils = followed(model.coils, vertical.coils, share, largest)
