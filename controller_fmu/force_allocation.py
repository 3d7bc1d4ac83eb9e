"""Allocation of normal forces to the motors of a platform, for the demanded accelerations."""

from controller_fmu.motor_place import MotorPlace
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from pmlsm.velocity_rows import GRAVITY


class ForceAllocation:
    """Even split over the motors of the force for y and the torques for roll and pitch.

    With the normal forces N (downwards), the thrusts Tx and Tz, and the height h of the magnets' faces:

        M_y y'' = M_y G + Σ N     I_roll roll'' = −Σ z N + h Tz     I_pitch pitch'' = Σ x N − h Tx

    The thrusts are those that the horizontal axes ask for. The rest, Jᵀ N = w, has many solutions with more than three
    motors; N = J (JᵀJ)⁻¹ w is the one with the smallest sum of squares. All forces are for each kg of M_y.
    """

    def __init__(self, mass_y: float, mass_x: float, mass_z: float, inertia_roll: float, inertia_pitch: float):
        self.mass_y = mass_y                  # kg, parameters: masses at which the constants are accelerations
        self.mass_x = mass_x                  # kg
        self.mass_z = mass_z                  # kg
        self.inertia_roll = inertia_roll      # kg m², parameter
        self.inertia_pitch = inertia_pitch    # kg m², parameter
        self.motors = 1.0                     # how many there are
        self.weight = GRAVITY                 # m/s², held by the normal forces; 0 in a law about an equilibrium
        self.force = 0.0                      # w, m/s²
        self.roll_torque = 0.0                # m²/s²
        self.pitch_torque = 0.0               # m²/s²

    def demand(self, platform: TiltingPlatform, y: float, x: float, z: float, roll: float, pitch: float) -> None:
        """Take in the accelerations (m/s², rad/s²) that the axes demand."""
        self.motors = platform.motors
        self.force = y - self.weight
        self.roll_torque = (self.inertia_roll * roll - platform.height * self.mass_z * z) / self.mass_y
        self.pitch_torque = (self.inertia_pitch * pitch + platform.height * self.mass_x * x) / self.mass_y

    def demand_at(self, place: MotorPlace) -> float:
        """Vertical acceleration (m/s²) that is demanded of a motor: the platform's, if all motors did as this one."""
        return self.weight + self.motors * place.carried(self.force, self.roll_torque, self.pitch_torque)

    def gather(self, tilts: TiltMeasurement, place: MotorPlace, demand: float) -> None:
        """Add a motor's demand (m/s²) to those of y, roll and pitch; without thrust the inverse of `demand_at`."""
        force = demand / self.motors
        tilts.y += force
        tilts.roll -= place.z * force * self.mass_y / self.inertia_roll
        tilts.pitch += place.x * force * self.mass_y / self.inertia_pitch

    def roll_ratio(self, platform: TiltingPlatform) -> float:
        """Stiffness and gain of roll under currents that change along z, by those of y: M_y Σ z² / (n I_roll)."""
        return self.mass_y * platform.spread_z() / self.inertia_roll

    def pitch_ratio(self, platform: TiltingPlatform) -> float:
        """Stiffness and gain of pitch under currents that change along x, by those of y: M_y Σ x² / (n I_pitch)."""
        return self.mass_y * platform.spread_x() / self.inertia_pitch
