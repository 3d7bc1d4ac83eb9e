"""The PD controller of ../pd_controller_c, written with pythonfmu and with the port names of the stage.

    pythonfmu build -f pd_controller.py
    maglev run 2dof-step-1-nonlinear --controller PDController.fmu
"""

from math import cos, pi, sin

from pythonfmu import Fmi2Causality, Fmi2Slave, Fmi2Variability, Real

POLE_PITCH = 57.15e-3    # m
HOLDING = -0.25          # A, direct current that holds the mover at a gap of 20 mm
HOLDING_SLOPE = -415.0   # A/m, its slope over the gap
GAP_STIFFNESS = 1435.0   # 1/s², instability of the gap at 20 mm
GAP_GAIN = 3.432         # m/(s² A), acceleration by the direct current there
TRAVEL_GAIN = -6.68      # m/(s² A), acceleration by the quadrature current there
FILTER_TIME = 1.5e-3     # s, of the velocities: a step of the encoder is not a velocity
LARGEST = 6.0            # A

INPUTS = {"v.measured": 20e-3, "h.measured": 0.0, "v.reference": 20e-3, "h.reference": 0.0}
OUTPUTS = ("motor.i_a_cmd", "motor.i_b_cmd", "motor.i_c_cmd")
PARAMETERS = {"bandwidth": 60.0, "damping": 0.9}   # rad/s, and the ratio


def limited(current):
    """Limit a current (A)."""
    return max(-LARGEST, min(LARGEST, current))


class PDController(Fmi2Slave):
    """PD on both axes with the holding current as feed-forward."""

    description = "PD controller of the 2-DOF stage"

    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.values = {**INPUTS, **dict.fromkeys(OUTPUTS, 0.0), **PARAMETERS}
        self.last = None            # gap and displacement at the step before, m
        self.rates = (0.0, 0.0)     # m/s, filtered
        for name in INPUTS:
            self.register(name, Fmi2Causality.input)
        for name in OUTPUTS:
            self.register(name, Fmi2Causality.output)
        for name in PARAMETERS:
            self.register(name, Fmi2Causality.parameter, variability=Fmi2Variability.tunable)

    def register(self, name, causality, **options):
        """Register a variable that lies in `values`."""
        self.register_variable(Real(name, causality=causality, getter=lambda: self.values[name],
                                    setter=lambda value: self.values.update({name: value}), **options))

    def do_step(self, current_time, step_size):
        """Compute the commands from the inputs at the start of the step."""
        x = self.values
        position = (x["v.measured"], x["h.measured"])
        follow = step_size / (FILTER_TIME + step_size)
        self.rates = tuple(rate + follow * ((now - before) / step_size - rate)
                           for rate, now, before in zip(self.rates, position, self.last or position, strict=True))
        self.last = position

        w = x["bandwidth"]
        damping = 2.0 * x["damping"] * w
        gap_demand = -w * w * (position[0] - x["v.reference"]) - damping * self.rates[0]
        travel_demand = -w * w * (position[1] - x["h.reference"]) - damping * self.rates[1]
        holding = HOLDING + HOLDING_SLOPE * (x["v.reference"] - 20e-3)
        i_d = limited(holding + (gap_demand - GAP_STIFFNESS * (position[0] - x["v.reference"])) / GAP_GAIN)
        i_q = limited(travel_demand / TRAVEL_GAIN)
        angle = pi / POLE_PITCH * (position[1] - POLE_PITCH / 2.0)
        for name, lag in zip(OUTPUTS, (0.0, 2.0 * pi / 3.0, -2.0 * pi / 3.0), strict=True):
            x[name] = cos(angle - lag) * i_d - sin(angle - lag) * i_q
        return True
