"""The plan of a run: its FMUs, references, metrics and claims."""

from math import nan
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from pydantic import BeforeValidator, Field, PlainValidator, PrivateAttr, StrictBool, field_validator, model_validator

from maglev.descriptions.packaged import best_stage
from maglev.files.errors import QuantityError, key_path, nearest
from maglev.files.time_grid import ON_GRID, whole_steps
from maglev.files.units import known_unit, own_number, parse_quantity, read_quantity, split_text
from maglev.scenario.claims import RunClaim
from maglev.scenario.layers import ScenarioSource, entries
from maglev.scenario.procedure import ProcedureSettings
from maglev.scenario.signals import Csv, Signal, Steps
from maglev.scenario.toml_table import Metres, Radians, Seconds, Table, ValueKind, key_refused
from maglev.user.reading import read_own
from pmlsm.stage_description import StageDescription


class StartValue(NamedTuple):
    """A start value in SI, its written unit (None for a plain number or a Boolean), and its text.

    `origin` is its source if that is not the scenario file, such as "--set plant.y.mass=7". `file` is a parameter set,
    whose values are not for inputs with a signal or connection. `text` is that of a String variable, or the name of an
    item of an Enumeration; the value is NaN then.
    """

    value: float | int | bool
    unit: str | None
    written: float | int | bool | str
    origin: str = ""
    file: str = ""
    text: str | None = None

    @property
    def given(self) -> float | int | bool | str:
        """Return the value for the FMU."""
        return self.value if self.text is None else self.text


def read_start_value(value: Any) -> StartValue:
    """Read a Boolean, a number, or text with a unit."""
    value = own_number(value)
    if isinstance(value, bool):
        return StartValue(value, None, value)
    si, unit = read_quantity(value)   # refuses what no float can hold
    return StartValue(value if isinstance(value, int) else si, unit, value)


def read_allowed(value: Any) -> StartValue:
    """Read an allowed deviation: a quantity of 0 or more."""
    start = StartValue(*read_quantity(value), value)
    if start.value < 0.0:
        raise ValueError("expected 0 or more")
    return start


def read_open_value(value: Any) -> StartValue:
    """Read a value, but leave text in a unit that only the FMU may know, or that is no quantity."""
    if isinstance(value, str):
        try:
            number, unit = split_text(value)
        except QuantityError:
            return StartValue(nan, None, value, text=value)
        if known_unit(unit) is None:
            return StartValue(number, unit, value)
    return read_start_value(value)


Start = Annotated[StartValue, PlainValidator(read_open_value), ValueKind("quantity")]


class RunOutput(Table):
    """An output, `fmu.variable`, of another run at the end of that run."""

    PLACE = "[fmus.NAME.start_from]"

    run: str = Field(description="name of the other run, of this file or of the package")
    output: str = Field(description="output of that run, `fmu.variable`")


class FmuTable(Table):
    """One FMU: a model that this project builds, or a file."""

    PLACE = "[fmus.NAME]"

    model: str | None = Field(default=None, description="an FMU that `maglev build` makes, by its name; or `file`")
    file: str | None = Field(default=None, description="path of an FMU, or of a Python file with a class, from the "
                                                       "folder of the scenario; it overrides `model` of a base file")
    start: dict[str, Start] = Field(default={}, description="start values of parameters and inputs, by variable")
    inherited: dict[str, Start] = {}   # start values of the FMU that it replaces in a file that extends another
    start_from: dict[str, RunOutput] = Field(default={}, description="start values that are results of other runs, by "
                                             "variable")
    inputs: dict[str, str] = Field(default={}, description="connections: an output `fmu.variable` by the name of the "
                                                           "input, or empty for no connection; they override those of "
                                                           "base files")
    before: str | None = Field(default=None, description="name of the FMU before which this one steps; without it the "
                                                         "order is that of the table")

    @model_validator(mode="after")
    def one_source(self) -> "FmuTable":
        """Refuse an FMU with neither or both of model and file."""
        if (self.model is None) == (self.file is None):
            raise ValueError("expected either model, the name of an FMU of this project, or file, the path of an FMU")
        if self.model is not None and self.model.endswith((".fmu", ".py")):
            raise key_refused("model", self.model, "expected the name of an FMU of this project; of a path the key is "
                              "file")
        if self.model is not None:
            for name, start in self.start.items():
                try:
                    parse_quantity(start.written) if isinstance(start.written, str) else None
                except QuantityError as error:
                    raise key_refused(name, start.written, str(error), "start") from None
        return self


