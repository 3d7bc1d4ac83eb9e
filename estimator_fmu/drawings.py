"""Icon of the estimators, and their block diagram."""

import math

from fmi_export.pages.icon import Shape, disc, stroke
from fmi_export.pages.sketch import arrow, box, line, sketch, symbol, words

CURVE = [(14 + 3 * k, round(46 - 36 * math.exp(-0.11 * k) * math.cos(0.62 * k), 3)) for k in range(27)]


def icon(axes: int) -> tuple[Shape, ...]:
    """An estimate that approaches the value that is sought; dots for the axes."""
    dots = [disc(50 + 16 * (k - (axes - 1) / 2), 92, 5.5, "#404850") for k in range(axes)]
    return (*stroke([(12, 6), (12, 80), (94, 80)], 6, "#404850"), *stroke([(16, 46), (94, 46)], 5, "#c03030"),
            *stroke(CURVE, 6, "#2b4fc7"), *dots)


def block_diagram() -> str:
    """From measured positions and delivered currents to the constants."""
    return sketch(
        800, 200, "Block diagram: of the measured positions the velocity filter makes y; with the delivered currents "
                  "they give the rows A and b; the estimator follows the constants C with a gain from its weight Σ.",
        words(14, 50, "measured", "start"), arrow([(80, 45), (180, 45)]), box(180, 20, 130, 50, "velocity filter",
                                                                            "$T_1, T_2$"),
        arrow([(310, 45), (540, 45)]), symbol(425, 38, "y"), line([(120, 45), (120, 115)]),
        arrow([(120, 115), (180, 115)]), symbol(14, 160, "i_d, i_q", "start"), arrow([(80, 155), (180, 155)]),
        box(180, 95, 130, 80, "rows by", "$f_1 … f_4$"), arrow([(310, 135), (370, 135)]), symbol(340, 127, "A, b"),
        box(370, 110, 110, 50, "matched filter", "(can be on)"), arrow([(480, 135), (540, 135)]),
        box(540, 20, 140, 140, "estimator (3.8)", "$ε Σ Ĉ′ = Aᵀ (y − x̂)$",
            "$Σ′ = AᵀA − Q / γ²$"), arrow([(680, 90), (740, 90)]), symbol(770, 95, "C_1 …"))
