"""The FMU AdaptiveRegulator3DOF."""

from controller_fmu.regulator_3dof_fmu import REGULATOR
from estimator_fmu.adaptive_regulator_3dof import AdaptiveRegulator3DOF
from estimator_fmu.definition import adaptive_regulator
from estimator_fmu.estimator_3dof_fmu import ESTIMATOR
from pmlsm.rig_3dof import RIG

ADAPTIVE_REGULATOR = adaptive_regulator(RIG, AdaptiveRegulator3DOF, REGULATOR, ESTIMATOR)
