"""The FMU AdaptiveRegulator5DOF."""

from controller_fmu.regulator_5dof_fmu import REGULATOR
from estimator_fmu.adaptive_regulator_5dof import AdaptiveRegulator5DOF
from estimator_fmu.definition import adaptive_regulator
from estimator_fmu.estimator_5dof_fmu import ESTIMATOR
from pmlsm.rig_5dof import RIG

ADAPTIVE_REGULATOR = adaptive_regulator(RIG, AdaptiveRegulator5DOF, REGULATOR, ESTIMATOR)
