"""The FMU PID5DOF."""

from controller_fmu.definitions import pid
from controller_fmu.pid_5dof import PID5DOF
from pmlsm.rig_5dof import RIG

PID = pid(RIG, PID5DOF)
