"""Gain table: an interpolated law's linearisations on a fine grid of air gaps, with straight lines in between."""

from controller_fmu.gain_point import GainPoint
from controller_fmu.linearisation import Linearisation
from controller_fmu.vertical_law import VerticalLaw
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.stage_description import Table


class GainTable:
    """Points at equal distances; beyond the first and the last, these count."""

    def __init__(self, table: Table):
        self.lower = table.lower       # m, gap of the first point
        self.spacing = table.spacing   # m
        self.linear = Linearisation()
        self.points = [GainPoint() for _ in table.gaps]
        self.last = len(self.points) - 1
        self.middle = self.last // 2

    def prepare(self, motor: MotorGeometry, attraction: float, coils: float, iron: float) -> bool:
        """Linearise at every gap; arguments and result as of `Linearisation.prepare`."""
        fine = True
        for k, point in enumerate(self.points):
            if not point.prepare(motor, attraction, coils, iron, self.lower + k * self.spacing, self.linear):
                fine = False
        return fine

    def choose(self, gap: float, law: VerticalLaw) -> float:
        """Hand a law what counts at a gap (m); returns its gain by that of the middle point."""
        place = (gap - self.lower) / self.spacing
        below = 0
        if place >= self.last - 1:
            below = self.last - 1
        elif place >= 1.0:
            below = int(place)
        low = self.points[below]
        high = self.points[below + 1]
        part = place - below
        if part < 0.0:
            part = 0.0
        elif part > 1.0:
            part = 1.0
        gain = low.gain + part * (high.gain - low.gain)
        law.take(low.current + part * (high.current - low.current), gain, low.f1 + part * (high.f1 - low.f1))
        return gain / self.points[self.middle].gain
