"""Icon of the closed loops: the stage inside a loop."""

from plant_fmu.icon import PLANT_ICON

CLOSED_LOOP_ICON = (
    *PLANT_ICON, (6, 6, 188, 4, "#3050c0"), (6, 190, 188, 4, "#3050c0"), (6, 6, 4, 188, "#3050c0"),
    (190, 6, 4, 188, "#3050c0"))
