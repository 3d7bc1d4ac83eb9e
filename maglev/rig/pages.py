"""Sections of the FMUs' documentation that are a rig's own: its equations, with TeX between the marks of `mathml`."""

from html import escape

from maglev.rig.text import module, thrust_constant, vertical_constants
from pmlsm.rig import Rig

GREEK = "alpha, beta, gamma, delta"   # letters of TeX
GROUPS = {1.0: "motor", 2.0: "pair of motors", 3.0: "three motors"}   # with one current


def stage_page(rig: Rig) -> str:
    """Text of `plant_fmu/documentation/stage_NAME.html`."""
    vertical = rig.vertical.name
    *others, last = (f"{axis.name} (driven by {motor_words(rig, axis.name)})" for axis in rig.horizontal)
    rows = [rf"\ddot g = {normal_row(rig)} + \Delta_{tex_axis(vertical)}",
            *(rf"\ddot {tex_axis(axis.name)} = -{thrust_row(rig, axis.name)} + \Delta_{tex_axis(axis.name)}" for axis in rig.horizontal)]
    sentences = (
        noted(rig, "equation"), f"Constants of the stage: {escape(rig.source('stage'))}.",
        f"The controllers' model has its own: {escape(rig.source('model'))}.", noted(rig, "constants"),
        "All are accelerations at the nominal masses; other masses are below.")
    return module(rf"""
<h2>The {escape(rig.title)}</h2>
<p>Motion{cited(rig.equation)} along the axes {", ".join([f"{vertical} (the air gap g)", *others])} and {last}:</p>
{equations(rows)}
<p>{chr(10).join(filter(None, sentences))}</p>
""")


def linearisation_page(rig: Rig) -> str:
    """Text of `controller_fmu/documentation/linearisation_NAME.html`."""
    motors = len(rig.motors)
    squares = [f"{number(len(rig.motors_of(axis.name)))}{symbol(rig, axis.name)}^2" for axis in rig.horizontal]
    direct = f"{number(motors)}i_d^2"
    squares = [*squares, direct] if motors > 1 else [f"{symbol(rig, rig.horizontal[0].name)}^2", direct]
    attraction, coils, iron = tex_constants(rig)
    row = (f"G - {number(rig.sharing)}{iron} f_4 ({' + '.join(squares)}) + {number(rig.carrying)}{coils} f_3 i_d "
           f"- {number(rig.carrying)}{attraction} f_2")
    root = rf"i_d: \text{{ smaller root of }} {row} = v_{tex_axis(rig.vertical.name)}"
    shared = "" if motors == 1 else "; all motors get the same direct current"
    return module(rf"""
<h2>Feedback linearisation</h2>
<p>The currents that make demanded accelerations {demands(rig)} in the controller's own
model{cited(rig.source("law"))}{shared}:</p>
{equations([quadrature(rig), root])}
""")


def setpoint_page(rig: Rig) -> str:
    """Text of `controller_fmu/documentation/setpoint_NAME.html`."""
    attraction, coils, iron = tex_constants(rig)
    all_, twice = number(rig.carrying), number(2.0 * rig.carrying)
    gap = tex_axis(rig.vertical.name)
    motors, holding = ("motor", "") if len(rig.motors) == 1 else ("motors", ", in all of them,")
    slopes = (rf"\alpha = {all_}{coils} f_3^\prime i_d^* - {all_}{iron} f_4^\prime (i_d^*)^2 - {all_}{attraction} "
              rf"f_2^\prime, \qquad \beta = {all_}{coils} f_3 - {twice}{iron} f_4 i_d^*")
    currents = rf"i_d = \frac{{v_{gap} - \alpha e_{gap}}}{{\beta}}, \qquad {quadrature(rig)}"
    return module(rf"""
<h2>Linearisation about a set-point</h2>
<p>The output regulator is that of the nonlinear controller, and acts on the {motors} linearised about the equilibrium at the
set-point g*{cited(rig.source("linearisation"))}: \(i_d^{{*}}\) is the smaller current that{holding} holds the mover there in
the controller's model \(G - {all_}{iron} f_4 i_d^2 + {all_}{coils} f_3 i_d - {all_}{attraction} f_2 = 0\), and, all at g*,</p>
{equations([slopes, currents])}
<p>with the demands v of the regulator below. Near g* the closed loop has the poles of the nonlinear one: the gains on the
currents are those of the nonlinear law, less α on the error, over β. No current is fed forward. The gains are computed at
the initialization.</p>
<p>Where <code>bumpless</code> is false, the integrators do not start with what holds the mover where it is but as they rest
at g*: the law begins with \(i_d = i_d^* + (v_{gap} - \alpha e_{gap})/\beta\) and no integral of an
error, as from rest with the target's equilibrium current fed forward. Which of the two the thesis's runs had is assumed; it
does not say.</p>
""")


