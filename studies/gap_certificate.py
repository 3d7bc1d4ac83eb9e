"""Certify the vertical loop of the interpolated regulator over a range of air gaps that move at a bounded rate.

    python -m studies.gap_certificate [--rate 0.05] [--decay 0.05]
    python -m studies.gap_certificate --starts          # steps from rest that the committed certificate covers
    python -m studies.gap_certificate --groups 400      # of random runs, in search of one that is lost

Let e = g − r, i°(g) the plant's equilibrium current, i*(g) and β(g) those of the table. The current deviates by
b = β (i − i°) and the integral I by w = β (I + i* − i°). The loop is exactly

    v' = μ b − c v              b' = (k1 e + k2 v̂ + k4 ξ2 + k5 ξ3 + w − b)/τ + (σ − β i*') v + (β'/β) v b
    e' = v                      w' = (k3 + 1) ξ2 + σ v + (β'/β) v w              ξ2' = ξ3    ξ3' = e − ω0² ξ2
    l' = (e − l)/T1             v̂' = ((e − l)/T1 − v̂)/T2

with μ = γ/β, where g'' = γ (i − i°) by the secant of the plant's row, and σ = β (i*' − i°'). In a cell of the table
i*' and β' are constants. Intervals bound μ, σ and the rest for any gap in the cell and any current within the limit.
V = xᵀ P(g) x, with P linear between the gaps of the table, decreases on the whole table if it decreases at the corners:
the inequality is linear in each corner. Clarabel finds P; `verify` believes none of it and works in rationals.
"""

import argparse
import json
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import suppress
from fractions import Fraction
from functools import partial
from itertools import pairwise, product
from math import atan, inf, nextafter, pi
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from mpmath import iv
from numpy.typing import NDArray
from scipy.linalg import solve_continuous_lyapunov

import maglev
from controller_fmu.places import axis_number
from controller_fmu.regulator import Regulator
from controller_fmu.status import INTERPOLATED
from maglev.analysis.certificate import TOLERANCES, solver
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.whole_file import write_whole
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.stage_description import StageAxis, StageDescription
from pmlsm.velocity_rows import GRAVITY

DESCRIPTION = PACKAGED_STAGES["3dof"]

LOWER, UPPER = 18.5e-3, 30.0e-3   # m: the stop, and the last gap at which 4 A hold the mover
LAG = 0.4e-3                      # s: of the amplifiers, and half a sample for the hold
CLOSE = 1e-14                     # of an arctangent, how nearly a float is
PARTS = 20                        # of a cell, whose intervals are joined
ROOM = Fraction(9, 10)            # share of the solver's decay that is verified
STATES = ("e", "v", "b", "l", "v̂", "w", "ξ2", "ξ3")
WEIGHTS = (1e6, 1e3, 1.0, 1e6, 1e3, 1.0, 1e4, 1e3)   # of their squares, for the solver
RUNS, GROUP = Path(__file__).with_suffix(".toml"), 2500   # runs of a group
EVEN = (1.0, 1.0, 0.2, 0.1, 0.1, 1.0, 1.0, 1.0)      # fast ones like slow ones, for the solver
Box = dict[str, tuple[float, float]]
Rationals = NDArray[np.object_]   # of Fraction
rational = np.vectorize(Fraction, otypes=[object])


class Loop(NamedTuple):
    """A certified loop: file, regulator, matrix, and its bounds in a cell with their subject."""

    file: Path
    regulator: Callable[[int], Any]
    matrix: Callable[..., list[list[Any]]]   # of the regulator, the bounded values, in their order, and the gap's rate
    bounds: Callable[[Any, int, float, float], Box]
    middle: tuple[float, ...]


def set_up(loop: Loop) -> Any:
    """The regulator, started."""
    regulator = loop.regulator(INTERPOLATED)
    if regulator.start():
        raise ArithmeticError("the table of the interpolated regulator: expected equilibria at all of its gaps")
    return regulator


