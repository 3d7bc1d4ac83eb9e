"""The 2-DOF stage: one motor carries the mover vertically (v, the air gap) and drives it horizontally (h)."""

from plant_fmu.attraction import attraction_factor
from plant_fmu.axis import Axis
from plant_fmu.encoder import Encoder
from plant_fmu.integration import LONGEST_COMMUNICATION_STEP, integration_steps
from plant_fmu.motor_supply import MotorSupply
from pmlsm.data_sheet import (
    CONTINUOUS_CURRENT_2DOF,
    ENCODER_RESOLUTION,
    MASS_H,
    MASS_V,
    PEAK_CURRENT_2DOF,
    SLOT_PITCH,
)
from pmlsm.gap_functions import gap_functions
from pmlsm.velocity_rows import normal_acceleration, thrust_acceleration

LONGEST_STEP = 0.25e-3   # s; docs/accuracy.md has the study behind it

STARTED = 0           # status of `start` and `step`
V_BEYOND_STOP = 1
H_BEYOND_STOP = 2
RUN_AWAY = 3
STEP_TOO_LONG = 4


class Stage2DOF:
    """Motion (4.3) of the 2-DOF stage with friction, bias, ripple, stops, amplifiers and encoders."""

    def __init__(self) -> None:
        self.C1 = 14.20      # m/(s² A), parameter: thrust
        self.C2 = 791.00     # m/(s² T²), parameter: attraction
        self.C3 = 30.90      # m/(s² A T), parameter: magnets on coils
        self.C4 = 0.12       # m/(s² A²), parameter: coils on iron
        self.attraction_modulation = 0.027   # parameter
        self.v = Axis(MASS_V, 0.2, 4.0, 0.3e-3, 2.0, 8.0e-3, 28.0e-3, 20.0e-3)
        self.h = Axis(MASS_H, 0.1, 0.5, 0.3e-3, 1.0, -70.0e-3, 70.0e-3, 0.0)
        self.h.ripple.period = SLOT_PITCH
        self.motor = MotorSupply(PEAK_CURRENT_2DOF, CONTINUOUS_CURRENT_2DOF)
        self.encoder = Encoder(ENCODER_RESOLUTION)
        self.at_stop = False   # output

    def start(self) -> int:
        """Place the mover at its start position; the status says which axis is beyond a stop."""
        if not self.v.start():
            return V_BEYOND_STOP
        if not self.h.start():
            return H_BEYOND_STOP
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
        self.motor.deliver(self.h.position)
        self.measure()
        return STARTED

    def integrate(self, dt: float) -> bool:
        """Move over one integration step dt (s); False where the mover has run away."""
        v = self.v
        h = self.h
        motor = self.motor
        motor.advance(dt)
        v.begin()
        h.begin()
        motor.at_start(h.position)
        self.add_slope(dt / 6.0, dt / 2.0)
        motor.at_middle(h.position)
        self.add_slope(dt / 3.0, dt / 2.0)
        motor.at_middle(h.position)
        self.add_slope(dt / 3.0, dt)
        motor.at_end(h.position)
        self.add_slope(dt / 6.0, 0.0)
        contained = v.finish() and h.finish()
        if self.beyond_stop():
            self.at_stop = True
        return contained

    def add_slope(self, weight: float, ahead: float) -> None:
        """Add one Runge–Kutta slope on both axes (4.3)."""
        f1, f2, f3, f4 = gap_functions(self.v.position)
        f2 *= attraction_factor(self.attraction_modulation, self.h.position)
        i_d = self.motor.i_d
        i_q = self.motor.i_q
        share = self.v.mass_ratio
        v_motors = normal_acceleration(share * self.C2, share * self.C3, share * self.C4, f2, f3, f4,
                                       i_d, i_q * i_q + i_d * i_d)
        h_motors = thrust_acceleration(self.h.mass_ratio * self.C1, f1, i_q)
        self.v.add_slope(v_motors, weight, ahead)
        self.h.add_slope(h_motors, weight, ahead)

    def time_to_stop(self, dt: float) -> float:
        """Time (s) in which the first axis meets an end stop; dt if none does within dt."""
        dt = self.v.time_to_stop(dt)
        return self.h.time_to_stop(dt)

    def beyond_stop(self) -> bool:
        """Whether any axis is beyond an end stop."""
        return self.v.beyond_stop() or self.h.beyond_stop()

    def measure(self) -> None:
        """Set the encoder outputs."""
        self.v.encoder = self.encoder.measure(self.v.position)
        self.h.encoder = self.encoder.measure(self.h.position)
