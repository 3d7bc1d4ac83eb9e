"""The FMU Commutation2DOF."""

from controller_fmu.commutation_2dof import Commutation2DOF
from controller_fmu.definitions import commutation
from pmlsm.rig_2dof import RIG

COMMUTATION = commutation(RIG, Commutation2DOF)
