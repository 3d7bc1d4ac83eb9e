"""e^x within 0.8 ULP and e^x − 1 within 0.9, at every number; infinite on overflow, 0 on underflow.

x = k ln 2 + r in two parts of ln 2 (W. J. Cody and W. Waite, *Software Manual for the Elementary Functions*, 1980). The
even function r (e^r + 1)/(e^r − 1) is 2 + r² P(r²), with a minimax polynomial P on ±0.415. With c = r − r² P, solved
for e^r, this is 1 + r + r²/2 (1 + (c − 2 r P)/(2 − c)).
"""

from math import inf

from pmlsm.logarithm import LN2_HIGH, LN2_REST
from pmlsm.whole_numbers import NEAREST_WHOLE

ONE_OVER_LN2 = 1.4426950408889634
LARGEST_EXPONENT = 709.782712893384             # its exponential is the largest number
SMALLEST_EXPONENT = -745.1332191019412          # beyond, it is 0
DIRECT_EXPONENT = 0.41                          # for which e^x − 1 is taken without a power of two
LOWEST_BESIDE_ONE = -37.5                      # beyond, the exponential is lost next to 1
HIGHEST_BESIDE_ONE = 36.7                       # beyond, the 1 is small next to it, and a power less 1 inexact
TINY_EXPONENT = 1.1102230246251565e-16          # 2^-53
LARGEST_SHIFT = 62                             # whose power `power_of_two` gives
TWO_31 = 2147483648.0
TWO_62 = 4611686018427387904.0
TWO_MINUS_62 = 2.168404344971009e-19


def exponential(x: float) -> float:
    """e^x."""
    if x > LARGEST_EXPONENT:
        return inf
    if not x > SMALLEST_EXPONENT:
        return 0.0 if x <= SMALLEST_EXPONENT else x   # NaN stays NaN
    k = (x * ONE_OVER_LN2 + NEAREST_WHOLE) - NEAREST_WHOLE
    high = x - k * LN2_HIGH
    rest = k * LN2_REST
    first = 1.0 + high
    return scaled(first + ((1.0 - first + high) + (bend(high - rest) - rest)), int(k))


def exponential_minus_one(x: float) -> float:
    """e^x − 1, also where e^x is close to 1."""
    if -DIRECT_EXPONENT < x < DIRECT_EXPONENT:
        return x if -TINY_EXPONENT < x < TINY_EXPONENT else x + bend(x)
    if not LOWEST_BESIDE_ONE < x < HIGHEST_BESIDE_ONE:
        return beyond_one(x)
    k = (x * ONE_OVER_LN2 + NEAREST_WHOLE) - NEAREST_WHOLE
    high = x - k * LN2_HIGH
    rest = k * LN2_REST
    shift = int(k)
    power = float(1 << shift) if 0 <= shift < 31 else power_of_two(shift)   # Python pays for a call
    whole = power - 1.0
    first = power * high
    total = whole + first
    return total + ((whole - total + first) + power * (bend(high - rest) - rest))


def beyond_one(x: float) -> float:
    """e^x − 1 where one of both is small next to the other."""
    if x >= HIGHEST_BESIDE_ONE:
        if x > LARGEST_EXPONENT - 1.0:
            return exponential(x)
        k = (x * ONE_OVER_LN2 + NEAREST_WHOLE) - NEAREST_WHOLE
        high = x - k * LN2_HIGH
        rest = k * LN2_REST
        one = power_of_two(-int(k)) if k < 62.0 else 0.0
        return scaled(1.0 + (high + (bend(high - rest) - rest - one)), int(k))
    return -1.0 if x <= LOWEST_BESIDE_ONE else x   # NaN stays NaN


def bend(r: float) -> float:
    """e^r − 1 − r for |r| up to 0.415."""
    t = r * r
    p = 0.16666666666666297 + t * (-0.00277777777746665 + t * (6.613755770674039e-05 + t * (
        -1.6533398760145752e-06 + t * 4.122347401319642e-08)))
    c = r - t * p
    half = 0.5 * t
    return half + half * ((c - 2.0 * r * p) / (2.0 - c))


def power_of_two(k: int) -> float:
    """2^k for |k| up to 62, exactly; a shift of 1 stays within 32 bits."""
    size = k if k >= 0 else -k
    beyond = size - 31
    power = float(1 << size) if beyond < 0 else TWO_31 * float(1 << beyond)
    return power if k >= 0 else 1.0 / power


def scaled(x: float, k: int) -> float:
    """x 2^k for x between 1/2 and 2: exact, except for numbers below the normal ones, which are rounded once."""
    while k > LARGEST_SHIFT:
        x *= TWO_62
        k -= LARGEST_SHIFT
    left = k
    while left < -LARGEST_SHIFT:
        left += LARGEST_SHIFT
    x *= power_of_two(left)
    while k < -LARGEST_SHIFT:
        x *= TWO_MINUS_62
        k += LARGEST_SHIFT
    return x
