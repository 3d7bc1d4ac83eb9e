"""Samples of a study: points of a design, and the values of the varied quantities there."""

import math
from collections.abc import Sequence
from decimal import Decimal

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError
from maglev.many.study_file import DISCRETE, MOST_SAMPLES, StudyFile, Varied

SMALLEST = 2.0**-53   # no sample lies at 0 or 1, where a normal distribution has no end


def samples(study: StudyFile) -> Array:
    """Return the values of the varied quantities, in order, shape (samples, quantities), SI; equal for the same study.

    ScenarioError if there are too many samples, or values do not suit the design.
    """
    design, varied = study.design, len(study.vary)
    if design.kind == "rows":
        return design_rows(study)
    grid = [different_values(study, side) for side in study.vary] if design.kind == "grid" else []
    number = design.samples or math.prod(map(len, grid))
    number *= varied + 2 if design.kind == "saltelli" else 1
    if number > MOST_SAMPLES:
        raise ScenarioError(f"{study.name}: design: {number:.3g} samples, expected at most {MOST_SAMPLES:.0e}")
    if grid:
        return np.stack(np.meshgrid(*grid, indexing="ij"), axis=-1).reshape(-1, varied)
    return values_of_points(study, unit_samples(study))


def different_values(study: StudyFile, varied: Varied) -> Array:
    """Return the values of a quantity in a grid, shape (n,); ScenarioError if one occurs twice."""
    tried = np.array(tried_values(varied), dtype=np.float64)
    if (different := len(np.unique(tried))) < len(tried):   # a set would take eight times the memory
        raise ScenarioError(f"{study.name}: vary: {varied.column}: {len(tried)} values of which {different} differ, "
                            "expected each once in a design of kind 'grid'")
    return tried


def design_rows(study: StudyFile) -> Array:
    """Values side by side, one row a sample; ScenarioError if there are more of one than of another."""
    columns = {varied.column: tried_values(varied) for varied in study.vary}
    numbers = {name: len(column) for name, column in columns.items()}
    if len({*numbers.values()}) > 1:
        raise ScenarioError(f"{study.name}: vary: {', '.join(f'{name}: {number}' for name, number in numbers.items())} "
                            "values, expected as many of each in a design of kind 'rows'")
    return np.column_stack([np.array(column, dtype=np.float64) for column in columns.values()])


def unit_samples(study: StudyFile) -> Array:
    """Points of the design in the unit cube, shape (number of samples, number that vary)."""
    from scipy.stats import qmc  # its import takes half of the start of a study, and grids do not need it

    design, varied = study.design, len(study.vary)
    assert design.samples is not None   # not of a grid
    if design.kind == "saltelli":
        return saltelli(varied, design.samples, design.seed)
    engine = {"latin hypercube": qmc.LatinHypercube, "sobol": qmc.Sobol, "halton": qmc.Halton}[design.kind]
    return np.asarray(engine(varied, rng=design.seed).random(design.samples))


def saltelli(varied: int, base: int, seed: int) -> Array:
    """Saltelli's points for first and total indices: of two matrices A and B, A, then A with each column of B, then B.

    SALib reads them in that order; both matrices are one scrambled sequence of Sobol of twice the dimension.
    """
    from scipy.stats import qmc

    first, second = np.hsplit(np.asarray(qmc.Sobol(2 * varied, rng=seed).random(base)), 2)
    rows = np.empty((base, varied + 2, varied))
    rows[:, 0], rows[:, -1] = first, second
    for column in range(varied):
        rows[:, column + 1] = first
        rows[:, column + 1, column] = second[:, column]
    return rows.reshape(-1, varied)


def values_of_points(study: StudyFile, points: Array) -> Array:
    """Return the values of the varied quantities at points of the unit cube."""
    from scipy.special import ndtri

    points = np.clip(points, SMALLEST, 1.0 - SMALLEST)
    values = np.column_stack([quantile_values(varied, points[:, column]) for column, varied in enumerate(study.vary)])
    columns = [varied.column for varied in study.vary]
    for group in study.correlated:
        chosen = [columns.index(name) for name in group.of]
        means = np.array([si_number(study.vary[column].mean) for column in chosen])
        values[:, chosen] = means + ndtri(points[:, chosen]) @ cholesky_factor(group.of, group.covariance).T
    return values


def quantile_values(varied: Varied, points: Array) -> Array:
    """Values of one that varies where its distribution function is at the points, shape (n,)."""
    from scipy.special import ndtri

    if varied.kind in DISCRETE:
        values = np.array(tried_values(varied), dtype=np.float64)
        return np.asarray(values[np.minimum((points * len(values)).astype(int), len(values) - 1)])
    if varied.kind == "percent":
        share = si_number(varied.percent)
        return 1.0 - share + 2.0 * share * points
    if varied.kind == "normal":
        deviation = 0.0 if varied.deviation is None else si_number(varied.deviation)   # 0: a covariance follows
        return np.asarray(si_number(varied.mean) + deviation * ndtri(points))
    low, high = si_number(varied.low), si_number(varied.high)
    if varied.kind == "uniform":
        return np.asarray(low + (high - low) * points)
    # The powers of `math`: those of NumPy are others on some processors.
    return np.array([low * math.pow(high / low, point) for point in points.tolist()])


def tried_values(varied: Varied) -> list[float]:
    """Values of a list, or of a grid: the decimals that a person would write, 7.6 and not 7.6000000000000005."""
    if varied.kind == "list":
        return [si_number(value) for value in varied.values or ()]
    count = varied.number or 1
    first, last = (Decimal(repr(si_number(end))) for end in (varied.start, varied.to))
    return [float(first + (last - first) * i / max(1, count - 1)) for i in range(count)]


def si_number(quantity: object) -> float:
    """SI value of a quantity that its kind has."""
    value = getattr(quantity, "value", None)
    assert value is not None   # the schema refuses a kind without its keys
    return float(value)


def cholesky_factor(names: Sequence[str], covariance: Sequence[Sequence[float]]) -> Array:
    """Return the lower triangular matrix L with L Lᵀ = covariance; ScenarioError if there is none."""
    matrix = np.array(covariance, dtype=np.float64)
    try:
        if not np.allclose(matrix, matrix.T):
            raise np.linalg.LinAlgError
        return np.asarray(np.linalg.cholesky(matrix))
    except np.linalg.LinAlgError:
        raise ScenarioError(f"covariance of {', '.join(names)}: {matrix.tolist()}: expected a symmetric, positive "
                            "definite matrix") from None
