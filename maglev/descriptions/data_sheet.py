"""Constants of the velocity rows, and field of the magnets, from the numbers that motor makers print."""

from dataclasses import dataclass, field
from math import pi, sin, sinh, sqrt, tanh
from typing import Any
from warnings import catch_warnings, simplefilter

import numpy as np

from maglev.files.errors import StageError
from pmlsm.gap_functions import gap_functions
from pmlsm.motor_geometry import MotorGeometry
from pmlsm.stage_description import Constants, StageDescription, quantity

MAGNETIC_CONSTANT = 4e-7 * pi   # µ0, V s/(A m)
DEGREE = 12                     # of the polynomial of `MagnetField`
LARGEST_MISFIT = 0.01           # of the polynomial, relative to the field there


def twelve_digits(value: float) -> float:
    """A number to twelve digits: libraries differ from one another in the last four, and stages would with them."""
    return float(f"{value:.12g}")


def optional(unit: str, low: float, high: float) -> Any:
    """Number of a data sheet that it may leave out."""
    return field(default=None, metadata={"unit": unit, "low": low, "high": high})


@dataclass(frozen=True)
class Winding:
    """Windings and magnets of a motor, for the formulas of the thesis."""

    turns: float = quantity("1", 1.0, 1e6)           # W, of a phase
    pole_pairs: float = quantity("1", 0.5, 1e3)      # p, of the stator
    magnets: float = quantity("1", 1.0, 1e3)         # pm, on the mover
    magnet_width: float = quantity("m", 1e-4, 1.0)   # τp, along the motion
    length: float = quantity("m", 1e-4, 10.0)        # LA, across it
    coercivity: float = quantity("A/m", 1e3, 1e7)    # Hc
    factor: float = quantity("1", 0.1, 1.0, 1.0)     # winding factor kw1


@dataclass(frozen=True)
class Catalogue:
    """Numbers of one motor as its maker prints them."""

    # "rms" or "peak": how its currents are meant, those per ampere included; i_d and i_q are peaks.
    currents: str
    force_constant: float | None = optional("N/A", 1e-6, 1e6)   # thrust per current
    at: float | None = optional("m", 1e-4, 0.1)                 # air gap of it; where the mover starts if not given
    attraction: float | None = optional("N", 1e-3, 1e7)         # without current
    attraction_gap: float | None = optional("m", 1e-4, 0.1)     # air gap of it
    direct_constant: float | None = optional("N/A", 1e-6, 1e6)  # normal force per direct current, at the gap `at`
    iron_attraction: float | None = optional("1", 1e-9, 1e6)    # N/A², attraction per current squared, there
    peak: float | None = optional("A", 1e-3, 700.0)             # current of its amplifiers
    continuous: float | None = optional("A", 0.0, 700.0)        # current of its amplifiers
    lag: float | None = optional("s", 0.0, 0.1)                 # of its amplifiers: 1/(2 π bandwidth)
    # Value of a phase: half of the value measured from one phase to another.
    resistance: float | None = optional("Ohm", 1e-3, 1e4)
    inductance: float | None = optional("H", 1e-6, 10.0)
    winding: Winding | None = None                              # for the formulas, where something above is missing

    @property
    def amplitude(self) -> float:
        """Peak of a current of 1 A as the maker means it, A."""
        return sqrt(2.0) if self.currents == "rms" else 1.0


@dataclass(frozen=True)
class Field:
    """Field of the magnets over the air gap: exponential, table, or coefficients of the polynomial."""

    lower: float = quantity("m", 1e-4, 0.1)          # smallest air gap at which it holds
    upper: float = quantity("m", 1e-4, 0.1)          # largest
    B0: float | None = optional("T", 1e-3, 10.0)     # of B = B0 exp(−g/decay)
    decay: float | None = optional("m", 1e-4, 1.0)
    gaps: tuple[float, ...] = quantity("m", 1e-5, 1.0, ())   # of a table
    B: tuple[float, ...] = quantity("T", 1e-9, 10.0, ())     # at these
    # Coefficients of s⁰, s¹ … with s = (g − centre)/scale; centre and scale are the middle and half of the range.
    coefficients: tuple[float, ...] = quantity("T", -1e3, 1e3, ())