class Axis(Table):
    """Names of the recorded variables of an axis, and whether it points along gravity or is a rotation."""

    PLACE = "[axes.NAME]"

    position: str = Field(description="measured output `fmu.variable`")
    reference: str = Field(description="its reference, an input or output `fmu.variable`")
    vertical: StrictBool = Field(default=False, description="true if the axis points along gravity, for the picture "
                                                            "in the report")
    rotation: StrictBool = Field(default=False, description="true if the axis is a rotation, in rad")

    @property
    def unit(self) -> str:
        """Return the SI unit of its position."""
        return "rad" if self.rotation else "m"


class Motor(Table):
    """Names of the recorded currents of a motor."""

    PLACE = "[motors.NAME]"

    currents: list[str] = Field(default=[], description="delivered currents, outputs `fmu.variable`, for the peak and "
                                                        "the mean current")
    commands: list[str] = Field(default=[], description="commanded currents, outputs `fmu.variable`, for the peak and "
                                                        "the mean command")


class MetricSettings(Table):
    """Settings of the metrics: settling bands, the start of steady tracking, and the allowed error at the end."""

    PLACE = "[metrics]"

    bands: list[Annotated[Metres, Field(gt=0.0)]] = Field(
        default=[], description="bands around a setpoint, each with a settling time")
    tilt_bands: list[Annotated[Radians, Field(gt=0.0)]] = Field(default=[], description="the same for rotations")
    tracking_from: Seconds | None = Field(default=None, description="time after which tracking errors of a moving "
                                                                    "reference count")
    fail_error: Metres = Field(default=1e-3, gt=0.0, description="a run with a larger error at its end ended off "
                                                                 "target")
    fail_tilt: Radians = Field(   # 1 mm at the motors of the 5-DOF stage, 200 mm from the centre
        default=5e-3, gt=0.0, description="the same for rotations")

    def bands_of(self, axis: Axis) -> list[float]:
        """Return the settling bands of an axis, m or rad."""
        return self.tilt_bands if axis.rotation else self.bands

    def fail_error_of(self, axis: Axis) -> float:
        """Return the error (m or rad) of an axis beyond which a run ends off target."""
        return self.fail_tilt if axis.rotation else self.fail_error


class Event(Table):
    """An event of a run, such as a push, with the window in which its effect is measured."""

    PLACE = "[[events]]"

    name: str = Field(min_length=1, description="name of the event, such as push of x")
    time: Seconds = Field(ge=0.0, description="time of the event, at which its window begins")
    end: Seconds | None = Field(default=None, description="end of its window; otherwise the next event, the next step "
                                                          "of a reference, or the end of the run")


class SignalTolerance(Table):
    """The allowed deviation of a signal from its baseline: absolute (SI) plus relative times the expected value."""

    PLACE = "[check.signals]"

    allowed: Annotated[StartValue, BeforeValidator(read_allowed), ValueKind("quantity")] = Field(
        default=StartValue(0.0, None, 0.0), alias="absolute",
        description="allowed deviation from the baseline, in the unit of the signal")
    relative: float = Field(default=0.0, ge=0.0, description="additional allowed deviation, as a share of the "
                                                             "expected value")

    @property
    def absolute(self) -> float:
        """Return the absolute part in SI."""
        return float(self.allowed.value)


class CheckSettings(Table):
    """Signals of a baseline, their sampling, and the tolerances of a run."""

    PLACE = "[check]"

    interval: Seconds = Field(default=0.05, gt=0.0, description="time between two samples of the baseline")
    through_contact: StrictBool = Field(default=False, description="true if the baseline continues after a stop is "
                                                                   "touched or the controller trips")
    signals: dict[str, SignalTolerance] = Field(default={}, description="tolerances of the compared signals, by "
                                                                        "`fmu.variable`")


