"""Icons of the plants, and sketches of the stages with their axes, directions and symbols."""

from maglev.fmi.icon import Shape, disc, rectangle, stroke
from maglev.fmi.sketch import WIDTH, filled_box, labelled_arrow, line, picture, sketch, symbol, words

IRON, MOVER, COPPER, RED, BLUE = "#607080", "#404850", "#d08030", "#c03030", "#3050c0"
PHASES = "acbacb"   # of successive slots
POLE, SLOT, TOOTH = 36, 16, 12   # px


def icon(axes: int) -> tuple[Shape, ...]:
    """Icon of a plant: the 2-DOF stage from the side, the 3-DOF stage from above, a tilting stage with its tilts."""
    return from_the_side() if axes == 2 else from_above() if axes == 3 else (*from_above(), *tilting_corners())


def from_the_side() -> tuple[Shape, ...]:
    """Stator with teeth and coils, and below it the mover with its magnets."""
    teeth = [rectangle(6 + 26 * k, 8, 10, 38, IRON) for k in range(4)]
    coils = [rectangle(16 + 26 * k, 22, 16, 22, COPPER) for k in range(3)]
    magnets = [rectangle(14 + 18 * k, 60, 18, 12, (RED, BLUE)[k % 2]) for k in range(4)]
    return (rectangle(6, 8, 88, 13, IRON), *teeth, *coils, *magnets, rectangle(14, 72, 72, 18, MOVER))


def from_above() -> tuple[Shape, ...]:
    """Mover with the magnets of four motors, of which two drive it along either direction."""
    bars = [rectangle(24, y, 52, 14, COPPER) for y in (6, 80)] + [rectangle(x, 24, 14, 52, BLUE) for x in (6, 80)]
    cross = [*stroke([(50, 32), (50, 68)], 6, "#ffffff"), *stroke([(32, 50), (68, 50)], 6, "#ffffff")]
    return (rectangle(6, 6, 88, 88, "#d5dade"), rectangle(22, 22, 56, 56, MOVER), *bars, *cross, disc(50, 50, 8, RED))


def tilting_corners() -> tuple[Shape, ...]:
    """Corners that go up and down."""
    up = [((x, 4), (x - 9, 18), (x + 9, 18)) for x in (14, 86)]
    down = [((x, 96), (x - 9, 82), (x + 9, 82)) for x in (14, 86)]
    return (*((RED, corner) for corner in up), *((BLUE, corner) for corner in down))


def stage_sketch(title: str, vertical: str, *others: str) -> str:
    """A stage from the side, and from above where it moves along two directions; its tilts are the last two axes."""
    horizontal, tilted = others[:2], others[2:]
    side = picture(270, side_view(vertical, horizontal[0]))
    if len(horizontal) == 1:
        return sketch(f"{title} from the side: stator with slots above, mover with magnets below it. The air gap "
                      f"{vertical} grows downwards, the displacement {horizontal[0]} to the right.", side)
    return sketch(f"{title} from the side and from above: the air gap {vertical} grows downwards; motors drive the "
                  f"mover along {horizontal[0]}, to the right, and along {horizontal[1]}."
                  f"{f' It tilts by {tilted[0]} and {tilted[1]}.' if tilted else ''}",
                  side, picture(270, above(125, 138, vertical, horizontal), *turns(125, 138, horizontal, tilted),
                                width=250))


