"""A scenario: which FMUs run together, on which references, and what is measured and claimed."""

from functools import cache
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator, Field, PlainValidator, PrivateAttr, StrictBool, ValidationError, model_validator

from scenarios.claims import TRACKING_METRICS, Claim
from scenarios.errors import ScenarioError, nearest
from scenarios.quantity import parse_quantity, read_quantity
from scenarios.signals import Signal
from scenarios.toml_table import (
    Layer,
    Metres,
    Seconds,
    Table,
    extended,
    key_refused,
    merged,
    one_line,
    read_layers,
)

PACKAGED = Path(__file__).parent


class StartValue(NamedTuple):
    """A start value in SI, the unit it was written in (None for a plain number or a Boolean), and the text."""

    value: float | int | bool
    unit: str | None
    written: float | int | bool | str


def read_start_value(value: Any) -> StartValue:
    """Read a Boolean, a number, or text with a unit."""
    if isinstance(value, bool | int):
        return StartValue(value, None, value)
    return StartValue(*read_quantity(value), value)


class Fmu(Table):
    """One FMU: a model that this project builds, or a file, and its start values by variable name."""

    model: str | None = None
    file: str | None = None
    start: dict[str, Annotated[StartValue, PlainValidator(read_start_value)]] = {}

    @model_validator(mode="after")
    def one_source(self) -> "Fmu":
        """Refuse an FMU that is neither or both."""
        if (self.model is None) == (self.file is None):
            raise ValueError("expected either model, the name of an FMU of this project, or file, the path of an FMU")
        return self


class Axis(Table):
    """Names of the recorded variables of an axis, and whether it points along gravity."""

    position: str
    reference: str
    vertical: StrictBool = False


class Motor(Table):
    """Names of the recorded currents of a motor."""

    currents: list[str] = []
    commands: list[str] = []


class MetricSettings(Table):
    """What is measured: settling bands, the start of steady tracking, and the end error that is a failure."""

    bands: list[Metres] = []
    tracking_from: Seconds | None = None
    fail_error: Metres = 1e-3


class SignalTolerance(Table):
    """What a signal may differ from its baseline: absolute (SI) plus relative times the expected value."""

    absolute: Annotated[float, BeforeValidator(parse_quantity), Field(ge=0.0)] = 0.0
    relative: Annotated[float, Field(ge=0.0)] = 0.0


class CheckSettings(Table):
    """Which signals a baseline holds, how often, and how closely a run must follow them."""

    interval: Annotated[Seconds, Field(gt=0.0)] = 0.05
    signals: dict[str, SignalTolerance] = {}


class Scenario(Table):
    """One experiment.

    The FMUs are stepped in the order of `fmus`. All quantities are SI.
    """

    name: str
    title: str
    description: str = ""
    figures: list[str] = []
    stop_time: Annotated[Seconds, Field(gt=0.0)]
    step: Annotated[Seconds, Field(gt=0.0)]
    output_interval: Annotated[Seconds, Field(gt=0.0)]
    fmus: dict[str, Fmu] = Field(min_length=1)
    connections: list[tuple[str, str]] = []   # from an output to an input
    signals: list[Signal] = []
    axes: dict[str, Axis] = {}
    motors: dict[str, Motor] = {}
    stop_flag: str | None = None
    trip_flag: str | None = None
    metrics: MetricSettings = MetricSettings()
    check: CheckSettings = CheckSettings()
    claims: list[Claim] = []
    _path: Path = PrivateAttr(default=Path("scenario"))

    @model_validator(mode="before")
    @classmethod
    def output_every_step(cls, table: Any) -> Any:
        """Without `output_interval`, record every communication step."""
        if isinstance(table, dict) and "output_interval" not in table and "step" in table:
            return {**table, "output_interval": table["step"]}
        return table

    @model_validator(mode="after")
    def whole_steps(self) -> "Scenario":
        """Refuse times that are not whole numbers of communication steps."""
        for key in ("output_interval", "stop_time"):
            steps = getattr(self, key) / self.step
            if round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps:
                raise key_refused(key, getattr(self, key), f"expected a multiple of step = {self.step} s")
        return self

    @model_validator(mode="after")
    def judgeable_claims(self) -> "Scenario":
        """Refuse a claim about an axis, motor or band that is not measured."""
        for i, claim in enumerate(self.claims):
            for key, names, known in (("axes", claim.axes, self.axes), ("motors", claim.motors, self.motors)):
                for name in names or ():
                    if name not in known:
                        raise key_refused(key, name, f"not in [{key}], nearest is {nearest(name, known)}", "claims", i)
            if claim.band is not None and claim.band not in self.metrics.bands:
                raise key_refused("band", claim.band, f"expected one of metrics.bands, {self.metrics.bands} m",
                                  "claims", i)
            if claim.metric in TRACKING_METRICS and self.metrics.tracking_from is None:
                raise key_refused("metric", claim.metric, "expected metrics.tracking_from to be given", "claims", i)
            if claim.than is None and claim.than_axis is not None and claim.than_axis not in self.axes:
                raise key_refused("than_axis", claim.than_axis,
                                  f"not in [axes], nearest is {nearest(claim.than_axis, self.axes)}", "claims", i)
        return self

    @property
    def path(self) -> Path:
        """The file the scenario was read from."""
        return self._path

    @property
    def steps(self) -> int:
        """Number of communication steps."""
        return round(self.stop_time / self.step)

    @property
    def output_every(self) -> int:
        """Number of communication steps between two recorded samples."""
        return round(self.output_interval / self.step)


