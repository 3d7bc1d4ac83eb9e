"""Icon of the closed loops, and the sketch of a loop."""

from controller_fmu.icons import COLOURS, law_symbol
from maglev.fmi.icon import Shape, disc, rectangle, stroke
from maglev.fmi.sketch import arrow, box, picture, sketch, symbol, words
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
        f"Block diagram: {controller} gives phase currents to {plant}, whose encoders it reads; only the references, "
        "their rates and external forces come from outside.",
        picture(276, words(2, 57, "references", "start"), symbol(34, 78, "r, ṙ"), arrow([(72, 52), (110, 52)]),
                box(110, 20, 200, 64, controller, "every sample_time"), arrow([(260, 84), (260, 160)]),
                symbol(270, 108, "i_a, i_b, i_c", "start"), words(270, 126, "constant in", "start small"),
                words(270, 141, "a sample", "start small"), box(110, 160, 200, 64, plant),
                arrow([(160, 160), (160, 84)]), words(152, 126, "encoders", "end small"),
                arrow([(160, 268), (160, 224)]), words(152, 256, "external forces", "end small"),
                arrow([(260, 224), (260, 268)]), words(268, 256, "positions", "start small")))