def shapes(motor: MotorGeometry, g: Any) -> tuple[Any, ...]:
    """Shape functions f2, f3, f4 (2.2), (2.4) and their slopes on an interval of gaps."""
    reach = g + motor.slot_height
    slot, slot_slope = 1 - motor.slot_loss / reach, motor.slot_loss / (reach * reach)
    ratio = motor.slot_width / (2 * g)
    angle = iv.mpf([atan(float(ratio.a)) * (1.0 - CLOSE), atan(float(ratio.b)) * (1.0 + CLOSE)])
    log = iv.log(1 + ratio * ratio)
    carter = 1 - g * 4 / iv.pi * (ratio * angle - log / 2) / motor.slot_pitch   # 1/Kc
    carter_slope = 2 / iv.pi * log / motor.slot_pitch
    s = (g - motor.field.centre) / motor.field.scale
    field, field_slope = iv.mpf(0), iv.mpf(0)
    for k in range(12, -1, -1):
        field = field * s + getattr(motor.field, f"B{k}")
    for k in range(12, 0, -1):
        field_slope = field_slope * s + k * iv.mpf(getattr(motor.field, f"B{k}"))
    field_slope /= motor.field.scale
    grown = iv.exp(2 * motor.wave_number * (motor.magnet_height + g))
    coth, coth_slope = 1 + 2 / (grown - 1), -4 * motor.wave_number * grown / ((grown - 1) * (grown - 1))
    u, u_slope = coth * carter, coth_slope * carter + coth * carter_slope
    return (slot * field * field, slot * field * u, slot * u * u,
            slot_slope * field * field + 2 * slot * field * field_slope,
            slot_slope * field * u + slot * field_slope * u + slot * field * u_slope,
            slot_slope * u * u + 2 * slot * u * u_slope)


class Part(NamedTuple):
    """Intervals of a part of a cell: gain β of the table, the attraction, f3, f4, slopes of f2 to f4, and i°."""

    gain: Any
    attraction: Any
    f3: Any
    f4: Any
    slopes: Sequence[Any]
    root: Any    # that of the equation of i°
    rest: Any


COILS, IRON = 4 * iv.mpf(DESCRIPTION.plant.coils), 4 * iv.mpf(DESCRIPTION.plant.iron)


def slopes(regulator: Any, cell: int) -> tuple[Any, Any]:
    """Slopes i*' and β' of the table in a cell."""
    low, high = regulator.currents.gains.points[cell:cell + 2]
    spacing = iv.mpf(regulator.currents.gains.spacing)
    return (high.current - iv.mpf(low.current)) / spacing, (high.gain - iv.mpf(low.gain)) / spacing


def gap_parts(regulator: Any, cell: int, lower: float, upper: float) -> Iterator[Part]:
    """Parts between two gaps (m) in a cell of the table.

    The plant's bias counts, its ripple as any force that it can be, the modulation of the attraction as any of its
    values.
    """
    low, _, gain_slope = regulator.currents.gains.points[cell], *slopes(regulator, cell)
    start = regulator.currents.gains.lower + cell * iv.mpf(regulator.currents.gains.spacing)
    ripple = DESCRIPTION.vertical.ripple
    force = iv.mpf([-ripple.amplitude, ripple.amplitude]) + DESCRIPTION.vertical.bias + GRAVITY
    attraction = 4 * DESCRIPTION.plant.attraction * iv.mpf([1 - DESCRIPTION.modulation, 1])
    for part in range(PARTS):
        g = lower + (iv.mpf([part, part + 1]) / PARTS) * (iv.mpf(upper) - lower)
        f2, f3, f4, *changes = shapes(regulator.model.layout.kinds[0].geometry, g)
        # The smaller root of iron f4 i² − coils f3 i + attraction f2 − force = 0.
        constant = attraction * f2 - force
        root = iv.sqrt((COILS * f3) ** 2 - 4 * IRON * f4 * constant)
        yield Part(low.gain + gain_slope * (g - start), attraction, f3, f4, changes, root,
                   2 * constant / (COILS * f3 + root))


