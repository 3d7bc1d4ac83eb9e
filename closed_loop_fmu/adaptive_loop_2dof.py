"""The 2-DOF stage under its adaptive regulator: plant and controller as one block, stepped in sequence.

pyccel finds the attributes of a part only where the class of the part is imported, used by its name or not.
"""
# ruff: noqa: F401

from closed_loop_fmu.loop_step import COMMAND_TOO_LARGE, loop_status, samples_in, supply
from controller_fmu.output_regulator import OutputRegulator
from controller_fmu.regulator_2dof import Regulator2DOF
from controller_fmu.status import STEP_MISFIT, STEPPED
from estimator_fmu.adaptive_regulator_2dof import AdaptiveRegulator2DOF
from plant_fmu.axis import Axis
from plant_fmu.stage_2dof import Stage2DOF


def advance_2dof(controller: AdaptiveRegulator2DOF, plant: Stage2DOF, t: float, dt: float) -> int:
    """Step a loop from t to t + dt (s): at each sample the controller computes, then the stage moves until the next."""
    regulator = controller.regulator
    sample_time = regulator.sample_time
    samples = samples_in(dt, sample_time)
    if samples == 0:
        return STEP_MISFIT
    for k in range(samples):
        regulator.v.measured = plant.v.encoder
        regulator.h.measured = plant.h.encoder
        controller.sample()
        if not (supply(plant.motor, regulator.motor)):
            return COMMAND_TOO_LARGE
        status = plant.step(t + k * sample_time, sample_time)
        if status != 0:
            return loop_status(STEPPED, status)
    return STEPPED


class ClosedLoopAdaptive2DOF:
    """Stage under the regulator that takes over what it estimates."""

    def __init__(self) -> None:
        self.controller = AdaptiveRegulator2DOF()
        self.plant = Stage2DOF()

    def start(self) -> int:
        """Start both parts."""
        return loop_status(self.controller.start(), self.plant.start())

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance_2dof(self.controller, self.plant, t, dt)
