"""Gain schedule: which linearisation counts at which air gap (Table 5.4)."""

from controller_fmu.linearisation import Linearisation
from pmlsm.motor_geometry import MotorGeometry


class GainSchedule:
    """Linearisations at four setpoints; the measured gap chooses.

    Region 1 is above the gap `upper`, region 2 from `middle`, region 3 from `lower`, region 4 below (m).
    """

    def __init__(self, upper: float, middle: float, lower: float, setpoint1: float, setpoint2: float,
                 setpoint3: float, setpoint4: float):
        self.upper = upper           # m
        self.middle = middle         # m
        self.lower = lower           # m
        self.setpoint1 = setpoint1   # m
        self.setpoint2 = setpoint2   # m
        self.setpoint3 = setpoint3   # m
        self.setpoint4 = setpoint4   # m
        self.region1 = Linearisation()
        self.region2 = Linearisation()
        self.region3 = Linearisation()
        self.region4 = Linearisation()

    def prepare(self, motor: MotorGeometry, attraction: float, coils: float, iron: float) -> bool:
        """Linearise at every setpoint; arguments and result as of `Linearisation.prepare`."""
        found1 = self.region1.prepare(motor, attraction, coils, iron, self.setpoint1)
        found2 = self.region2.prepare(motor, attraction, coils, iron, self.setpoint2)
        found3 = self.region3.prepare(motor, attraction, coils, iron, self.setpoint3)
        found4 = self.region4.prepare(motor, attraction, coils, iron, self.setpoint4)
        return found1 and found2 and found3 and found4

    def choose(self, gap: float, chosen: Linearisation) -> None:
        """Copy into `chosen` the linearisation of the region that a gap (m) lies in."""
        if gap > self.upper:
            take(chosen, self.region1)
        elif gap >= self.middle:
            take(chosen, self.region2)
        elif gap >= self.lower:
            take(chosen, self.region3)
        else:
            take(chosen, self.region4)


def take(chosen: Linearisation, region: Linearisation) -> None:
    """Make a linearisation equal to another."""
    chosen.stiffness = region.stiffness
    chosen.gain = region.gain
    chosen.f1 = region.f1
