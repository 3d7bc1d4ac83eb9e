"""A flexible mode along an axis: a share of the moving mass swings. All assumed."""

from math import pi


class FlexibleMode:
    """One mode of a free mover: the share μ of its mass m swings on a spring and a damper, with the deflection r.

    Motors, guide, ripple, stops and external force act on the rest, whose place p is the position of the axis. With
    the acceleration a that they and gravity would give to the mover if it were rigid, and e = ω² r + 2 ζ ω r',

        p'' = a/(1 − μ) + μ e
        r'' = −a/(1 − μ) − e,

    so that the centre of mass keeps p'' + μ r'' = a. ω and ζ are those of the free mover; with the rest held in place
    the share swings at ω √(1 − μ). r counts from where gravity and bias leave it. Off where the frequency is 0.
    """

    def __init__(self) -> None:
        self.frequency = 0.0       # ω/2π, Hz, parameter
        self.damping = 0.01        # ζ, parameter
        self.mass_share = 0.1      # μ, parameter
        self.encoder_share = 0.0   # parameter: of r in the measurement of the encoder
        self.stiffness = 0.0       # ω², 1/s²
        self.resistance = 0.0      # 2 ζ ω, 1/s
        self.lightness = 1.0       # 1/(1 − μ)
        self.deflection = 0.0      # r, m, state
        self.rate = 0.0            # r', m/s, state
        self.deflection_0 = 0.0    # state at the start of the integration step
        self.rate_0 = 0.0
        self.deflection_sum = 0.0   # weighted slopes so far
        self.rate_sum = 0.0

    def start(self) -> bool:
        """Begin at rest; return True if there is a mode."""
        omega = 2.0 * pi * self.frequency
        self.stiffness = omega * omega
        self.resistance = 2.0 * self.damping * omega
        self.lightness = 1.0 / (1.0 - self.mass_share)
        self.deflection = 0.0
        self.rate = 0.0
        return self.frequency > 0.0

    def begin(self) -> None:
        """Begin an integration step."""
        self.deflection_0 = self.deflection
        self.rate_0 = self.rate
        self.deflection_sum = 0.0
        self.rate_sum = 0.0

    def add_slope(self, rigid: float, weight: float, ahead: float) -> float:
        """Add the slope at the present point, go to the next one, and return the acceleration of the rest (m/s²).

        Parameters
        ----------
        rigid : float
            a, acceleration of a rigid mover by the forces on it, m/s².
        weight, ahead : float
            As of `plant_fmu.axis.Axis.add_slope`, s.
        """
        rate = self.rate
        pull = self.stiffness * self.deflection + self.resistance * rate
        driven = self.lightness * rigid
        slope = -driven - pull
        self.deflection_sum += weight * rate
        self.rate_sum += weight * slope
        self.deflection = self.deflection_0 + ahead * rate
        self.rate = self.rate_0 + ahead * slope
        return driven + self.mass_share * pull

    def finish(self) -> float:
        """Go to the end of the integration step; how much more than the position the encoder sees there (m)."""
        self.deflection = self.deflection_0 + self.deflection_sum
        self.rate = self.rate_0 + self.rate_sum
        return self.encoder_share * self.deflection
