"""Common part of every closed loop in a communication step: count samples, pass on currents, report refusals."""

from controller_fmu.motor_command import MotorCommand
from plant_fmu.integration import LONGEST_COMMUNICATION_STEP
from plant_fmu.motor_supply import MotorSupply

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
