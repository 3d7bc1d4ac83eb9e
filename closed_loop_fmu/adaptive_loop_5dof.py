"""The 5-DOF stage under its adaptive regulator: plant and controller as one block, stepped in sequence.

pyccel finds the attributes of a part only where the class of the part is imported, used by its name or not.
"""
# ruff: noqa: F401

from closed_loop_fmu.loop_step import COMMAND_TOO_LARGE, loop_status, samples_in, supply
from controller_fmu.motor_place import MotorPlace
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.regulator_5dof import Regulator5DOF
from controller_fmu.status import STEP_MISFIT, STEPPED
from estimator_fmu.adaptive_regulator_5dof import AdaptiveRegulator5DOF
from plant_fmu.axis import Axis
from plant_fmu.motor_mount import MotorMount
from plant_fmu.stage_5dof import Stage5DOF


def advance_5dof(controller: AdaptiveRegulator5DOF, plant: Stage5DOF, t: float, dt: float) -> int:
    """Step a loop from t to t + dt (s): at each sample the controller computes, then the stage moves until the next."""
    regulator = controller.regulator
    sample_time = regulator.sample_time
    samples = samples_in(dt, sample_time)
    if samples == 0:
        return STEP_MISFIT
    for k in range(samples):
        regulator.x.measured = plant.x.encoder
        regulator.z.measured = plant.z.encoder
        regulator.alpha1_place.gap_measured = plant.alpha1_mount.gap_encoder
        regulator.alpha2_place.gap_measured = plant.alpha2_mount.gap_encoder
        regulator.beta1_place.gap_measured = plant.beta1_mount.gap_encoder
        regulator.beta2_place.gap_measured = plant.beta2_mount.gap_encoder
        controller.sample()
        if not (supply(plant.alpha1, regulator.alpha1) and supply(plant.alpha2, regulator.alpha2)
                and supply(plant.beta1, regulator.beta1) and supply(plant.beta2, regulator.beta2)):
            return COMMAND_TOO_LARGE
        status = plant.step(t + k * sample_time, sample_time)
        if status != 0:
            return loop_status(STEPPED, status)
    return STEPPED


class ClosedLoopAdaptive5DOF:
    """Stage under the regulator that takes over what it estimates."""

    def __init__(self) -> None:
        self.controller = AdaptiveRegulator5DOF()
        self.plant = Stage5DOF()

    def start(self) -> int:
        """Start both parts."""
        return loop_status(self.controller.start(), self.plant.start())

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance_5dof(self.controller, self.plant, t, dt)
