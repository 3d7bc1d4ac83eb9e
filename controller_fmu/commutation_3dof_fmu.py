"""The FMU Commutation3DOF."""

from controller_fmu.commutation_3dof import Commutation3DOF
from controller_fmu.definitions import commutation
from pmlsm.rig_3dof import RIG

COMMUTATION = commutation(RIG, Commutation3DOF)
