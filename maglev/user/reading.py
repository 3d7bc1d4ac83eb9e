"""Description of a user's stage: omitted values are completed from its data sheet and its poles."""

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any

from maglev.descriptions import EXAMPLE
from maglev.descriptions.data_sheet import Catalogue, Field, catalogue_constants, field_geometry, twelve_digits
from maglev.descriptions.description_file import Reader
from maglev.descriptions.packaged import PACKAGED_STAGES
from maglev.files.errors import StageError, one_of
from maglev.files.toml_file import read_toml, toml_text
from maglev.user.gain_design import axis_design, designed_rates, gains_of_poles, unstable_rate, wanted_sample_time
from maglev.user.motor import MOTORS, packaged_tables
from pmlsm.stage_description import Constants, Estimator, MotorKind, StageDescription, StageMotor

Table = dict[str, Any]

KIND = ("geometry", "catalogue", "field")   # tables that a motor can have for itself


def read_own(path: Path) -> StageDescription:
    """Read a description, which may have a catalogue, a field and poles; omitted values of the design are designed.

    StageError, ScenarioError as in `read_stage`.
    """
    if str(path) in PACKAGED_STAGES and not path.exists():
        raise StageError(f"{path}: is a packaged stage, expected the description of your own, NAME.toml")
    return stage_from_text(path, toml_text(path))


@lru_cache(maxsize=32)   # a run asks for its stage a dozen times, and the design takes its time
def stage_from_text(path: Path, text: str) -> StageDescription:
    """Return the stage in the text of a description; errors as in `read_own`."""
    table, reader = read_toml(path, text), Reader(path)
    if "extends" in table or isinstance(table.get("stage"), str):
        raise StageError(f"{path}: is a scenario, expected the description of a stage")
    put_packaged_motors(reader, table)
    unlike = unlike_motors(table)
    sheet = reader.read(Catalogue, table.pop("catalogue"), "catalogue") if "catalogue" in table else None
    sheets = {name: sheet if "catalogue" not in of else reader.read(Catalogue, of["catalogue"],
                                                                    f"motors.{name}.catalogue")
              for name, of in unlike.items()}
    field = reader.read(Field, table.pop("field"), "field") if "field" in table else None
    with_model, with_estimator = "model" in table, "estimator" in table
    if (sheet is None) == ("plant" not in table):
        raise StageError(f"{path}: plant: expected the constants there, or the numbers of a data sheet in [catalogue]"
                       + (", not both" if sheet is not None else ""))
    said = {"sample_time"} & {*table} | {*design_of(table)}
    open_designs = fill_in(path, table, sheet, sheets)
    stage: StageDescription = reader.read(StageDescription, table, "")
    if field is not None:
        stage = replace(stage, geometry={**stage.geometry, **field_geometry(f"{path}: field", field)})
    if sheet is not None:
        stage = replace(stage, plant=catalogue_constants(f"{path}: catalogue", sheet, stage),
                      sources={"plant": "from the motor's data sheet", **stage.sources})
    # By it currents are limited, those of other motors in proportion to theirs.
    peak = min(motor.amplifier.peak for motor in [motor for motor in stage.motors if motor.name not in unlike]
               or stage.motors[:1])
    stage = replace(stage, motors=tuple(
        with_kind(reader, stage, motor, unlike[motor.name], sheets[motor.name], peak) if motor.name in unlike else motor
        for motor in stage.motors))
    if not with_model:
        stage = replace(stage, model=stage.plant)
    if not with_estimator:
        stage = replace(stage, estimator=Estimator(scaled_constants(stage.model, 0.5), thesis_weights(stage)))
    reader.check(stage)
    limit = stage.design.current_limit if "current_limit" in said else peak
    stage = replace(stage, design=replace(
        stage.design, current_limit=limit,
        pid_current_limit=stage.design.pid_current_limit if "pid_current_limit" in said else limit))
    try:
        if "sample_time" not in said:
            stage = replace(stage, sample_time=wanted_sample_time(stage))
        return designed(stage, open_designs, "observer_time" in said)
    except StageError as error:
        raise StageError(f"{path}: {error}") from None


def put_packaged_motors(reader: Reader, table: Table) -> None:
    """Put tables of a packaged motor where one is named, `motor = "small"`; keys that are there go over its own."""
    places = {"": table, **{f"motors.{name}.": motor for name, motor in tables(table, "motors").items()}}
    for place, of in places.items():
        name = of.pop("motor", None)
        if name is None:
            continue
        if name not in [*MOTORS]:   # which may be a list, and no key
            reader.refuse(f"{place}motor", f"{name!r}, expected {one_of(str(name), MOTORS)}")
        vertical, axis = next(iter(tables(table, "axes").items()), ("", {}))
        gap = reader.number(axis.get("start", "5 mm"), f"axes.{vertical}.start", "m", 1e-4, 1.0)
        for key, packaged in packaged_tables(name, gap).items():
            given = of.get(key, {})
            of[key] = given if not isinstance(given, dict) or {"gaps", "coefficients"} & {*given} else packaged | given


def unlike_motors(table: Table) -> dict[str, Table]:
    """Motors' own tables instead of [geometry], [catalogue] and [field], which leave the table of the motor.

    If all of them have such a table and the description does not, it gets that of the first motor.
    """
    motors = tables(table, "motors")
    kinds = {name: {key: motor.pop(key) for key in KIND if isinstance(motor.get(key), dict)}
             for name, motor in motors.items()}
    for key in KIND:
        if key not in table and "plant" not in table and kinds and all(key in of for of in kinds.values()):
            table[key] = next(iter(kinds.values()))[key]
    return {name: of for name, of in kinds.items() if of}


