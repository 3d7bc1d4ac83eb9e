"""The FMU Estimator5DOF."""

from estimator_fmu.definition import estimator
from estimator_fmu.estimator_5dof import Estimator5DOF
from pmlsm.rig_5dof import RIG

ESTIMATOR = estimator(RIG, Estimator5DOF)
