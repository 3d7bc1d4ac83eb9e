"""Geometry of a motor: slots, poles and magnets, on which forces and commutation depend."""

from math import pi

from pmlsm.magnet_field import MagnetField


class MotorGeometry:
    """Slots, poles and magnets of the iron-cored PMLSM, stated for both stages in Tables 4.1 and 5.1."""

    def __init__(self) -> None:
        self.slot_width = 12.7e-3         # b0, m, parameter
        self.slot_pitch = 19.05e-3        # t1, m, parameter
        self.pole_pitch = 57.15e-3        # τ, m, parameter
        self.magnet_height = 5.0e-3       # hm, m, parameter
        self.recoil_permeability = 1.05   # µrec, parameter; assumed: the thesis gives no value
        self.field = MagnetField()
        self.wave_number = 0.0            # π/τ, 1/m
        self.slot_height = 0.0            # b0/2 + hm/µrec, m
        self.slot_loss = 0.0              # b0²/(4 t1), m
        self.carter_share = 0.0           # 4/(π t1), 1/m
        self.prepare()

    def prepare(self) -> bool:
        """Compute what follows from the parameters; False where they are of no motor."""
        self.wave_number = pi / self.pole_pitch
        self.slot_height = self.slot_width / 2.0 + self.magnet_height / self.recoil_permeability
        self.slot_loss = self.slot_width * self.slot_width / (4.0 * self.slot_pitch)
        self.carter_share = 4.0 / (pi * self.slot_pitch)
        return self.slot_width < self.slot_pitch and self.field.lower < self.field.upper

    def electrical_angle(self, displacement: float) -> float:
        """Angle θ = π/τ (d − τ/2) in rad at a translational displacement d (m), equation (4.4)."""
        return self.wave_number * (displacement - self.pole_pitch / 2.0)
