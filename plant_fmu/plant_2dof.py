"""The FMU Plant2DOF."""

from plant_fmu.definition import plant
from plant_fmu.stage_2dof import Stage2DOF
from pmlsm.rig_2dof import RIG

PLANT = plant(RIG, Stage2DOF)
