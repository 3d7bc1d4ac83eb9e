"""Stages as data: their descriptions, and the FMUs that follow from them."""

EXAMPLE = "3dof"   # stage of new files, if none is named
