"""Gain schedule: which linearisation counts at which air gap (Table 5.4)."""

from controller_fmu.linearisation import Linearisation
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.stage_description import Schedule


class GainSchedule:
    """Linearisations at setpoints, one in each region; the measured gap chooses the region.

    Region 1 is above the first bound, the next one from the second bound on, and so on.
    """

    def __init__(self, schedule: Schedule):
        self.bounds = list(schedule.bounds)         # m
        self.setpoints = list(schedule.setpoints)   # m
        self.regions = [Linearisation() for _ in self.setpoints]

    def prepare(self, motor: MotorGeometry, attraction: float, coils: float, iron: float) -> bool:
        """Linearise at every setpoint; arguments and result as of `Linearisation.prepare`."""
        fine = True
        for region, setpoint in zip(self.regions, self.setpoints, strict=True):
            if not region.prepare(motor, attraction, coils, iron, setpoint):
                fine = False
        return fine

    def choose(self, gap: float, law: VerticalLaw) -> float:
        """Hand a law the linearisation of the region that a gap (m) lies in; returns 1, as of `GainTable.choose`."""
        number = 0
        if gap <= self.bounds[0]:
            number = 1
            for k in range(1, len(self.bounds)):
                if gap < self.bounds[k]:
                    number = k + 1
        law.linear.copy(self.regions[number])
        return 1.0
