"""Write the tables of docs/results_stability.md: the thesis's poles and those of its gains.

    python tools/published_poles.py
"""

from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from maglev.files.marked import markdown_table, write_part
from maglev.linear.design import regulator_polynomial
from maglev.linear.loop import Loop, linearise_loop
from maglev.linear.model import equivalents, slowest_first

PAGE = Path(__file__).parents[1] / "docs" / "results_stability.md"
OMEGA0 = 1.5 * np.pi   # rad/s
SAME = 0.01            # of every coefficient: what the rounding of the printed poles and gains explains
NEARLY = 0.06
FAST = 300.0           # 1/s; poles beyond are those of amplifiers and observers

Array = NDArray[np.complex128]


class GainSet(NamedTuple):
    """Printed poles (1/s) and gains k1…k5, and where they are run: plant, controller, gap (m), axis."""

    name: str
    source: str
    poles: tuple[complex, ...]
    gains: tuple[float, ...]
    stage: str
    gap: float
    axes: tuple[str, ...]


def pair(real: float, imaginary: float) -> tuple[complex, complex]:
    return complex(real, imaginary), complex(real, -imaginary)


SETS = (
    GainSet("Kh", "(4.17)", (-9, -10, -11, -12, -13), (-1182, -55, -154440, -45128, -11924), "2DOF", 20e-3, ("h",)),
    GainSet("Kv", "(4.17)", (-11, -12, -13, -14, -15), (-1662, -65, -360360, -103350, -20332), "2DOF", 20e-3, ("v",)),
    GainSet("Kv, low overshoot", "(4.17)", (-57.9, *pair(-9.9, 11.3), *pair(-1.6, 1.4)),
            (-1592, -81, -55736, -11573, -15825), "2DOF", 20e-3, ("v",)),
    GainSet("Kx = Kz, k4 as printed", "(5.12)", (-31.6, *pair(-2.8, 5.6), *pair(-2.1, 1.7)),
            (-354, -41, -8945, -1201, -1472), "3DOF", 25e-3, ("x", "z")),
    GainSet("Kx = Kz, k4 = +1201", "(5.12)", (-31.6, *pair(-2.8, 5.6), *pair(-2.1, 1.7)),
            (-354, -41, -8945, 1201, -1472), "3DOF", 25e-3, ("x", "z")),
    GainSet("Ky", "(5.12)", (-129.1, *pair(-3.3, 5.8), *pair(-2.2, 1.9)), (-1487, -140, -50001, -560, -7836),
            "3DOF", 25e-3, ("y",)),
    GainSet("Kx = Kz", "(5.14)", (-5, -6, -7, -8, -9), (-463, -35, -15121, -997, -2548), "3DOF", 25e-3, ("x", "z")),
    GainSet("Ky", "(5.14)", (-91.3, *pair(-4.2, 6.4), *pair(-2.3, 2.0)), (-1274, -104, -50001, -3936, -7774),
            "3DOF", 25e-3, ("y",)),
)


def largest_difference(gain_set: GainSet) -> float:
    """Largest relative difference of a coefficient of the polynomial of the gains from that of the printed poles."""
    printed = np.poly(gain_set.poles).real
    return float(np.abs(regulator_polynomial(gain_set.gains, OMEGA0) / printed - 1.0)[1:].max())


def poles_verdict(share: float) -> str:
    return "the same" if share < SAME else "nearly" if share < NEARLY else "**not these**"


def loop_with(gain_set: GainSet, parameters: Mapping[str, float] | None = None) -> Loop:
    """Loop of the stage with these gains on their axes, and parameters of the plant; all others are as they start."""
    gains = {f"{axis}.k{k}": value for axis in gain_set.axes for k, value in enumerate(gain_set.gains, 1)}
    vertical = "v" if gain_set.stage == "2DOF" else "y"
    return linearise_loop(f"Plant{gain_set.stage}", f"Regulator{gain_set.stage}", {vertical: gain_set.gap},
                          # Without bias no quadrature current flows at rest, and the axes do not act on each other.
                          plant_parameters={**{f"{axis}.bias": 0.0 for axis in ("vh" if vertical == "v" else "yxz")},
                                            **(parameters or {})},
                          controller_parameters=gains)


def axis_rates(loop: Loop, axis: str) -> Array:
    """Rates (1/s) of the closed loop that belong to one axis, the slowest first, without bias."""
    closed = loop.closed
    stage = loop.plant.equilibrium.stage
    currents = {f"{motor.name}.i_q"
                for motor in stage.motors_of(axis)} or {f"{motor}.i_d" for motor in stage.motor_names}
    own = [k for k, name in enumerate(closed.states)
           if name.removeprefix("controller.").startswith(f"{axis}.") or name in currents]
    poles = np.linalg.eigvals(closed.A[np.ix_(own, own)]).astype(np.complex128)
    return slowest_first(equivalents(poles, loop.controller.sample_time or 0.0))


def pole_words(poles: Array | tuple[complex, ...]) -> str:
    """Poles as text, the fastest first, a pair as one."""
    values = sorted((complex(pole) for pole in poles), key=lambda pole: pole.real)
    return ", ".join((f"{pole.real:.1f} ± {pole.imag:.1f}i" if pole.imag else f"{pole.real:.1f}").replace("-", "−")
                     for pole in values if pole.imag >= 0.0)


def design_table() -> str:
    """Printed poles, the poles of the printed gains, and how far their polynomials are apart."""
    rows = []
    for gain_set in SETS:
        share, poles = largest_difference(gain_set), slowest_first(
            np.roots(regulator_polynomial(gain_set.gains, OMEGA0)).astype(np.complex128))
        rows.append((f"{gain_set.name} {gain_set.source}", pole_words(gain_set.poles), pole_words(poles),
                     f"{100.0 * share:.2g} %", poles_verdict(share)))
    heads = ("gains", "printed poles (1/s)", "poles of the gains (1/s)", "coefficients within", "verdict")
    return markdown_table(heads, rows)


def poles_beside_loop() -> str:
    """Poles of the design next to those of the sampled loop of plant and regulator, and its margins."""
    rows = []
    for gain_set in SETS:
        loop = loop_with(gain_set)
        axis = gain_set.axes[0]
        margins = loop.margins(axis)
        slow = [rate for rate in axis_rates(loop, axis) if abs(rate) < FAST]
        rows.append((f"{gain_set.name} {gain_set.source}", f"{axis}, {1e3 * gain_set.gap:.0f} mm",
                     pole_words(np.array(slow)), f"{margins.gain_down:.2f}…{margins.gain_up:.0f}",
                     f"{np.degrees(margins.phase):.0f}°", f"{1e3 * margins.delay:.1f} ms",
                     f"{margins.sensitivity_peak:.2f}", f"{margins.disk:.2f}"))
    heads = ("gains", "axis, at", "poles in the loop, to 300 /s (1/s)", "gain factor", "phase", "delay", "Ms", "disk")
    return markdown_table(heads, rows)


TABLES = {"design": design_table, "loop": poles_beside_loop}


def main() -> None:
    for name, table in TABLES.items():
        write_part(PAGE, name, table())


if __name__ == "__main__":
    main()
