"""Regularised least squares: the most probable parameters, their deviations, and profiles of what the evidence says."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.optimize import least_squares

from maglev.arrays import Array

HIGHEST = 4.0                              # of u: four standard deviations of what was assumed
PROFILE = (-2.0, -1.0, 1.0, 2.0)           # places of a profile, in deviations found


@dataclass(frozen=True)
class Fit:
    """What a fit has found, n parameters u that are normal with mean 0 and standard deviation 1 beforehand."""

    u: Array              # shape (n,)
    # Standard deviations of u afterwards, by the curvature at the minimum, (n,). Near 1 the evidence says nothing.
    deviations: Array
    correlations: Array   # shape (n, n)
    cost: float           # half the sum of squares at u: residuals of the evidence, and u
    cost_before: float    # the same at 0
    # Rise of the cost where one parameter is held at `PROFILE` deviations and the others move along; without the share
    # of u, so that what the prior holds and the evidence does not shows as a rise near or below 0. Where the costs of
    # all is quadratic and the evidence strong, 2, 0.5, 0.5, 2. NaN where u would leave its range. Shape (n, 4).
    profiles: Array


class Objective:
    """Residuals of the evidence at u, and u itself; remembers what was evaluated."""

    def __init__(self, evidence: Callable[[Array], Array], lowest: Array):
        self.evidence = evidence
        self.lowest = lowest
        self.known: dict[tuple[float, ...], Array] = {}

    def residuals(self, u: Array) -> Array:
        """Residuals of the evidence and u in one row."""
        key = tuple(float(each) for each in u)
        if key not in self.known:
            self.known[key] = self.evidence(u)
        return np.concatenate([self.known[key], u])

    def cost(self, u: Array) -> float:
        """Half the sum of squares."""
        return 0.5 * float(np.sum(self.residuals(u) ** 2))

    def misfit(self, u: Array) -> float:
        """Half the sum of squares of the evidence alone."""
        return self.cost(u) - 0.5 * float(np.sum(u ** 2))

    def jacobian(self, u: Array, difference: float) -> Array:
        """Derivatives by differences upwards, or downwards at the upper end of the range."""
        middle, columns = self.residuals(u), []
        for k in range(len(u)):
            there = u.copy()
            there[k] += difference if u[k] + difference <= HIGHEST else -difference
            columns.append((self.residuals(there) - middle) / (there[k] - u[k]))
        return np.stack(columns, axis=1)


def fit(evidence: Callable[[Array], Array], lowest: Array, difference: float, iterations: int) -> Fit:
    """Fit from u = 0.

    Parameters
    ----------
    evidence : callable
        From u, shape (n,), to the residuals of the evidence in standard deviations, shape (m,).
    lowest : ndarray, shape (n,)
        Smallest u.
    difference : float
        Step of u for derivatives, and the smallest with which the neighbourhood of the minimum is searched.
    iterations : int
        At most.
    """
    objective, start = Objective(evidence, lowest), np.zeros(len(lowest))

    def slopes_at(u: Array) -> Array:
        return objective.jacobian(u, difference)

    found = least_squares(objective.residuals, start, jac=slopes_at,
                          bounds=(lowest - 1e-9, np.full(len(lowest), HIGHEST)), max_nfev=iterations, xtol=1e-2,
                          ftol=1e-3)
    best = polished(objective, min([start, found.x], key=objective.cost), difference)
    slopes = slopes_at(best)
    covariance = np.linalg.inv(slopes.T @ slopes)
    deviations = np.sqrt(np.diag(covariance))
    profiles = np.array([[profile(objective, best, slopes, k, place * deviations[k]) for place in PROFILE]
                         for k in range(len(best))])
    return Fit(best, deviations, covariance / np.outer(deviations, deviations), objective.cost(best),
               objective.cost(start), profiles)


def polished(objective: Objective, u: Array, difference: float) -> Array:
    """Search along each parameter for what derivatives do not see, such as an error that comes to rest in a band."""
    best = u.copy()
    for size in (4.0 * difference, difference):
        for k in range(len(u)):
            tries = [best]
            for sign in (-1.0, 1.0):
                there = best.copy()
                there[k] = np.clip(best[k] + sign * size, objective.lowest[k], HIGHEST)
                tries.append(there)
            best = min(tries, key=objective.cost)
    return best


def profile(objective: Objective, best: Array, slopes: Array, held: int, shift: float) -> float:
    """Rise of the evidence's misfit where one parameter is shifted and the others are fitted, by the slopes, anew."""
    moved = best.copy()
    moved[held] += shift
    if not objective.lowest[held] <= moved[held] <= HIGHEST:
        return float("nan")
    others = [k for k in range(len(best)) if k != held]
    along = moved.copy()
    along[others] -= np.linalg.lstsq(slopes[:, others], slopes[:, held] * shift, rcond=None)[0]
    along = np.clip(along, objective.lowest, HIGHEST)
    return objective.misfit(min([moved, along], key=objective.cost)) - objective.misfit(best)
