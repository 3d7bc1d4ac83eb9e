"""Direct currents by which a PID controller holds a level mover."""

from controller_fmu.feedback_linearisation import equilibrium_current
from controller_fmu.level_platform import LevelPlatform
from controller_fmu.linearisation import Linearisation
from controller_fmu.motor_model import MotorModel
from controller_fmu.pid_axis import PIDAxis
from pmlsm.stage_description import StageDescription


class LevelCurrents:
    """The vertical axis alone moves with the direct currents."""

    def __init__(self, stage: StageDescription):
        # Motors for means: one motor represents all motors that are equal to it.
        self.counted = list(range(len(stage.motors))) if stage.unlike else [0]

    def design(self, axes: list[PIDAxis], platform: LevelPlatform, stiffness: float, gain: float) -> None:
        """Design no other axis than the vertical one."""
        axes[0].design(stiffness, gain)

    def hold(self, axes: list[PIDAxis], model: MotorModel, platform: LevelPlatform,
             linears: list[Linearisation]) -> None:
        """Begin with the current that holds the mover at the measured gap."""
        layout = model.layout
        current = 0.0
        for k in self.counted:
            number = layout.kind[k]
            attraction, coils, iron = model.carried(number)
            holding, found = equilibrium_current(layout.kinds[number].geometry, attraction, coils, iron,
                                                 axes[0].measured)
            current += holding * (linears[number].gain / linears[0].gain)
        axes[0].start(current / len(self.counted))
