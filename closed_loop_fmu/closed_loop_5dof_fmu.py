"""The FMUs ClosedLoop… of the 5-DOF stage: one for each controller."""

from closed_loop_fmu.closed_loop_5dof import ClosedLoop5DOF, ClosedLoopPID5DOF
from closed_loop_fmu.definition import closed_loop
from controller_fmu.pid_5dof_fmu import PID
from controller_fmu.regulator_5dof_fmu import INTERPOLATED_REGULATOR, LINEAR_REGULATOR, REGULATOR
from plant_fmu.plant_5dof import PLANT
from pmlsm.rig_5dof import RIG

CLOSED_LOOP_NONLINEAR = closed_loop(RIG, ClosedLoop5DOF, "nonlinear", REGULATOR, PLANT)
CLOSED_LOOP_LINEAR = closed_loop(RIG, ClosedLoop5DOF, "linear", LINEAR_REGULATOR, PLANT)
CLOSED_LOOP_INTERPOLATED = closed_loop(RIG, ClosedLoop5DOF, "interpolated", INTERPOLATED_REGULATOR, PLANT)
CLOSED_LOOP_PID = closed_loop(RIG, ClosedLoopPID5DOF, "PID", PID, PLANT)
