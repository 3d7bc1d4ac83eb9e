"""Estimator of the constants of the 5-DOF stage while it moves (sections 3.1.3, 4.3, 5.3)."""

from controller_fmu.motor_place import MotorPlace
from controller_fmu.platform_5dof import measure_tilts, prepare_platform
from controller_fmu.sample_clock import SampleClock
from controller_fmu.status import BAD_GEOMETRY, BAD_PLACES, STEP_MISFIT, STEPPED
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from controller_fmu.velocity_observer import ObserverFilter
from estimator_fmu.constant_estimate import ConvergenceRule
from estimator_fmu.estimated_axis import NormalAxis, ThrustAxis
from estimator_fmu.motor_current import MotorCurrent
from estimator_fmu.motor_rows import MotorRows
from estimator_fmu.velocity_model import EstimatorLaw
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.velocity_rows import GRAVITY


class Estimator5DOF:
    """Samples positions and delivered currents, estimates C1 to C5 by the reduced NPFSI estimator (3.8)."""

    def __init__(self) -> None:
        self.epsilon = 0.01              # s, parameter
        self.gamma = 1.1                 # parameter
        self.forgetting = 0.0            # 1/s, parameter, 0 = off
        self.matched_filter = False      # parameter
        self.held = False                # parameter
        self.sample_time = 0.0002        # s, parameter
        self.geometry = MotorGeometry()
        # Guesses of the constants of each row, and their weights, the diagonal of Q0.
        self.y = NormalAxis(0.025, 163.75, 4.24, 0.0035, 1e-06, 0.0001, 0.1)
        self.x = ThrustAxis(0.3068, 0.01)
        self.z = ThrustAxis(0.4112, 0.01)
        self.alpha1 = MotorCurrent()
        self.alpha2 = MotorCurrent()
        self.beta1 = MotorCurrent()
        self.beta2 = MotorCurrent()
        self.platform = TiltingPlatform(-0.03)
        self.tilts = TiltMeasurement()
        self.alpha1_place = MotorPlace(0.0, 0.2, 0.025)
        self.alpha2_place = MotorPlace(0.0, -0.2, 0.025)
        self.beta1_place = MotorPlace(0.2, 0.0, 0.025)
        self.beta2_place = MotorPlace(-0.2, 0.0, 0.025)
        self.rows = MotorRows(1.0)
        self.observer = ObserverFilter()
        self.convergence = ConvergenceRule()
        self.law = EstimatorLaw()
        self.clock = SampleClock()
        self.started = False         # state: a measurement has come in

    def start(self) -> int:
        """Begin with the guesses and their weights."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        if not prepare_platform(self.platform, self.alpha1_place, self.alpha2_place, self.beta1_place,
                                self.beta2_place):
            return BAD_PLACES
        self.observer.prepare(self.sample_time)
        self.x.begin()
        self.z.begin()
        self.y.begin()
        return STEPPED

    def step(self, t: float, dt: float) -> int:
        """Sample if the sampling grid has a point at t; the estimates hold over t to t + dt (s)."""
        if not self.clock.fits(dt, self.sample_time):
            return STEP_MISFIT
        if self.clock.due(dt, self.sample_time):
            self.sample()
        return STEPPED

    def sample(self) -> None:
        """Take in a sample, with the geometry of the estimator's own parameters."""
        self.take(self.geometry)

    def take(self, geometry: MotorGeometry) -> None:
        """Take in a sample: the rows of A(y, u), then one step of the estimator on each."""
        y = self.y
        if not measure_tilts(self.tilts, self.alpha1_place, self.alpha2_place, self.beta1_place, self.beta2_place):
            return   # an importer that has not exchanged values yet: this is no measurement
        y.measured = self.tilts.y
        rows = self.rows
        rows.clear()
        thrust_x = (rows.add(geometry, self.alpha1_place.gap_measured, self.alpha1)
                    + rows.add(geometry, self.alpha2_place.gap_measured, self.alpha2))
        thrust_z = (rows.add(geometry, self.beta1_place.gap_measured, self.beta1)
                    + rows.add(geometry, self.beta2_place.gap_measured, self.beta2))
        attraction = rows.attraction
        coils = rows.coils
        iron = rows.iron
        if not self.started:
            self.started = True
            y.seed(attraction, coils, iron)
            self.x.seed(thrust_x)
            self.z.seed(thrust_z)
        law = self.law
        law.prepare(self.sample_time, self.epsilon, self.gamma, self.forgetting)
        if self.held:
            law.hold()
        y.sample(attraction, coils, iron, GRAVITY, self.matched_filter, self.observer, law, self.convergence)
        self.x.sample(thrust_x, self.matched_filter, self.observer, law, self.convergence)
        self.z.sample(thrust_z, self.matched_filter, self.observer, law, self.convergence)
