"""The 5-DOF stage under control: plant and controller as one block, stepped in sequence.

pyccel finds the attributes of an axis only where the class of the axis is imported, used by its name or not.
"""

from closed_loop_fmu.loop_step import COMMAND_TOO_LARGE, loop_status, samples_in, supply
from controller_fmu.motor_place import MotorPlace  # noqa: F401
from controller_fmu.output_regulator import OutputRegulator  # noqa: F401
from controller_fmu.pid_5dof import PID5DOF
from controller_fmu.pid_axis import PIDAxis  # noqa: F401
from controller_fmu.regulator_5dof import Regulator5DOF
from controller_fmu.status import STEP_MISFIT, STEPPED
from plant_fmu.axis import Axis  # noqa: F401
from plant_fmu.motor_mount import MotorMount  # noqa: F401
from plant_fmu.stage_5dof import Stage5DOF


def advance_5dof(controller: Regulator5DOF | PID5DOF, plant: Stage5DOF, t: float, dt: float) -> int:
    """Step a loop from t to t + dt (s): at each sample the controller computes, then the stage moves until the next."""
    sample_time = controller.sample_time
    samples = samples_in(dt, sample_time)
    if samples == 0:
        return STEP_MISFIT
    for k in range(samples):
        controller.x.measured = plant.x.encoder
        controller.z.measured = plant.z.encoder
        controller.alpha1_place.gap_measured = plant.alpha1_mount.gap_encoder
        controller.alpha2_place.gap_measured = plant.alpha2_mount.gap_encoder
        controller.beta1_place.gap_measured = plant.beta1_mount.gap_encoder
        controller.beta2_place.gap_measured = plant.beta2_mount.gap_encoder
        controller.sample()
        if not (supply(plant.alpha1, controller.alpha1) and supply(plant.alpha2, controller.alpha2)
                and supply(plant.beta1, controller.beta1) and supply(plant.beta2, controller.beta2)):
            return COMMAND_TOO_LARGE
        status = plant.step(t + k * sample_time, sample_time)
        if status != 0:
            return loop_status(STEPPED, status)
    return STEPPED


class ClosedLoop5DOF:
    """Stage under an output regulator; the law is one of `Regulator5DOF`."""

    def __init__(self, law: int):
        self.controller = Regulator5DOF(law)
        self.plant = Stage5DOF()

    def start(self) -> int:
        """Start both parts."""
        return loop_status(self.controller.start(), self.plant.start())

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance_5dof(self.controller, self.plant, t, dt)


class ClosedLoopPID5DOF:
    """Stage under a PID for each axis."""

    def __init__(self) -> None:
        self.controller = PID5DOF()
        self.plant = Stage5DOF()

    def start(self) -> int:
        """Start both parts."""
        return loop_status(self.controller.start(), self.plant.start())

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance_5dof(self.controller, self.plant, t, dt)
