"""Icon of the closed loops, and the sketch of a loop."""

from controller_fmu.drawings.icons import COLOURS, law_symbol
from fmi_export.pages.icon import Shape, disc, rectangle, stroke
from fmi_export.pages.sketch import arrow, box, sketch, symbol, words
from plant_fmu.drawings import BLUE, COPPER, IRON, MOVER, RED

LOOP = "#404850"


def icon(law: str, axes: int) -> tuple[Shape, ...]:
    """The controller's law above, the stage below, and the loop about them; dots for the axes."""
    loop = [*stroke([(74, 25), (92, 25), (92, 75), (80, 75)], 6, LOOP), (LOOP, ((68, 75), (82, 65), (82, 85))),
            *stroke([(26, 75), (8, 75), (8, 25), (18, 25)], 6, LOOP), (LOOP, ((32, 25), (18, 15), (18, 35)))]
    coils = [rectangle(32 + 14 * k, 66, 8, 8, COPPER) for k in range(3)]
    magnets = [rectangle(32 + 12 * k, 82, 12, 5, (RED, BLUE)[k % 2]) for k in range(3)]
    dots = [disc(50 + 10 * (k - (axes - 1) / 2), 93, 2.6, "#ffffff") for k in range(axes)]
    return (*loop, rectangle(30, 3, 44, 44, COLOURS[law]), *law_symbol(law, 30, 3, 44),
            rectangle(28, 58, 44, 16, IRON), *coils, *magnets, rectangle(28, 87, 44, 12, MOVER), *dots)


def loop(controller: str, plant: str) -> str:
    """Controller and plant by their names."""
    return sketch(
        880, 160, f"Block diagram: {controller} gives phase currents to {plant}, whose encoders it reads; only the "
                  "references, their rates and external forces come from outside.",
        symbol(44, 47, "r, ṙ"), words(44, 70, "references", "small"), arrow([(74, 50), (150, 50)]),
        box(150, 20, 200, 64, controller, "every sample_time"), arrow([(350, 50), (500, 50)]),
        symbol(425, 42, "i_a, i_b, i_c"), words(425, 70, "held over a sample", "small"),
        box(500, 20, 180, 64, plant), arrow([(590, 150), (590, 84)]), words(598, 140, "external forces", "start small"),
        arrow([(680, 50), (780, 50)]), words(730, 42, "positions", "small"),
        arrow([(520, 84), (520, 120), (250, 120), (250, 84)]), words(385, 138, "encoders", "small"))
