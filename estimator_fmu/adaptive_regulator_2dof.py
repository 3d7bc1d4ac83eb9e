"""Adaptive regulator of the 2-DOF stage: output regulation with the constants that are estimated while it runs.

pyccel finds the attributes of a part only where the class of the part is imported, used by its name or not.
"""
# ruff: noqa: F401

from controller_fmu.motor_command import MotorCommand
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.regulator_2dof import Regulator2DOF
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import NONLINEAR, STEP_MISFIT, STEPPED
from controller_fmu.velocity_observer import ObserverFilter
from estimator_fmu.adaptation import Adaptation, Travel, followed
from estimator_fmu.constant_estimate import ConstantEstimate, ConvergenceRule
from estimator_fmu.estimated_axis import NormalAxis, ThrustAxis
from estimator_fmu.estimator_2dof import Estimator2DOF
from estimator_fmu.motor_current import MotorCurrent
from pmlsm.motor_geometry import MotorGeometry


class AdaptiveRegulator2DOF:
    """The nonlinear regulator, and the estimator (3.8) whose constants it takes over where data decide them.

    The estimator sees what the regulator measures and commands. C4 is not adapted: what it does is too little.
    """

    def __init__(self) -> None:
        self.regulator = Regulator2DOF(NONLINEAR)
        self.estimator = Estimator2DOF()
        self.estimator.forgetting = 0.2              # 1/s, parameter
        self.estimator.matched_filter = True         # parameter
        self.estimator.convergence.tolerance = 0.05  # parameter
        self.estimator.convergence.time = 0.5        # s, parameter
        self.estimator.v.iron.weight = 1e12      # holds C4
        self.adaptation = Adaptation()
        # Parameters: the constants that the regulator begins with.
        self.estimator.h.thrust.guess = 14.2
        self.estimator.v.attraction.guess = 796.99
        self.estimator.v.coils.guess = 31.04
        self.estimator.v.iron.guess = 0.07
        self.v_travel = Travel(0.008, 0.028)
        self.h_travel = Travel(-0.07, 0.07)

    def start(self) -> int:
        """Begin with the constants that are given, and the same measurement in both parts."""
        regulator = self.regulator
        estimator = self.estimator
        estimator.sample_time = regulator.sample_time
        estimator.observer.time1 = regulator.observer.time1
        estimator.observer.time2 = regulator.observer.time2
        regulator.C1 = estimator.h.thrust.guess
        regulator.C2 = estimator.v.attraction.guess
        regulator.C3 = estimator.v.coils.guess
        regulator.C4 = estimator.v.iron.guess
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
        estimator.v.measured = regulator.v.measured
        estimator.h.measured = regulator.h.measured
        estimator.motor.i_d = regulator.motor.i_d_cmd
        estimator.motor.i_q = regulator.motor.i_q_cmd
        at_stop = self.v_travel.ends(regulator.v.measured) or self.h_travel.ends(regulator.h.measured)
        limited = regulator.saturated or regulator.tripped or not regulator.feasible
        estimator.held = self.adaptation.judge(limited or at_stop, regulator.sample_time)
        estimator.take(regulator.geometry)

    def adapt(self) -> None:
        """Let the constants of a row follow their estimates, if these have converged."""
        regulator = self.regulator
        estimator = self.estimator
        share = self.adaptation.share(regulator.sample_time)
        largest = self.adaptation.range
        if estimator.h.thrust.converged:
            regulator.C1 = followed(regulator.C1, estimator.h.thrust, share, largest)
        v = estimator.v
        if v.attraction.converged and v.coils.converged:
            regulator.C2 = followed(regulator.C2, v.attraction, share, largest)
            regulator.C3 = followed(regulator.C3, v.coils, share, largest)
