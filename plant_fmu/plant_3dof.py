"""The FMU Plant3DOF."""

from plant_fmu.definition import plant
from plant_fmu.stage_3dof import Stage3DOF
from pmlsm.rig_3dof import RIG

PLANT = plant(RIG, Stage3DOF)
