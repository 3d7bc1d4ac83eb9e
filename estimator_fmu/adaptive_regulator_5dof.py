"""Adaptive regulator of the 5-DOF stage: output regulation with the constants that are estimated while it runs.

pyccel finds the attributes of a part only where the class of the part is imported, used by its name or not.
"""
# ruff: noqa: F401

from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_place import MotorPlace
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.regulator_5dof import Regulator5DOF
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import NONLINEAR, STEP_MISFIT, STEPPED
from controller_fmu.velocity_observer import ObserverFilter
from estimator_fmu.adaptation import Adaptation, Travel, followed
from estimator_fmu.constant_estimate import ConstantEstimate, ConvergenceRule
from estimator_fmu.estimated_axis import NormalAxis, ThrustAxis
from estimator_fmu.estimator_5dof import Estimator5DOF
from estimator_fmu.motor_current import MotorCurrent
from pmlsm.motor_geometry import MotorGeometry


class AdaptiveRegulator5DOF:
    """The nonlinear regulator, and the estimator (3.8) whose constants it takes over where data decide them.

    The estimator sees what the regulator measures and commands. C5 is not adapted: what it does is too little.
    """

    def __init__(self) -> None:
        self.regulator = Regulator5DOF(NONLINEAR)
        self.estimator = Estimator5DOF()
        self.estimator.forgetting = 0.2              # 1/s, parameter
        self.estimator.matched_filter = True         # parameter
        self.estimator.convergence.tolerance = 0.05  # parameter
        self.estimator.convergence.time = 0.5        # s, parameter
        self.estimator.y.iron.weight = 1e12      # holds C5
        self.adaptation = Adaptation()
        # Parameters: the constants that the regulator begins with.
        self.estimator.x.thrust.guess = 0.6135
        self.estimator.z.thrust.guess = 0.8224
        self.estimator.y.attraction.guess = 327.5
        self.estimator.y.coils.guess = 8.48
        self.estimator.y.iron.guess = 0.007
        self.x_travel = Travel(-0.062, 0.062)
        self.z_travel = Travel(-0.062, 0.062)
        self.gap_travel = Travel(0.0185, 0.032)   # of every motor

    def start(self) -> int:
        """Begin with the constants that are given, and the same measurement in both parts."""
        regulator = self.regulator
        estimator = self.estimator
        estimator.sample_time = regulator.sample_time
        estimator.observer.time1 = regulator.observer.time1
        estimator.observer.time2 = regulator.observer.time2
        estimator.alpha1_place.x = regulator.alpha1_place.x
        estimator.alpha1_place.z = regulator.alpha1_place.z
        estimator.alpha2_place.x = regulator.alpha2_place.x
        estimator.alpha2_place.z = regulator.alpha2_place.z
        estimator.beta1_place.x = regulator.beta1_place.x
        estimator.beta1_place.z = regulator.beta1_place.z
        estimator.beta2_place.x = regulator.beta2_place.x
        estimator.beta2_place.z = regulator.beta2_place.z
        regulator.C1 = estimator.x.thrust.guess
        regulator.C2 = estimator.z.thrust.guess
        regulator.C3 = estimator.y.attraction.guess
        regulator.C4 = estimator.y.coils.guess
        regulator.C5 = estimator.y.iron.guess
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
        regulator = self.regulator
        if regulator.started:
            self.estimate()
            if not self.adaptation.frozen:
                self.adapt()
        regulator.sample()

    def estimate(self) -> None:
        """Show the estimator a sample, unless what happened in it misleads."""
        regulator = self.regulator
        estimator = self.estimator
        estimator.x.measured = regulator.x.measured
        estimator.z.measured = regulator.z.measured
        estimator.alpha1_place.gap_measured = regulator.alpha1_place.gap_measured
        estimator.alpha1.i_d = regulator.alpha1.i_d_cmd
        estimator.alpha1.i_q = regulator.alpha1.i_q_cmd
        estimator.alpha2_place.gap_measured = regulator.alpha2_place.gap_measured
        estimator.alpha2.i_d = regulator.alpha2.i_d_cmd
        estimator.alpha2.i_q = regulator.alpha2.i_q_cmd
        estimator.beta1_place.gap_measured = regulator.beta1_place.gap_measured
        estimator.beta1.i_d = regulator.beta1.i_d_cmd
        estimator.beta1.i_q = regulator.beta1.i_q_cmd
        estimator.beta2_place.gap_measured = regulator.beta2_place.gap_measured
        estimator.beta2.i_d = regulator.beta2.i_d_cmd
        estimator.beta2.i_q = regulator.beta2.i_q_cmd
        at_stop = (self.x_travel.ends(regulator.x.measured) or self.z_travel.ends(regulator.z.measured)
                   or self.gap_travel.ends(regulator.alpha1_place.gap_measured)
                   or self.gap_travel.ends(regulator.alpha2_place.gap_measured)
                   or self.gap_travel.ends(regulator.beta1_place.gap_measured)
                   or self.gap_travel.ends(regulator.beta2_place.gap_measured))
        limited = regulator.saturated or regulator.tripped or not regulator.feasible
        estimator.held = self.adaptation.judge(limited or at_stop, regulator.sample_time)
        estimator.take(regulator.geometry)

    def adapt(self) -> None:
        """Let the constants of a row follow their estimates, if these have converged."""
        regulator = self.regulator
        estimator = self.estimator
        share = self.adaptation.share(regulator.sample_time)
        largest = self.adaptation.range
        if estimator.x.thrust.converged:
            regulator.C1 = followed(regulator.C1, estimator.x.thrust, share, largest)
        if estimator.z.thrust.converged:
            regulator.C2 = followed(regulator.C2, estimator.z.thrust, share, largest)
        y = estimator.y
        if y.attraction.converged and y.coils.converged:
            regulator.C3 = followed(regulator.C3, y.attraction, share, largest)
            regulator.C4 = followed(regulator.C4, y.coils, share, largest)
