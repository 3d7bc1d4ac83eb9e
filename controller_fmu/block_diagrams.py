"""Block diagrams of the controllers: signals go downwards, measurements next to them on the right."""

from maglev.fmi.sketch import arrow, box, junction, line, picture, sketch, symbol, words

LAWS = {"nonlinear": ("feedback", "linearisation"), "linear": ("motor linearised", "about g*"),
        "scheduled": ("one of four", "linearisations"), "interpolated": ("linearised at", "the gap")}
RAIL = 335   # px across, of the measurements


def regulator(law: str) -> str:
    """Output regulation on a motor that is linearised: a law of `LAWS`."""
    by_gap = "" if law == "linear" else arrow([(RAIL, 297), (235, 297)]) + words(285, 290, "gap", "small")
    return sketch(
        "Block diagram: the error drives an internal model; a state feedback of error, its rate and the model's states "
        "demands an acceleration; the motor's linearisation converts it to currents, which are limited and commutated. "
        "The part beyond the limit is fed back to the internal model.",
        picture(
            535, symbol(60, 16, "r"), arrow([(60, 22), (60, 51)]), junction(60, 60), arrow([(RAIL, 60), (69, 60)]),
            line([(60, 69), (60, 84)]), symbol(48, 86, "e"), arrow([(60, 84), (60, 104)]),
            arrow([(60, 84), (165, 84), (165, 190)]), box(10, 104, 135, 48, "internal model", "$ξ′ = φ ξ + N e$"),
            arrow([(110, 152), (110, 190)]), symbol(120, 175, "ξ"),
            symbol(225, 16, "ṙ"), arrow([(225, 22), (225, 104)]), box(185, 104, 125, 48, "velocity observer"),
            arrow([(RAIL, 128), (310, 128)]), arrow([(225, 152), (225, 190)]), symbol(236, 175, "ė"),
            box(85, 190, 160, 50, "state feedback", "$v = K x + ξ_1$"),
            arrow([(165, 240), (165, 272)]), symbol(177, 260, "v"), box(95, 272, 140, 50, *LAWS[law]), by_gap,
            limit_and_commutation(165, 322),
            line([(142, 377), (36, 377), (36, 160)], "dashed"), arrow([(36, 160), (36, 152)]),
            symbol(44, 366, "E_c (sat(u) − u)", "start"), measured_inputs(464)))


def pid() -> str:
    """PID on the currents."""
    return sketch(
        "Block diagram: the filtered reference is compared with the measurement; a PID on the error and its rate "
        "commands currents, which are limited and commutated.",
        picture(
            445, symbol(60, 16, "r"), arrow([(60, 22), (60, 40)]), box(10, 40, 100, 50, "pre-filter", "$ω$"),
            arrow([(60, 90), (60, 121)]), symbol(74, 105, "r_f"), junction(60, 130), arrow([(RAIL, 130), (69, 130)]),
            arrow([(60, 139), (60, 182)]), symbol(72, 164, "e"),
            box(10, 182, 190, 50, "PID", "$k_p e + k_i ∫e dt + k_d ė$"),
            box(190, 146, 125, 28, "velocity observer"), arrow([(RAIL, 160), (315, 160)]),
            arrow([(260, 174), (260, 207), (200, 207)]), symbol(230, 200, "ė"),
            limit_and_commutation(105, 232), measured_inputs(374)))


def commutation() -> str:
    """Commutation alone."""
    return sketch(
        "Block diagram: the direct and quadrature currents are limited; the commutation converts them to phase "
        "currents at the measured displacement.",
        picture(225, limit_and_commutation(105, 10), measured_inputs(152)))


def own_class(sampled: int) -> str:
    """Draw a class with inputs and outputs, which is sampled (1) or not (0)."""
    when, said = (("every sample_time", "at every sample the class computes its outputs from its inputs; they are "
                                        "constant between samples") if sampled else
                  ("every communication step",
                   "in every communication step the class advances by it with constant inputs"))
    return sketch(
        f"Block diagram: {said}.",
        picture(165, words(125, 16, "inputs"), arrow([(125, 22), (125, 50)]),
                box(10, 50, 230, 60, "step of the class,", when), arrow([(125, 110), (125, 142)]),
                words(125, 160, "outputs"), width=250))


def limit_and_commutation(x: float, y: float) -> str:
    """Draw limit and commutation, from commanded currents, at y, to phase currents."""
    return "".join([
        symbol(x + 12, y + 19, "i_d, i_q", "start"), arrow([(x, y), (x, y + 30)]), box(x - 23, y + 30, 46, 50),
        line([(x - 17, y + 69), (x - 9, y + 69), (x + 9, y + 41), (x + 17, y + 41)]),
        words(x + 31, y + 59, "limit", "start small"), arrow([(x, y + 80), (x, y + 112)]),
        box(x - 53, y + 112, 106, 60, "commutation", "(C.1)"), arrow([(x, y + 172), (x, y + 205)]),
        symbol(x + 12, y + 196, "i_a, i_b, i_c", "start"), arrow([(RAIL, y + 142), (x + 53, y + 142)]),
        words((x + 53 + RAIL) / 2, y + 135, "displacement", "small")])


def measured_inputs(y: float) -> str:
    """Draw the measurements, on the right, from the top to the commutation at y."""
    return words(RAIL + 10, 16, "measured", "end") + line([(RAIL, 22), (RAIL, y)])
