"""Linearisation of an interpolated law at one air gap."""

from controller_fmu.feedback_linearisation import equilibrium_current
from controller_fmu.linearisation import Linearisation
from pmlsm.motor_geometry import MotorGeometry


class GainPoint:
    """δg'' = β (i_d − i*) about the equilibrium at one gap, whose current is fed forward, and f1 for the thrust."""

    def __init__(self) -> None:
        self.current = 0.0   # i*, A
        self.gain = 1.0      # β, m/(s² A)
        self.f1 = 1.0        # thrust shape function

    def prepare(self, motor: MotorGeometry, attraction: float, coils: float, iron: float, gap: float,
                linear: Linearisation) -> bool:
        """Linearise at a gap (m), in `linear`; the other arguments and the result are as of `Linearisation.prepare`."""
        found = linear.prepare(motor, attraction, coils, iron, gap)
        self.current, held = equilibrium_current(motor, attraction, coils, iron, gap)
        self.gain = linear.gain
        self.f1 = linear.f1
        return found and held
