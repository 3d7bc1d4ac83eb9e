"""The FMU Measurement2DOF."""

from measurement_fmu.definition import measurement
from measurement_fmu.measurement_2dof import Measurement2DOF
from pmlsm.rig_2dof import RIG

MEASUREMENT = measurement(RIG, Measurement2DOF)
