"""Tuning files: TOML with the searched parameters, the minimised metrics, their limits, and the plants."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from maglev.files.toml_file import read_toml
from maglev.files.units import measures
from maglev.many.study_file import LISTED, Count, Design, Limit, Quantity, Seed, StudyFile, Varied, file_for, read_study
from maglev.scenario.layers import PACKAGED, Layer
from maglev.scenario.toml_table import Table, key_refused

FOLDER = PACKAGED / "tuning"   # those that come with the package


class Range(Table):
    low: Quantity
    high: Quantity

    @model_validator(mode="after")
    def not_empty(self) -> "Range":
        if not self.low.value < self.high.value:
            raise key_refused("high", self.high.written, f"expected more than low = {self.low.written}")
        return self


class Poles(Table):
    """Axes of an output regulator whose gains k1…k5 are searched together, by the poles that they place.

    One real pole at −rate, and two pairs with s² + 2 damping · rate · s + rate²; a pair with a damping above 1 is two
    real poles.
    """

    of: Annotated[list[str], Field(min_length=1)]   # "controller.x"
    rate: Range      # 1/s or rad/s
    damping: Range

    @model_validator(mode="after")
    def stable(self) -> "Poles":
        """Refuse poles that are not on the left, and other units."""
        for key, ends, units in (("rate", self.rate, ("1/s", "rad/s")), ("damping", self.damping, ())):
            for end, given in (("low", ends.low), ("high", ends.high)):
                if given.unit is not None and not any(measures(given.unit, unit) for unit in units):
                    raise key_refused(end, given.written, f"expected {' or '.join(units) or 'a plain number'}", key)
            if not ends.low.value > 0.0:
                raise key_refused("low", ends.low.written, "expected more than 0", key)
        return self


class Searched(Range):
    """One or several parameters that take one value, which is searched."""

    set: Annotated[list[str], Field(min_length=1)]


class TuneFile(Table):
    """A tuning: the scenario, searched parameters, minimised metrics, limits, and plants.

    `minimise` are metrics of a study. The largest value of a run counts, and the worst or the mean of the plants.
    `times_before` limits metrics, on every plant, to multiples of their values with the scenario's own parameters.
    """

    name: Annotated[str, Field(pattern=r"^\w[\w.+-]*$")]   # the result is named after it: it is no path
    title: str = ""
    description: str = ""
    scenario: str
    controller: str | None = None   # an FMU or a Python file next to this one, instead of the scenario's
    set: dict[str, float | int | bool | str] = {}
    minimise: Annotated[list[str], Field(min_length=1)]
    over: Literal["worst", "mean"] = "worst"
    times_before: dict[str, Annotated[float, Field(strict=True, gt=0.0, allow_inf_nan=False)]] = {}
    limits: dict[str, Limit] = {}
    poles: list[Poles] = []
    search: list[Searched] = []
    vary: list[Varied] = []
    design: Design = Design()
    population: Annotated[Count, Field(ge=5)] = 30
    generations: Count = 20
    seed: Seed = 0
    fresh: Annotated[int, Field(strict=True, ge=0)] = 0   # plants that were not searched with

    @model_validator(mode="after")
    def something_to_search(self) -> "TuneFile":
        """Refuse a file that searches nothing, or asks for fresh plants where there is but a grid of them."""
        if not self.poles and not self.search:
            raise key_refused("poles", None, "required key is missing: expected [[poles]] or [[search]]")
        if self.fresh and (not self.vary or self.design.kind in (*LISTED, "saltelli")):
            raise key_refused("fresh", self.fresh, "expected [[vary]] with a [design] of kind latin hypercube, sobol "
                              "or halton")
        if self.design.kind == "sobol" and self.fresh & (self.fresh - 1):
            raise key_refused("fresh", self.fresh, "expected a power of 2, as Sobol's sequence needs")
        return self

    def plants(self, samples: int | None = None, seed: int | None = None) -> StudyFile | None:
        """Study of the plants, with another number of samples and another seed if given; None if nothing varies."""
        design = self.design if samples is None else self.design.model_copy(update={"samples": samples, "seed": seed})
        return StudyFile(name=self.name, scenario=self.scenario, vary=self.vary, design=design) if self.vary else None


def load_tuning(name_or_path: str | Path) -> tuple[TuneFile, Path]:
    """Read a tuning file of the package by its name, or any other by its path; ScenarioError if it cannot be used."""
    path = file_for(name_or_path, FOLDER, "tuning file")
    return read_tuning(read_toml(path), path), path


def read_tuning(table: Mapping[str, Any], path: Path) -> TuneFile:
    """Return the tuning of a table; `path` is the file that errors name."""
    tuning = TuneFile.of_file(table, [Layer(path, dict(table))])
    if tuning.vary:   # what a study refuses of its design
        read_study({key: table[key] for key in ("name", "scenario", "vary", "design") if key in table}, path)
    return tuning
