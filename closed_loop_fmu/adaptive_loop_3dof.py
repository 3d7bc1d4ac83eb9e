"""The 3-DOF stage under its adaptive regulator: plant and controller as one block, stepped in sequence.

pyccel finds the attributes of a part only where the class of the part is imported, used by its name or not.
"""
# ruff: noqa: F401

from closed_loop_fmu.loop_step import COMMAND_TOO_LARGE, loop_status, samples_in, supply
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.regulator_3dof import Regulator3DOF
from controller_fmu.status import STEP_MISFIT, STEPPED
from estimator_fmu.adaptive_regulator_3dof import AdaptiveRegulator3DOF
from plant_fmu.axis import Axis
from plant_fmu.stage_3dof import Stage3DOF


def advance_3dof(controller: AdaptiveRegulator3DOF, plant: Stage3DOF, t: float, dt: float) -> int:
    """Step a loop from t to t + dt (s): at each sample the controller computes, then the stage moves until the next."""
    regulator = controller.regulator
    sample_time = regulator.sample_time
    samples = samples_in(dt, sample_time)
    if samples == 0:
        return STEP_MISFIT
    for k in range(samples):
        regulator.y.measured = plant.y.encoder
        regulator.x.measured = plant.x.encoder
        regulator.z.measured = plant.z.encoder
        controller.sample()
        if not (supply(plant.alpha, regulator.alpha) and supply(plant.beta, regulator.beta)):
            return COMMAND_TOO_LARGE
        status = plant.step(t + k * sample_time, sample_time)
        if status != 0:
            return loop_status(STEPPED, status)
    return STEPPED


class ClosedLoopAdaptive3DOF:
    """Stage under the regulator that takes over what it estimates."""

    def __init__(self) -> None:
        self.controller = AdaptiveRegulator3DOF()
        self.plant = Stage3DOF()

    def start(self) -> int:
        """Start both parts."""
        return loop_status(self.controller.start(), self.plant.start())

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance_3dof(self.controller, self.plant, t, dt)
