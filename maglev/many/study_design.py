"""Samples of a study: points of a design, values of the varied quantities there, and the targets that they set.

Targets are parameters, inputs and references.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal

import numpy as np
from fmpy.model_description import ModelDescription

from maglev.files.arrays import Array
from maglev.files.errors import ScenarioError, nearest
from maglev.files.units import measures
from maglev.many.study_file import DISCRETE, MOST_SAMPLES, Mode, StudyFile, Varied
from maglev.runs.preparation import Experiment
from maglev.scenario.run_plan import StartValue
from maglev.scenario.settings import REFERENCE, port_of, reference_unit, with_reference
from maglev.scenario.signals import Steps

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


@dataclass(frozen=True)
class Target:
    """One start value `fmu.variable`, or reference, that a study sets."""

    name: str
    column: int      # of the design, whose value it takes
    mode: Mode       # "value", "factor" of the nominal value, or "offset" to it
    nominal: float   # SI, of the scenario
    unit: str        # SI; empty text where the FMU gives none
    boolean: bool
    low: float       # end of its range
    high: float

    def values(self, column: Array) -> Array:
        """Its values, from those of the design's column: in decimals, so that 0.7 kg more than 6.9 kg are 7.6 kg."""
        if self.mode == "value":
            return column
        nominal = Decimal(repr(float(self.nominal)))
        changed = nominal.__mul__ if self.mode == "factor" else nominal.__add__
        return np.array([float(changed(Decimal(repr(each)))) for each in column.tolist()])


def targets_of(vary: Iterable[Varied], experiment: Experiment, origin: str, key: str = "vary") -> list[Target]:
    """Return the targets of a study, in the order of the file; ScenarioError if one cannot be set, or not to its
    values.
    """
    descriptions = experiment.check()
    targets = []
    for i, varied in enumerate(vary):
        entry = f"{origin}: {key}[{i}]"
        for name in varied.set:
            target = target_of(name, i, varied.mode, experiment, descriptions, f"{entry}.set = {name!r}")
            if target.boolean and (varied.kind not in DISCRETE or (varied.number or 2) > 2):   # any but 0 is true
                raise ScenarioError(f"{entry}: {name} is Boolean, expected no value between false and true")
            expected = "1" if varied.mode == "factor" else target.unit or "1"
            for quantity in varied.quantities:
                if quantity.unit is not None and not measures(quantity.unit, expected):
                    raise ScenarioError(f"{entry}: {quantity.written}: is in {quantity.unit}, expected a "
                                        f"{'factor' if varied.mode == 'factor' else f'quantity in {expected}'}")
                if target.boolean != isinstance(quantity.value, bool):
                    raise ScenarioError(f"{entry}: {quantity.written}: {name} is "
                                        f"{'Boolean, expected true or false' if target.boolean else 'a number'}")
            targets.append(target)
        if varied.mode == "factor" and not any(target.nominal for target in targets if target.column == i):
            raise ScenarioError(f"{entry}.set = {', '.join(varied.set)!r}: a factor on 0 varies nothing, expected "
                                "values, such as LOW:HIGH, or mode = 'offset'")
    return targets


def require_free(settings: Mapping[str, StartValue], vary: Iterable[Varied], origin: str) -> None:
    """Refuse to set `fmu.variable` that varies; the target of a factor or an offset may be set."""
    varied = {name for parameter in vary if parameter.mode == "value" for name in parameter.set}
    for name in settings.keys() & varied:
        raise ScenarioError(f"{origin}: {settings[name].origin}: {name} is set and varied, expected one of both")


def target_of(name: str, column: int, mode: Mode, experiment: Experiment, descriptions: dict[str, ModelDescription],
              key: str) -> Target:
    """Return one target by its name; `key` is the key that errors name."""
    fmu, _, own = name.partition(".")
    if fmu == REFERENCE:
        what = own.rpartition(".")[2]
        try:
            plan = with_reference(experiment.plan, own, experiment.plan.stop_time if what == "time" else 1.0)
        except ScenarioError as error:
            raise ScenarioError(f"{key}: {error}") from None
        to = port_of(plan, own.rpartition(".")[0])
        signal = next(signal for signal in experiment.plan.signals if signal.to == to)
        times = {"start": 0.0, "end": experiment.plan.stop_time}
        nominal = signal.value(times[what]) if what in times else 1.0
        if what == "time" and isinstance(signal, Steps):
            nominal = signal.times[-1]
        return Target(name, column, mode, nominal, reference_unit(plan, own), False, -np.inf, np.inf)
    if fmu not in descriptions:
        raise ScenarioError(f"{key}: there is no FMU {fmu!r}, {nearest(fmu, [*descriptions, REFERENCE])}")
    variables = {variable.name: variable for variable in descriptions[fmu].modelVariables}
    settable = [name for name, variable in variables.items() if variable.causality in ("parameter", "input")]
    if own not in variables:
        raise ScenarioError(f"{key}: {fmu} has no parameter {own!r}; {nearest(own, settable)}")
    variable = variables[own]
    if own not in settable:
        raise ScenarioError(f"{key}: is of causality {variable.causality}, expected a parameter or an input; "
                            f"{nearest(own, settable)}")
    if variable.type not in ("Real", "Boolean"):
        raise ScenarioError(f"{key}: is of type {variable.type}, expected Real or Boolean")
    plan = experiment.plan
    if own in plan.fmus[fmu].start_from:
        raise ScenarioError(f"{key}: comes from another run, expected what the scenario itself sets")
    if name in {*(end for _, end in plan.wires.values()), *(port for signal in plan.signals
                                                            for port in (signal.to, signal.rate_to))}:
        raise ScenarioError(f"{key}: is fed from the start, expected a parameter, an input that nothing feeds, or "
                            "reference.AXIS.amplitude, .start or .end")
    boolean = variable.type == "Boolean"
    if boolean and mode != "value":
        raise ScenarioError(f"{key}: is Boolean, expected mode = 'value'")
    return Target(name, column, mode, experiment.start_value(name, descriptions), variable.unit or "", boolean,
                  -np.inf if variable.min is None else float(variable.min),
                  np.inf if variable.max is None else float(variable.max))


def target_values(targets: Sequence[Target], design: Array, origin: str) -> Array:
    """Values of the targets, shape (number of samples, number of targets); ScenarioError if some are out of range."""
    values = np.column_stack([target.values(design[:, target.column]) for target in targets])
    for i, target in enumerate(targets):
        outside = np.flatnonzero(~((values[:, i] >= target.low) & (values[:, i] <= target.high)))
        if len(outside):
            raise ScenarioError(f"{origin}: {target.name}: {len(outside)} of {len(values)} samples are out of range, "
                                f"the first is {values[outside[0], i]:g}, expected {target.low:g} to {target.high:g} "
                                f"{target.unit}".rstrip())
    return values
