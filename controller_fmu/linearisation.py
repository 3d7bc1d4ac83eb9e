"""Linearisation of the controller's motor model about an equilibrium (section 4.6.1)."""

from controller_fmu.feedback_linearisation import equilibrium_current
from pmlsm.gap_functions import gap_functions
from pmlsm.gap_slopes import gap_slopes
from pmlsm.motor_geometry import MotorGeometry


class Linearisation:
    """The vertical row and the thrust at one gap: δg'' = α δg + β δi_d, and f1 for the horizontal rows."""

    def __init__(self) -> None:
        self.stiffness = 0.0   # α, 1/s²
        self.gain = 1.0        # β, m/(s² A)
        self.f1 = 1.0          # thrust shape function

    def prepare(self, motor: MotorGeometry, attraction: float, coils: float, iron: float, gap: float) -> bool:
        """Linearise g'' = G − iron f4 i_d² + coils f3 i_d − attraction f2 about its equilibrium at a gap.

        Parameters
        ----------
        motor : MotorGeometry
        attraction, coils, iron : float
            As of `demanded_current`.
        gap : float
            The setpoint g*, m.

        Returns
        -------
        bool
            Whether there is an equilibrium that a direct current can control.
        """
        current, found = equilibrium_current(motor, attraction, coils, iron, gap)
        f1, f2, f3, f4 = gap_functions(motor, gap)
        slope2, slope3, slope4 = gap_slopes(motor, gap)
        self.f1 = f1
        self.stiffness = coils * slope3 * current - iron * slope4 * current * current - attraction * slope2
        gain = coils * f3 - 2.0 * iron * f4 * current
        if not found or gain <= 0.0:
            return False
        self.gain = gain
        return True

    def copy(self, other: "Linearisation") -> None:
        """Copy the values of another linearisation."""
        self.stiffness = other.stiffness
        self.gain = other.gain
        self.f1 = other.f1

    def direct_current(self, demand: float, error: float) -> float:
        """Direct current (A) by which the linear model has a demanded acceleration (m/s²) at an error (m)."""
        return (demand - self.stiffness * error) / self.gain

    def demand(self, current: float, error: float) -> float:
        """Acceleration (m/s²) that stands for a direct current (A) at an error (m): the inverse of `direct_current`."""
        return self.gain * current + self.stiffness * error
