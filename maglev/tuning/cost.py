"""What a candidate costs: the worst or the mean over the plants of what is minimised, if all limits are met."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from maglev.arrays import Array
from maglev.studies.columns import Column

REFUSED = 1e6          # cost of a candidate that breaks a limit: more than any that meets all
SMALLEST = 1e-6        # by which an excess is divided at least
LARGEST_EXCESS = 1.0   # that one metric of one flight counts


@dataclass(frozen=True)
class Cost:
    """Cost of flights."""

    # What is measured, with the limits on it; the first is `failed`, which every tuning limits.
    columns: tuple[Column, ...]
    minimised: tuple[int, ...]          # numbers of columns
    # By number of a column: how many times what it is with the scenario's own values it may be.
    times_before: Mapping[int, float]
    over: str                           # "worst" or "mean" of the plants

    def excess(self, flown: Array, before: Array) -> Array:
        """How far flights are beyond the limits, 0 if within all, shape (candidates, plants).

        `flown` has the shape (candidates, plants, columns), NaN where a sample was not flown to its end; `before`,
        those with the scenario's own values, (plants, columns).
        """
        lows, highs = (np.array([getattr(column, end) for column in self.columns]) for end in ("min", "max"))
        highs = np.broadcast_to(highs, before.shape).copy()
        for column, times in self.times_before.items():
            highs[:, column] = np.minimum(highs[:, column], times * before[:, column])
        with np.errstate(invalid="ignore"):   # of infinite limits, and of metrics without an end
            beyond = np.fmax((flown - highs) / np.maximum(np.abs(highs), SMALLEST),
                             (lows - flown) / np.maximum(np.abs(lows), SMALLEST))
        beyond = np.where(np.isnan(beyond), 0.0, beyond)
        beyond[np.isnan(flown)] = LARGEST_EXCESS
        # What is minimised and never ends, such as settling, is beyond all limits.
        minimised = list(self.minimised)
        beyond[..., minimised] = np.where(np.isfinite(flown[..., minimised]), beyond[..., minimised], LARGEST_EXCESS)
        return np.asarray(np.clip(beyond, 0.0, LARGEST_EXCESS).sum(axis=-1))

    def of(self, flown: Array, before: Array) -> Array:
        """Cost of each candidate, shape (candidates,); arguments as of `excess`.

        Among candidates that break limits, the one that breaks them less costs less (Deb's rules).
        """
        excess = self.excess(flown, before).mean(axis=1)
        each = flown[..., list(self.minimised)].max(axis=-1)
        with np.errstate(invalid="ignore"):
            cost = each.max(axis=1) if self.over == "worst" else each.mean(axis=1)
        return np.asarray(np.where(excess > 0.0, REFUSED * (1.0 + excess), cost))
