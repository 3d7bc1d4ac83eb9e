"""The FMU Plant5DOF."""

from plant_fmu.definition import plant
from plant_fmu.stage_5dof import Stage5DOF
from pmlsm.rig_5dof import RIG

PLANT = plant(RIG, Stage5DOF)
