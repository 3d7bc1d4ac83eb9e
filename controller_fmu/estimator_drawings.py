"""Icon of the estimators, and their block diagram."""

import math

from maglev.fmi.icon import Shape, disc, stroke
from maglev.fmi.sketch import arrow, box, line, picture, sketch, symbol, words

CURVE = [(14 + 3 * k, round(46 - 36 * math.exp(-0.11 * k) * math.cos(0.62 * k), 3)) for k in range(27)]


def icon(axes: int) -> tuple[Shape, ...]:
    """An estimate that approaches the value that is sought; dots for the axes."""
    dots = [disc(50 + 16 * (k - (axes - 1) / 2), 92, 5.5, "#404850") for k in range(axes)]
    return (*stroke([(12, 6), (12, 80), (94, 80)], 6, "#404850"), *stroke([(16, 46), (94, 46)], 5, "#c03030"),
            *stroke(CURVE, 6, "#2b4fc7"), *dots)


def block_diagram() -> str:
    """Draw the estimator, from measured positions and delivered currents to the constants."""
    return sketch(
        "Block diagram: the velocity filter computes y from the measured positions; positions and delivered currents "
        "give the rows A and b; the estimator follows the constants C with a gain from its weight Σ.",
        picture(402, words(75, 16, "measured"), arrow([(75, 22), (75, 60)]),
                box(10, 60, 130, 50, "velocity filter", "$T_1, T_2$"), arrow([(75, 110), (75, 260)]),
                symbol(62, 180, "y"), line([(75, 40), (215, 40)]), arrow([(215, 40), (215, 60)]),
                symbol(275, 16, "i_d, i_q"), arrow([(275, 22), (275, 60)]),
                box(180, 60, 130, 60, "rows by", "$f_1 … f_4$"), arrow([(245, 120), (245, 160)]),
                symbol(264, 144, "A, b"), box(180, 160, 130, 50, "matched filter", "(optional)"),
                arrow([(245, 210), (245, 260)]),
                box(10, 260, 300, 80, "estimator (3.8)", "$ε Σ Ĉ′ = Aᵀ (y − x̂)$", "$Σ′ = AᵀA − Q / γ²$"),
                arrow([(160, 340), (160, 376)]), symbol(160, 395, "C_1 …"), width=320))
