"""The FMU Estimator2DOF."""

from estimator_fmu.definition import estimator
from estimator_fmu.estimator_2dof import Estimator2DOF
from pmlsm.rig_2dof import RIG

ESTIMATOR = estimator(RIG, Estimator2DOF)
