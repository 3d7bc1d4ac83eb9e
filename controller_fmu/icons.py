"""Icons of the controllers: a block with the curve of its law; dots for the axes that it controls."""

import math

from maglev.fmi.icon import Point, Shape, disc, rectangle, stroke

COLOURS = {"nonlinear": "#2b4fc7", "linear": "#137a4b", "scheduled": "#8a3aa0", "interpolated": "#0e7490",
           "adaptive": "#b0306a", "PID": "#b45309", "commutation": "#334155", "written": "#0f6f86"}
PHASES = ("#c03030", "#2b4fc7", "#137a4b")
AXES = "#9aa3ac"

# Letters, in a square of side 1.
LETTERS = (((0.06, 0.8), (0.06, 0.2), (0.26, 0.2), (0.3, 0.35), (0.26, 0.5), (0.06, 0.5)), ((0.48, 0.2), (0.48, 0.8)),
           ((0.66, 0.2), (0.66, 0.8), (0.82, 0.8), (0.95, 0.65), (0.95, 0.35), (0.82, 0.2), (0.66, 0.2)))
CURVES: dict[str, tuple[tuple[Point, ...], ...]] = {
    "nonlinear": (tuple((k / 16, 0.5 - 0.42 * math.tanh(4.0 * (k / 16 - 0.5))) for k in range(17)),),
    "linear": (((0.06, 0.94), (0.94, 0.06)),),
    "scheduled": (((0.0, 0.92), (0.25, 0.92), (0.25, 0.66), (0.5, 0.66), (0.5, 0.38), (0.75, 0.38), (0.75, 0.1),
                   (1.0, 0.1)),),
    "interpolated": (((0.0, 0.92), (0.3, 0.72), (0.62, 0.42), (1.0, 0.1)),),
    "adaptive": (tuple((k / 24, 0.5 - 0.45 * math.exp(-k / 8) * math.cos(math.pi * k / 6)) for k in range(25)),),
    "PID": LETTERS,
    "commutation": tuple(tuple((k / 24, 0.5 - 0.4 * math.sin(2.0 * math.pi * (k / 24 - phase / 3))) for k in range(25))
                         for phase in range(3)),
    "written": (((0.12, 0.22), (0.42, 0.5), (0.12, 0.78)), ((0.55, 0.8), (0.92, 0.8)))}


def controller(law: str, axes: int = 0) -> tuple[Shape, ...]:
    """Icon of a controller by its law, one of `CURVES`."""
    colour = COLOURS[law]
    dots = [disc(50 + 16 * (k - (axes - 1) / 2), 92, 5.5, colour) for k in range(axes)]
    return (*stroke([(3, 43), (97, 43)], 6, "#404850"), rectangle(14, 7, 72, 72, colour), *law_symbol(law, 14, 7, 72),
            *dots)


def law_symbol(law: str, x: float, y: float, size: float) -> list[Shape]:
    """A law's curve on white, within a frame of the law's colour whose upper left corner and size are given."""
    frame = 0.08 * size
    inner, low = size - 2 * frame, 0.13 * size
    shapes = [rectangle(x + frame, y + frame, inner, inner, "#ffffff")]
    span = size - 2 * frame - low
    left, top = x + frame + low / 2, y + frame + low / 2
    if law in ("nonlinear", "linear"):
        shapes += stroke([(left, top + span / 2), (left + span, top + span / 2)], 0.035 * size, AXES)
        shapes += stroke([(left + span / 2, top), (left + span / 2, top + span)], 0.035 * size, AXES)
    for k, curve in enumerate(CURVES[law]):
        points = [(round(left + span * a, 3), round(top + span * b, 3)) for a, b in curve]
        shapes += stroke(points, 0.1 * size, PHASES[k] if law == "commutation" else COLOURS[law])
    return shapes