def field_geometry(place: str, of: Field) -> dict[str, float]:
    """Parameters of `pmlsm.magnet_field` that a field has, by path of the geometry.

    StageError if it is not given in one way, is not positive, or no polynomial of the twelfth degree comes near it.
    """
    ways = [of.B0 is not None and of.decay is not None, bool(of.gaps and of.B), bool(of.coefficients)]
    if sum(ways) != 1 or not of.lower < of.upper:
        raise StageError(f"{place}: expected lower below upper, and one of B0 with decay, gaps with B, or coefficients")
    centre, scale = 0.5 * (of.lower + of.upper), 0.5 * (of.upper - of.lower)
    if of.coefficients:
        coefficients = list(of.coefficients)
        if len(coefficients) > DEGREE + 1:
            raise StageError(f"{place}.coefficients: {len(coefficients)} numbers, expected at most {DEGREE + 1}")
    else:
        gaps = np.linspace(of.lower, of.upper, 801)
        wanted = sampled_field(place, of, gaps)
        s = (gaps - centre) / scale
        with catch_warnings():
            simplefilter("ignore")   # how well it fits is looked at below
            fitted = np.polynomial.Polynomial.fit(s, wanted, DEGREE, domain=[-1.0, 1.0], w=1.0 / wanted)
        misfits = np.abs(fitted(s) / wanted - 1.0)
        worst = int(misfits.argmax())
        if misfits[worst] > LARGEST_MISFIT:
            raise StageError(f"{place}: a polynomial of degree {DEGREE} misses the field by {misfits[worst]:.1%} at "
                           f"{1e3 * gaps[worst]:.3g} mm, expected at most {LARGEST_MISFIT:.0%}: a smoother field or a "
                           "shorter range")
        # Rounded to 1e-10 T, far below the misfit: the last digits of a fit differ between machines.
        coefficients = [round(value, 10) for value in fitted.convert().coef.tolist()]
    coefficients += [0.0] * (DEGREE + 1 - len(coefficients))
    return {"field.lower": of.lower, "field.upper": of.upper, "field.centre": centre, "field.scale": scale,
            **{f"field.B{k}": value for k, value in enumerate(coefficients)}}


def sampled_field(place: str, of: Field, gaps: Any) -> Any:
    """Field (T) at air gaps (m): between those of a table its logarithm is interpolated."""
    if of.B0 is not None and of.decay is not None:
        return of.B0 * np.exp(-gaps / of.decay)
    known, values = np.array(of.gaps), np.array(of.B)
    if len(known) != len(values) or len(known) < 2 or (np.diff(known) <= 0.0).any() or (values <= 0.0).any():
        raise StageError(f"{place}: gaps = {list(of.gaps)} m, B = {list(of.B)} T, expected as many fields above 0 T as "
                       "ascending gaps, two or more")
    if known[0] > of.lower or known[-1] < of.upper:
        raise StageError(f"{place}: gaps from {1e3 * known[0]:g} to {1e3 * known[-1]:g} mm, expected a table from "
                       f"lower = {1e3 * of.lower:g} mm to upper = {1e3 * of.upper:g} mm")
    from scipy.interpolate import PchipInterpolator  # a third of the start of every command, needed by few stages

    return np.exp(PchipInterpolator(known, np.log(values))(gaps))


