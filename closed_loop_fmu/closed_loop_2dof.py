"""The 2-DOF stage under control: plant and controller as one block, stepped in sequence.

pyccel finds the attributes of an axis only where the class of the axis is imported, used by its name or not.
"""

from closed_loop_fmu.loop_step import COMMAND_TOO_LARGE, loop_status, samples_in, supply
from controller_fmu.output_regulator import OutputRegulator  # noqa: F401
from controller_fmu.pid_2dof import PID2DOF
from controller_fmu.pid_axis import PIDAxis  # noqa: F401
from controller_fmu.regulator_2dof import Regulator2DOF
from controller_fmu.status import STEP_MISFIT, STEPPED
from plant_fmu.axis import Axis  # noqa: F401
from plant_fmu.stage_2dof import Stage2DOF


def advance_2dof(controller: Regulator2DOF | PID2DOF, plant: Stage2DOF, t: float, dt: float) -> int:
    """Step a loop from t to t + dt (s): at each sample the controller computes, then the stage moves until the next."""
    sample_time = controller.sample_time
    samples = samples_in(dt, sample_time)
    if samples == 0:
        return STEP_MISFIT
    for k in range(samples):
        controller.v.measured = plant.v.encoder
        controller.h.measured = plant.h.encoder
        controller.sample()
        if not (supply(plant.motor, controller.motor)):
            return COMMAND_TOO_LARGE
        status = plant.step(t + k * sample_time, sample_time)
        if status != 0:
            return loop_status(STEPPED, status)
    return STEPPED


class ClosedLoop2DOF:
    """Stage under an output regulator; the law is one of `Regulator2DOF`."""

    def __init__(self, law: int):
        self.controller = Regulator2DOF(law)
        self.plant = Stage2DOF()

    def start(self) -> int:
        """Start both parts."""
        return loop_status(self.controller.start(), self.plant.start())

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance_2dof(self.controller, self.plant, t, dt)


class ClosedLoopPID2DOF:
    """Stage under a PID for each axis."""

    def __init__(self) -> None:
        self.controller = PID2DOF()
        self.plant = Stage2DOF()

    def start(self) -> int:
        """Start both parts."""
        return loop_status(self.controller.start(), self.plant.start())

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance_2dof(self.controller, self.plant, t, dt)
