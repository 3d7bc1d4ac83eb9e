"""Sine and cosine within 0.8 ULP for angles up to 8.4e8 rad, NaN beyond; sine of turns, of any number, within 2 ULP.

Reduction by multiples of π/2 in parts (W. J. Cody and W. Waite, *Software Manual for the Elementary Functions*, 1980),
then minimax polynomials on ±π/4, of turns on ±π/2. Two parts of π/2 are enough for angles of 1024 quarter turns that
are not close to a multiple. The others need seven, whose products with a whole number of 29 bits are exact.
"""

from math import nan

from pmlsm.whole_numbers import NEAREST_WHOLE, fraction

LARGEST_REDUCED = 8.4e8                 # rad
TWO_PI = 6.283185307179586
MOST_TURNS = 2251799813685248.0      # 2^51, to which the quick way to the nearest whole number goes
TWO_OVER_PI = 0.6366197723675814
HALF_PI_HIGH = 1.5707963267341256             # π/2 in 33 bits
HALF_PI_REST = 6.077100506506192e-11         # and the rest of it
QUICK_QUARTERS = 1024.0                        # quarter turns for which these two do
CLOSE_TO_QUARTER = 9.5367431640625e-07           # 2^-20 rad
TINY_ANGLE = 7.450580596923828e-09          # 2^-27 rad: a sine is its angle, a cosine is 1

# π/2 in parts of 24 bits.
HALF_PI_PART1 = 1.570796251296997
HALF_PI_PART2 = 7.549789415861596e-08
HALF_PI_PART3 = 5.390302529957765e-15
HALF_PI_PART4 = 3.282003415807913e-22
HALF_PI_PART5 = 1.270655753080676e-29
HALF_PI_PART6 = 1.2293330898111133e-36
HALF_PI_PART7 = 2.7337005381646456e-44


def sine_cosine(angle: float) -> tuple[float, float]:
    """Sine and cosine of one angle (rad)."""
    quarters = angle * TWO_OVER_PI
    r = 0.0
    low = 0.0
    if -QUICK_QUARTERS < quarters < QUICK_QUARTERS:
        quarters = (quarters + NEAREST_WHOLE) - NEAREST_WHOLE
        high = angle - quarters * HALF_PI_HIGH
        rest = quarters * HALF_PI_REST
        r = high - rest
        low = (high - r) - rest
    if -CLOSE_TO_QUARTER < r < CLOSE_TO_QUARTER:
        if -TINY_ANGLE < angle < TINY_ANGLE:
            return angle, 1.0
        if not -LARGEST_REDUCED <= angle <= LARGEST_REDUCED:
            return nan, nan
        quarters, r, low = reduced(angle)
    sine, cosine = near_zero(r, low)
    turned = int(quarters) & 3
    if turned == 0:
        return sine, cosine
    if turned == 1:
        return cosine, -sine
    if turned == 2:
        return -sine, -cosine
    return -cosine, sine


def near_zero(r: float, low: float) -> tuple[float, float]:
    """Sine and cosine of an angle r + low (rad) within ±π/4, of which r is the nearest number."""
    z = r * r
    sine = r + (r * z * (-0.1666666666666663 + z * (0.008333333333321896 + z * (-0.00019841269829405222 + z * (
        2.7557313555272827e-06 + z * (-2.5050737092840422e-08 + z * 1.5895594254342187e-10)))))
        + (low - 0.5 * z * low))
    half = 0.5 * z
    near = 1.0 - half
    cosine = near + (((1.0 - near) - half) + (z * z * (0.04166666666666659 + z * (-0.001388888888887274 + z * (
        2.4801587288648806e-05 + z * (-2.755731411923503e-07 + z * (
            2.087569249018533e-09 + z * -1.135809478875488e-11))))) - r * low))
    return sine, cosine


def sine_of_turns(turns: float) -> float:
    """Return the sine of an angle in turns, sin(2π t), of any size; the remainder after whole turns is exact."""
    part = turns - ((turns + NEAREST_WHOLE) - NEAREST_WHOLE) if -MOST_TURNS < turns < MOST_TURNS else fraction(turns)
    if part > 0.25:
        part = 0.5 - part
    elif part < -0.25:
        part = -0.5 - part
    r = TWO_PI * part
    z = r * r
    return r + r * z * (-0.16666666666666666 + z * (0.008333333333333191 + z * (-0.00019841269841207763 + z * (
        2.755731921088093e-06 + z * (-2.50521068487628e-08 + z * (1.6058938470494378e-10 + z * (
            -7.64295867253171e-13 + z * 2.7208227459711254e-15)))))))


def reduced(angle: float) -> tuple[float, float, float]:
    """Return quarter turns and the remainder of an angle (rad), |angle| < LARGEST_REDUCED, in two parts (rad)."""
    quarters = (angle * TWO_OVER_PI + NEAREST_WHOLE) - NEAREST_WHOLE
    high, low = less(angle, 0.0, quarters * HALF_PI_PART1)
    high, low = less(high, low, quarters * HALF_PI_PART2)
    high, low = less(high, low, quarters * HALF_PI_PART3)
    high, low = less(high, low, quarters * HALF_PI_PART4)
    high, low = less(high, low, quarters * HALF_PI_PART5)
    high, low = less(high, low, quarters * HALF_PI_PART6)
    high, low = less(high, low, quarters * HALF_PI_PART7)
    return quarters, high, low


def less(high: float, low: float, taken: float) -> tuple[float, float]:
    """The difference of a number in two parts and another one, in two parts; exact except for the rounding of `low`."""
    difference = high - taken
    back = difference - high
    low += (high - (difference - back)) - (taken + back)
    total = difference + low
    return total, low - (total - difference)
