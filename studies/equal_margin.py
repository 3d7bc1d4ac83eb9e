"""Compare laws of the 3-DOF stage at equal margins: the table of docs/results_controllers.md.

    python -m studies.equal_margin

One rule for all laws that contain the thesis's regulator: an axis has the poles of (5.14) for x and z times a factor.
The factor gives the axis the delay margin of ADRC at 25 mm. The thesis's gains, which are slower, are a row.
"""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np

import maglev
from maglev.files.arrays import Array
from maglev.files.marked import markdown_table, write_part
from maglev.linear.design import gains_of

ROOT = Path(__file__).parents[1]
DOCS, RUN = ROOT / "docs" / "results_controllers.md", Path(__file__).with_name("learning.toml")
ADAPTING = ROOT / "examples" / "adapting"
AT = {"y": "25 mm"}
POLES = (-5.0, -6.0, -7.0, -8.0, -9.0)   # 1/s
OMEGA0 = 1.5 * np.pi                     # rad/s
STEPS, CLOSE = 8, 0.01                   # of the search for a factor, and how near it comes
NOISY = {f"measurement.{axis}.noise": "5 um" for axis in ("y", "x", "z")}
LOST = {"reference.plant.C1.end": 0.65 * 0.6135}   # 35 % of the thrust of x, after 6 s
HEADS = ("law", "factor of the poles of y, x", "delay margin of y, x (ms)", "phase margin of y", "mean error of y (µm)",
         "… of x", "… of x, 35 % of its thrust lost", "noise of i_q (A)")

Gains = Mapping[str, float]
Margins = Mapping[str, tuple[float, float]]   # by axis, delay (s) and phase margin (degrees)
LAWS = {"regulator": "Regulator3DOF", "interpolated": "InterpolatedRegulator3DOF", "adaptive": "AdaptiveRegulator3DOF",
        "RLS": str(ADAPTING / "directional_rls.py"), "L1": str(ADAPTING / "l1_adaptive.py")}
ADRC = str(ADAPTING / "adrc.py")
HELD = {LAWS["adaptive"]: {"adaptation.active": False}, LAWS["RLS"]: {"adaptation.active": False}}   # for margins


def gains(y: float, x: float) -> dict[str, float]:
    """Gains that place the poles, times a factor for y and one for x and z."""
    return {f"{axis}.k{k}": gain for axis, factor in (("y", y), ("x", x), ("z", x))
            for k, gain in enumerate(gains_of(np.poly(factor * np.array(POLES)).tolist(), OMEGA0), 1)}


def margins(controller: str, parameters: Gains) -> Margins:
    """Margins of y and x, with the constants that the law begins with."""
    given = {**parameters, **HELD.get(controller, {})}
    if controller.endswith(".py"):
        loop = maglev.linearise_numerically("Plant3DOF", controller, AT, controller_parameters=given).loop
    else:
        loop = maglev.linearise_loop("Plant3DOF", controller, AT, controller_parameters=given)
    if loop is None:
        raise ArithmeticError(f"{controller}: expected a loop that has a linear model")
    return {axis: (found.delay, float(np.degrees(found.phase))) for axis in ("y", "x")
            for found in (loop.margins(axis),)}


def factors(of: Callable[[float, float], Margins], wanted: Mapping[str, float]) -> list[float]:
    """Return factors of y and x that give the desired delay margins (s) to 1 %, by a secant in logarithms.

    The axes do not depend on each other, so both are found at once.
    """
    aims = np.log([wanted["y"], wanted["x"]])
    last, now = np.log([3.0, 3.0]), np.log([4.0, 4.0])

    def misses(at: Array) -> Array:
        found = of(*np.exp(at).tolist())
        return np.asarray(np.log([found["y"][0], found["x"][0]]) - aims)

    before, here = misses(last), misses(now)
    for _ in range(STEPS):
        if np.abs(here).max() < CLOSE:
            break
        moved = np.where(now != last, here * (now - last) / np.where(here != before, here - before, 1.0), 0.0)
        last, now, before = now, now - moved, here
        here = misses(now)
    else:
        raise ArithmeticError(f"margins miss those of ADRC by {np.abs(here).max():.0%} after {STEPS} steps")
    return [float(factor) for factor in np.exp(now)]


def measured(controller: str, parameters: Gains) -> tuple[float, float, float, float]:
    """Mean errors of y and x (m), that of x once thrust is lost, and the noise of its command (A)."""
    given = {**NOISY, **{f"controller.{name}": value for name, value in parameters.items()}}
    whole, lost = (maglev.run(RUN, controller=controller, set={**given, **more}, kind="native") for more in ({}, LOST))
    return (value_of(whole, "mean tracking error", "y"), value_of(whole, "mean tracking error", "x"),
            value_of(lost, "mean tracking error", "x"),
            float(np.sqrt(0.5 * np.mean(np.diff(whole["controller.alpha.i_q_cmd"]) ** 2))))


def value_of(run: maglev.Run, quantity: str, of: str) -> float:
    return next(each.value for each in run.measures if (each.quantity, each.of) == (quantity, of))


def row(law: str, times: str, of: Margins, found: tuple[float, float, float, float]) -> tuple[str, ...]:
    y, x, lost, noise = found
    return (law, times, f"{1e3 * of['y'][0]:.1f}, {1e3 * of['x'][0]:.1f}", f"{of['y'][1]:.0f}°", f"{1e6 * y:.0f}",
            f"{1e6 * x:.0f}", f"{1e6 * lost:.0f}", f"{noise:.3f}")


def main() -> None:
    """Find the gains of every law, run them, and write the table."""
    fast = margins(ADRC, {})
    wanted = {axis: delay for axis, (delay, _) in fast.items()}
    rows = [row("regulator, thesis's gains", "–", margins(LAWS["regulator"], {}), measured(LAWS["regulator"], {}))]
    common = factors(lambda y, x: margins(LAWS["regulator"], gains(y, x)), wanted)
    for law, controller in LAWS.items():
        found = common
        if law == "L1":   # whose compensation takes from the margin
            found = factors(lambda y, x: margins(LAWS["L1"], gains(y, x)), wanted)
        parameters = gains(*found)
        rows.append(row(law, ", ".join(f"{factor:.2f}" for factor in found), margins(controller, parameters),
                        measured(controller, parameters)))
        print(*rows[-1], sep=" | ", flush=True)
    rows.append(row("ADRC", "–", fast, measured(ADRC, {})))
    write_part(DOCS, "margins", markdown_table(HEADS, rows))


if __name__ == "__main__":
    main()
