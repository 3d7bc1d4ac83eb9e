"""Vertical law of a regulator: the direct current for a demanded acceleration, feedback-linearised or linearised."""

from controller_fmu.feedback_linearisation import demanded_current, equilibrium_current
from controller_fmu.linearisation import Linearisation
from controller_fmu.status import INTERPOLATED, NONLINEAR
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry


class VerticalLaw:
    """Knows the vertical row of the controller's model, and the thrust function that goes with it.

    A NONLINEAR law solves the row at the measured gap (4.12), (5.7). The others linearise it (section 4.6.1); an
    INTERPOLATED law about the equilibrium at the measured gap, whose current it feeds forward.
    """

    def __init__(self, law: int):
        self.law = law
        self.attraction = 1.0    # m/(s² T²), constants as of `demanded_current`
        self.coils = 1.0         # m/(s² A T)
        self.iron = 1.0          # m/(s² A²)
        self.f1 = 1.0            # shape functions that count now
        self.f2 = 0.0
        self.f3 = 1.0
        self.f4 = 0.0            # stays so in a linear law: its row has no squares
        self.linear = Linearisation()   # the one that counts now
        self.forward = 0.0       # A, current that an interpolated law feeds forward
        self.feasible = True     # true if the last current makes the demanded acceleration

    def take_constants(self, attraction: float, coils: float, iron: float) -> None:
        """Take in the constants of the model, which may have been tuned."""
        self.attraction = attraction
        self.coils = coils
        self.iron = iron

    def linearise(self, motor: MotorGeometry, gap: float) -> bool:
        """Linearise about a gap (m); return True if there is an equilibrium that a direct current can control."""
        return self.linear.prepare(motor, self.attraction, self.coils, self.iron, gap)

    def holding_demand(self, motor: MotorGeometry, gap: float, error: float) -> float:
        """Demand (m/s²) by which the law commands the current that holds the mover at a gap (m) with an error (m)."""
        if self.law == NONLINEAR or self.law == INTERPOLATED:
            return 0.0
        current, found = equilibrium_current(motor, self.attraction, self.coils, self.iron, gap)
        return self.linear.demand(current, error)

    def carrying_demand(self, motor: MotorGeometry, gap: float, error: float, left: float) -> float:
        """As `holding_demand`, of a motor that leaves an acceleration (m/s²) to the others."""
        if self.law == NONLINEAR:
            return 0.0
        f1, f2, f3, f4 = gap_functions(motor, gap)
        current, found = demanded_current(left, 0.0, self.attraction, self.coils, self.iron, f2, f3, f4)
        return self.linear.demand(current, error)

    def take(self, current: float, gain: float, f1: float) -> None:
        """Take over the linearisation at the measured gap in an interpolated law: see `GainPoint`."""
        self.forward = current
        self.linear.gain = gain
        self.linear.f1 = f1

    def look(self, motor: MotorGeometry, gap: float) -> None:
        """Set the shape functions for a measured gap (m)."""
        if self.law == NONLINEAR:
            self.f1, self.f2, self.f3, self.f4 = gap_functions(motor, gap)
        else:
            self.f1 = self.linear.f1

    def direct_current(self, demand: float, error: float, by_quadrature: float) -> float:
        """Direct current (A) for a demanded acceleration (m/s²).

        Parameters
        ----------
        demand : float
            m/s².
        error : float
            Of the gap, m; counts in a linear law.
        by_quadrature : float
            Acceleration that the quadrature currents take away, m/s²; counts in a nonlinear law.
        """
        if self.law == INTERPOLATED:
            return self.forward + demand / self.linear.gain
        if self.law != NONLINEAR:
            return self.linear.direct_current(demand, error)
        current, self.feasible = demanded_current(demand, by_quadrature, self.attraction, self.coils, self.iron,
                                                  self.f2, self.f3, self.f4)
        return current