def gap_bounds(regulator: Any, cell: int, lower: float, upper: float) -> Box:
    """Bounds of μ, −β i*', σ and β'/β between two gaps (m) in a cell; the ripple's stiffness is any that it can be."""
    slope, gain_slope = slopes(regulator, cell)
    ripple, limit = DESCRIPTION.vertical.ripple, regulator.current_limit
    waves = ripple.amplitude * 2 * pi / ripple.period
    intervals: dict[str, list[Any]] = {"mu": [], "alpha": [], "sigma": [], "growth": []}
    for gain, attraction, f3, f4, (slope2, slope3, slope4), root, rest in gap_parts(regulator, cell, lower, upper):
        stiffness = COILS * slope3 * rest - IRON * slope4 * rest**2 - attraction * slope2 + iv.mpf([-waves, waves])
        intervals["mu"].append((COILS * f3 - IRON * f4 * (iv.mpf([-limit, limit]) + rest)) / gain)
        intervals["alpha"].append(-gain * slope)
        intervals["sigma"].append(gain * (slope + stiffness / root))
        intervals["growth"].append(gain_slope / gain)
    return hulls(intervals)


def hulls(intervals: Mapping[str, Sequence[Any]]) -> Box:
    """The least box, by name, that holds intervals."""
    return {name: (min(nextafter(float(interval.a), -inf) for interval in values),
                   max(nextafter(float(interval.b), inf) for interval in values)) for name, values in intervals.items()}


def cells(loop: Loop, regulator: Any) -> list[tuple[float, float, Box]]:
    """Cells of the table in the range: both gaps (m), and the bounds between them."""
    gaps = [regulator.currents.gains.lower + k * regulator.currents.gains.spacing for k in range(15)]
    pieces = []
    for k, (lower, upper) in enumerate(pairwise(gaps)):
        lower, upper = max(lower, LOWER), min(upper, UPPER)
        if upper - lower > 1e-9:
            pieces.append((lower, upper, loop.bounds(regulator, k, lower, upper)))
    return pieces


def vertical(regulator: Any, mu: Any, alpha: Any, sigma: Any, growth: Any, rate: Any) -> list[list[Any]]:
    """Matrix of the loop, see `matrix_of`."""
    return matrix_of(regulator, DESCRIPTION, DESCRIPTION.vertical, mu, 0, 0, alpha + sigma, sigma, growth * rate)


def matrix_of(regulator: Any, stage: StageDescription, axis: StageAxis, mu: Any, nu: Any, eta: Any, crossing: Any,
              sigma: Any,
              moved: Any) -> list[list[Any]]:
    """Matrix of the loop of an axis, of numbers of the kind of μ: floats or fractions; `crossing` leads from v to b."""
    number, law = type(mu), regulator.axes[axis_number(stage, axis.name)]
    k1, k2, k3, k4, k5 = (number(getattr(law, f"k{k}")) for k in range(1, 6))
    lag, time1, time2 = number(LAG), number(regulator.observer.time1), number(regulator.observer.time2)
    zero, one, drag = number(0), number(1), number(axis.friction.viscous) / number(axis.mass)
    square = number(regulator.omega0) ** 2
    return [[zero, one, zero, zero, zero, zero, zero, zero],
            [nu, -drag, mu, zero, zero, zero, zero, zero],
            [(k1 + eta) / lag, crossing, moved - one / lag, zero, k2 / lag, one / lag, k4 / lag, k5 / lag],
            [one / time1, zero, zero, -one / time1, zero, zero, zero, zero],
            [one / time1 / time2, zero, zero, -one / time1 / time2, -one / time2, zero, zero, zero],
            [zero, sigma, zero, zero, zero, moved, k3 + one, zero],
            [zero, zero, zero, zero, zero, zero, zero, one],
            [one, zero, zero, zero, zero, zero, -square, zero]]


def corners(box: Mapping[str, tuple[float, float]], rate: float) -> Iterator[tuple[float, ...]]:
    """Corners of the range of the loop: its parameters, then the rate of the gap (m/s)."""
    return product(*box.values(), (-rate, rate))


