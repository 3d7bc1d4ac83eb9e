"""The plan of a run: which FMUs run together, on which references, and what is measured and claimed."""

from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator, Field, PlainValidator, PrivateAttr, StrictBool, model_validator

from maglev.errors import key_path, nearest
from maglev.own_stage.reading import read_own
from maglev.schema.claims import RunClaim
from maglev.schema.procedure import ProcedureSettings
from maglev.schema.signals import Signal
from maglev.schema.toml_table import Metres, Radians, Seconds, Table, key_refused
from maglev.units import parse_quantity, read_quantity
from pmlsm.rig import Rig
from pmlsm.rigs import rig_of

MOST_STEPS = 1e8   # communication steps of a run


class StartValue(NamedTuple):
    """A start value in SI, the unit it was written in (None for a plain number or a Boolean), and the text.

    `origin` is where it was written if not in the scenario file, such as "--set plant.y.mass=7".
    """

    value: float | int | bool
    unit: str | None
    written: float | int | bool | str
    origin: str = ""


def read_start_value(value: Any) -> StartValue:
    """Read a Boolean, a number, or text with a unit."""
    if isinstance(value, bool):
        return StartValue(value, None, value)
    if isinstance(value, int):
        read_quantity(value)   # refuses what no float can hold
        return StartValue(value, None, value)
    return StartValue(*read_quantity(value), value)


class RunOutput(Table):
    """What an output, `fmu.variable`, of another run is at the end of that run."""

    run: str
    output: str


class FmuTable(Table):
    """One FMU: a model that this project builds, or a file.

    `start` has its start values by variable name, `start_from` those that are results of other runs, and `inputs` the
    outputs, `fmu.variable`, that feed its inputs. `inherited` has those of the model or file whose place it takes in a
    file that extends another.
    """

    model: str | None = None
    file: str | None = None
    start: dict[str, Annotated[StartValue, PlainValidator(read_start_value)]] = {}
    inherited: dict[str, Annotated[StartValue, PlainValidator(read_start_value)]] = {}
    start_from: dict[str, RunOutput] = {}
    inputs: dict[str, str] = {}
    before: str | None = None

    @model_validator(mode="after")
    def one_source(self) -> "FmuTable":
        """Refuse an FMU that is neither or both."""
        if (self.model is None) == (self.file is None):
            raise ValueError("expected either model, the name of an FMU of this project, or file, the path of an FMU")
        return self


class Axis(Table):
    """Names of the recorded variables of an axis, and whether it points along gravity or is a rotation."""

    position: str
    reference: str
    vertical: StrictBool = False
    rotation: StrictBool = False

    @property
    def unit(self) -> str:
        """SI unit of its position."""
        return "rad" if self.rotation else "m"


class Motor(Table):
    """Names of the recorded currents of a motor."""

    currents: list[str] = []
    commands: list[str] = []


class MetricSettings(Table):
    """What is measured: settling bands, the start of steady tracking, and the end error that is a failure.

    `tilt_bands` and `fail_tilt` are those of rotations.
    """

    bands: list[Metres] = []
    tilt_bands: list[Radians] = []
    tracking_from: Seconds | None = None
    fail_error: Metres = 1e-3
    fail_tilt: Radians = 5e-3   # 1 mm at the motors of the 5-DOF stage, 200 mm from the centre

    def bands_of(self, axis: Axis) -> list[float]:
        """Settling bands of an axis, m or rad."""
        return self.tilt_bands if axis.rotation else self.bands

    def fail_error_of(self, axis: Axis) -> float:
        """Error (m or rad) of an axis that is a failure."""
        return self.fail_tilt if axis.rotation else self.fail_error


class Event(Table):
    """Something that happens to a run, such as a push: what is measured in the window from its time to its end.

    Without `end` the window goes to the next event, that of the last one to the end of the run.
    """

    name: Annotated[str, Field(min_length=1)]
    time: Annotated[Seconds, Field(ge=0.0)]
    end: Seconds | None = None


class SignalTolerance(Table):
    """What a signal may differ from its baseline: absolute (SI) plus relative times the expected value."""

    absolute: Annotated[float, BeforeValidator(parse_quantity), Field(ge=0.0)] = 0.0
    relative: Annotated[float, Field(ge=0.0)] = 0.0


class CheckSettings(Table):
    """Which signals a baseline holds, how often, and how closely a run must follow them.

    `through_contact` says that it does not end where a stop is touched or the controller trips.
    """

    interval: Annotated[Seconds, Field(gt=0.0)] = 0.05
    through_contact: StrictBool = False
    signals: dict[str, SignalTolerance] = {}


