"""What is estimated, and from what: the settings of the study as `estimation.toml` has them."""

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

FILE = Path(__file__).with_name("estimation.toml")

Defaults = Mapping[str, float]   # by `model.variable`, SI


@dataclass(frozen=True)
class Scale:
    """One scale of Coulomb friction on all axes."""

    candidates: tuple[float, ...]
    assumed: Defaults   # what is scaled, SI by `model.variable`
    follows: Defaults   # what is scaled along where a scenario gives it at all
    ripple: Defaults    # what is tried beside the scale that is chosen


@dataclass(frozen=True)
class RoughnessSettings:
    """Rail roughness together with one scale of friction."""

    tracks: tuple[int, ...]        # seeds of those that it is estimated on
    judging: tuple[int, ...]       # of those on which the evidence that was held out is judged
    scales: tuple[float, ...]
    multiples: tuple[float, ...]   # of `rms`, for each axis
    outliers: float                # probability that a printed number has nothing to do with the model
    lesser: tuple[float, ...]      # shares of the rms that is found, which are judged as well and decide nothing
    rms: Defaults                  # m/s² by `model.variable`


@dataclass(frozen=True)
class Settings:
    """The whole study; see `estimation.toml`."""

    training: frozenset[str]   # runs whose sentences and bounds are for training; all others are held out
    largest_residual: float
    scale: Scale
    roughness: RoughnessSettings
    causes: Mapping[str, Defaults]   # other causes of printed numbers, by what they are in words


def times(scale: float, values: Defaults) -> dict[str, float]:
    """Every value times a scale."""
    return {name: scale * value for name, value in values.items()}


def read_settings(path: Path = FILE) -> Settings:
    """Read the settings; KeyError or TypeError where a table lacks something or has too much."""
    table = tomllib.loads(path.read_text(encoding="utf-8"))
    scale: dict[str, Any] = with_tuples(table.pop("scale"))
    rough: dict[str, Any] = with_tuples(table.pop("roughness"))
    return Settings(**{**table, "training": frozenset(table["training"]), "scale": Scale(**scale),
                       "roughness": RoughnessSettings(**rough)})


def with_tuples(table: Mapping[str, Any]) -> dict[str, Any]:
    """A table with tuples for its lists."""
    return {name: tuple(value) if isinstance(value, list) else value for name, value in table.items()}
