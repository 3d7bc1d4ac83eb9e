r"""Names of a stage in the equations of its pages, as TeX between the marks of `mathml`."""

from typing import Any

from maglev.fmi.escapes import page_text
from pmlsm.stage_description import StageDescription

GREEK = "alpha, beta, gamma, delta"   # letters of TeX
GROUPS = {1.0: "motor", 2.0: "pair of motors", 3.0: "three motors"}   # with one current


def tex(stage: StageDescription) -> dict[str, Any]:
    """Values for equations: axes, constants and currents by their names, and factors.

    `i_q` are the quadrature currents of each horizontal axis, `i_d` the direct currents, and `squares` the squares of
    all. `shared_squares` are the squares with one direct current in all motors and one quadrature current for each
    axis. `drivers` are the words for the motors that drive an axis.
    """
    horizontal = [axis.name for axis in stage.horizontal]
    attraction, coils, iron = (constant_symbol(name) for name in stage.constants_of(stage.vertical.name))
    i_q = {axis: [current(stage, "q", motor.name) for motor in stage.motors_of(axis)] for axis in horizontal}
    alone = len(stage.motors) == 1
    return {
        "gap": axis(stage.vertical.name), "symbol": {name: axis(name) for name in stage.axis_names},
        "attraction": attraction, "coils": coils, "iron": iron,
        "thrust": {name: constant_symbol(stage.constants_of(name)[0]) for name in horizontal},
        "n": factor_text(stage.sharing), "all": factor_text(stage.carrying), "twice": factor_text(2.0 * stage.carrying),
        "i_q": i_q, "i_d": [current(stage, "d", motor) for motor in stage.motor_names],
        "squares": " + ".join(f"{current(stage, component, motor)}^2"
                              for motor in stage.motor_names for component in "qd"),
        "shared_squares": " + ".join([*(f"{factor_text(len(i_q[name]))}{i_q[name][0]}^2" for name in horizontal),
                                      f"{factor_text(len(stage.motors))}i_d^2"]),
        "currents": r", \qquad ".join(
            rf"{' = '.join(i_q[name])} = -\frac{{v_{axis(name)}}}{{{factor_text(stage.sharing * len(i_q[name]))}"
            rf"{constant_symbol(stage.constants_of(name)[0])} f_1}}" for name in horizontal),
        "alone": alone, "drivers": {name: drivers(stage, name) for name in horizontal}}


def drivers(stage: StageDescription, name: str) -> str:
    """Words for the motors that drive an axis, such as "the pair of motors alpha"."""
    group = GROUPS.get(stage.sharing, "motors")
    if len(stage.motors) == 1:
        return f"one {group}" if stage.sharing < 3.0 else group
    return " and ".join(f"the {group} {motor.name}" for motor in stage.motors_of(name))


def factor_text(factor: float) -> str:
    """Factor in front of a term; nothing if it is 1."""
    return "" if factor == 1.0 else f"{factor:g} "


def axis(name: str) -> str:
    return name if len(name) == 1 else rf"{{\mathrm{{{name.replace('_', '')}}}}}"


def constant_symbol(name: str) -> str:
    return f"C_{{{name[1:]}}}" if len(name) > 2 else f"C_{name[1:]}"


def current(stage: StageDescription, component: str, motor: str) -> str:
    if len(stage.motors) == 1:
        return f"i_{component}"
    name = rf"\{motor}" if motor in GREEK.split(", ") else rf",\mathrm{{{motor.replace('_', '')}}}"
    return f"i_{{{component}{name}}}"


def cited(source: str) -> str:
    """Return the source of an equation, as text continues with it; empty if the description does not give it."""
    text = page_text(source)
    return "" if text in ("", "assumed") else f" {text}" if text.startswith("(") else f" ({text})"


def tex_sentence(note: str) -> str:
    """A sentence of the description's sources."""
    return page_text(f"{note[:1].upper()}{note[1:]}.")
