"""The columns of a study: metrics by name, and the limits on them."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from math import inf, isnan
from typing import Any

from maglev.files.errors import ScenarioError, nearest
from maglev.files.units import parse_quantity, read_quantity, refused_as, unit_of
from maglev.many.study_file import Limit
from maglev.runs.measures import numbers
from maglev.runs.metrics import ManyMetrics, Metrics, larger_of
from maglev.scenario.quantities import printed
from maglev.scenario.run_plan import RunPlan

# Metrics of every run; the time of an event that did not happen is inf. `failed` is 1 after a stop contact or a trip;
# `ended off` is 1 if the error at the end was too large.
FLAWS = ("failed", "ended off")
OF_EVERY_RUN = (*FLAWS, "trip time", "stop contact time", "lost setpoints")

METADATA = b"maglev"    # key of a dataset's metadata, JSON
AT_STEP = " at t = "   # in the name of a metric of one step
BAND = re.compile(r"(?<=settling time to )[\d.]+ ?[^\s\d]+")


@dataclass(frozen=True)
class Column:
    """A metric that a study keeps: its name, its SI unit ("1" of a share, empty of a count), and its limits."""

    name: str
    unit: str
    min: float = -inf
    max: float = inf

    def passes(self, value: float) -> bool:
        """Return True if a value is within the limits; a missing value is not."""
        return (self.min == -inf and self.max == inf) or self.min <= value <= self.max


def named_values(plan: RunPlan, metrics: Metrics | ManyMetrics) -> dict[str, tuple[Any, str]]:
    """Values and units of a run by name, or of many, then arrays of shape (runs,).

    "overshoot of x at t = 6 s" is that of one step, "overshoot of x" the largest of all steps.
    """
    values: dict[str, tuple[Any, str]] = {}
    steps: dict[str, tuple[Any, str]] = {}
    for quantity, of, time, value, unit, _ in numbers(plan, metrics):
        name = f"{quantity} of {of}" if of else quantity
        if time is not None:
            steps[f"{name}{AT_STEP}{time:g} s"] = value, unit
            values[name] = larger_of(values.get(name, (-inf, ""))[0], value), unit
        else:
            values[name] = value, unit
    return {**values, **steps}


def columns_of(known: Mapping[str, tuple[float, str]], asked: Iterable[str] | None, limits: Mapping[str, Limit],
               origin: str) -> list[Column]:
    """Return the columns of a study, limited metrics among them; `known` has those of an expected run.

    A name such as "overshoot" means those of all axes or motors. Without any name, all are kept except those of single
    steps. `origin` is the source that errors name.
    """
    names = [name for name in known if AT_STEP not in name] if asked is None else [
        *OF_EVERY_RUN, *(name for pattern in asked for name in metric_names(known, pattern, f"{origin}: metrics"))]
    bounds: dict[str, tuple[float, float]] = {}
    for pattern, limit in limits.items():
        for name in metric_names(known, pattern, f"{origin}: limits"):
            unit = known[name][1] or "1"
            with refused_as(ScenarioError, f"{origin}: limits.{pattern}"):
                low, high = (default if given is None else parse_quantity(given.written, unit)
                             for given, default in ((limit.min, -inf), (limit.max, inf)))
            before = bounds.get(name, (-inf, inf))
            least, most = bounds[name] = max(low, before[0]), min(high, before[1])
            if least > most:
                raise ScenarioError(f"{origin}: limits.{pattern}: {name} would have to be {least:g} at least and "
                                    f"{most:g} at most, expected min below max")
    return [Column(name, known[name][1], *bounds.get(name, (-inf, inf))) for name in dict.fromkeys([*names, *bounds])]


def metric_names(known: Mapping[str, object], asked: str, origin: str) -> list[str]:
    """Names that a name means; ScenarioError with the nearest if there is none."""
    with refused_as(ScenarioError, f"{origin}: {asked!r}"):
        name = BAND.sub(lambda band: as_named(band[0]), asked)
    if name in known:
        return [name]
    matching = [column for column in known if column.startswith(f"{name} of ") and AT_STEP not in column]
    if not matching:
        raise ScenarioError(f"{origin}: there is no metric {asked!r}; {nearest(name, known)}")
    return matching


def as_named(band: str) -> str:
    """A band as names of metrics have it, however it is written: "0.1 mm" of "100 um"."""
    value, unit = read_quantity(band)
    return printed(value, unit_of(str(unit)).si)


def passed(columns: Iterable[Column], values: Iterable[float], failure: str | None, limited: bool) -> bool:
    """Return True if a sample passes: completed and within all limits; without limits, neither failed nor ended off."""
    return failure is None and all(
        column.passes(value) if limited else column.name not in FLAWS or isnan(value) or value == 0.0
        for column, value in zip(columns, values, strict=True))
