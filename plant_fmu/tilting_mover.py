"""A platform that tilts: each motor has an air gap and a displacement of its own, and acts at its place."""

from plant_fmu.attraction import attraction_factor
from plant_fmu.axis import Axis
from plant_fmu.encoder import Encoder
from plant_fmu.magnetics import Magnetics
from plant_fmu.magnets import magnet_strength
from plant_fmu.motor_mount import MotorMount
from plant_fmu.motor_supply import MotorSupply
from plant_fmu.payload import Payload
from plant_fmu.tilt_guide import TiltGuide
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import StageDescription
from pmlsm.velocity_rows import GRAVITY


class TiltingMover:
    """Accelerations of the axes by gravity, the motors, their end stops, a payload, and guides against the tilts.

    The platform tilts by small angles: by roll φ about x and by pitch θ about z, right-handed with y down. With one
    horizontal axis, x, guides hold the pitch. A motor at x, z of the platform, whose magnets' faces are h below its
    centre of mass, has

        air gap       g = y − z φ + x θ
        displacement  d = x − h θ along x, z + h φ along z,

    and with the normal forces N and the thrusts T the torques are h Σ T_z − Σ z N and −h Σ T_x + Σ x N.
    """

    def __init__(self, stage: StageDescription):
        horizontal = [axis.name for axis in stage.horizontal]
        self.height = stage.height   # h, m, parameter: of the magnets' faces against the centre of mass, downwards
        self.payload = Payload()
        self.guides = [TiltGuide() for _ in stage.rotations]
        self.mounts = [MotorMount(motor.x, motor.z, 1 + horizontal.index(motor.drives), stage.gap_stop)
                       for motor in stage.motors]
        self.accelerations = [0.0 for _ in stage.axes]   # m/s² or rad/s², by axis
        self.thrusts = [0.0 for _ in stage.horizontal]   # N, along each of the axes
        # Numbers of the axes; where guides hold the pitch, that of roll stands for it.
        self.roll = 1 + len(stage.horizontal)
        self.pitch = len(stage.axes) - 1
        # By horizontal axis: the tilt that moves the magnets along it, and its lever over the height.
        both = len(stage.rotations) == 2
        self.tilt = [self.pitch, self.roll] if both else [self.roll]
        self.lever = [-1.0, 1.0] if both else [0.0]
        self.displacements = [0.0 for _ in stage.axes]   # d, m, of the motors that drive an axis, by axis
        self.yaw_moment = 0.0   # N m, output: about y, of the motors; the guides hold it

    def push(self, axes: list[Axis], motors: list[MotorSupply], magnetics: Magnetics) -> None:
        """Compute the accelerations at the present point, and the forces of the motors."""
        normal = self.add_forces(axes, motors, magnetics)
        self.accelerations[0] = GRAVITY + normal / axes[0].present_mass
        for k, thrust in enumerate(self.thrusts):
            self.accelerations[k + 1] = thrust / axes[k + 1].present_mass
        self.turn(axes)

    def add_forces(self, axes: list[Axis], motors: list[MotorSupply], magnetics: Magnetics) -> float:
        """Compute the forces of the motors at the present point; return the sum of their normal forces, N."""
        strength = magnet_strength(magnetics.magnet_rise)
        gap = axes[0]
        pull = gap.nominal_mass * magnetics.attraction * strength * strength   # N/T²
        coils = gap.nominal_mass * magnetics.coils * strength                  # N/(A T)
        iron = gap.nominal_mass * magnetics.iron                               # N/A²
        groups = magnetics.groups
        kinds = magnetics.kinds
        for group in groups:
            kind = kinds[group.kind]
            group.attraction = kind.ratio.attraction * pull * attraction_factor(
                magnetics.modulation, self.displacements[group.axis], kind.geometry.slot_pitch)
        thrusts = self.thrusts
        for k in range(len(thrusts)):
            thrusts[k] = 0.0
        normal = 0.0
        for k, mount in enumerate(self.mounts):
            motor = motors[k]
            group = groups[motor.group]
            kind = kinds[group.kind]
            ratio = kind.ratio
            along = motor.axis - 1
            thrust = axes[motor.axis].nominal_mass * magnetics.thrust[along] * strength   # N/A
            mount.push(kind.geometry, motor.i_d, motor.i_q, ratio.thrust * thrust, group.attraction,
                       ratio.coils * coils, ratio.iron * iron)
            normal += mount.normal
            thrusts[along] += mount.thrust
        return normal

    def turn(self, axes: list[Axis]) -> None:
        """Compute the accelerations of the tilts by the forces of the motors."""
        roll = self.roll
        torque = 0.0
        if self.pitch != roll:
            torque = self.height * self.thrusts[roll - 2]
        for mount in self.mounts:
            torque += mount.roll_torque()
        torque = torque + self.payload.roll_torque() + self.guides[0].torque(axes[roll].position)
        self.accelerations[roll] = torque / axes[roll].present_mass
        if self.pitch != roll:
            pitch = self.pitch
            torque = -self.height * self.thrusts[0]
            for mount in self.mounts:
                torque += mount.pitch_torque()
            torque = torque + self.payload.pitch_torque() + self.guides[pitch - roll].torque(axes[pitch].position)
            self.accelerations[pitch] = torque / axes[pitch].present_mass

    def induce(self, axes: list[Axis], motors: list[MotorSupply], magnetics: Magnetics, ahead: float) -> None:
        """Compute the voltages that the motion induces in the windings a time ahead (s)."""
        gap = axes[0]
        roll = axes[self.roll]
        pitch = axes[self.pitch]
        strength = magnet_strength(magnetics.magnet_rise)
        coils = gap.nominal_mass * magnetics.coils * strength   # N/(A T)
        iron = gap.nominal_mass * magnetics.iron                # N/A²
        for k, mount in enumerate(self.mounts):
            motor = motors[k]
            kind = magnetics.kinds[magnetics.groups[motor.group].kind]
            geometry = kind.geometry
            ratio = kind.ratio
            axis = axes[motor.axis]
            tilt = axes[self.tilt[motor.axis - 1]]
            lever = self.lever[motor.axis - 1] * self.height
            rate = axis.velocity + lever * tilt.velocity
            change = axis.acceleration + lever * tilt.acceleration
            thrust = axis.nominal_mass * magnetics.thrust[motor.axis - 1] * strength   # N/A
            f1, f2, f3, f4 = gap_functions(geometry, mount.gap + ahead * mount.gap_rate)
            motor.induce(
                geometry.electrical_angle(self.displacements[motor.axis] + ahead * rate),
                mount.gap_rate + ahead * mount.gap_change(gap, roll, pitch),
                rate + ahead * change, ratio.thrust * thrust * f1, ratio.coils * coils * f3, ratio.iron * iron * f4)

    def load(self, axes: list[Axis]) -> None:
        """Put the payload on the platform."""
        payload = self.payload
        for k in range(self.roll):
            axes[k].payload = payload.mass
        axes[self.roll].payload = payload.roll_inertia()
        if self.pitch != self.roll:
            axes[self.pitch].payload = payload.pitch_inertia()

    def start(self) -> None:
        """Start again, with geometries that may have changed."""
        for mount in self.mounts:
            mount.start()

    def begin(self, axes: list[Axis]) -> None:
        """Begin an integration step."""
        self.load(axes)
        for mount in self.mounts:
            mount.begin()

    def resume(self, axes: list[Axis]) -> None:
        """Begin to compute the rates at the present point of a continuous model."""
        self.load(axes)
        for mount in self.mounts:
            mount.resume()

    def place(self, axes: list[Axis]) -> None:
        """Put the motors where the platform has them."""
        gap = axes[0]
        roll = axes[self.roll]
        pitch = axes[self.pitch]
        for mount in self.mounts:
            mount.place(gap, roll, pitch)
        for k, lever in enumerate(self.lever):
            self.displacements[k + 1] = axes[k + 1].position + lever * self.height * axes[self.tilt[k]].position

    def deliver(self, axes: list[Axis], motors: list[MotorSupply], magnetics: Magnetics) -> None:
        """Compute the forces that the yaw moment follows from, at the end of a communication step."""
        self.add_forces(axes, motors, magnetics)

    def measure(self, axes: list[Axis], encoder: Encoder) -> None:
        """Set the outputs of the encoders of the air gaps, and the yaw moment."""
        gap = axes[0]
        roll = axes[self.roll]
        pitch = axes[self.pitch]
        for mount in self.mounts:
            mount.gap_encoder = encoder.measure(mount.seen_gap(gap, roll, pitch))
        self.report()

    def report(self) -> None:
        """Set the yaw moment by the forces at the present point."""
        moment = 0.0
        for mount in self.mounts:
            if mount.axis == 1:
                moment += mount.z * mount.thrust
        for mount in self.mounts:
            if mount.axis == 2:
                moment -= mount.x * mount.thrust
        self.yaw_moment = moment

    def first_beyond(self) -> int:
        """Number, from 1, of the first motor whose gap is beyond an end stop; 0 if none is."""
        for k, mount in enumerate(self.mounts):
            if mount.beyond_stop():
                return k + 1
        return 0

    def time_to_stop(self, axes: list[Axis], dt: float) -> float:
        """Time (s) in which the first gap meets an end stop; dt if none does within dt."""
        gap = axes[0]
        roll = axes[self.roll]
        pitch = axes[self.pitch]
        for mount in self.mounts:
            dt = mount.time_to_stop(gap, roll, pitch, dt)
        return dt

    def settle(self) -> bool:
        """Take in an event of a continuous model; return True if a gap is at a stop."""
        stopped = False
        for mount in self.mounts:
            if mount.settle():
                stopped = True
        return stopped
