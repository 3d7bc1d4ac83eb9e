"""Natural logarithm within 0.9 ULP, of every number: −∞ at 0, NaN below 0.

x = 2^k (1 + f) with 1 + f between √½ and √2, then ln(1 + f) = 2 artanh s with s = f/(2 + f): f − (f²/2 − s (f²/2 + R)),
with a minimax polynomial R of s² (W. J. Cody and W. Waite, *Software Manual for the Elementary Functions*, 1980).
"""

from math import inf, nan

LN2_HIGH = 0.6931471804855391        # ln 2 in 32 bits
LN2_REST = 7.440617110012397e-11     # and the rest of it
SQRT2 = 1.4142135623730951
SQRT_HALF = 0.7071067811865476
TWO_32 = 4294967296.0
TWO_MINUS_32 = 2.3283064365386963e-10
TINY_SHARE = 1.1102230246251565e-16        # 2^-53


def logarithm(x: float) -> float:
    """ln x."""
    if not 0.0 < x < inf:
        if x == 0.0:
            return -inf
        return nan if x < 0.0 else x   # ∞ and NaN do not change
    m, k = reduced_to_one(x)
    return combined(m - 1.0, 0.0, k)


def logarithm_one_plus(x: float) -> float:
    """ln(1 + x), also where x is close to 0."""
    if SQRT_HALF - 1.0 < x < SQRT2 - 1.0:
        if -TINY_SHARE < x < TINY_SHARE:
            return x
        return combined(x, 0.0, 0.0)
    if not -1.0 < x < inf:
        if x == -1.0:
            return -inf
        return nan if x < -1.0 else x
    total = 1.0 + x
    lost = x - (total - 1.0) if x < 1.0 else 1.0 - (total - x)
    m, k = reduced_to_one(total)
    return combined(m - 1.0, lost / total, k)


def combined(f: float, rest: float, k: float) -> float:
    """k ln 2 + ln(1 + f) + rest, for 1 + f between √½ and √2."""
    s = f / (2.0 + f)
    z = s * s
    series = z * (0.666666666666667 + z * (0.3999999999989606 + z * (0.2857142862747574 + z * (
        0.2222221089785555 + z * (0.18182905919712283 + z * (0.15331176242406247 + z * 0.14623056200055742))))))
    half = 0.5 * f * f
    return k * LN2_HIGH - ((half - (s * (half + series) + (k * LN2_REST + rest))) - f)


def reduced_to_one(x: float) -> tuple[float, float]:
    """A number between √½ and √2, and how often to double it to have x."""
    k = 0.0
    while x >= TWO_32:
        x *= TWO_MINUS_32
        k += 32.0
    while x < TWO_MINUS_32:
        x *= TWO_32
        k -= 32.0
    while x > SQRT2:
        x *= 0.5
        k += 1.0
    while x < SQRT_HALF:
        x *= 2.0
        k -= 1.0
    return x, k
