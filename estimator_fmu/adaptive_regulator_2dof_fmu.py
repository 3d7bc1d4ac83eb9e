"""The FMU AdaptiveRegulator2DOF."""

from controller_fmu.regulator_2dof_fmu import REGULATOR
from estimator_fmu.adaptive_regulator_2dof import AdaptiveRegulator2DOF
from estimator_fmu.definition import adaptive_regulator
from estimator_fmu.estimator_2dof_fmu import ESTIMATOR
from pmlsm.rig_2dof import RIG

ADAPTIVE_REGULATOR = adaptive_regulator(RIG, AdaptiveRegulator2DOF, REGULATOR, ESTIMATOR)
