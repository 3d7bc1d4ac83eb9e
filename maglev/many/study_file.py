"""Study files: TOML with the scenario, the varied quantities, the design, and the columns to keep."""

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import BeforeValidator, Field, PlainValidator, StringConstraints, field_validator, model_validator

from maglev.files.errors import ScenarioError, nearest, shortened
from maglev.files.toml_file import read_toml
from maglev.files.units import own_number
from maglev.scenario.layers import PACKAGED, Layer
from maglev.scenario.run_plan import StartValue, read_start_value
from maglev.scenario.toml_table import Seconds, Table, key_refused

FOLDER = PACKAGED / "studies"   # those that come with the package
MOST_SAMPLES = 1_000_000

Quantity = Annotated[StartValue, PlainValidator(read_start_value)]
Count = Annotated[int, BeforeValidator(own_number), Field(strict=True, ge=1, le=MOST_SAMPLES)]
Seed = Annotated[int, BeforeValidator(own_number), Field(strict=True, ge=0)]
Kind = Literal["grid", "list", "uniform", "normal", "log-uniform", "percent"]
Mode = Literal["value", "factor", "offset"]

# The keys that say what values there are, by kind.
KEYS: dict[str, tuple[str, ...]] = {
    "grid": ("from", "to", "number"), "list": ("values",), "uniform": ("low", "high"), "log-uniform": ("low", "high"),
    "normal": ("mean", "deviation"), "percent": ("percent",)}
DISCRETE = ("grid", "list")
LISTED = ("grid", "rows")   # designs of values that are given


class Varied(Table):
    """One varied quantity: the targets that it sets, and its values.

    `set` names one or several: parameters and inputs `fmu.variable` (also initial positions), and references
    `reference.AXIS.amplitude`, `.start`, `.end`. A value of mode "factor" multiplies their nominal values, one of
    "offset" is added to them. Kind "percent" is uniform and a factor: nominal ± so much.
    """

    set: Annotated[list[Annotated[str, StringConstraints(strip_whitespace=True)]], Field(min_length=1),
                   BeforeValidator(lambda given: [given] if isinstance(given, str) else given)]
    name: str = ""
    mode: Mode = "value"
    kind: Kind
    start: Quantity | None = Field(default=None, alias="from")
    to: Quantity | None = None
    number: Count | None = None
    values: Annotated[list[Quantity], Field(min_length=1)] | None = None
    low: Quantity | None = None
    high: Quantity | None = None
    mean: Quantity | None = None
    deviation: Quantity | None = None
    percent: Quantity | None = None

    @model_validator(mode="before")
    @classmethod
    def keys_of_kind(cls, table: Any) -> Any:
        """Refuse a kind without its keys, and keys of another kind; a percentage is a factor."""
        if not isinstance(table, Mapping) or table.get("kind") not in KEYS:
            return table
        kind = table["kind"]
        for key in {key for keys in KEYS.values() for key in keys} & set(table) - set(KEYS[kind]):
            raise key_refused(key, table[key], f"not allowed with kind = {kind!r}, which has "
                                               f"{', '.join(KEYS[kind])}")
        for key in KEYS[kind]:
            if table.get(key) is None and key != "deviation":   # a covariance can take its place
                raise key_refused(key, None, f"required key is missing with kind = {kind!r}")
        if kind == "percent":
            if table.get("mode", "factor") != "factor":
                raise key_refused("mode", table["mode"], "not allowed, a percentage is a factor")
            return {**table, "mode": "factor"}
        return table

    @model_validator(mode="after")
    def sensible(self) -> "Varied":
        """Refuse an empty range, a deviation or a logarithm of nothing."""
        if self.low is not None and self.high is not None and not self.low.value < self.high.value:
            raise key_refused("high", self.high.written, f"expected more than low = {self.low.written}")
        if self.kind == "log-uniform" and self.low is not None and not self.low.value > 0.0:
            raise key_refused("low", self.low.written, "expected more than 0, for the scale is logarithmic")
        for key in ("deviation", "percent"):
            given = getattr(self, key)
            if given is not None and not given.value > 0.0:
                raise key_refused(key, given.written, "expected more than 0")
        return self

    @property
    def column(self) -> str:
        """Return its name in the results; its targets have columns of their own if their values differ."""
        return self.name or (self.set[0] if self.mode == "value" else f"{self.mode} of {self.set[0]}")

    @property
    def quantities(self) -> list[StartValue]:
        given = [self.start, self.to, self.low, self.high, self.mean, self.deviation, *(self.values or ())]
        return [kind for kind in given if kind is not None]


class Design(Table):
    """Samples to run: every combination of grids and lists, or points of scipy.stats.qmc in the unit cube.

    Of "rows", sample k takes the k-th value of each list or grid. Of "saltelli", which Sobol indices need, `samples` is
    the base: it has that many times (number that vary + 2).
    """

    kind: Literal["grid", "latin hypercube", "sobol", "halton", "saltelli", "rows"] = "grid"
    samples: Count | None = None
    seed: Seed = 0

    @model_validator(mode="after")
    def number_of_samples(self) -> "Design":
        """Refuse a design without its number of samples, and a grid with one."""
        if (self.kind in LISTED) != (self.samples is None):
            raise key_refused("samples", self.samples, f"not allowed, {self.kind!r} has its own"
                              if self.kind in LISTED else f"required key is missing with kind = {self.kind!r}")
        if self.kind in ("sobol", "saltelli") and self.samples is not None and self.samples & (self.samples - 1):
            raise key_refused("samples", self.samples, "expected a power of 2, as Sobol's sequence needs")
        return self