def find(loop: Loop, rate: float, decay: float) -> dict[str, Any]:
    """Certificate for a rate of the gap (m/s), V decreasing as exp(−2 decay t); its P are of x in units of `scale`."""
    cvxpy, regulator = solver(), set_up(loop)
    parts = cells(loop, regulator)
    middle = np.array(loop.matrix(regulator, *loop.middle, 0.0))
    # Each state in the unit in which a first V, of one gap alone, is about 1.
    first = solve_continuous_lyapunov((middle + decay * np.eye(len(middle))).T, -np.diag(WEIGHTS))
    scale = 2.0 ** np.round(-0.5 * np.log2(np.diag(first)))
    size = len(STATES)
    P = [cvxpy.Variable((size, size), symmetric=True) for _ in range(len(parts) + 1)]
    largest = cvxpy.Variable()
    even = np.diag(EVEN)
    constraints = [matrix >> np.eye(size) for matrix in P] + [matrix << largest * np.eye(size) for matrix in P]
    for k, (lower, upper, box) in enumerate(parts):
        for end, corner in product((0, 1), corners(box, rate)):
            a = np.array(loop.matrix(regulator, *map(float, corner))) * scale[None, :] / scale[:, None]
            change = (a.T @ P[k + end] + P[k + end] @ a + 2.0 * decay * P[k + end]
                      + corner[-1] / (upper - lower) * (P[k + 1] - P[k]))
            constraints.append(even @ change @ even << 0)
    problem = cvxpy.Problem(cvxpy.Minimize(largest), constraints)
    for tolerance in TOLERANCES:
        with suppress(cvxpy.SolverError), warnings.catch_warnings():
            warnings.simplefilter("ignore")   # that it may be inaccurate: its results are verified
            problem.solve(solver=cvxpy.CLARABEL, tol_gap_abs=tolerance, tol_gap_rel=tolerance, tol_feas=tolerance,
                          accept_unknown=True)
            if P[0].value is not None:
                break
    else:
        raise SystemExit(f"rate {rate:g} m/s, decay {decay:g} 1/s: Clarabel found nothing")
    return {"rate": rate, "decay": float(ROOM) * decay, "scale": scale.tolist(),
            "P": [matrix.value.tolist() for matrix in P]}


def verify(loop: Loop, certificate: Mapping[str, Any]) -> bool:
    """Return True if V is positive and decreases at every corner of every cell, in rational arithmetic."""
    regulator, decay = set_up(loop), Fraction(certificate["decay"])
    scale = rational(certificate["scale"])
    P = [rational(matrix) / np.outer(scale, scale) for matrix in certificate["P"]]
    parts = cells(loop, regulator)
    if len(P) != len(parts) + 1 or any((matrix != matrix.T).any() for matrix in P) or not all(map(positive, P)):
        return False
    for k, (lower, upper, box) in enumerate(parts):
        for end, corner in product((0, 1), corners(box, certificate["rate"])):
            half = P[k + end] @ rational(loop.matrix(regulator, *map(Fraction, corner))) + decay * P[k + end]
            per_gap = Fraction(corner[-1]) / (Fraction(upper) - Fraction(lower))
            if not positive(-(half + half.T + per_gap * (P[k + 1] - P[k]))):
                return False
    return True


def covered_steps(certificate: Mapping[str, Any]) -> tuple[list[float], float]:
    """Largest steps from rest (m) in which V keeps the rate of the gap below the certified one, and how far e goes.

    There is one for each gap of the table at which a step can begin. At rest all states but e and l are 0, so a step s
    starts at V = s² uᵀP u. While V decreases, |v| ≤ √(V (P⁻¹)vv), with the largest (P⁻¹)vv of all gaps; likewise e.
    Between two gaps V is linear and (P⁻¹)vv convex, so the ends decide. No bound on the commands follows from V.
    """
    scale = np.array(certificate["scale"])
    P = np.array(certificate["P"]) / np.outer(scale, scale)
    moved = np.array([name in ("e", "l") for name in STATES], dtype=float)
    most_e, most_v = np.linalg.inv(P).diagonal(axis1=1, axis2=2).max(axis=0)[:2]
    return (certificate["rate"] / np.sqrt(most_v * (moved @ P @ moved))).tolist(), certificate["rate"] * float(
        np.sqrt(most_e / most_v))


