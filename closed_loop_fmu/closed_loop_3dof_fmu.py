"""The FMUs ClosedLoop… of the 3-DOF stage: one for each controller."""

from closed_loop_fmu.closed_loop_3dof import ClosedLoop3DOF, ClosedLoopPID3DOF
from closed_loop_fmu.definition import closed_loop
from controller_fmu.pid_3dof_fmu import PID
from controller_fmu.regulator_3dof_fmu import INTERPOLATED_REGULATOR, LINEAR_REGULATOR, REGULATOR, SCHEDULED_REGULATOR
from plant_fmu.plant_3dof import PLANT
from pmlsm.rig_3dof import RIG

CLOSED_LOOP_NONLINEAR = closed_loop(RIG, ClosedLoop3DOF, "nonlinear", REGULATOR, PLANT)
CLOSED_LOOP_LINEAR = closed_loop(RIG, ClosedLoop3DOF, "linear", LINEAR_REGULATOR, PLANT)
CLOSED_LOOP_SCHEDULED = closed_loop(RIG, ClosedLoop3DOF, "scheduled", SCHEDULED_REGULATOR, PLANT)
CLOSED_LOOP_INTERPOLATED = closed_loop(RIG, ClosedLoop3DOF, "interpolated", INTERPOLATED_REGULATOR, PLANT)
CLOSED_LOOP_PID = closed_loop(RIG, ClosedLoopPID3DOF, "PID", PID, PLANT)
