"""PID controller of any stage (Figs. 4.6, 5.6): one PID for each axis, on the currents that move it."""

from typing import Any

from controller_fmu.described_platform import platform_of
from controller_fmu.level_currents import LevelCurrents
from controller_fmu.level_platform import LevelPlatform
from controller_fmu.linearisation import Linearisation
from controller_fmu.motor_command import MotorCommand
from controller_fmu.motor_model import MotorModel
from controller_fmu.pid_axis import PIDAxis
from controller_fmu.platform_currents import PlatformCurrents
from controller_fmu.safety_trip import exceeds
from controller_fmu.sample_clock import SampleClock
from controller_fmu.sampled import Sampled
from controller_fmu.status import (
    BAD_GEOMETRY,
    BAD_PLACES,
    NO_EQUILIBRIUM,
    PREFILTER_TOO_FAST,
    STEPPED,
)
from controller_fmu.velocity_observer import ObserverFilter
from pmlsm.stage_description import StageAxis, StageDescription


def axis_pid(axis: StageAxis) -> PIDAxis:
    """Return the PID of an axis, by its design."""
    pole, pair_real, pair_imaginary = axis.design.pid
    pid = PIDAxis(pole, pair_real, pair_imaginary, axis.start)
    pid.prefilter = axis.design.prefilter
    return pid


class PID(Sampled):
    """Samples positions and references, commands phase currents that hold until the next sample.

    All motors get the direct current of the vertical axis. Where the platform tilts, that axis and the tilts follow
    from the gaps at the motors. The PIDs of the tilts command the slope of the current over the platform, in A/m.
    Motors that are unlike get the currents that make the forces which they would make in the others.
    """

    def __init__(self, stage: StageDescription):
        design = stage.design
        rotations = len(stage.rotations)
        horizontal = len(stage.horizontal)
        self.model = MotorModel(stage)
        self.sample_time = stage.sample_time                # s, parameter
        self.setpoint = stage.vertical.start                # m, parameter: gap of the design
        self.current_limit = design.pid_current_limit     # A, parameter, 0 = none
        self.antiwindup = False                           # parameter
        self.trip_error = 0.0                             # m, parameter, 0 = never
        self.trip_tilt = 0.0                              # rad, parameter, 0 = never
        self.observer = ObserverFilter(design.observer_time)
        self.clock = SampleClock()
        # The vertical axis, the horizontal ones, the tilts.
        axes = (stage.vertical, *stage.horizontal, *stage.rotations)
        self.axes = [axis_pid(axis) for axis in axes]
        self.tilted = [axis.rotation for axis in axes]   # true if an axis is a tilt
        self.motors = [MotorCommand() for _ in stage.motors]
        self.linears = [Linearisation() for _ in self.model.layout.kinds]
        # Of any type: the currents below know their type.
        self.platform: Any = platform_of(stage) if rotations else LevelPlatform()
        self.holding = PlatformCurrents(stage) if rotations else LevelCurrents(stage)
        # A or A/m, of y, x, z, roll, pitch; directions that guides hold stay 0.
        self.currents = [0.0, 0.0, 0.0, 0.0, 0.0]
        self.places = [*range(1 + horizontal), *range(3, 3 + rotations)]   # of each axis among them
        self.held = [False for _ in stage.axes]   # true if the limit holds the integral of an axis
        self.started = False    # state: a measurement has come in
        self.saturated = False  # output
        self.feasible = True    # output; a current is always commanded
        self.tripped = False    # state and output
        self.start()            # the gains of the design are start values

    def start(self) -> int:
        """Compute what follows from the fixed parameters."""
        model = self.model
        layout = model.layout
        if not layout.prepare():
            return BAD_GEOMETRY
        self.observer.prepare(self.sample_time)
        if not self.platform.prepare():
            return BAD_PLACES
        for axis in self.axes:
            if not axis.filterable(self.sample_time):
                return PREFILTER_TOO_FAST
        for number in range(len(self.linears)):
            attraction, coils, iron = model.carried(number)
            if not self.linears[number].prepare(layout.kinds[number].geometry, attraction, coils, iron, self.setpoint):
                return NO_EQUILIBRIUM
        linear = self.linears[0]
        stiffness = 0.0
        for k in self.holding.counted:
            stiffness += self.linears[layout.kind[k]].stiffness
        self.holding.design(self.axes, self.platform, 1.0 / len(self.holding.counted) * stiffness, linear.gain)
        for k, thrust in enumerate(model.thrust):
            self.axes[k + 1].design(0.0, -model.driving[k] * thrust * linear.f1)
        return STEPPED

    def sample(self) -> None:
        """Run the law once."""
        axes = self.axes
        platform = self.platform
        seen = platform.observe(axes)
        if not (self.started or seen):
            return   # an importer that has not exchanged values yet: this is no measurement
        if not self.started:
            for k in range(len(self.model.thrust)):
                axes[k + 1].start(0.0)
            self.holding.hold(axes, self.model, platform, self.linears)
            self.started = True
        sample_time = self.sample_time
        observer = self.observer
        for k, axis in enumerate(axes):
            axis.sample(observer, sample_time)
            if exceeds(axis.error, self.trip_tilt if self.tilted[k] else self.trip_error):
                self.tripped = True
        if self.tripped:
            for motor in self.motors:
                motor.release()
            self.saturated = False
            return
        self.command()
        for k, axis in enumerate(axes):
            axis.update(sample_time, self.antiwindup and self.held[k])

    def command(self) -> None:
        """Command the motors what the axes ask for, and note which commands are at the limit."""
        axes = self.axes
        layout = self.model.layout
        platform = self.platform
        currents = self.currents
        held = self.held
        linear = self.linears[0]
        self.saturated = False
        for k in range(len(held)):
            held[k] = False
        for k, axis in enumerate(axes):
            currents[self.places[k]] = axis.current()
        below = False
        for number, motor in enumerate(self.motors):
            k = layout.drives[number]
            kind = layout.kinds[layout.kind[number]]
            own = self.linears[layout.kind[number]]
            i_d = linear.gain / own.gain * platform.moved(number, currents[0], currents[3], currents[4])
            i_q = linear.f1 / (kind.ratio.thrust * own.f1) * currents[k + 1]
            along = platform.along(k, axes[k + 1].measured)
            motor.command(i_d, i_q, kind.ratio.limit * self.current_limit, kind.geometry.electrical_angle(along))
            if motor.limited:
                self.saturated = True
                if motor.excess_q != 0.0:
                    held[k + 1] = True
                if motor.excess_d != 0.0:
                    below = True
        if below:
            for k, place in enumerate(self.places):
                if place == 0 or place > 2:
                    held[k] = True
