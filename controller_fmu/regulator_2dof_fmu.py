"""The FMUs of the regulators of the 2-DOF stage."""

from controller_fmu.definitions import regulator
from controller_fmu.regulator_2dof import Regulator2DOF
from controller_fmu.status import LINEAR, NONLINEAR
from pmlsm.rig_2dof import RIG

REGULATOR = regulator(RIG, Regulator2DOF, NONLINEAR)
LINEAR_REGULATOR = regulator(RIG, Regulator2DOF, LINEAR)
