"""What a search looks for: numbers in ranges, and the parameters that they make."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from maglev.arrays import Array
from maglev.linear.design import gains_of
from maglev.tuning.schema import TuneFile

DIGITS = 5   # of the parameters that are flown, and written: those of the published gains, and one more


@dataclass(frozen=True)
class PlacedPoles:
    """Axes whose gains place a real pole and two pairs: five numbers, of which each axis gets k1…k5."""

    axes: tuple[str, ...]
    omega0: float   # rad/s

    @property
    def names(self) -> list[str]:
        return [f"{axis}.k{i}" for axis in self.axes for i in range(1, 6)]

    def parameters(self, numbers: Sequence[float]) -> list[float]:
        real, rate1, damping1, rate2, damping2 = numbers
        polynomial = np.polymul([1.0, real], np.polymul([1.0, 2.0 * damping1 * rate1, rate1 * rate1],
                                                        [1.0, 2.0 * damping2 * rate2, rate2 * rate2]))
        return list(gains_of(polynomial.tolist(), self.omega0)) * len(self.axes)


@dataclass(frozen=True)
class PlainParameters:
    """Parameters that take the number itself."""

    names: list[str]

    def parameters(self, numbers: Sequence[float]) -> list[float]:
        number, = numbers
        return [number] * len(self.names)


@dataclass(frozen=True)
class Unknowns:
    """All that a search looks for."""

    parts: tuple[PlacedPoles | PlainParameters, ...]   # what makes parameters of numbers
    lows: tuple[tuple[float, ...], ...]                # lower ends of the ranges of the numbers of each part
    highs: tuple[tuple[float, ...], ...]               # upper ends

    @property
    def names(self) -> list[str]:
        """Names of the parameters, `fmu.variable`."""
        return [name for part in self.parts for name in part.names]

    @property
    def bounds(self) -> list[tuple[float, float]]:
        return [pair for lows, highs in zip(self.lows, self.highs, strict=True)
                for pair in zip(lows, highs, strict=True)]

    def parameters(self, numbers: Array) -> Array:
        """Values of the parameters for numbers, shape (number of bounds,), rounded as they are written."""
        found: list[float] = []
        start = 0
        for part, lows in zip(self.parts, self.lows, strict=True):
            found += part.parameters(numbers[start:start + len(lows)].tolist())
            start += len(lows)
        return np.array([float(f"{value:.{DIGITS}g}") for value in found])


def unknowns_of(tuning: TuneFile, omega0: dict[str, float]) -> Unknowns:
    """What a tuning file searches; `omega0` are the frequencies of the internal models by FMU, rad/s."""
    parts: list[PlacedPoles | PlainParameters] = []
    lows: list[tuple[float, ...]] = []
    highs: list[tuple[float, ...]] = []
    for poles in tuning.poles:
        parts.append(PlacedPoles(tuple(poles.of), omega0[poles.of[0].partition(".")[0]]))
        for ends, found in (("low", lows), ("high", highs)):
            rate, damping = (float(getattr(each, ends).value) for each in (poles.rate, poles.damping))
            found.append((rate, rate, damping, rate, damping))
    for searched in tuning.search:
        parts.append(PlainParameters(list(searched.set)))
        lows.append((float(searched.low.value),))
        highs.append((float(searched.high.value),))
    return Unknowns(tuple(parts), tuple(lows), tuple(highs))
