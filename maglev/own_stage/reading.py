"""Description of a stage of the user's: what it leaves open is completed from its data sheet and its poles."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from maglev.errors import RigError
from maglev.own_stage.design import (
    BANDWIDTH,
    FAST,
    SLOW,
    designed_rates,
    gains_of_poles,
    regulator_gains,
    unstable_rate,
    wanted_sample_time,
)
from maglev.rig.data_sheet import Catalogue, Field, catalogue_constants, field_geometry
from maglev.rig.description import Reader
from maglev.rig.digits import kept
from maglev.toml_file import read_toml
from pmlsm.rig import Constants, Estimator, Rig
from pmlsm.rigs import EXAMPLE, RIGS

Table = dict[str, Any]


def read_own(path: Path) -> Rig:
    """Read a description, which may have a catalogue, a field and poles; what it leaves out of the design is designed.

    RigError, ScenarioError as of `read_rig`.
    """
    table, reader = read_toml(path), Reader(path)
    sheet = reader.read(Catalogue, table.pop("catalogue"), "catalogue") if "catalogue" in table else None
    field = reader.read(Field, table.pop("field"), "field") if "field" in table else None
    with_model, with_estimator = "model" in table, "estimator" in table
    if (sheet is None) == ("stage" not in table):
        raise RigError(f"{path}: stage: expected the constants there, or the numbers of a data sheet in [catalogue]"
                       + (", not both" if sheet is not None else ""))
    said = {"sample_time"} & {*table} | {*design_of(table)}
    open_designs = completed(path, table, sheet)
    rig: Rig = reader.read(Rig, table, "")
    if field is not None:
        rig = replace(rig, geometry={**rig.geometry, **field_geometry(f"{path}: field", field)})
    if sheet is not None:
        rig = replace(rig, stage=catalogue_constants(f"{path}: catalogue", sheet, rig),
                      sources={"stage": "from the motor's data sheet", **rig.sources})
    if not with_model:
        rig = replace(rig, model=rig.stage)
    if not with_estimator:
        rig = replace(rig, estimator=Estimator(scaled(rig.model, 0.5), weights(rig)))
    reader.check(rig)
    limit = rig.design.current_limit if "current_limit" in said else min(each.amplifier.peak for each in rig.motors)
    rig = replace(rig, design=replace(
        rig.design, current_limit=limit,
        pid_current_limit=rig.design.pid_current_limit if "pid_current_limit" in said else limit))
    try:
        if "sample_time" not in said:
            rig = replace(rig, sample_time=wanted_sample_time(rig))
        return designed(rig, open_designs, "observer_time" in said)
    except RigError as error:
        raise RigError(f"{path}: {error}") from None


def completed(path: Path, table: Table, sheet: Catalogue | None) -> dict[str, set[str]]:
    """Put into a table what it may leave out; returns, for each axis, what of its design is still to be found."""
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
    table.setdefault("stage", unknown)
    table.setdefault("model", table["stage"])
    table.setdefault("estimator", {"guess": unknown, "weight": unknown})
    if sheet is not None and sheet.peak is not None:
        rating = {"peak": sheet.amplitude * sheet.peak, "continuous": sheet.amplitude * (sheet.continuous or 0.0),
                  **({} if sheet.lag is None else {"lag": sheet.lag})}
        for motor in motors.values():
            motor.setdefault("amplifier", rating)
    if sheet is not None and isinstance(sharing := table.get("sharing", 1), int | float) and sharing >= 1:
        printed = {"resistance": sheet.resistance, "inductance": sheet.inductance}
        seen = {key: value / sharing for key, value in printed.items() if value is not None}   # motors in parallel
        for motor in motors.values():
            motor.setdefault("winding", seen)
    missing = {}
    for axis, entries in axes.items():
        design = entries.setdefault("design", {})
        if not isinstance(design, dict):
            continue
        if "poles" in design:
            if "gains" in design:
                raise RigError(f"{path}: axes.{axis}.design.poles: expected poles or gains, not both")
            design["gains"] = gains_of_poles(f"{path}: axes.{axis}.design.poles", design.pop("poles"))
        missing[axis] = {key for key in ("gains", "pid", "bandwidth", "prefilter") if key not in design}
        for key, value in (("gains", [0.0] * 5), ("pid", [-1.0, -1.0, 0.0]), ("bandwidth", 1.0)):
            design.setdefault(key, value)
    return missing


def tables(table: Table, key: str) -> dict[str, Table]:
    """Tables by name; of what is no such thing none, for it is refused where it is read."""
    given = table.get(key)
    return {name: entry for name, entry in given.items() if isinstance(entry, dict)} if isinstance(given, dict) else {}


def design_of(table: Table) -> Table:
    """The table [design]; what is no such thing is refused where it is read."""
    design = table.get("design")
    return design if isinstance(design, dict) else {}


def scaled(of: Constants, factor: float) -> Constants:
    return Constants({axis: factor * value for axis, value in of.thrust.items()}, factor * of.attraction,
                     factor * of.coils, factor * of.iron)


def weights(rig: Rig) -> Constants:
    """Weights of the 3-DOF stage, whichever the axes."""
    of = RIGS[EXAMPLE].estimator.weight
    return replace(of, thrust={axis.name: max(of.thrust.values()) for axis in rig.horizontal})


def designed(rig: Rig, missing: dict[str, set[str]], observer_time: bool) -> Rig:
    """Rig with what is missing of its design: on its linear model, over the travel of the air gap."""
    if not any(missing.values()):
        return rig
    unstable_rate(rig)   # refuses a mover that nothing holds at its start
    given = rig.design.observer_time if observer_time else None
    time, rates, _ = designed_rates(rig, [axis for axis, keys in missing.items() if keys], given)
    axes = []
    for axis in rig.axes:
        if missing[axis.name]:
            rate = rates[axis.name]
            found: dict[str, Any] = {"gains": regulator_gains(rate), "bandwidth": kept(BANDWIDTH * rate),
                                     "pid": (-SLOW * rate, -FAST[0] * rate, FAST[1] * rate)}
            # Steps of gap and tilts share the currents of the motors: without a pre-filter they end on the stops.
            tilting = rig.rotations and axis not in rig.horizontal
            found["prefilter"] = min(found["bandwidth"], 1.0 / rig.sample_time) if tilting else 0.0
            axis = replace(axis, design=replace(axis.design, **{key: found[key] for key in missing[axis.name]}))
        axes.append(axis)
    return replace(rig, axes=tuple(axes), design=replace(rig.design, observer_time=time))
