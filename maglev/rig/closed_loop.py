"""The blocks of stage and controller in one, written from the description of a rig."""

from maglev.rig.text import each, module
from pmlsm.rig import Rig

LOOP = '''
class {name}:
    """{text}"""

    def __init__(self{argument}):
        self.controller = {controller}
        self.plant = {plant}()

    def start(self) -> int:
        """Start both parts."""
        return loop_status(self.controller.start(), self.plant.start())

    def step(self, t: float, dt: float) -> int:
        """Step both parts from t to t + dt (s), a whole number of samples, with references and forces held."""
        return advance_{rig}(self.controller, self.plant, t, dt)
'''


def measured(rig: Rig) -> str:
    """What the encoders show the controller: the positions of all axes, or gaps at the motors where the platform tilts."""
    axes = [axis.name for axis in (rig.horizontal if rig.rotations else rig.axes)]
    gaps = rig.motor_names if rig.rotations else ()
    return "\n".join([*(f"        controller.{axis}.measured = plant.{axis}.encoder" for axis in axes),
                      *(f"        controller.{motor}_place.gap_measured = plant.{motor}_mount.gap_encoder"
                        for motor in gaps)])


def closed_loop(rig: Rig) -> str:
    """Text of `closed_loop_fmu/closed_loop_NAME.py`."""
    plant = f"Stage{rig.suffix}"
    supplied = f"        if not ({each(rig.motor_names, 'supply(plant.{0}, controller.{0})', ' and ')}):"
    under_law = LOOP.format(name=f"ClosedLoop{rig.suffix}", argument=", law: int", plant=plant, rig=rig.name,
                            text=f"Stage under an output regulator; the law is one of `Regulator{rig.suffix}`.",
                            controller=f"Regulator{rig.suffix}(law)")
    under_pid = LOOP.format(name=f"ClosedLoopPID{rig.suffix}", argument="", plant=plant, rig=rig.name,
                            text="Stage under a PID for each axis.", controller=f"PID{rig.suffix}()"
                            ).replace("def __init__(self):", "def __init__(self) -> None:")
    return module(f'''
"""The {rig.title} under control: plant and controller as one block, stepped in sequence.

pyccel finds the attributes of an axis only where the class of the axis is imported, used by its name or not.
"""

from closed_loop_fmu.loop_step import COMMAND_TOO_LARGE, loop_status, samples_in, supply
{"from controller_fmu.motor_place import MotorPlace  # noqa: F401" + chr(10) if rig.rotations else ""}\
from controller_fmu.output_regulator import OutputRegulator  # noqa: F401
from controller_fmu.pid_{rig.name} import PID{rig.suffix}
from controller_fmu.pid_axis import PIDAxis  # noqa: F401
from controller_fmu.regulator_{rig.name} import Regulator{rig.suffix}
from controller_fmu.status import STEP_MISFIT, STEPPED
from plant_fmu.axis import Axis  # noqa: F401
{"from plant_fmu.motor_mount import MotorMount  # noqa: F401" + chr(10) if rig.rotations else ""}\
from plant_fmu.stage_{rig.name} import {plant}


def advance_{rig.name}(controller: Regulator{rig.suffix} | PID{rig.suffix}, plant: {plant}, t: float, dt: float) -> int:
    """Step a loop from t to t + dt (s): at each sample the controller computes, then the stage moves until the next."""
    sample_time = controller.sample_time
    samples = samples_in(dt, sample_time)
    if samples == 0:
        return STEP_MISFIT
    for k in range(samples):
{measured(rig)}
        controller.sample()
{supplied}
            return COMMAND_TOO_LARGE
        status = plant.step(t + k * sample_time, sample_time)
        if status != 0:
            return loop_status(STEPPED, status)
    return STEPPED

{under_law}
{under_pid}''')