def catalogue_constants(place: str, sheet: Catalogue, stage: StageDescription) -> Constants:
    """Constants of a stage whose motors have a data sheet.

    With peaks of the currents, F = Kf i_q and N at the gaps of the data sheet. Two terms of the normal force are not in
    it, but follow from it. i_d acts on the same flux as i_q, so that it gives Kf coth a by virtual work. The fields of
    magnets and coils add before they are squared, 4 C_attraction C_iron = C_coils². On the stages of the thesis these
    two are 0.83 and 0.58 times, 2.5 and 13 times the identified values; with a winding the formulas replace them.
    StageError if a number without a substitute is missing, or a gap is outside the field's range.
    """
    if sheet.currents not in ("rms", "peak"):
        raise StageError(f"{place}.currents: {sheet.currents!r}, expected 'rms' or 'peak'")
    motor, vertical = stage.motor(), stage.vertical
    at = vertical.start if sheet.at is None else sheet.at
    attraction_at = at if sheet.attraction_gap is None else sheet.attraction_gap
    for key, gap in (("at", at), ("attraction_gap", attraction_at)):
        if not motor.field.lower <= gap <= motor.field.upper:
            raise StageError(f"{place}.{key}: {1e3 * gap:g} mm, expected a gap of {1e3 * motor.field.lower:g}…"
                           f"{1e3 * motor.field.upper:g} mm, where the field is known")
    for key in ("force_constant", "attraction"):
        if getattr(sheet, key) is None and sheet.winding is None:
            raise StageError(f"{place}.{key}: missing; give it, or [catalogue.winding] for the formulas")
    f1, _, f3, f4 = gap_functions(motor, at)
    _, f2, _, _ = gap_functions(motor, attraction_at)
    per_peak = 1.0 / sheet.amplitude
    # Forces over the shape functions, N/A, N/T², N/(A T), N/A²: of one motor.
    by_formula: tuple[float | None, ...] = (None,) * 4 if sheet.winding is None else formulas(sheet.winding, motor)
    thrust, attraction, coils, iron = by_formula
    if sheet.force_constant is not None:
        thrust = sheet.force_constant * per_peak / f1
    if sheet.attraction is not None:
        attraction = sheet.attraction / f2
    assert thrust is not None and attraction is not None   # as was just seen
    if sheet.direct_constant is not None:
        coils = sheet.direct_constant * per_peak / f3
    elif coils is None:
        coils = thrust * f1 / tanh(motor.wave_number * (motor.magnet_height + at)) / f3
    if sheet.iron_attraction is not None:
        iron = sheet.iron_attraction * per_peak**2 / f4
    elif iron is None:
        iron = coils**2 / (4.0 * attraction)
    return Constants({axis.name: twelve_digits(thrust / axis.mass) for axis in stage.horizontal},
                     *(twelve_digits(constant / vertical.mass) for constant in (attraction, coils, iron)))


def formulas(of: Winding, motor: MotorGeometry) -> tuple[float, float, float, float]:
    """Forces of one motor over its shape functions, K1/f1 … K4/f4, by (2.2) and (2.4), as in (4.1) and (5.2).

    With σm = Hc and kw1 = 1 they give 3.1 times the identified thrust on the 2-DOF stage, and 10.8 (x) and 9.9 (z)
    times on the 3-DOF stage. They give 0.66 and 0.985 of the attraction, 0.63 and 1.41 of the coils, and 14 and 230
    times the iron. Returns thrust, attraction, coils and iron: N/A, N/T², N/(A T), N/A².
    """
    tau, area = motor.pole_pitch, of.length * of.magnets
    turns = of.turns * of.factor
    thrust = (12.0 * sqrt(2.0) * turns * area * of.coercivity * MAGNETIC_CONSTANT
              * sinh(motor.wave_number * motor.magnet_height) * sin(pi * of.magnet_width / (2.0 * tau))
              / (pi * of.pole_pairs))
    return (thrust, area * tau / (4.0 * MAGNETIC_CONSTANT), 3.0 * sqrt(2.0) * area * turns / of.pole_pairs**2,
            18.0 * area * turns**2 * MAGNETIC_CONSTANT / (tau * of.pole_pairs**2))