def rows_page(rig: Rig) -> str:
    """Text of `estimator_fmu/documentation/rows_NAME.html`."""
    attraction, coils, iron = tex_constants(rig)
    direct, squares = sums(rig)
    s = number(rig.sharing)
    vertical = (rf"\ddot {tex_axis(rig.vertical.name)} = \begin{{pmatrix}} -{number(rig.carrying)}f_2 & {s}f_3 {direct} & -{s}f_4 "
                rf"({squares}) \end{{pmatrix}} \begin{{pmatrix}} {attraction} \\ {coils} \\ {iron} \end{{pmatrix}} + G")
    horizontal = r", \qquad ".join(rf"\ddot {tex_axis(axis.name)} = -{thrust_row(rig, axis.name, last=True)}"
                                   for axis in rig.horizontal)
    note = noted(rig, "equation")
    return module(rf"""
<h2>Rows of the {escape(rig.title)}</h2>
<p>{f"From {rig.equation}, with" if rig.equation else "With"} the shape functions \(f_1\) … \(f_4\) at the measured gap and
the delivered currents:</p>
{equations([vertical, horizontal])}
{f"<p>{note}</p>" if note else ""}
""")


def equations(rows: list[str]) -> str:
    """Equations on lines of their own."""
    return '<div class="eq">' + "\n".join(rf"\[{row}\]" for row in rows) + "</div>"


def cited(source: str) -> str:
    """Where an equation stands, as text goes on with it; nothing if the rig's description does not say."""
    text = escape(source)
    return "" if text in ("", "assumed") else f" {text}" if text.startswith("(") else f" ({text})"


def noted(rig: Rig, key: str) -> str:
    """A sentence of the description's sources; nothing if it has none."""
    note = escape(rig.sources.get(key, ""))
    return f"{note[0].upper()}{note[1:]}." if note else ""


def motor_words(rig: Rig, axis: str) -> str:
    """What drives an axis, such as "the pair of motors alpha"."""
    motors = rig.motors_of(axis)
    group = GROUPS.get(rig.sharing, "motors")
    if len(rig.motors) == 1:
        return f"one {group}" if rig.sharing < 3.0 else group
    return " and ".join(f"the {group} {motor.name}" for motor in motors)


def number(factor: float) -> str:
    """Factor in front of a term; nothing if it is 1."""
    return "" if factor == 1.0 else f"{factor:g} "


def current(rig: Rig, component: str, motor: str) -> str:
    """Direct or quadrature current of a motor in TeX."""
    if len(rig.motors) == 1:
        return f"i_{component}"
    name = rf"\{motor}" if motor in GREEK.split(", ") else rf",\mathrm{{{motor.replace('_', '')}}}"
    return f"i_{{{component}{name}}}"


def symbol(rig: Rig, axis: str) -> str:
    """Quadrature current of an axis, which its motors have in common."""
    return current(rig, "q", rig.motors_of(axis)[0].name)


def tex_axis(name: str) -> str:
    """Name of an axis in TeX."""
    return name if len(name) == 1 else rf"{{\mathrm{{{name.replace('_', '')}}}}}"


def tex_constants(rig: Rig) -> tuple[str, str, str]:
    """Constants of the vertical row in TeX: attraction, coils, iron."""
    attraction, coils, iron = (tex_name(name) for name in vertical_constants(rig))
    return attraction, coils, iron


def tex_name(constant: str) -> str:
    """Name of a constant in TeX."""
    return f"C_{{{constant[1:]}}}" if len(constant) > 2 else f"C_{constant[1:]}"


def sums(rig: Rig) -> tuple[str, str]:
    """Sum of the direct currents, in parentheses if there are several, and of the squares of all."""
    direct = " + ".join(current(rig, "d", motor) for motor in rig.motor_names)
    squares = " + ".join(f"{current(rig, component, motor)}^2" for motor in rig.motor_names for component in ("q", "d"))
    return direct if len(rig.motors) == 1 else f"({direct})", squares


def normal_row(rig: Rig) -> str:
    """Acceleration of the air gap by gravity and motors."""
    attraction, coils, iron = tex_constants(rig)
    direct, squares = sums(rig)
    s = number(rig.sharing)
    return f"G - {s}{iron} f_4 ({squares}) + {s}{coils} f_3 {direct} - {number(rig.carrying)}{attraction} f_2"


def thrust_row(rig: Rig, axis: str, last: bool = False) -> str:
    """Acceleration against a horizontal axis; the constant stands `last` in the row of an estimator."""
    currents = " + ".join(current(rig, "q", motor.name) for motor in rig.motors_of(axis))
    thrust = f"f_1 {currents}" if len(rig.motors_of(axis)) == 1 else f"f_1 ({currents})"
    constant = tex_name(thrust_constant(rig, axis))
    return f"{number(rig.sharing)}{f'{thrust} {constant}' if last else f'{constant} {thrust}'}"


def quadrature(rig: Rig) -> str:
    """Quadrature currents for the demanded accelerations of the horizontal axes."""
    return r", \qquad ".join(
        " = ".join(current(rig, "q", motor.name) for motor in rig.motors_of(axis.name))
        + rf" = -\frac{{v_{tex_axis(axis.name)}}}{{{number(rig.sharing * len(rig.motors_of(axis.name)))}"
          rf"{tex_name(thrust_constant(rig, axis.name))} f_1}}" for axis in rig.horizontal)


def demands(rig: Rig) -> str:
    """Demanded accelerations of all axes."""
    return ", ".join(rf"\(v_{tex_axis(axis)}\)" for axis in rig.axis_names)
