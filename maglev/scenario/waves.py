"""Sines and cosines of many angles at once, with the bits of those that blocks compute.

NumPy has its own on every kind of processor; its sums, products and comparisons are exact everywhere.
"""

from collections.abc import Iterable
from math import pi
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from maglev.files.arrays import Array
from pmlsm.sine_cosine import (
    CLOSE_TO_QUARTER,
    HALF_PI_HIGH,
    HALF_PI_REST,
    QUICK_QUARTERS,
    TWO_OVER_PI,
    near_zero,
    sine_cosine,
)
from pmlsm.whole_numbers import NEAREST_WHOLE


def sines_cosines(angles: NDArray[np.floating[Any]]) -> tuple[Array, Array]:
    """Return sines and cosines of angles (rad), each of the angles' shape; NaN for an angle beyond `LARGEST_REDUCED`.
    """
    quick = np.abs(angles * TWO_OVER_PI) < QUICK_QUARTERS
    seen = np.where(quick, angles, 0.0)
    quarters = (seen * TWO_OVER_PI + NEAREST_WHOLE) - NEAREST_WHOLE
    high = seen - quarters * HALF_PI_HIGH
    rest = quarters * HALF_PI_REST
    r = high - rest
    near = cast(tuple[Array, Array], near_zero(r, (high - r) - rest))   # type: ignore[arg-type]
    turned = quarters.astype(np.int64) & 3
    sines = np.choose(turned, [near[0], near[1], -near[0], -near[1]])
    cosines = np.choose(turned, [near[1], -near[0], -near[1], near[0]])
    for place in np.argwhere(~quick | (np.abs(r) < CLOSE_TO_QUARTER)):
        sines[tuple(place)], cosines[tuple(place)] = sine_cosine(float(angles[tuple(place)]))
    return sines, cosines


def period_of(samples: int, harmonics: Iterable[int], phases: Array) -> Array:
    """Return one period of a sum of cosines, shape (samples,): the periods of each harmonic, with its phase (rad)."""
    sines, cosines = sines_cosines(2.0 * pi / samples * np.arange(samples))
    wave = np.zeros(samples)
    for number, sine, cosine in zip(harmonics, *sines_cosines(phases), strict=True):
        turned = number * np.arange(samples) % samples
        wave += cosine * cosines[turned] - sine * sines[turned]
    return wave
