"""Direct currents by which a PID controller holds a platform that tilts."""

from controller_fmu.described_platform import allocation_of
from controller_fmu.feedback_linearisation import demanded_current
from controller_fmu.linearisation import Linearisation
from controller_fmu.motor_model import MotorModel
from controller_fmu.pid_axis import PIDAxis
from controller_fmu.tilt_measurement import TiltMeasurement
from controller_fmu.tilting_platform import TiltingPlatform
from pmlsm.gap_functions import gap_functions
from pmlsm.stage_description import StageDescription


class PlatformCurrents:
    """A current that all motors have in common moves the vertical axis, its slopes over the platform move the tilts."""

    def __init__(self, stage: StageDescription):
        self.allocation = allocation_of(stage)
        self.unlike = len(stage.unlike) > 0
        # Motors for means: one motor represents all motors that are equal to it.
        self.counted = list(range(len(stage.motors))) if stage.unlike else [0]
        self.held = TiltMeasurement()

    def design(self, axes: list[PIDAxis], platform: TiltingPlatform, stiffness: float, gain: float) -> None:
        """Design the vertical axis and the tilts for the stiffness (1/s²) and gain (m/(s² A)) of the gap."""
        axes[0].design(stiffness, gain)
        first = platform.horizontal + 1
        ratio = self.allocation.roll_ratio(platform)
        axes[first].design(ratio * stiffness, ratio * gain)
        if platform.horizontal == 2:
            ratio = self.allocation.pitch_ratio(platform)
            axes[first + 1].design(ratio * stiffness, ratio * gain)

    def hold(self, axes: list[PIDAxis], model: MotorModel, platform: TiltingPlatform,
             linears: list[Linearisation]) -> None:
        """Begin with the currents by which each motor carries its part at its gap."""
        layout = model.layout
        allocation = self.allocation
        held = self.held
        held.clear()
        if self.unlike:
            allocation.demand(platform, 0.0, 0.0, 0.0, 0.0, 0.0)
        for place, number in zip(platform.places, layout.kind, strict=True):
            f1, f2, f3, f4 = gap_functions(layout.kinds[number].geometry, place.gap_measured)
            attraction, coils, iron = model.carried(number)
            demand = allocation.demand_at(place) if self.unlike else 0.0
            current, found = demanded_current(demand, 0.0, attraction, coils, iron, f2, f3, f4)
            held.add(place, current * (linears[number].gain / linears[0].gain))
        axes[0].start(held.y)
        first = platform.horizontal + 1
        axes[first].start(held.roll)
        if platform.horizontal == 2:
            axes[first + 1].start(held.pitch)