class RunPlan(Table):
    """One run of a scenario file: the scenario itself, or one of its variants merged over it.

    The FMUs are stepped in the order of `fmus`. All quantities are SI.
    """

    rig_file: str | None = Field(default=None, alias="rig")   # description of a stage of the user's
    name: Annotated[str, Field(pattern=r"^\w[\w.+-]*$")]   # results are named after it: it is no path
    title: str
    description: str = ""
    figures: list[str] = []
    check_only: StrictBool = False   # no experiment: flown by name and by the check of everything
    another_reading: StrictBool = False   # of an experiment that has its run: claims are judged, and not counted
    stop_time: Annotated[Seconds, Field(gt=0.0)]
    step: Annotated[Seconds, Field(gt=0.0)]
    output_interval: Annotated[Seconds, Field(gt=0.0)]
    fmus: dict[str, FmuTable] = Field(min_length=1)
    connections: list[tuple[str, str]] = []   # from an output to an input; see also `wires`
    signals: list[Signal] = []
    axes: dict[str, Axis] = {}
    motors: dict[str, Motor] = {}
    stop_flag: str | None = None
    trip_flag: str | None = None
    metrics: MetricSettings = MetricSettings()
    events: list[Event] = []
    check: CheckSettings = CheckSettings()
    claims: list[RunClaim] = []
    procedure: ProcedureSettings | None = None
    _path: Path = PrivateAttr(default=Path("scenario"))
    _own: bool = PrivateAttr(default=False)
    _sha256: str = PrivateAttr(default="")

    @model_validator(mode="before")
    @classmethod
    def output_every_step(cls, table: Any) -> Any:
        """Without `output_interval`, record every communication step."""
        if isinstance(table, dict) and "output_interval" not in table and "step" in table:
            return {**table, "output_interval": table["step"]}
        return table

    @model_validator(mode="before")
    @classmethod
    def in_order(cls, table: Any) -> Any:
        """Put FMUs that are to be stepped `before` others in front of these; without it the order is the table's."""
        fmus = table.get("fmus") if isinstance(table, dict) else None
        if not isinstance(fmus, dict):
            return table
        order = list(fmus)
        later = {name: fmu["before"] for name, fmu in fmus.items() if isinstance(fmu, dict) and "before" in fmu}
        for name, other in later.items():
            if other not in fmus or other == name:
                raise key_refused("before", other, "expected another FMU of this scenario, nearest is "
                                  f"{nearest(str(other), [each for each in fmus if each != name])}", "fmus", name)
        for _ in fmus:
            for name, other in later.items():
                if order.index(name) > order.index(other):
                    order.remove(name)
                    order.insert(order.index(other), name)
        for name, other in later.items():
            if order.index(name) > order.index(other):
                raise key_refused("before", other, "expected no FMUs that are to be stepped before each other",
                                  "fmus", name)
        return {**table, "fmus": {name: fmus[name] for name in order}}

    @model_validator(mode="after")
    def whole_steps(self) -> "RunPlan":
        """Refuse times that are not whole numbers of communication steps."""
        for key in ("output_interval", "stop_time"):
            steps = getattr(self, key) / self.step
            if not steps <= MOST_STEPS:
                raise key_refused(key, getattr(self, key), f"{steps:.3g} steps of {self.step} s, expected at most "
                                                           f"{MOST_STEPS:.0e}")
            if round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps:
                raise key_refused(key, getattr(self, key), f"expected a multiple of step = {self.step} s")
        return self

    @model_validator(mode="after")
    def events_in_order(self) -> "RunPlan":
        """Refuse events that have the name of another, do not ascend, or have a window that is not of the run."""
        for i, (event, end) in enumerate(zip(self.events, self.event_ends, strict=True)):
            before = self.events[:i]
            if event.name in [each.name for each in before]:
                raise key_refused("name", event.name, "expected another name than an earlier event has", "events", i)
            if before and event.time <= before[-1].time:
                raise key_refused("time", event.time, f"expected ascending times, {before[-1].name} is at "
                                                      f"{before[-1].time} s", "events", i)
            if event.time >= self.stop_time:
                raise key_refused("time", event.time, f"expected before stop_time = {self.stop_time} s", "events", i)
            if event.end is not None and not event.time < end <= self.stop_time:
                raise key_refused("end", end, f"expected a time after {event.time} s, and stop_time = "
                                              f"{self.stop_time} s at most", "events", i)
        return self

    @model_validator(mode="after")
    def judgeable_claims(self) -> "RunPlan":
        """Refuse a claim about an axis, motor, event or band that is not measured."""
        for i, claim in enumerate(self.claims):
            for key, names, known in (("axes", claim.axes, self.axes), ("motors", claim.motors, self.motors)):
                for name in names or ():
                    if name not in known:
                        raise key_refused(key, name, f"not in [{key}], nearest is {nearest(name, known)}", "claims", i)
            events = [event.name for event in self.events]
            if claim.measured is not None and claim.measured.on in ("event", "effort") and not events:
                raise key_refused("metric", claim.quantity, "expected [[events]] to be given", "claims", i)
            if claim.event is not None and claim.event not in events:
                raise key_refused("event", claim.event, f"not in [[events]], nearest is {nearest(claim.event, events)}",
                                  "claims", i)
            for name in (claim.axes or self.axes) if claim.of_one_unit else ():
                if self.axes[name].unit != claim.axis_unit:
                    raise key_refused("axes", claim.axes, f"{name} is in {self.axes[name].unit}, expected axes in "
                                                          f"{claim.axis_unit} alone, as the claim is", "claims", i)
            bands = self.metrics.bands if claim.axis_unit == "m" else self.metrics.tilt_bands
            if claim.band is not None and claim.band not in bands:
                key = "bands" if claim.axis_unit == "m" else "tilt_bands"
                raise key_refused("band", claim.band, f"expected one of metrics.{key}, {bands} {claim.axis_unit}",
                                  "claims", i)
            if claim.measured is not None and claim.measured.on == "tracking" and self.metrics.tracking_from is None:
                raise key_refused("metric", claim.quantity, "expected metrics.tracking_from to be given", "claims", i)
            if claim.than is None and claim.than_axis is not None and claim.than_axis not in self.axes:
                raise key_refused("than_axis", claim.than_axis,
                                  f"not in [axes], nearest is {nearest(claim.than_axis, self.axes)}", "claims", i)
        return self

    @property
    def wires(self) -> dict[str, tuple[str, str]]:
        """Connections from an output to an input, by their keys in the file: those in `connections` come first."""
        own = {key_path(["fmus", name, "inputs", variable]): (source, f"{name}.{variable}")
               for name, fmu in self.fmus.items() for variable, source in fmu.inputs.items() if source}
        return {f"connections[{i}]": pair for i, pair in enumerate(self.connections)} | own

    @property
    def axis_names(self) -> set[str]:
        """Names of the axes that are measured or that have start values: a run may measure none."""
        return {*self.axes, *(variable.partition(".")[0] for fmu in self.fmus.values() for variable in fmu.start)}

    @property
    def rig(self) -> Rig | None:
        """The rig that it is about: as described, or by its FMUs or else by its axes; None if it is about none."""
        if self.rig_file is not None:
            return read_own(Path(self.rig_file))
        return rig_of((fmu.model for fmu in self.fmus.values() if fmu.model), self.axis_names)

    @property
    def plants(self) -> set[str]:
        """FMUs whose positions are measured: their parameters are conditions of the experiment, as inputs are.

        Parameters of the others, such as gains and limits, are settings of a design, and mean something to that design.
        """
        return {"plant", *(axis.position.partition(".")[0] for axis in self.axes.values())}

    @property
    def needs(self) -> set[str]:
        """Names of the runs whose results this one starts from."""
        return {source.run for fmu in self.fmus.values() for source in fmu.start_from.values()}

    @property
    def path(self) -> Path:
        """The file the scenario was read from."""
        return self._path

    @property
    def own(self) -> bool:
        """Whether it is of a user's file, not of the package's."""
        return self._own

    @property
    def sha256(self) -> str:
        """SHA-256 of what the file and those that it extends say of this run; empty if it was read from none."""
        return self._sha256

    @property
    def steps(self) -> int:
        """Number of communication steps."""
        return round(self.stop_time / self.step)

    @property
    def event_ends(self) -> list[float]:
        """Ends of the windows of its events, s."""
        later = [*(event.time for event in self.events[1:]), self.stop_time]
        return [after if event.end is None else event.end for event, after in zip(self.events, later, strict=False)]

    @property
    def output_every(self) -> int:
        """Number of communication steps between two recorded samples."""
        return round(self.output_interval / self.step)
