"""Certify roll and pitch of the 5-DOF stage under the interpolated regulator, to first order in the tilts.

    python -m studies.tilt_certificate [--rate 0.05] [--decay 0.05]
    python -m studies.tilt_certificate --groups 40      # of random runs, in search of one that is lost

Without tilt all four motors are at the gap g with one current i, and y is the loop of the 3-DOF stage, which
`gap_certificate` certifies. A small tilt φ changes the gap at two opposite motors by ∓l φ, their currents by ∓δi. R(g,
i) is the plant's row of y, κ = l My/(2 I), b = κ β δi. w is the integral's part of a tilt's demand, and n the demand of
y. To first order, whatever y does, the loop of a tilt is

    φ' = v                      b' = ((k1 + η) φ + k2 v̂ + k4 ξ2 + k5 ξ3 + w − b)/τ + (β'/β) g' b
    v' = μ b + ν φ − c v        w' = (k3 + 1) ξ2 + (β'/β) g' w               ξ2' = ξ3    ξ3' = φ − ω0² ξ2
    l' = (φ − l)/T1             v̂' = ((φ − l)/T1 − v̂)/T2

where μ = R_i/β, ν = κ l R_g and η = κ l (β i*' − n β'/β). They depend on i and n: both are taken to be what currents
within ABOUT of those that hold the gap can make them. The rest is as in `gap_certificate`.
"""

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from mpmath import iv

import maglev
from controller_fmu.regulator import Regulator
from maglev.descriptions.packaged import PACKAGED_STAGES
from studies.gap_certificate import COILS, GROUP, IRON, Box, Loop, certify_loop, gap_parts, hulls, matrix_of, slopes

DESCRIPTION = PACKAGED_STAGES["5dof"]
ABOUT = 0.8   # A
RUNS = Path(__file__).with_suffix(".toml")
ROLL = next(axis for axis in DESCRIPTION.axes if axis.name == "roll")   # pitch has the same constants
MASS = next(axis.mass for axis in DESCRIPTION.axes if axis.name == "y")
LEVER = max(motor.z for motor in DESCRIPTION.motors)                    # m
SHARE = LEVER**2 * MASS / (2.0 * ROLL.mass)                     # κ l


def bounds(regulator: Any, cell: int, lower: float, upper: float) -> Box:
    """Bounds of μ, ν, η and β'/β between two gaps (m) in a cell of the table."""
    slope, gain_slope = slopes(regulator, cell)
    about = iv.mpf([-ABOUT, ABOUT])
    intervals: dict[str, list[Any]] = {"mu": [], "nu": [], "eta": [], "growth": []}
    for gain, attraction, f3, f4, (slope2, slope3, slope4), _, rest in gap_parts(regulator, cell, lower, upper):
        current = rest + about
        intervals["mu"].append((COILS * f3 - 2 * IRON * f4 * current) / gain)
        intervals["nu"].append(SHARE * (COILS * slope3 * current - IRON * slope4 * current**2 - attraction * slope2))
        intervals["eta"].append(SHARE * (gain * slope - gain_slope * about))
        intervals["growth"].append(gain_slope / gain)
    return hulls(intervals)


def tilting(regulator: Any, mu: Any, nu: Any, eta: Any, growth: Any, rate: Any) -> list[list[Any]]:
    """Matrix of the loop of a tilt, see `matrix_of`."""
    return matrix_of(regulator, DESCRIPTION, ROLL, mu, nu, eta, 0, 0, growth * rate)


TILT = Loop(Path(__file__).with_suffix(".json"), partial(Regulator, DESCRIPTION), tilting, bounds,
            (1.0, 900.0, -900.0, -70.0))


def run_group(number: int) -> tuple[float, Any]:
    """Random runs of the FMUs with a step of up to 3 mm, each from tilts of up to 4 mrad: its end (m), and their batch.

    Each starts within 1 mm of the gap before the step, with other ripple, modulation and friction of y.
    """
    random = np.random.default_rng(20_000 + number)
    before = float(random.uniform(20.5e-3, 28.0e-3))
    after = float(np.clip(before + random.uniform(-3e-3, 3e-3), 20.5e-3, 28.0e-3))
    values = {"plant.y.position_start": before + random.uniform(-1e-3, 1e-3, GROUP),
              "plant.roll.position_start": random.uniform(-4e-3, 4e-3, GROUP),
              "plant.pitch.position_start": random.uniform(-4e-3, 4e-3, GROUP),
              "plant.y.ripple.amplitude": random.uniform(0.0, 0.15, GROUP),
              "plant.y.friction.coulomb": random.uniform(0.0, 2.0, GROUP),
              "plant.attraction_modulation": random.uniform(0.0, DESCRIPTION.modulation, GROUP)}
    return after, maglev.batch(RUNS, values, set={"reference.y.start": before, "reference.y.end": after}, kind="native",
                               metrics=["stop contact time", "end error"])


if __name__ == "__main__":
    certify_loop(TILT, run_group, {"y": "µm", "roll": "µrad", "pitch": "µrad"}, __doc__.splitlines()[0])