class Correlated(Table):
    """Normal ones that vary together: their names, and their covariance in SI."""

    of: Annotated[list[str], Field(min_length=2)]
    covariance: list[list[Annotated[float, Field(strict=True, allow_inf_nan=False)]]]


class Limit(Table):
    """A bound on a metric for a sample to pass, from above or below."""

    min: Quantity | None = None
    max: Quantity | None = None

    @model_validator(mode="after")
    def one_at_least(self) -> "Limit":
        """Refuse a limit that limits nothing, and one that nothing keeps."""
        if self.min is None and self.max is None:
            raise key_refused("max", None, "required key is missing: expected max or min")
        if self.min is not None and self.max is not None and not self.min.value <= self.max.value:
            raise key_refused("max", self.max.written, f"expected at least min = {self.min.written}")
        return self


class Repetition(Table):
    """The keys that files of studies and of tunings share: a scenario, its differences, a design, and limits."""

    name: Annotated[str, Field(pattern=r"^\w[\w.+-]*$")]   # results are named after it: it is no path
    title: str = ""
    description: str = ""
    scenario: str
    controller: str | None = None   # an FMU or a Python file next to this one, instead of the scenario's
    set: dict[str, float | int | bool | str] = {}
    design: Design = Design()
    limits: dict[str, Limit] = {}


class StudyFile(Repetition):
    """A study: the scenario, varied quantities, design, columns to keep, and limits for a sample to pass."""

    vary: Annotated[list[Varied], Field(min_length=1)]
    correlated: list[Correlated] = []
    metrics: list[str] | None = None
    keep: list[str] = []
    keep_interval: Annotated[Seconds, Field(gt=0.0)] | None = None
    sample_timeout: Annotated[Seconds, Field(gt=0.0)] | None = None   # wall time

    @field_validator("keep")
    @classmethod
    def kept_once(cls, keep: list[str]) -> list[str]:
        """Refuse a signal that is listed twice."""
        for i, name in enumerate(keep):
            if name in keep[:i]:
                raise key_refused(i, name, "is listed twice, expected once")
        return keep

    @field_validator("vary")
    @classmethod
    def unique_targets(cls, vary: list[Varied]) -> list[Varied]:
        """Refuse two that have one name or set the same."""
        columns: dict[str, int] = {}
        targets: dict[str, int] = {}
        for i, varied in enumerate(vary):
            if columns.setdefault(varied.column, i) != i:
                raise key_refused("name", varied.column, "expected another name, this one is taken", i)
            for target in varied.set:
                if target in targets:
                    raise key_refused("set", target, f"vary[{targets[target]}] sets it already", i)
                targets[target] = i
        for i, varied in enumerate(vary):
            if varied.name in targets:
                raise key_refused("name", varied.name, "expected another name than that of a parameter", i)
        return vary

    @model_validator(mode="after")
    def of_one_design(self) -> "StudyFile":
        """Refuse a grid of a quantity without steps, and correlations of one that is not normal."""
        normal = [varied.column for varied in self.vary if varied.kind == "normal"]
        together: set[str] = set()
        for i, group in enumerate(self.correlated):
            for name in group.of:
                if name not in normal:
                    raise key_refused("of", name, f"expected names of entries with kind = 'normal'; "
                                                  f"{nearest(name, normal)}", "correlated", i)
                if name in together:
                    raise key_refused("of", name, "expected in one group only", "correlated", i)
                together.add(name)
            if any(len(row) != len(group.of) for row in group.covariance) or len(group.covariance) != len(group.of):
                raise key_refused("covariance", group.covariance, f"expected {len(group.of)} rows of {len(group.of)}",
                                  "correlated", i)
        for i, varied in enumerate(self.vary):
            if self.design.kind in LISTED and varied.kind not in DISCRETE:
                raise key_refused("kind", varied.kind, "expected grid or list in a design of kind "
                                  f"{self.design.kind!r}", "vary", i)
            if varied.kind == "normal" and (varied.deviation is None) != (varied.column in together):
                raise key_refused("deviation", None if varied.deviation is None else varied.deviation.written,
                                  "not allowed, it has a covariance" if varied.column in together
                                  else "required key is missing with kind = 'normal'", "vary", i)
        return self


def load_study(name_or_path: str | Path) -> tuple[StudyFile, Path]:
    """Read a study of the package by its name, or any other by its path; ScenarioError if it cannot be used."""
    path = file_for(name_or_path, FOLDER, "study")
    return read_study(read_toml(path), path), path


def file_for(name_or_path: str | Path, folder: Path, what: str) -> Path:
    """File of a folder of the package by its name, or the path itself; ScenarioError says what there is not."""
    if not isinstance(name_or_path, str | Path):
        raise ScenarioError(f"{what}: {shortened(name_or_path)}, expected a name or a path")
    path = Path(name_or_path)
    if path.name != str(name_or_path) or path.suffix == ".toml":
        return path
    names = {file.stem: file for file in sorted(folder.glob("*.toml"))}
    if path.name not in names:
        raise ScenarioError(f"there is no {what} {path.name!r}; "
                            f"{nearest(path.name, names, '.toml')}, or give the path of a TOML file")
    return names[path.name]


def read_study(table: Mapping[str, Any], place: object) -> StudyFile:
    """Return the study of a table; `place` is the file, or another origin, that errors name."""
    return StudyFile.of_file(table, [Layer(place, dict(table))])
