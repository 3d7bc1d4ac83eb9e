"""The FMU PID3DOF."""

from controller_fmu.definitions import pid
from controller_fmu.pid_3dof import PID3DOF
from pmlsm.rig_3dof import RIG

PID = pid(RIG, PID3DOF)
