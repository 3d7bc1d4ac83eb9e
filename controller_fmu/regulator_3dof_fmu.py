"""The FMUs of the regulators of the 3-DOF stage."""

from controller_fmu.definitions import regulator
from controller_fmu.regulator_3dof import Regulator3DOF
from controller_fmu.status import INTERPOLATED, LINEAR, NONLINEAR, SCHEDULED
from pmlsm.rig_3dof import RIG

REGULATOR = regulator(RIG, Regulator3DOF, NONLINEAR)
LINEAR_REGULATOR = regulator(RIG, Regulator3DOF, LINEAR)
SCHEDULED_REGULATOR = regulator(RIG, Regulator3DOF, SCHEDULED)
INTERPOLATED_REGULATOR = regulator(RIG, Regulator3DOF, INTERPOLATED)
