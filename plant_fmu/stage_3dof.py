"""The 3-DOF stage: motor pairs alpha and beta carry the mover (y, the air gap) and drive it along x and z."""

from plant_fmu.attraction import attraction_factor
from plant_fmu.axis import Axis
from plant_fmu.encoder import Encoder
from plant_fmu.integration import LONGEST_COMMUNICATION_STEP, integration_steps
from plant_fmu.motor_supply import MotorSupply
from pmlsm.data_sheet import (
    CONTINUOUS_CURRENT_3DOF,
    ENCODER_RESOLUTION,
    MASS_X,
    MASS_Y,
    MASS_Z,
    MOTORS_3DOF,
    MOTORS_IN_PAIR,
    PEAK_CURRENT_3DOF,
    SLOT_PITCH,
)
from pmlsm.gap_functions import gap_functions
from pmlsm.velocity_rows import normal_acceleration, thrust_acceleration

LONGEST_STEP = 0.2e-3   # s; docs/accuracy.md has the study behind it

STARTED = 0           # status of `start` and `step`
Y_BEYOND_STOP = 1
X_BEYOND_STOP = 2
Z_BEYOND_STOP = 3
RUN_AWAY = 4
STEP_TOO_LONG = 5


class Stage3DOF:
    """Motion (5.3) of the 3-DOF stage with friction, bias, ripple, stops, amplifiers and encoders."""

    def __init__(self) -> None:
        self.C1 = 0.6135     # m/(s² A), parameter: thrust along x
        self.C2 = 0.8224     # m/(s² A), parameter: thrust along z
        self.C3 = 334.52     # m/(s² T²), parameter: attraction
        self.C4 = 8.71       # m/(s² A T), parameter: magnets on coils
        self.C5 = 0.0045     # m/(s² A²), parameter: coils on iron
        self.attraction_modulation = 0.0135   # parameter
        self.y = Axis(MASS_Y, 0.1, 2.0, 0.5e-3, 2.0, 18.5e-3, 32.0e-3, 25.0e-3)
        self.x = Axis(MASS_X, 0.05, 2.4, 0.5e-3, 2.0, -62.0e-3, 62.0e-3, 0.0)
        self.z = Axis(MASS_Z, 0.05, 2.2, 0.5e-3, 2.0, -62.0e-3, 62.0e-3, 0.0)
        self.y.ripple.amplitude = 0.15
        self.x.ripple.period = SLOT_PITCH
        self.z.ripple.period = SLOT_PITCH
        self.alpha = MotorSupply(PEAK_CURRENT_3DOF, CONTINUOUS_CURRENT_3DOF)
        self.beta = MotorSupply(PEAK_CURRENT_3DOF, CONTINUOUS_CURRENT_3DOF)
        self.encoder = Encoder(ENCODER_RESOLUTION)
        self.at_stop = False   # output

    def start(self) -> int:
        """Place the mover at its start position; the status says which axis is beyond a stop."""
        if not self.y.start():
            return Y_BEYOND_STOP
        if not self.x.start():
            return X_BEYOND_STOP
        if not self.z.start():
            return Z_BEYOND_STOP
        self.measure()
        return STARTED

    def step(self, t: float, dt: float) -> int:
        """Move from t to t + dt (s) with the inputs held."""
        if dt > LONGEST_COMMUNICATION_STEP:
            return STEP_TOO_LONG
        steps = integration_steps(dt, LONGEST_STEP)
        part = dt / steps
        self.at_stop = self.beyond_stop()
        for _ in range(steps):
            meeting = self.time_to_stop(part)
            contained = self.integrate(meeting)
            if contained and meeting < part:
                contained = self.integrate(part - meeting)
            if not contained:
                return RUN_AWAY
        self.alpha.deliver(self.x.position)
        self.beta.deliver(self.z.position)
        self.measure()
        return STARTED

    def integrate(self, dt: float) -> bool:
        """Move over one integration step dt (s); False where the mover has run away."""
        y = self.y
        x = self.x
        z = self.z
        alpha = self.alpha
        beta = self.beta
        alpha.advance(dt)
        beta.advance(dt)
        y.begin()
        x.begin()
        z.begin()
        alpha.at_start(x.position)
        beta.at_start(z.position)
        self.add_slope(dt / 6.0, dt / 2.0)
        alpha.at_middle(x.position)
        beta.at_middle(z.position)
        self.add_slope(dt / 3.0, dt / 2.0)
        alpha.at_middle(x.position)
        beta.at_middle(z.position)
        self.add_slope(dt / 3.0, dt)
        alpha.at_end(x.position)
        beta.at_end(z.position)
        self.add_slope(dt / 6.0, 0.0)
        contained = y.finish() and x.finish() and z.finish()
        if self.beyond_stop():
            self.at_stop = True
        return contained

    def add_slope(self, weight: float, ahead: float) -> None:
        """Add one Runge–Kutta slope on all axes (5.3)."""
        f1, f2, f3, f4 = gap_functions(self.y.position)
        f2 *= attraction_factor(self.attraction_modulation, self.x.position)
        i_da = self.alpha.i_d
        i_qa = self.alpha.i_q
        i_db = self.beta.i_d
        i_qb = self.beta.i_q
        all_motors = MOTORS_3DOF * self.y.mass_ratio
        pair = MOTORS_IN_PAIR * self.y.mass_ratio
        y_motors = normal_acceleration(all_motors * self.C3, pair * self.C4, pair * self.C5, f2, f3, f4,
                                       i_da + i_db, i_qa * i_qa + i_da * i_da + i_qb * i_qb + i_db * i_db)
        x_motors = thrust_acceleration(MOTORS_IN_PAIR * self.x.mass_ratio * self.C1, f1, i_qa)
        z_motors = thrust_acceleration(MOTORS_IN_PAIR * self.z.mass_ratio * self.C2, f1, i_qb)
        self.y.add_slope(y_motors, weight, ahead)
        self.x.add_slope(x_motors, weight, ahead)
        self.z.add_slope(z_motors, weight, ahead)

    def time_to_stop(self, dt: float) -> float:
        """Time (s) in which the first axis meets an end stop; dt if none does within dt."""
        dt = self.y.time_to_stop(dt)
        dt = self.x.time_to_stop(dt)
        return self.z.time_to_stop(dt)

    def beyond_stop(self) -> bool:
        """Whether any axis is beyond an end stop."""
        return self.y.beyond_stop() or self.x.beyond_stop() or self.z.beyond_stop()

    def measure(self) -> None:
        """Set the encoder outputs."""
        self.y.encoder = self.encoder.measure(self.y.position)
        self.x.encoder = self.encoder.measure(self.x.position)
        self.z.encoder = self.encoder.measure(self.z.position)