def positive(matrix: Rationals) -> bool:
    """Return True if a symmetric matrix is positive definite: all pivots of its elimination are positive."""
    rows = matrix.copy()
    for k in range(len(rows)):
        if rows[k, k] <= 0:
            return False
        rows[k + 1:] -= np.outer(rows[k + 1:, k] / rows[k, k], rows[k])
    return True


def run_group(number: int) -> tuple[float, Any]:
    """Random runs of the FMUs with a step of up to 3 mm at a place of x: its end (m), and their batch.

    Each starts within 1 mm of the gap before the step, with other friction, ripple and modulation.
    """
    random = np.random.default_rng(10_000 + number)
    before = float(random.uniform(19.2e-3, 29.2e-3))
    after = float(np.clip(before + random.uniform(-3e-3, 3e-3), 19.2e-3, 29.2e-3))
    common = {"reference.y.start": before, "reference.y.end": after}
    common |= dict.fromkeys(("plant.x.position_start", "reference.x.start", "reference.x.end"),
                            float(random.uniform(-55e-3, 55e-3)))
    values = {"plant.y.position_start": np.clip(before + random.uniform(-1e-3, 1e-3, GROUP), 18.7e-3, 29.8e-3),
              "plant.y.ripple.amplitude": random.uniform(0.0, 0.15, GROUP),
              "plant.y.friction.coulomb": random.uniform(0.0, 2.0, GROUP),
              "plant.attraction_modulation": random.uniform(0.0, DESCRIPTION.modulation, GROUP)}
    return after, maglev.batch(RUNS, values, set=common, kind="native", metrics=["stop contact time", "end error"])


VERTICAL = Loop(Path(__file__).with_suffix(".json"), partial(Regulator, DESCRIPTION), vertical, gap_bounds,
                (1.0, 1300.0, 0.0, -70.0))


def certify_loop(loop: Loop, group: Callable[[int], tuple[float, Any]], units: Mapping[str, str], words: str) -> None:
    """Find a certificate of a loop, verify it, and write it; or run groups, and print how they end, by axis."""
    parser = argparse.ArgumentParser(description=words)
    parser.add_argument("--rate", type=float, default=0.05, help="of the gap, m/s")
    parser.add_argument("--decay", type=float, default=0.05, help="1/s")
    if loop is VERTICAL:
        parser.add_argument("--starts", action="store_true", help="print the steps that are covered")
    parser.add_argument("--groups", type=int, help=f"of {GROUP} random runs, which are made instead")
    given = parser.parse_args()
    if getattr(given, "starts", False):
        steps, furthest = covered_steps(json.loads(loop.file.read_text(encoding="utf-8")))
        print(f"steps from rest of {1e3 * min(steps):.2f} to {1e3 * max(steps):.2f} mm, by the gap they begin at; no "
              f"error exceeds {1e3 * furthest:.2f} mm")
        return
    if given.groups:
        largest = dict.fromkeys(units, 0.0)
        for number in range(given.groups):
            after, runs = group(number)
            touched = np.isfinite(runs["stop contact time"])
            if touched.any():
                print(f"group {number}: {touched.sum()} of {GROUP} touch a stop on their way to {1e3 * after:.1f} mm")
            for axis, before in largest.items():
                largest[axis] = max(before, np.max(runs[f"end error of {axis}"], where=~touched, initial=0.0))
        print(f"{given.groups * GROUP:,} runs: largest error of those that touch no stop",
              ", ".join(f"{axis} {1e6 * largest[axis]:.0f} {unit}" for axis, unit in units.items()))
        return
    certificate = find(loop, given.rate, given.decay)
    if not verify(loop, certificate):
        raise SystemExit(f"rate {given.rate:g} m/s, decay {given.decay:g} 1/s: not certified")
    write_whole(loop.file, json.dumps(certificate) + "\n")
    print(f"certified at {certificate['rate']:g} m/s, decay {certificate['decay']:g} 1/s: {loop.file.name}")


if __name__ == "__main__":
    certify_loop(VERTICAL, run_group, {"y": "µm"}, __doc__.splitlines()[0])
