"""The experiments with which the live page begins on the thesis's stages and the 5-DOF one."""

HOMES = ("3dof-setpoints-improved", "2dof-setpoints", "5dof-setpoints")
