"""A normal variate of a random word.

Wichura's PPND7 (algorithm AS 241, Applied Statistics 37, 1988, doi 10.2307/2347330), the quantile to 1e-7.
"""

from math import sqrt

from pmlsm.logarithm import logarithm
from pmlsm.random_words import SHARE

CENTRE = 0.425   # from the middle, where the first rational function ends; no word comes to where the second does
CENTRE_SQUARED = 0.180625
NEAR_CENTRE = 1.6


def normal_variate(word: int) -> float:
    """Value of a standard normal distribution for a word of 32 bits, at most 6.4 without its sign."""
    share = (word + 0.5) * SHARE
    q = share - 0.5
    if -CENTRE <= q <= CENTRE:
        r = CENTRE_SQUARED - q * q
        return q * (((59.109374720 * r + 159.29113202) * r + 50.434271938) * r + 3.3871327179) / (
            ((67.187563600 * r + 78.757757664) * r + 17.895169469) * r + 1.0)
    r = sqrt(-logarithm(share if q < 0.0 else 1.0 - share)) - NEAR_CENTRE
    value = (((0.17023821103 * r + 1.3067284816) * r + 2.7568153900) * r + 1.4234372777) / (
        (0.12021132975 * r + 0.73700164250) * r + 1.0)
    return -value if q < 0.0 else value
