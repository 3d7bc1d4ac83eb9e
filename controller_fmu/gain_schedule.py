"""Gain schedule of the 3-DOF stage: which linearisation counts at which air gap (Table 5.4)."""

from controller_fmu.linearisation import Linearisation

UPPER_GAP = 26.0e-3    # m, region 1 is above it
MIDDLE_GAP = 24.0e-3   # m, region 2 is from here
LOWER_GAP = 22.0e-3    # m, region 3 is from here, region 4 below

# Assumed: the thesis names no set-points; these are mid-region, and evenly spaced.
SETPOINT1 = 27.0e-3
SETPOINT2 = 25.0e-3
SETPOINT3 = 23.0e-3
SETPOINT4 = 21.0e-3


class GainSchedule:
    """Linearisations at four set-points; the measured gap chooses."""

    def __init__(self) -> None:
        self.region1 = Linearisation()
        self.region2 = Linearisation()
        self.region3 = Linearisation()
        self.region4 = Linearisation()

    def prepare(self, attraction: float, coils: float, iron: float) -> bool:
        """Linearise at every set-point; arguments and result as of `Linearisation.prepare`."""
        found1 = self.region1.prepare(attraction, coils, iron, SETPOINT1)
        found2 = self.region2.prepare(attraction, coils, iron, SETPOINT2)
        found3 = self.region3.prepare(attraction, coils, iron, SETPOINT3)
        found4 = self.region4.prepare(attraction, coils, iron, SETPOINT4)
        return found1 and found2 and found3 and found4

    def choose(self, gap: float, chosen: Linearisation) -> None:
        """Copy into `chosen` the linearisation of the region that a gap (m) lies in."""
        if gap > UPPER_GAP:
            take(chosen, self.region1)
        elif gap >= MIDDLE_GAP:
            take(chosen, self.region2)
        elif gap >= LOWER_GAP:
            take(chosen, self.region3)
        else:
            take(chosen, self.region4)


def take(chosen: Linearisation, region: Linearisation) -> None:
    """Make a linearisation equal to another."""
    chosen.stiffness = region.stiffness
    chosen.gain = region.gain
    chosen.f1 = region.f1
