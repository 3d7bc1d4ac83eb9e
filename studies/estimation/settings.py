"""What is estimated, and from what: the settings of the study as `estimation.toml` has them."""

import math
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from maglev.arrays import Array

FILE = Path(__file__).with_name("estimation.toml")

Defaults = Mapping[str, float]   # by `model.variable`, SI


@dataclass(frozen=True)
class Parameter:
    """One number that is estimated, by a u that is normal with mean 0 and standard deviation 1 beforehand."""

    name: str
    variables: tuple[str, ...]   # `model.variable`, those whose default it is
    unit: str
    scale: str                   # "log": value = assumed exp(spread u); "linear": value = assumed + spread u
    assumed: float
    spread: float
    least: float = -math.inf     # smallest value
    # A variable `model.variable` that is this value times a factor, where a scenario gives it at all.
    follows: tuple[str, float] | None = None

    def value(self, u: float) -> float:
        """Value (SI) at u."""
        if self.scale == "log":
            return self.assumed * math.exp(self.spread * u)
        return max(self.least, self.assumed + self.spread * u)

    def range(self, u: float, deviation: float) -> tuple[float, float]:
        """Values (SI) one standard deviation of u below and above, the smaller one first."""
        low, high = sorted((self.value(u - deviation), self.value(u + deviation)))
        return low, high

    @property
    def lowest(self) -> float:
        """Smallest u."""
        return -4.0 if math.isinf(self.least) else max(-4.0, (self.least - self.assumed) / self.spread)


@dataclass(frozen=True)
class Rig:
    """One stage: what is estimated of it, and the runs whose claims are for training; all others are held out."""

    name: str
    training: tuple[str, ...]
    parameters: tuple[Parameter, ...]

    def defaults(self, u: Array | Sequence[float]) -> dict[str, float]:
        """Defaults of variables at u, shape (parameters,)."""
        return {variable: parameter.value(float(each)) for parameter, each in zip(self.parameters, u, strict=True)
                for variable in parameter.variables}

    def following(self, u: Array | Sequence[float]) -> dict[str, float]:
        """Values, at u, of variables that follow a parameter where a scenario gives them."""
        return {parameter.follows[0]: parameter.follows[1] * parameter.value(float(each))
                for parameter, each in zip(self.parameters, u, strict=True) if parameter.follows is not None}


@dataclass(frozen=True)
class Scale:
    """One scale of Coulomb friction on all axes."""

    candidates: tuple[float, ...]
    assumed: Defaults   # what is scaled, SI by `model.variable`
    follows: Defaults   # what is scaled along where a scenario gives it at all
    ripple: Defaults    # what is tried beside the scale that is chosen


def times(scale: float, values: Defaults) -> dict[str, float]:
    """Every value times a scale."""
    return {name: scale * value for name, value in values.items()}


@dataclass(frozen=True)
class Settings:
    """The whole study; see `estimation.toml`."""

    scale: Scale
    rigs: tuple[Rig, ...]
    largest_residual: float
    difference: float
    iterations: int

    @property
    def training(self) -> frozenset[str]:
        """Runs whose claims are for training."""
        return frozenset(run for rig in self.rigs for run in rig.training)


def read_settings(path: Path = FILE) -> Settings:
    """Read the settings; KeyError or TypeError where a table lacks something or has too much."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    rigs = tuple(Rig(rig["name"], tuple(rig["training"]), tuple(read_parameters(rig["parameters"])))
                 for rig in table["rigs"])
    scale = Scale(**{**table["scale"], "candidates": tuple(table["scale"]["candidates"])})
    return Settings(scale, rigs, table["largest_residual"], table["difference"], table["iterations"])


def read_parameters(tables: Iterable[Mapping[str, Any]]) -> Iterable[Parameter]:
    for table in tables:
        follows = table.get("follows")
        yield Parameter(**{**table, "variables": tuple(table["variables"]),
                           "follows": None if follows is None else (follows["variable"], follows["factor"])})