def side_view(vertical: str, horizontal: str) -> str:
    """Draw one motor from the side, with the names of its axes."""
    middle, face, gap, width = WIDTH / 2, 92, 50, 4 * POLE
    top, left = face + gap, middle + 30 - width / 2
    slots = [middle + (SLOT + TOOTH) * (k - 5) - SLOT / 2 for k in range(11)]
    parts = [filled_box(slots[0] - TOOTH, 30, slots[-1] - slots[0] + SLOT + 2 * TOOTH, face - 30, "iron")]
    for k, x in enumerate(slots):
        parts += [filled_box(x, 52, SLOT, face - 52, "paper"), words(x + SLOT / 2, 78, PHASES[k % 6], "small")]
    parts.append(filled_box(left, top + 16, width, 34, "iron"))
    for k in range(4):
        parts += [filled_box(left + POLE * k + 4, top, POLE - 8, 16, ("north", "south")[k % 2])]
    bottom = top + 50
    right = left + width
    return "".join(parts) + "".join([
        words(middle, 20, "stator with the coils of phases a, b, c"),
        words(left + width / 2, bottom - 12, "mover with magnets"),
        line([(middle, face + 4), (middle, top - 2)], "dashed"),
        line([(middle, bottom + 4), (middle, bottom + 52)], "dashed"),
        line([(left + width / 2, bottom + 4), (left + width / 2, bottom + 46)]),
        labelled_arrow([(middle, bottom + 40), (left + width / 2, bottom + 40)], horizontal, "axis",
                       (left + width / 2 + 8, bottom + 45)),
        words(middle, bottom + 68, "displacement, 0 at the stator's middle", "small"),
        line([(left - 48, face), (left - 8, face)]), line([(left - 48, top), (left - 4, top)]),
        labelled_arrow([(left - 36, face), (left - 36, top)], f"{vertical} = g", "axis",
                       (left - 44, face + 22), "end"),
        words(left - 44, face + 40, "air gap", "end small"),
        labelled_arrow([(right + 6, bottom - 18), (right + 6 + 40, bottom - 18)], "F", "force",
                        (right + 52, bottom - 13)),
        labelled_arrow([(left - 6, bottom - 18), (left - 46, bottom - 18)], "i_q > 0", "force",
                       (left - 52, bottom - 13), "end"),
        words(left - 6, bottom + 4, "pushes it this way", "end small"),
        # Arrows in the gap, over the mover.
        labelled_arrow([(right - 60, face + 8), (right - 60, face + 42)], "i_d > 0, G", "force",
                       (right - 50, face + 22)),
        words(right - 50, face + 40, "push it down", "start small"),
        words(right + 6, bottom + 4, f"{horizontal}.force > 0", "start small")])


def above(x: float, y: float, vertical: str, horizontal: tuple[str, ...]) -> str:
    """The mover from above, with the motors that drive it along each direction."""
    size, bar = 160, 26
    left, top = x - size / 2, y - size / 2
    pairs = [filled_box(left + bar + 4, place, size - 2 * bar - 8, bar, "north") for place in (top, top + size - bar)]
    pairs += [filled_box(place, top + bar + 4, bar, size - 2 * bar - 8, "south") for place in (left, left + size - bar)]
    return "".join([
        words(x, 20, "from above"), filled_box(left, top, size, size, "iron"), *pairs,
        words(x, top - 8, f"motors along {horizontal[0]}", "small"),
        words(x, top + size + 18, f"motors at the sides: along {horizontal[1]}", "small"),
        labelled_arrow([(x, y), (x + 46, y)], horizontal[0], "axis", (x + 36, y + 18)),
        labelled_arrow([(x, y), (x, y - 46)], horizontal[1], "axis", (x - 16, y - 34), "end"),
        f'<circle class="head" cx="{x:g}" cy="{y:g}" r="3"/>', symbol(x - 10, y + 18, vertical, "end"),
        words(x - 6, y + 34, "down", "small")])


def turns(x: float, y: float, horizontal: tuple[str, ...], tilted: tuple[str, ...]) -> list[str]:
    """Draw the names of the tilts and the numbers of the motors in the view from above; nothing without tilts."""
    if not tilted:
        return []
    numbers = ((x, y - 63, "1"), (x, y + 73, "2"), (x + 67, y + 5, "1"), (x - 67, y + 5, "2"))
    return [words(x, y + 118, f"{tilted[0]} about {horizontal[0]}, {tilted[1]} about {horizontal[1]}", "small"),
            *(f'<circle class="paper" cx="{a:g}" cy="{b - 4:g}" r="9"/>' + words(a, b, text, "small")
              for a, b, text in numbers)]
