"""The FMU PID2DOF."""

from controller_fmu.definitions import pid
from controller_fmu.pid_2dof import PID2DOF
from pmlsm.rig_2dof import RIG

PID = pid(RIG, PID2DOF)
