"""A motor at its place on a platform that tilts."""

from plant_fmu.axis import Axis
from plant_fmu.end_stop import EndStop
from pmlsm.gap_functions import GapEffect
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.stage_description import Stop
from pmlsm.velocity_rows import normal_terms, thrust_term


class MotorMount:
    """Air gap of a motor, and its forces on the platform; an end stop acts on the gap.

    The platform turns by small angles: roll about x, pitch about z, right-handed with y down.
    """

    def __init__(self, x: float, z: float, axis: int, stop: Stop):
        self.x = x                 # m, parameter: place on the platform, from its centre of mass
        self.z = z                 # m, parameter
        self.axis = axis           # number of the axis that the motor drives
        self.stop = EndStop(stop.lower, stop.upper)
        self.stop.stiffness = stop.stiffness
        self.stop.damping = stop.damping
        self.effect = GapEffect()
        self.gap = 0.0             # g, m, output
        self.gap_encoder = 0.0     # m, output
        self.gap_rate = 0.0        # m/s
        self.normal = 0.0          # N, of motor and stop, downwards
        self.thrust = 0.0          # T, N

    def place(self, y: Axis, roll: Axis, pitch: Axis) -> None:
        """Go to where the platform is: g = y − z φ + x θ."""
        self.gap = y.position - self.z * roll.position + self.x * pitch.position
        self.gap_rate = y.velocity - self.z * roll.velocity + self.x * pitch.velocity

    def seen_gap(self, y: Axis, roll: Axis, pitch: Axis) -> float:
        """Gap (m) that the encoder measures, where flexible modes move it against the platform."""
        return self.gap + (y.swing - self.z * roll.swing + self.x * pitch.swing)

    def beyond_stop(self) -> bool:
        """Return True if the gap is beyond an end stop."""
        return self.stop.touched(self.gap)

    def time_to_stop(self, y: Axis, roll: Axis, pitch: Axis, dt: float) -> float:
        """Time (s) in which the gap meets an end stop; dt if not within dt."""
        return self.stop.time_to_meet(self.gap, self.gap_rate, self.gap_change(y, roll, pitch), dt)

    def gap_change(self, y: Axis, roll: Axis, pitch: Axis) -> float:
        """Second derivative of the gap, m/s², at the last integration point."""
        return y.acceleration - self.z * roll.acceleration + self.x * pitch.acceleration

    def start(self) -> None:
        """Start again, with a geometry that may have changed."""
        self.effect.forget()

    def begin(self) -> None:
        """Begin an integration step."""
        self.stop.engage(self.gap)

    def resume(self) -> None:
        """Begin to compute the rates at the present point of a continuous model."""
        self.stop.resume(self.gap)
        self.effect.forget()

    def settle(self) -> bool:
        """Take in an event of a continuous model; return True if the gap is at a stop."""
        return self.stop.settle(self.gap_rate)

    def push(self, geometry: MotorGeometry, i_d: float, i_q: float, thrust: float, attraction: float, coils: float,
             iron: float) -> None:
        """Compute the forces at the present point.

        Parameters
        ----------
        geometry : MotorGeometry
        i_d, i_q : float
            A.
        thrust, attraction, coils, iron : float
            Constants of the motor's rows as forces: N/A, N/T², N/(A T), N/A²; the attraction as it is at this place
            along the slots.
        """
        effect = self.effect
        effect.follow(geometry, self.gap)
        by_attraction, by_coils, by_iron = normal_terms(attraction, coils, iron, effect.f2, effect.f3, effect.f4, i_d,
                                                        i_q * i_q + i_d * i_d)
        self.normal = by_iron + by_coils + by_attraction + self.stop.force(self.gap, self.gap_rate)
        self.thrust = thrust_term(thrust, effect.f1, i_q)

    def roll_torque(self) -> float:
        """Torque of the normal force about x, N m."""
        return -self.z * self.normal

    def pitch_torque(self) -> float:
        """Torque of the normal force about z, N m."""
        return self.x * self.normal
