"""Block diagrams of the controllers."""

from fmi_export.pages.sketch import arrow, box, difference, line, sketch, symbol, words

LAWS = {"nonlinear": ("feedback", "linearisation"), "linear": ("motor linearised", "about g*"),
        "scheduled": ("one of four", "linearisations"), "interpolated": ("linearised at", "the gap")}
MIDDLE = 120   # px, height of the signals' way from left to right


def regulator(law: str) -> str:
    """Output regulation on a motor that is linearised: a law of `LAWS`."""
    m = MIDDLE
    by_gap = "" if law == "linear" else (arrow([(505, m + 110), (505, m + 30)])
                                         + words(511, m + 82, "gap", "start small"))
    return sketch(
        880, 250, "Block diagram: the error drives an internal model; a state feedback of error, its rate and the "
                  "model's states demands an acceleration; the motor's linearisation makes currents of it, which are "
                  "limited and commutated. What the limit takes away goes back to the internal model.",
        symbol(14, m + 5, "r"), arrow([(24, m), (51, m)]), difference(60, m),
        line([(69, m), (305, m)]), arrow([(295, m), (305, m)]), symbol(90, m - 8, "e"),
        arrow([(110, m), (110, m - 60), (140, m - 60)]),
        box(140, m - 84, 130, 48, "internal model", "$ξ′ = φ ξ + N e$"), symbol(340, m - 68, "ξ"),
        arrow([(270, m - 60), (360, m - 60), (360, m - 32)]),
        symbol(14, m + 65, "ṙ"), arrow([(24, m + 60), (140, m + 60)]), box(140, m + 36, 130, 48, "velocity observer"),
        arrow([(205, m + 110), (205, m + 84)]), symbol(340, m + 78, "ė"),
        arrow([(270, m + 60), (360, m + 60), (360, m + 32)]),
        box(305, m - 32, 110, 64, "state feedback", "$v = K x + ξ_1$"),
        arrow([(415, m), (450, m)]), symbol(430, m - 8, "v"),
        box(450, m - 30, 115, 60, *LAWS[law]), by_gap,
        limit_and_commutation(565, m),
        line([(638, m - 25), (638, 16), (205, 16)], "dashed"), arrow([(205, 16), (205, m - 84)]),
        symbol(450, 32, "E_c (sat(u) − u)"), measured(m, 60, 565))


def pid() -> str:
    """PID on the currents."""
    m = 50
    return sketch(
        880, 180, "Block diagram: the reference behind its pre-filter is compared with what is measured; a PID on the "
                  "error and its rate makes currents, which are limited and commutated.",
        symbol(14, m + 5, "r"), arrow([(24, m), (60, m)]), box(60, m - 30, 100, 60, "pre-filter", "$ω$"),
        arrow([(160, m), (211, m)]), symbol(186, m - 8, "r_f"), difference(220, m),
        arrow([(229, m), (300, m)]), symbol(262, m - 8, "e"),
        box(300, m - 30, 190, 60, "PID", "$k_p e + k_i ∫e dt + k_d ė$"),
        box(300, m + 52, 190, 34, "velocity observer"), arrow([(395, m + 52), (395, m + 30)]), symbol(408, m + 46, "ė"),
        arrow([(395, m + 110), (395, m + 86)]), limit_and_commutation(490, m), measured(m, 220, 490))


def commutation() -> str:
    """Commutation alone."""
    m = 50
    return sketch(
        520, 180, "Block diagram: the direct and quadrature currents are limited; the commutation makes phase currents "
                  "of them at the measured displacement.",
        symbol(44, m - 8, "i_d, i_q"), line([(14, m), (90, m)]), limit_and_commutation(80, m, label=False),
        measured(m, None, 80))


def written(sampled: int) -> str:
    """A class of which its inputs and outputs are known, and whether it has samples, 1, or not, 0."""
    when, said = (("every sample_time", "at every sample the class computes its outputs from its inputs; they hold in "
                                        "between") if sampled else
                  ("every communication step", "in every communication step the class goes on by it, its inputs held"))
    return sketch(
        620, 90, f"Block diagram: {said}.", words(80, 50, "inputs"), arrow([(110, 45), (190, 45)]),
        box(190, 15, 230, 60, "step of the class,", when), arrow([(420, 45), (500, 45)]), words(540, 50, "outputs"))


def limit_and_commutation(x: float, m: float, label: bool = True) -> str:
    """From commanded currents, at x, to phase currents."""
    return "".join([
        symbol(x + 24, m - 8, "i_d, i_q") if label else "", arrow([(x, m), (x + 50, m)]), box(x + 50, m - 25, 46, 50),
        line([(x + 56, m + 14), (x + 64, m + 14), (x + 82, m - 14), (x + 90, m - 14)]),
        words(x + 73, m + 42, "limit", "small"), arrow([(x + 96, m), (x + 135, m)]),
        box(x + 135, m - 30, 105, 60, "commutation", "(C.1)"), arrow([(x + 240, m), (x + 305, m)]),
        symbol(x + 274, m - 8, "i_a, i_b, i_c"),
        words(x + 194, m + 82, "displacement", "start small")])


def measured(m: float, error: float | None, start: float) -> str:
    """What is measured, from below: to the error, if there is one at x, and to the commutation right of a start."""
    y, end = m + 110, start + 187
    to_error = "" if error is None else arrow([(error, y), (error, m + 9)])
    return (words(14, y + 18, "measured", "start") + line([(14, y), (end, y)]) + to_error
            + arrow([(end, y), (end, m + 30)]))
