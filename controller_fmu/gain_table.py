"""Gain table: an interpolated law's linearisations on a fine grid of air gaps, with straight lines in between."""

from controller_fmu.gain_point import GainPoint
from controller_fmu.linearisation import Linearisation
from pmlsm.motor_geometry import MotorGeometry


class GainTable:
    """Fifteen points at equal distances; beyond the first and the last, these count."""

    def __init__(self, lower: float, spacing: float):
        self.lower = lower       # m, gap of the first point
        self.spacing = spacing   # m
        self.linear = Linearisation()
        self.point0 = GainPoint()
        self.point1 = GainPoint()
        self.point2 = GainPoint()
        self.point3 = GainPoint()
        self.point4 = GainPoint()
        self.point5 = GainPoint()
        self.point6 = GainPoint()
        self.point7 = GainPoint()
        self.point8 = GainPoint()
        self.point9 = GainPoint()
        self.point10 = GainPoint()
        self.point11 = GainPoint()
        self.point12 = GainPoint()
        self.point13 = GainPoint()
        self.point14 = GainPoint()

    def prepare(self, motor: MotorGeometry, attraction: float, coils: float, iron: float) -> bool:
        """Linearise at every gap; arguments and result as of `Linearisation.prepare`."""
        linear = self.linear
        gap = self.lower
        found0 = self.point0.prepare(motor, attraction, coils, iron, gap, linear)
        found1 = self.point1.prepare(motor, attraction, coils, iron, gap + 1.0 * self.spacing, linear)
        found2 = self.point2.prepare(motor, attraction, coils, iron, gap + 2.0 * self.spacing, linear)
        found3 = self.point3.prepare(motor, attraction, coils, iron, gap + 3.0 * self.spacing, linear)
        found4 = self.point4.prepare(motor, attraction, coils, iron, gap + 4.0 * self.spacing, linear)
        found5 = self.point5.prepare(motor, attraction, coils, iron, gap + 5.0 * self.spacing, linear)
        found6 = self.point6.prepare(motor, attraction, coils, iron, gap + 6.0 * self.spacing, linear)
        found7 = self.point7.prepare(motor, attraction, coils, iron, gap + 7.0 * self.spacing, linear)
        found8 = self.point8.prepare(motor, attraction, coils, iron, gap + 8.0 * self.spacing, linear)
        found9 = self.point9.prepare(motor, attraction, coils, iron, gap + 9.0 * self.spacing, linear)
        found10 = self.point10.prepare(motor, attraction, coils, iron, gap + 10.0 * self.spacing, linear)
        found11 = self.point11.prepare(motor, attraction, coils, iron, gap + 11.0 * self.spacing, linear)
        found12 = self.point12.prepare(motor, attraction, coils, iron, gap + 12.0 * self.spacing, linear)
        found13 = self.point13.prepare(motor, attraction, coils, iron, gap + 13.0 * self.spacing, linear)
        found14 = self.point14.prepare(motor, attraction, coils, iron, gap + 14.0 * self.spacing, linear)
        return (found0 and found1 and found2 and found3 and found4 and found5 and found6 and found7
                and found8 and found9 and found10 and found11 and found12 and found13 and found14)

    def choose(self, gap: float, chosen: GainPoint) -> None:
        """Make of `chosen` what counts at a gap (m)."""
        place = (gap - self.lower) / self.spacing
        if place < 1.0:
            self.between(chosen, self.point0, self.point1, place)
        elif place < 2.0:
            self.between(chosen, self.point1, self.point2, place - 1.0)
        elif place < 3.0:
            self.between(chosen, self.point2, self.point3, place - 2.0)
        elif place < 4.0:
            self.between(chosen, self.point3, self.point4, place - 3.0)
        elif place < 5.0:
            self.between(chosen, self.point4, self.point5, place - 4.0)
        elif place < 6.0:
            self.between(chosen, self.point5, self.point6, place - 5.0)
        elif place < 7.0:
            self.between(chosen, self.point6, self.point7, place - 6.0)
        elif place < 8.0:
            self.between(chosen, self.point7, self.point8, place - 7.0)
        elif place < 9.0:
            self.between(chosen, self.point8, self.point9, place - 8.0)
        elif place < 10.0:
            self.between(chosen, self.point9, self.point10, place - 9.0)
        elif place < 11.0:
            self.between(chosen, self.point10, self.point11, place - 10.0)
        elif place < 12.0:
            self.between(chosen, self.point11, self.point12, place - 11.0)
        elif place < 13.0:
            self.between(chosen, self.point12, self.point13, place - 12.0)
        else:
            self.between(chosen, self.point13, self.point14, place - 13.0)

    def between(self, chosen: GainPoint, low: GainPoint, high: GainPoint, share: float) -> None:
        """Make of `chosen` what lies at a share of the way from one point to another, but not beyond them."""
        part = share
        if part < 0.0:
            part = 0.0
        elif part > 1.0:
            part = 1.0
        chosen.current = low.current + part * (high.current - low.current)
        chosen.gain = low.gain + part * (high.gain - low.gain)
        chosen.f1 = low.f1 + part * (high.f1 - low.f1)

    def scale(self, point: GainPoint) -> float:
        """The gain of a point by that of the middle one."""
        return point.gain / self.point7.gain
