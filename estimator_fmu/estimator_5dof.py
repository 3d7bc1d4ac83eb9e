"""Estimator of the constants of the 5-DOF stage while it moves (sections 3.1.3, 4.3, 5.3)."""

from controller_fmu.motor_place import MotorPlace
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
        self.C1_start = 0.3068           # m/(s² A), parameter: guess of C1
        self.C2_start = 0.4112           # m/(s² A), parameter: guess of C2
        self.C3_start = 163.75           # m/(s² T²), parameter: guess of C3
        self.C4_start = 4.24             # m/(s² A T), parameter: guess of C4
        self.C5_start = 0.0035           # m/(s² A²), parameter: guess of C5
        self.C1_weight = 0.01            # parameter: diagonal of Q0
        self.C2_weight = 0.01            # parameter: diagonal of Q0
        self.C3_weight = 1e-06           # parameter: diagonal of Q0
        self.C4_weight = 0.0001          # parameter: diagonal of Q0
        self.C5_weight = 0.1             # parameter: diagonal of Q0
        self.epsilon = 0.01              # s, parameter
        self.gamma = 1.1                 # parameter
        self.forgetting = 0.0            # 1/s, parameter, 0 = off
        self.matched_filter = False      # parameter
        self.held = False                # parameter
        self.sample_time = 0.0002        # s, parameter
        self.geometry = MotorGeometry()
        self.y = NormalAxis(0.025)
        self.x = ThrustAxis()
        self.z = ThrustAxis()
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
        self.C1 = 0.3068   # m/(s² A), output
        self.C2 = 0.4112   # m/(s² A), output
        self.C3 = 163.75   # m/(s² T²), output
        self.C4 = 4.24   # m/(s² A T), output
        self.C5 = 0.0035   # m/(s² A²), output
        self.C1_converged = False    # output
        self.C2_converged = False    # output
        self.C3_converged = False    # output
        self.C4_converged = False    # output
        self.C5_converged = False    # output

    def start(self) -> int:
        """Begin with the start values and their weights."""
        if not self.geometry.prepare():
            return BAD_GEOMETRY
        if not self.prepare_platform():
            return BAD_PLACES
        self.observer.prepare(self.sample_time)
        self.x.begin(self.C1_start, self.C1_weight)
        self.z.begin(self.C2_start, self.C2_weight)
        self.y.begin(self.C3_start, self.C4_start, self.C5_start, self.C3_weight, self.C4_weight, self.C5_weight)
        self.publish()
        return STEPPED

    def prepare_platform(self) -> bool:
        """Compute each motor's share; whether the motors feel and make every tilt."""
        platform = self.platform
        platform.begin()
        platform.add(self.alpha1_place)
        platform.add(self.alpha2_place)
        platform.add(self.beta1_place)
        platform.add(self.beta2_place)
        if not platform.solvable():
            return False
        platform.share(self.alpha1_place)
        platform.share(self.alpha2_place)
        platform.share(self.beta1_place)
        platform.share(self.beta2_place)
        return True

    def step(self, t: float, dt: float) -> int:
        """Sample if the sampling grid has a point at t; the estimates hold over t to t + dt (s)."""
        if not self.clock.fits(dt, self.sample_time):
            return STEP_MISFIT
        if self.clock.due(dt, self.sample_time):
            self.sample()
        return STEPPED

    def sample(self) -> None:
        """Take in a sample: the rows of A(y, u), then one step of the estimator on each."""
        y = self.y
        x = self.x
        z = self.z
        alpha1 = self.alpha1
        alpha2 = self.alpha2
        beta1 = self.beta1
        beta2 = self.beta2
        alpha1_place = self.alpha1_place
        alpha2_place = self.alpha2_place
        beta1_place = self.beta1_place
        beta2_place = self.beta2_place
        if (alpha1_place.gap_measured <= 0.0 or alpha2_place.gap_measured <= 0.0 or beta1_place.gap_measured <= 0.0
                or beta2_place.gap_measured <= 0.0):
            return   # an importer that has not exchanged values yet: this is no measurement
        self.measure()
        rows = self.rows
        rows.clear()
        thrust_x = (rows.add(self.geometry, alpha1_place.gap_measured, alpha1)
                    + rows.add(self.geometry, alpha2_place.gap_measured, alpha2))
        thrust_z = (rows.add(self.geometry, beta1_place.gap_measured, beta1)
                    + rows.add(self.geometry, beta2_place.gap_measured, beta2))
        attraction = rows.attraction
        coils = rows.coils
        iron = rows.iron
        if not self.started:
            self.started = True
            y.seed(attraction, coils, iron)
            x.seed(thrust_x)
            z.seed(thrust_z)
        law = self.law
        law.prepare(self.sample_time, self.epsilon, self.gamma, self.forgetting)
        if self.held:
            law.hold()
        y.sample(attraction, coils, iron, GRAVITY, self.matched_filter, self.observer, law)
        x.sample(thrust_x, self.matched_filter, self.observer, law)
        z.sample(thrust_z, self.matched_filter, self.observer, law)
        y.watch(self.convergence, self.sample_time)
        x.watch(self.convergence, self.sample_time)
        z.watch(self.convergence, self.sample_time)
        self.publish()

    def measure(self) -> None:
        """Compute the air gap at the centre from the gaps at the motors."""
        tilts = self.tilts
        tilts.clear()
        tilts.add(self.alpha1_place, self.alpha1_place.gap_measured)
        tilts.add(self.alpha2_place, self.alpha2_place.gap_measured)
        tilts.add(self.beta1_place, self.beta1_place.gap_measured)
        tilts.add(self.beta2_place, self.beta2_place.gap_measured)
        self.y.measured = tilts.y

    def publish(self) -> None:
        """Set the outputs."""
        y = self.y
        x = self.x
        z = self.z
        self.C1 = x.thrust
        self.C2 = z.thrust
        self.C3 = y.attraction
        self.C4 = y.coils
        self.C5 = y.iron
        self.C1_converged = x.converged
        self.C2_converged = z.converged
        self.C3_converged = y.converged1
        self.C4_converged = y.converged2
        self.C5_converged = y.converged3
