"""The FMU Measurement5DOF."""

from measurement_fmu.definition import measurement
from measurement_fmu.measurement_5dof import Measurement5DOF
from pmlsm.rig_5dof import RIG

MEASUREMENT = measurement(RIG, Measurement5DOF)