def packaged_scenarios() -> list[str]:
    """Return the names of the scenarios that come with the package."""
    return sorted(path.stem for path in PACKAGED.glob("*.toml"))


@cache
def packaged_runs() -> dict[str, str]:
    """Names of all runs that come with the package, one for each variant, and the scenarios that they belong to."""
    return {run: name for name in packaged_scenarios() for run in runs_in(read_layers(PACKAGED / f"{name}.toml"))}


def runs_in(layers: list[Layer]) -> list[str]:
    """Names of the runs that a scenario file defines."""
    table = merged(layers)
    variants = table.get("variants")
    names = [f"{table.get('name')}-{variant}" for variant in variants] if isinstance(variants, dict) else []
    return names or [str(table.get("name"))]


def load_runs(name_or_path: str | Path) -> list[Scenario]:
    """Load a packaged scenario, or one run of it, by its bare name, or any other scenario by its path.

    Returns
    -------
    list of Scenario
        One run for each variant of the scenario, or the one that is named.

    Raises
    ------
    ScenarioError
        If there is no such scenario, or something in it is not as expected; one line with file, key, value and
        what was expected.
    """
    path = Path(name_or_path)
    if path.name == str(name_or_path) and path.suffix != ".toml":
        names = {name: name for name in packaged_scenarios()} | packaged_runs()
        if path.name not in names:
            raise ScenarioError(f"there is no scenario {path.name!r}; nearest is {nearest(path.name, names)}")
        runs = read_runs(PACKAGED / f"{names[path.name]}.toml")
        return [run for run in runs if run.name == path.name] or runs
    return read_runs(path)


def load_scenario(name_or_path: str | Path) -> Scenario:
    """Load a single run; see `load_runs`."""
    runs = load_runs(name_or_path)
    if len(runs) != 1:
        raise ScenarioError(f"{name_or_path} has variants, expected one of {', '.join(run.name for run in runs)}")
    return runs[0]


def read_runs(path: Path) -> list[Scenario]:
    """Runs of a scenario file: one for each entry of its table `variants`, or the scenario itself.

    A variant is merged over the scenario; its claims come after the scenario's own.
    """
    layers = read_layers(path)
    table = merged(layers)
    variants = table.get("variants", {})
    if not isinstance(variants, dict) or not all(isinstance(variant, dict) for variant in variants.values()):
        raise ScenarioError(f"{path}: variants = {variants!r}: expected tables, one for each variant")
    base = [Layer(layer.path, {key: value for key, value in layer.table.items() if key != "variants"})
            for layer in layers]
    if not variants:
        return [read_run(path, base, runs_in(layers))]
    runs = []
    for name, variant in variants.items():
        claims = [*table.get("claims", []), *variant.get("claims", [])]
        over = {**variant, "name": f"{table.get('name')}-{name}", "claims": claims}
        runs.append(read_run(path, [*base, *extended(Layer(path, over))], runs_in(layers)))
    return runs


def read_run(path: Path, layers: list[Layer], siblings: list[str]) -> Scenario:
    """Scenario of one run; `siblings` are the runs of its file."""
    try:
        scenario = Scenario.model_validate(merged(layers))
    except ValidationError as error:
        raise ScenarioError(one_line(error, layers)) from None
    for claim in scenario.claims:
        if claim.than is not None and claim.than not in siblings and claim.than not in packaged_runs():
            raise ScenarioError(f"{path}: claims.than = {claim.than!r}: there is no such run; nearest is "
                                f"{nearest(claim.than, [*siblings, *packaged_runs()])}")
    scenario._path = path
    return scenario