class RunPlan(Table):
    """One run of a scenario file: the scenario itself, or one of its variants merged over it.

    The FMUs are stepped in the order of `fmus`. All quantities are SI.
    """

    PLACE = "the file itself"

    stage_file: str | None = Field(default=None, alias="stage",
                                   description="path of the description of your own stage, whose loop the file extends")
    name: str = Field(pattern=r"^\w[\w.+-]*$", description="name of the run and of its results: "
                                                           "letters, digits, and _ . + -")   # it is no path
    title: str = Field(description="title of a few words")
    description: str = Field(default="", description="description of one or two sentences")
    figures: list[str] = Field(default=[], description="numbers of the thesis's figures that it repeats")
    check_only: StrictBool = Field(default=False, description="true if it is no experiment: it runs only by its name, "
                                                              "and in `maglev check` of all runs")
    another_reading: StrictBool = Field(default=False, description="true if it is an alternative interpretation of an "
                                                                   "experiment: its claims are judged, but not "
                                                                   "counted")
    chose: str | None = Field(default=None, description="parameter that was chosen to fit the claims, which are "
                                                        "then not independent: for all claims without their own "
                                                        "`chose`")
    stop_time: Seconds = Field(gt=0.0, description="end of the run, a multiple of `step`")
    step: Seconds = Field(gt=0.0, description="communication step, in which FMUs exchange values once")
    output_interval: Seconds = Field(gt=0.0, description="time between two rows of the results, a multiple of `step`. "
                                                         "Metrics use every step")
    fmus: dict[str, FmuTable] = Field(min_length=1, description="the simulated FMUs, by names that you choose, in the "
                                                                "order of stepping")
    connections: list[tuple[str, str]] = Field(default=[], description="pairs of an output and its input, "
                                                                       "`fmu.variable`; see also `inputs` of an FMU")
    signals: list[Signal] = Field(default=[], description="signals of inputs and tunable parameters: references, "
                                                          "disturbances, faults")
    axes: dict[str, Axis] = Field(default={}, description="measured positions, by name of the axis")
    motors: dict[str, Motor] = Field(default={}, description="measured currents, by name of the motor")
    stop_flag: str | None = Field(default=None, description="Boolean output `fmu.variable` that is true while a stop "
                                                            "is touched: the run has failed")
    trip_flag: str | None = Field(default=None, description="Boolean output `fmu.variable` that is true after the "
                                                            "controller tripped: the run has failed")
    metrics: MetricSettings = Field(default=MetricSettings(), description="settings of the metrics")
    events: list[Event] = Field(default=[], description="events, in whose windows disturbances are measured")
    check: CheckSettings = Field(default=CheckSettings(), description="content and tolerances of the baseline")
    claims: list[RunClaim] = Field(default=[], description="claims about the run")
    procedure: ProcedureSettings | None = Field(default=None, description="the procedure that the runs belong to")
    _source: ScenarioSource = PrivateAttr(default=Path("scenario"))
    _own: bool = PrivateAttr(default=False)
    _sha256: str = PrivateAttr(default="")

    @model_validator(mode="before")
    @classmethod
    def completed(cls, table: Any) -> Any:
        """Record every communication step without `output_interval`; copy the run's `chose` to its claims in words.

        Signals to an FMU that is not of this project may be in units that it declares.
        """
        if not isinstance(table, dict):
            return table
        table = {"output_interval": table["step"], **table} if "step" in table else dict(table)
        if "chose" in table and isinstance(table.get("claims"), list):
            table["claims"] = [{"chose": table["chose"], **claim} if isinstance(claim, dict)
                               and not {"figure", "not_testable", "own"} & {*claim} else claim
                               for claim in table["claims"]]
        files = {name for name, fmu in entries(table.get("fmus")).items() if isinstance(fmu, dict) and "file" in fmu}
        if files and isinstance(table.get("signals"), list):
            table["signals"] = [{**signal, "open_unit": True} if isinstance(signal, dict)
                                and str(signal.get("to")).partition(".")[0] in files else signal
                                for signal in table["signals"]]
        return table

    @field_validator("fmus")
    @classmethod
    def in_order(cls, fmus: dict[str, FmuTable]) -> dict[str, FmuTable]:
        """Put FMUs that have `before` in front of the named ones; the others keep the order of the table."""
        order = list(fmus)
        later = {name: fmu.before for name, fmu in fmus.items() if fmu.before is not None}
        for name, other in later.items():
            if other not in fmus or other == name:
                raise key_refused("before", other, "expected another FMU of this scenario, "
                                  f"{nearest(other, [fmu for fmu in fmus if fmu != name])}", name)
        for _ in fmus:
            for name, other in later.items():
                if order.index(name) > order.index(other):
                    order.remove(name)
                    order.insert(order.index(other), name)
        for name, other in later.items():
            if order.index(name) > order.index(other):
                raise key_refused("before", other, "expected no FMUs that are to be stepped before each other", name)
        return {name: fmus[name] for name in order}

    @model_validator(mode="after")
    def times_that_fit(self) -> "RunPlan":
        """Refuse times that are not whole steps, tables next to the run, and tracking from after the end on."""
        for key in ("output_interval", "stop_time"):
            try:
                whole_steps(getattr(self, key), self.step)
            except QuantityError as error:
                raise key_refused(key, getattr(self, key), str(error)) from None
        for i, signal in enumerate(self.signals):
            if isinstance(signal, Csv) and (why := signal.misfit(self.stop_time)):
                raise key_refused("file", signal.file, why, "signals", i)
        begin = self.metrics.tracking_from
        if begin is not None and begin > self.stop_time:
            raise key_refused("tracking_from", begin, f"expected stop_time = {self.stop_time} s at most", "metrics")
        return self

    @model_validator(mode="after")
    def events_in_order(self) -> "RunPlan":
        """Refuse events that have the name of another, do not ascend, or have a window that is not of the run."""
        for i, (event, end) in enumerate(zip(self.events, self.event_ends, strict=True)):
            before = self.events[:i]
            if event.name in [earlier.name for earlier in before]:
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
                        raise key_refused(key, name, f"not in [{key}], {nearest(name, known)}", "claims", i)
            events = [event.name for event in self.events]
            if claim.measured is not None and claim.measured.on in ("event", "effort") and not events:
                raise key_refused("metric", claim.quantity, "expected [[events]] to be given", "claims", i)
            if claim.event is not None and claim.event not in events:
                raise key_refused("event", claim.event, f"not in [[events]], {nearest(claim.event, events)}",
                                  "claims", i)
            if claim.of_one_unit:
                for name in claim.axes or self.axes:
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
                                  f"not in [axes], {nearest(claim.than_axis, self.axes)}", "claims", i)
        return self

    @property
    def wires(self) -> dict[str, tuple[str, str]]:
        """Return the connections from outputs to inputs, by their keys in the file: those in `connections` come first.
        """
        own = {key_path(["fmus", name, "inputs", variable]): (source, f"{name}.{variable}")
               for name, fmu in self.fmus.items() for variable, source in fmu.inputs.items() if source}
        return {f"connections[{i}]": pair for i, pair in enumerate(self.connections)} | own

    @property
    def axis_names(self) -> set[str]:
        """Return the names of the axes that are measured or that have start values; the list may be empty."""
        return {*self.axes, *(variable.partition(".")[0] for fmu in self.fmus.values() for variable in fmu.start)}

    @property
    def stage(self) -> StageDescription | None:
        """Return the stage: as described, or by its FMUs or else by its axes; None if there is none."""
        if self.stage_file is not None:
            return read_own(Path(self.stage_file))
        return best_stage((fmu.model for fmu in self.fmus.values() if fmu.model), self.axis_names)

    @property
    def plants(self) -> set[str]:
        """Return the FMUs whose positions are measured. Their parameters are conditions of the experiment, as inputs
        are.

        Parameters of the others, such as gains and limits, are settings of a design, and mean something to that design.
        """
        return {"plant", *(axis.position.partition(".")[0] for axis in self.axes.values())}

    @property
    def needs(self) -> set[str]:
        """Return the names of the runs whose results this one starts from."""
        return {source.run for fmu in self.fmus.values() for source in fmu.start_from.values()}

    @property
    def source(self) -> ScenarioSource:
        """Return the file or the table that it is read from."""
        return self._source

    @property
    def own(self) -> bool:
        """Return True if the run is of a user's file."""
        return self._own

    @property
    def sha256(self) -> str:
        """Return the SHA-256 of this run's part of its files, with those that they extend; empty without a file."""
        return self._sha256

    @property
    def steps(self) -> int:
        return whole_steps(self.stop_time, self.step)

    @property
    def event_ends(self) -> list[float]:
        """Return the ends of the windows of its events, s: the stated ones, or the start of the next event or reference
        step.
        """
        begins = sorted({*(event.time for event in self.events), *(time for time, _ in self.jumps(references=True))})
        return [next((time for time in begins if time > event.time + ON_GRID * self.step), self.stop_time)
                if event.end is None else event.end for event in self.events]

    @property
    def disturbances(self) -> list[tuple[float, str]]:
        """Return the times (s) that end the windows of steps, with names: events, and jumps of inputs but references.

        The name is that of the event, or of the input.
        """
        return [*((event.time, event.name) for event in self.events), *self.jumps(references=False)]

    def jumps(self, references: bool) -> list[tuple[float, str]]:
        """Return the times (s) at which signals jump from one value to another, and the inputs that they feed."""
        measured = {axis.reference for axis in self.axes.values()}
        return [(time, signal.to) for signal in self.signals
                if isinstance(signal, Steps) and (signal.to in measured) == references
                for time, before, after in zip(signal.times[1:], signal.values, signal.values[1:], strict=False)
                if before != after]

    @property
    def windows(self) -> list[tuple[str, float, float]]:
        """Return the begin and the end (s) of the windows of its events, by name."""
        return [(event.name, event.time, end) for event, end in zip(self.events, self.event_ends, strict=True)]
