"""Icon of the plants: the slotted stator with its coils, and below it the mover with its magnets."""

STATOR = [(20, 20, 169, 18, "#607080")]
TEETH = [(20 + 26 * slot, 38, 13, 26, "#607080") for slot in range(7)]
COILS = [(33 + 26 * slot, 40, 13, 22, ("#d08030", "#b05020", "#e0a050")[slot % 3]) for slot in range(6)]
MAGNETS = [(44 + 30 * pole, 104, 22, 12, ("#c03030", "#3050c0")[pole % 2]) for pole in range(4)]
MOVER = [(34, 116, 132, 14, "#404850"), (60, 130, 80, 40, "#a0a8b0")]

PLANT_ICON = (*STATOR, *TEETH, *COILS, *MAGNETS, *MOVER)
