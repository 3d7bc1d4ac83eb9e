"""Icon of the measurement, and its block diagram."""

from maglev.fmi.icon import Shape, disc, stroke
from maglev.fmi.sketch import arrow, box, picture, sketch, symbol, words

# A signal with noise on it.
NOISE = (0, 5, -4, 7, -6, 2, 8, -3, -7, 4, 6, -5, 3, -8, 5, -2, 7, -6, 4, 0)
CURVE = [(12.0 + 4.0 * k, 58.0 - 1.4 * k + 1.5 * noise) for k, noise in enumerate(NOISE)]
LINE = [(12.0, 58.0), (88.0, 31.4)]


def icon(axes: int) -> tuple[Shape, ...]:
    """A signal with noise over the one without; dots for the axes."""
    dots = [disc(50 + 16 * (k - (axes - 1) / 2), 92, 5.5, "#404850") for k in range(axes)]
    return (*stroke([(12, 6), (12, 80), (94, 80)], 6, "#404850"), *stroke(CURVE, 5, "#2b4fc7"),
            *stroke(LINE, 4, "#c03030"), *dots)


def block_diagram() -> str:
    """Draw the way from the encoder to the controller."""
    return sketch(
        "Block diagram: each encoder is read with a delay and jitter; the interpolation error, offset, drift and noise "
        "are added; after a lost sample, or from a frozen encoder, the measurement does not change.",
        picture(374, words(115, 16, "encoder"), arrow([(115, 22), (115, 46)]),
                box(50, 46, 130, 56, "delay, jitter", "$t_k − τ − j u_k$"), arrow([(115, 102), (115, 136)]),
                symbol(126, 124, "q"),
                box(10, 136, 210, 80, "interpolation error", "$+ A sin(2π q/p)$", "offset, drift, noise"),
                arrow([(115, 216), (115, 250)]), box(50, 250, 130, 56, "lost or frozen:", "no change"),
                arrow([(115, 306), (115, 342)]), words(115, 362, "measured"), width=230))
