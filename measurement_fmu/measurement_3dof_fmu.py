"""The FMU Measurement3DOF."""

from measurement_fmu.definition import measurement
from measurement_fmu.measurement_3dof import Measurement3DOF
from pmlsm.rig_3dof import RIG

MEASUREMENT = measurement(RIG, Measurement3DOF)
