"""Gains of a law that has the same ones at every air gap."""

from controller_fmu.vertical_law import VerticalLaw
from pmlsm.motor_geometry import MotorGeometry


class FixedGains:
    """Stand-in for a gain schedule or a gain table in a law that has neither."""

    def prepare(self, motor: MotorGeometry, attraction: float, coils: float, iron: float) -> bool:
        """Return True: there is nothing to linearise."""
        return True

    def choose(self, gap: float, law: VerticalLaw) -> float:
        """Do not change the law; return 1, as `GainTable.choose` does."""
        return 1.0
