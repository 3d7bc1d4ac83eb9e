"""A stage under control: controller and plant as one block, stepped in sequence."""

from typing import Any

from controller_fmu.adaptive_regulator import AdaptiveRegulator
from controller_fmu.motor_command import MotorCommand
from controller_fmu.pid import PID
from controller_fmu.regulator import Regulator
from controller_fmu.status import STEP_MISFIT, STEPPED
from plant_fmu.integration import LONGEST_COMMUNICATION_STEP
from plant_fmu.motor_supply import MotorSupply
from plant_fmu.stage import Stage

SAMPLE_TOLERANCE = 1.0e-6   # of a sample, by which a communication step may miss a whole number of them
LARGEST_COMMAND = 1000.0    # A; largest current that the plant accepts

COMMAND_TOO_LARGE = 50      # status of a loop
OF_PLANT = 100              # added to a status of the plant, so that it differs from those of the controller


def samples_in(dt: float, sample_time: float) -> int:
    """Number of samples in a communication step dt (s); 0 if it is not a whole number of them, or too long."""
    if dt > LONGEST_COMMUNICATION_STEP:
        return 0
    samples = dt / sample_time
    whole = int(samples + 0.5)
    if whole - SAMPLE_TOLERANCE < samples < whole + SAMPLE_TOLERANCE:
        return whole
    return 0


def supply(motor: MotorSupply, commands: MotorCommand) -> bool:
    """Give the commands of the controller to the amplifiers of a motor; False if a command is no sensible current."""
    motor.i_a_cmd = commands.i_a_cmd
    motor.i_b_cmd = commands.i_b_cmd
    motor.i_c_cmd = commands.i_c_cmd
    return (-LARGEST_COMMAND <= motor.i_a_cmd <= LARGEST_COMMAND
            and -LARGEST_COMMAND <= motor.i_b_cmd <= LARGEST_COMMAND
            and -LARGEST_COMMAND <= motor.i_c_cmd <= LARGEST_COMMAND)


def loop_status(controller: int, plant: int) -> int:
    """Status of a loop from those of its parts: 0 if both are 0, else that of the first part that is not."""
    if controller != 0 or plant == 0:
        return controller
    return OF_PLANT + plant


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
