"""The FMU Estimator3DOF."""

from estimator_fmu.definition import estimator
from estimator_fmu.estimator_3dof import Estimator3DOF
from pmlsm.rig_3dof import RIG

ESTIMATOR = estimator(RIG, Estimator3DOF)
