"""A stage under control: controller and plant as one block, stepped in sequence."""

from typing import Any

from controller_fmu.adaptive_regulator import AdaptiveRegulator
from controller_fmu.pid import PID
from controller_fmu.regulator import Regulator
from controller_fmu.status import STEP_MISFIT, STEPPED
from maglev.closed_loop.loop_step import COMMAND_TOO_LARGE, loop_status, samples_in, supply
from plant_fmu.stage import Stage


def advance(controller: Regulator | PID | AdaptiveRegulator, ports: Regulator | PID, plant: Stage, t: float,
            dt: float) -> int:
    """Step a loop from t to t + dt (s): at each sample the controller computes, then the stage moves until the next.

    The ports are those of the controller, or of the regulator in it.
    """
    sample_time = ports.sample_time
    samples = samples_in(dt, sample_time)
    if samples == 0:
        return STEP_MISFIT
    for k in range(samples):
        for number in plant.measured:
            ports.axes[number].measured = plant.axes[number].encoder
        for place, mount in zip(ports.platform.places, plant.mover.mounts, strict=True):
            place.gap_measured = mount.gap_encoder
        controller.sample()
        for motor, command in zip(plant.motors, ports.motors, strict=True):
            if not supply(motor, command):
                return COMMAND_TOO_LARGE
        status = plant.step(t + k * sample_time, sample_time)
        if status != 0:
            return loop_status(STEPPED, status)
    return STEPPED


class ClosedLoop:
    """A plant under a controller; both are built here, from their classes and the arguments of these."""

    def __init__(self, controller: type, controller_arguments: tuple[Any, ...], plant: type,
                 plant_arguments: tuple[Any, ...]):
        self.controller = controller(*controller_arguments)
        self.plant = plant(*plant_arguments)

    def start(self) -> int:
        """Start both parts."""
        return loop_status(self.controller.start(), self.plant.start())

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance(self.controller, self.controller, self.plant, t, dt)


class AdaptiveLoop(ClosedLoop):
    """A plant under a regulator that takes over its own estimates."""

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance(self.controller, self.controller.regulator, self.plant, t, dt)
