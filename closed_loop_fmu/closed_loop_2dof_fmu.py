"""The FMUs ClosedLoop… of the 2-DOF stage: one for each controller."""

from closed_loop_fmu.closed_loop_2dof import ClosedLoop2DOF, ClosedLoopPID2DOF
from closed_loop_fmu.definition import closed_loop
from controller_fmu.pid_2dof_fmu import PID
from controller_fmu.regulator_2dof_fmu import LINEAR_REGULATOR, REGULATOR
from plant_fmu.plant_2dof import PLANT
from pmlsm.rig_2dof import RIG

CLOSED_LOOP_NONLINEAR = closed_loop(RIG, ClosedLoop2DOF, "nonlinear", REGULATOR, PLANT)
CLOSED_LOOP_LINEAR = closed_loop(RIG, ClosedLoop2DOF, "linear", LINEAR_REGULATOR, PLANT)
CLOSED_LOOP_PID = closed_loop(RIG, ClosedLoopPID2DOF, "PID", PID, PLANT)
