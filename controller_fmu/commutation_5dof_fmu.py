"""The FMU Commutation5DOF."""

from controller_fmu.commutation_5dof import Commutation5DOF
from controller_fmu.definitions import commutation
from pmlsm.rig_5dof import RIG

COMMUTATION = commutation(RIG, Commutation5DOF)
