"""The FMUs ClosedLoop…: one for each controller."""

from closed_loop_fmu.closed_loop_2dof import ClosedLoop2DOF, ClosedLoopPID2DOF
from closed_loop_fmu.closed_loop_3dof import ClosedLoop3DOF, ClosedLoopPID3DOF
from closed_loop_fmu.variables import loop_refusals, loop_variables
from controller_fmu.pid_fmu import PID_2DOF, PID_3DOF
from controller_fmu.regulator_2dof_fmu import LINEAR_REGULATOR_2DOF, REGULATOR_2DOF
from controller_fmu.regulator_3dof_fmu import LINEAR_REGULATOR_3DOF, REGULATOR_3DOF, SCHEDULED_REGULATOR_3DOF
from fmi_export.definition import Drawing, Experiment, FmuDefinition
from plant_fmu.plant_2dof import PLANT_2DOF
from plant_fmu.plant_3dof import PLANT_3DOF
from pmlsm.rigs import RIG_2DOF, RIG_3DOF, Rig

# Whole samples, whichever the stage, and at most 1000: fmpy doubles a shorter step until there are no more.
EXPERIMENT = Experiment(stop_time=26.0, step=40.0e-3)


def closed_loop(name: str, block: type, law: str, controller: FmuDefinition, plant: FmuDefinition,
                rig: Rig) -> FmuDefinition:
    """Definition of a loop, from those of its parts, and the controller's law."""
    return FmuDefinition(
        name=name,
        block=block,
        arguments=controller.arguments,
        description=f"Closed loop of {controller.name} and {plant.name}, stepped in sequence, controller first",
        variables=loop_variables(controller, plant),
        refusals=loop_refusals(controller, plant),
        experiment=EXPERIMENT,
        variable_step=False,
        documentation=tuple(dict.fromkeys((("closed_loop_fmu", "closed_loop.html"), *controller.documentation,
                                           *plant.documentation))),
        icon=Drawing("closed_loop_fmu.drawings", "icon", (law, len(rig.axis_names))),
        sketch=Drawing("closed_loop_fmu.drawings", "loop", (controller.name, plant.name)))


CLOSED_LOOP_2DOF = closed_loop("ClosedLoop2DOF", ClosedLoop2DOF, "nonlinear", REGULATOR_2DOF, PLANT_2DOF, RIG_2DOF)
CLOSED_LOOP_LINEAR_2DOF = closed_loop("ClosedLoopLinear2DOF", ClosedLoop2DOF, "linear", LINEAR_REGULATOR_2DOF,
                                      PLANT_2DOF, RIG_2DOF)
CLOSED_LOOP_PID_2DOF = closed_loop("ClosedLoopPID2DOF", ClosedLoopPID2DOF, "PID", PID_2DOF, PLANT_2DOF, RIG_2DOF)

CLOSED_LOOP_3DOF = closed_loop("ClosedLoop3DOF", ClosedLoop3DOF, "nonlinear", REGULATOR_3DOF, PLANT_3DOF, RIG_3DOF)
CLOSED_LOOP_LINEAR_3DOF = closed_loop("ClosedLoopLinear3DOF", ClosedLoop3DOF, "linear", LINEAR_REGULATOR_3DOF,
                                      PLANT_3DOF, RIG_3DOF)
CLOSED_LOOP_SCHEDULED_3DOF = closed_loop("ClosedLoopScheduled3DOF", ClosedLoop3DOF, "scheduled",
                                         SCHEDULED_REGULATOR_3DOF, PLANT_3DOF, RIG_3DOF)
CLOSED_LOOP_PID_3DOF = closed_loop("ClosedLoopPID3DOF", ClosedLoopPID3DOF, "PID", PID_3DOF, PLANT_3DOF, RIG_3DOF)