def with_kind(reader: Reader, stage: StageDescription, motor: StageMotor, of: Table, sheet: Catalogue | None,
              peak: float) -> StageMotor:
    """A motor of a stage with a geometry, a field and constants of its own, where others have a peak (A)."""
    place = f"motors.{motor.name}"
    geometry = dict(stage.geometry)
    if "geometry" in of:
        geometry = {key: value for key, value in geometry.items() if key.startswith("field.")}
        geometry |= reader.geometry(f"{place}.geometry", of["geometry"])
    if "field" in of:
        geometry |= field_geometry(f"{reader.path}: {place}.field", reader.read(Field, of["field"], f"{place}.field"))
    own, common, axis = stage.plant, stage.plant, motor.drives
    if axis not in own.thrust:
        return motor   # refused as such
    if sheet is not None:
        own = catalogue_constants(f"{reader.path}: {place}.catalogue", sheet, replace(stage, geometry=geometry))
    ratios = ((own.thrust[axis], common.thrust[axis]), (own.attraction, common.attraction), (own.coils, common.coils),
              (own.iron, common.iron), (motor.amplifier.peak, peak))
    return replace(motor, kind=MotorKind(geometry, *(twelve_digits(one / other) for one, other in ratios)))


def fill_in(path: Path, table: Table, sheet: Catalogue | None, own: dict[str, Catalogue | None]
            ) -> dict[str, set[str]]:
    """Add omitted values to a table; return, for each axis, the keys of its design that are still missing.

    The motors of `own` have their data sheets there.
    """
    axes, motors = tables(table, "axes"), tables(table, "motors")
    name = table.setdefault("name", path.stem)
    table.setdefault("title", f"stage {name}")
    table.setdefault("text", f"levitated and driven by iron-cored linear synchronous motors ({', '.join(motors)})")
    table.setdefault("longest_step", "0.2 ms")
    table.setdefault("sample_time", "1 ms")
    table.setdefault("design", {})
    for key in ("current_limit", "pid_current_limit"):
        design_of(table).setdefault(key, 0.0)
    horizontal = [axis for axis, entries in axes.items() if entries.get("rotation") is not True][1:]
    unknown = {"thrust": dict.fromkeys(horizontal, 1.0), "attraction": 1.0, "coils": 1.0, "iron": 1.0}
    table.setdefault("plant", unknown)
    table.setdefault("model", table["plant"])
    table.setdefault("estimator", {"guess": unknown, "weight": unknown})
    sharing = table.get("sharing", 1)
    for name, motor in motors.items():
        of = own.get(name, sheet)
        if of is not None and of.peak is not None:
            motor.setdefault("amplifier", {
                "peak": of.amplitude * of.peak, "continuous": of.amplitude * (of.continuous or 0.0),
                **({} if of.lag is None else {"lag": of.lag})})
        if of is not None and isinstance(sharing, int | float) and sharing >= 1:
            printed = {"resistance": of.resistance, "inductance": of.inductance}
            motor.setdefault("winding", {   # of motors in parallel
                key: value / sharing for key, value in printed.items() if value is not None})
    missing = {}
    for axis, entries in axes.items():
        design = entries.setdefault("design", {})
        if not isinstance(design, dict):
            continue
        if "poles" in design:
            if "gains" in design:
                raise StageError(f"{path}: axes.{axis}.design.poles: expected poles or gains, not both")
            design["gains"] = gains_of_poles(f"{path}: axes.{axis}.design.poles", design.pop("poles"))
        missing[axis] = {key for key in ("gains", "pid", "bandwidth", "prefilter") if key not in design}
        for key, value in (("gains", [0.0] * 5), ("pid", [-1.0, -1.0, 0.0]), ("bandwidth", 1.0)):
            design.setdefault(key, value)
    return missing


def tables(table: Table, key: str) -> dict[str, Table]:
    """Tables by name; anything else is left out here, for the reader of descriptions raises for it."""
    given = table.get(key)
    return {name: entry for name, entry in given.items() if isinstance(entry, dict)} if isinstance(given, dict) else {}


def design_of(table: Table) -> Table:
    """The table [design]; empty for anything else, for the reader of descriptions raises for it."""
    design = table.get("design")
    return design if isinstance(design, dict) else {}


def scaled_constants(of: Constants, factor: float) -> Constants:
    return Constants({axis: factor * value for axis, value in of.thrust.items()}, factor * of.attraction,
                     factor * of.coils, factor * of.iron)


def thesis_weights(stage: StageDescription) -> Constants:
    """Weights of the 3-DOF stage, whichever the axes."""
    of = PACKAGED_STAGES[EXAMPLE].estimator.weight
    return replace(of, thrust={axis.name: max(of.thrust.values()) for axis in stage.horizontal})


def designed(stage: StageDescription, missing: dict[str, set[str]], observer_time: bool) -> StageDescription:
    """Return the stage with the missing design values: from its linear model, over the travel of the air gap."""
    if not any(missing.values()):
        return stage
    unstable_rate(stage)   # refuses a mover that nothing holds at its start
    given = stage.design.observer_time if observer_time else None
    time, rates, _ = designed_rates(stage, [axis for axis, keys in missing.items() if keys], given)
    found = {name: axis_design(stage, stage.axis(name), rate) for name, rate in rates.items()}
    axes = tuple(replace(axis, design=replace(axis.design, **{
        key: found[axis.name][key] for key in missing[axis.name]})) for axis in stage.axes)
    return replace(stage, axes=axes, design=replace(stage.design, observer_time=time))
