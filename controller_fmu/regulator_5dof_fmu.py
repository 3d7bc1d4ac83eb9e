"""The FMUs of the regulators of the 5-DOF stage."""

from controller_fmu.definitions import regulator
from controller_fmu.regulator_5dof import Regulator5DOF
from controller_fmu.status import INTERPOLATED, LINEAR, NONLINEAR
from pmlsm.rig_5dof import RIG

REGULATOR = regulator(RIG, Regulator5DOF, NONLINEAR)
LINEAR_REGULATOR = regulator(RIG, Regulator5DOF, LINEAR)
INTERPOLATED_REGULATOR = regulator(RIG, Regulator5DOF, INTERPOLATED)
