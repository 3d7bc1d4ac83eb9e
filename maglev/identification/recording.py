"""Recorded data of a stage, read from CSV and checked before anything is computed from them."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from maglev.files.arrays import Array
from maglev.files.errors import IdentificationError, nearest, option
from maglev.files.regular_file import regular
from maglev.files.table import DataTable, read_table
from maglev.files.table_times import Even, Gaps, even, require_time, times_of
from maglev.identification.regressors import ESTIMATED_STAGES, EstimatedStage, estimated_stage
from maglev.user.adoption import stage_named
from pmlsm.dq_transform import clarke, park
from pmlsm.sine_cosine import sine_cosine

SHORTEST = 1.0            # s
SLOWEST = 5e-3            # s, sample time; the observer's time constants are 1 ms
LARGEST_TRAVEL = 0.5      # m
LARGEST_CURRENT = 100.0   # A
PLANT = "plant."    # before the names in results of this project


@dataclass(frozen=True)
class MotionRecording:
    """Positions and delivered currents of a stage at n evenly spaced times."""

    stage: EstimatedStage
    time: Array   # s; shape (n,)
    positions: Array   # m, or rad of tilts, measured; shape (n, axes)
    i_d: Array   # A, delivered; shape (n, motors)
    i_q: Array   # A, delivered; shape (n, motors)
    said: str = ""   # assumptions made in reading it, in one line

    @property
    def dt(self) -> float:
        """Sample time, s."""
        return float(self.time[-1] - self.time[0]) / (len(self.time) - 1)


def read_recording(given: Path | DataTable, stage_name: str | None = None, gaps: Gaps = "refuse") -> MotionRecording:
    """Read a recording.

    The columns are `time` (s), the positions `v`, `h` or `y`, `x`, `z` (m), and of each motor `i_d`, `i_q` or `i_a`,
    `i_b`, `i_c` (A). Where there are two motors, the motor's name and a point stand in front. A stage that tilts has
    `x`, `z` and the gaps at the motors, `alpha1.gap_encoder` …, or `y`, `roll`, `pitch` (rad). Names as in results of
    this project, such as `plant.v.encoder`, are understood too; the encoder goes before the true position. Units in the
    header, as in `v [mm]`, are converted. `gaps` decides about uneven times, as in `even`. IdentificationError or
    CsvError, in one line, with file, column, row, value and expected value.
    """
    table = read_table(given) if isinstance(given, Path) else given
    stage = chosen_stage(table, stage_name)
    times = even_times(table, gaps)
    positions = read_positions(table, stage, times)
    along = positions @ stage.places.along.T
    i_d, i_q = np.empty((len(times.time), len(stage.motors))), np.empty((len(times.time), len(stage.motors)))
    for k, motor in enumerate(stage.motors):
        i_d[:, k], i_q[:, k] = motor_currents(table, stage, motor, along[:, k], times)
    return MotionRecording(stage, times.time, positions, i_d, i_q, table.said)


def axis_names(axis: str) -> list[str]:
    """Columns that an axis may be recorded in, the best first."""
    return [f"{prefix}{axis}{suffix}" for suffix in ("", ".encoder", ".measured", ".position")
            for prefix in ("", PLANT)]


def gap_columns(motor: str) -> list[str]:
    """Columns that the air gap at a motor may be recorded in, the best first."""
    return [f"{prefix}{motor}.{name}" for name in ("gap_encoder", "gap_measured", "gap") for prefix in ("", PLANT)]


def current_names(stage: EstimatedStage, motor: str, current: str) -> list[str]:
    """Columns that a current of a motor may be recorded in, the best first."""
    bare = [current] if len(stage.motors) == 1 else []
    return [*bare, f"{motor}.{current}", f"{PLANT}{motor}.{current}"]


def chosen_stage(table: DataTable, stage_name: str | None) -> EstimatedStage:
    """The stage asked for, or the one whose positions are there."""
    if stage_name is not None:
        return estimated_stage(stage_named(stage_name))
    if plant := own_plant(table.path):
        raise IdentificationError(f"{table.path}: records a run of {plant}, needs {option('stage', 'mine.toml')}, the "
                                  "description of its stage")
    present = {stage.name: sum(has_axis(table, stage, axis) for axis in stage.axes)
               for stage in ESTIMATED_STAGES.values()}
    best = max(present, key=lambda name: present[name] / len(ESTIMATED_STAGES[name].axes))
    complete = [stage for stage in ESTIMATED_STAGES.values() if present[stage.name] == len(stage.axes)]
    # A recording with all axes of a stage and with tilts is of the stage that tilts.
    whole = [stage.name for stage in complete if not any({*stage.axes} < {*other.axes} for other in complete)]
    if len(whole) > 1:
        raise IdentificationError(f"{table.path}: has the positions of {' and '.join(whole)}, needs "
                                  f"{' or '.join(option('stage', name) for name in whole)}")
    if present[best] == 0:
        axes = " or ".join(f"{', '.join(stage.axes)} ({stage.name})" for stage in ESTIMATED_STAGES.values())
        raise IdentificationError(f"{table.path}: no column of a position, expected {axes}; its columns are "
                                  f"{', '.join(table.names[:8])}{' …' if len(table.names) > 8 else ''}")
    return ESTIMATED_STAGES[whole[0] if whole else best]


def own_plant(recording: Path) -> str | None:
    """Plant of a user's stage that moved in a run, by the record next to its columns; None of other recordings.

    Its columns may be called as those of a packaged stage, whose masses and motors are others.
    """
    try:
        used = json.loads(regular(recording.with_suffix(".json")).read_text(encoding="utf-8"))["provenance"]["fmus"]
        packaged = [f"Plant{stage.described.suffix}" for stage in ESTIMATED_STAGES.values()]
        return next((fmu["model"] for fmu in used if f"{fmu['name']}." == PLANT and fmu["model"].startswith("Plant")
                     and fmu["kind"] in ("native", "Python") and fmu["model"] not in packaged), None)
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def has_axis(table: DataTable, stage: EstimatedStage, axis: str) -> bool:
    """Return True if a position is recorded, or follows from the gaps at the motors."""
    return table.find(*axis_names(axis)) is not None or (
        has_gaps(table, stage) and axis not in (horizontal.name for horizontal in stage.described.horizontal))


def has_gaps(table: DataTable, stage: EstimatedStage) -> bool:
    """Return True if the gaps are recorded at all motors of a platform that tilts."""
    return bool(stage.described.rotations) and all(table.find(*gap_columns(motor)) for motor in stage.motors)


def read_positions(table: DataTable, stage: EstimatedStage, times: Even) -> Array:
    """Positions of all axes (m, rad), shape (n, axes); those that are in the gaps at the motors, from there."""
    at_motors = has_gaps(table, stage)
    axes = stage.described.measured if at_motors else stage.described.axes
    units = {first_column(table, axis_names(axis.name)): axis.unit("m") for axis in axes}
    units |= {first_column(table, gap_columns(motor)): "m" for motor in stage.motors if at_motors}
    columns = np.stack([table.column(name, unit) for name, unit in units.items()], axis=1)
    gaps = range(len(axes), len(units)) if at_motors else range(1)
    check_positions(table, stage, units, columns, gaps)
    columns = np.stack([times.resample(column) for column in columns.T], axis=1)
    return columns @ stage.places.measuring(stage.described).T if at_motors else columns


def first_column(table: DataTable, names: Sequence[str]) -> str:
    """First of the names that is a column; IdentificationError if none is."""
    name = table.find(*names)
    if name is None:
        raise IdentificationError(f"{table.path}: no column {names[0]}, expected {' or '.join(dict.fromkeys(names))}; "
                                  f"{nearest(names[0], table.names)}")
    return name


def even_times(table: DataTable, gaps: Gaps) -> Even:
    """Evenly spaced times, often and long enough to identify anything from them."""
    times = times_of(table, require_time(table), guess=True)
    found = even(table, times, gaps)
    steps = np.diff(found.time)
    dt = float(np.median(steps)) if len(steps) else 0.0
    if dt > SLOWEST:
        raise IdentificationError(f"{table.path}: column {times.name} has a sample every {dt:.6g} s, expected every "
                                  f"{SLOWEST} s or more often")
    assumed = f" ({'; '.join(table.assumed)})" if table.assumed else ""
    length = float(found.time[-1] - found.time[0]) if len(found.time) else 0.0
    if length < SHORTEST - 0.5 * dt:
        raise IdentificationError(f"{table.path}: {length:.6g} s of data in {len(found.time)} rows{assumed}, expected "
                                  f"{SHORTEST} s or more; 20 to 40 s are good")
    return found


def check_positions(table: DataTable, stage: EstimatedStage, units: Mapping[str, str], positions: Array,
                    gaps: range) -> None:
    """Raise if positions and gaps, some of the columns, have other units than m or rad, or are not in the model."""
    names = [*units]
    gap = float(np.median(positions[:, gaps[0]]))
    for least, unit in ((5e3, "µm"), (5.0, "mm"), (0.5, "cm")):
        if gap >= least:
            raise table.refusal(names[gaps[0]], 0, f"expected an air gap in m, such as 0.020: for {unit} give "
                                                   f"{option('units', {names[gaps[0]]: unit})}")
    for k, (name, unit) in enumerate(units.items()):
        field = stage.motor.field
        lower, upper = (field.lower, field.upper) if k in gaps else (-LARGEST_TRAVEL, LARGEST_TRAVEL)
        outside = np.flatnonzero((positions[:, k] < lower) | (positions[:, k] > upper))
        if len(outside):
            hint = "" if k in gaps else (f": for m{unit} give {option('units', {name: f'm{unit}'})}")
            raise table.refusal(name, int(outside[0]), f"expected {lower} to {upper} {unit}{hint}")


def motor_currents(table: DataTable, stage: EstimatedStage, motor: str, displacement: Array,
                   times: Even) -> tuple[Array, Array]:
    """i_d and i_q of a motor (A): recorded, or of three phases by (2.1) at the measured displacement (m)."""
    direct = [table.find(*current_names(stage, motor, current)) for current in ("i_d", "i_q")]
    phases = [table.find(*current_names(stage, motor, current)) for current in ("i_a", "i_b", "i_c")]
    if None in direct and None in phases:
        missing = "i_q" if direct[0] is not None else "i_d" if phases == [None] * 3 else (
            "i_a", "i_b", "i_c")[phases.index(None)]
        names = current_names(stage, motor, missing)
        raise IdentificationError(f"{table.path}: no column {names[0]}, expected i_d and i_q or i_a, i_b and i_c of "
                                  f"motor {motor}; {nearest(names[0], table.names)}")
    used = [name for name in (phases if None in direct else direct) if name is not None]
    currents = [table.column(name, "A") for name in used]
    for name, current in zip(used, currents, strict=True):
        outside = np.flatnonzero(np.abs(current) > LARGEST_CURRENT)
        if len(outside):
            raise table.refusal(name, int(outside[0]), f"expected a current within ±{LARGEST_CURRENT} A: for mA give "
                                                       f"{option('units', {name: 'mA'})}")
    currents = [times.resample(current) for current in currents]
    if None not in direct:
        return currents[0], currents[1]
    of = stage.geometries[motor]
    dq = np.array([park(*clarke(a, b, c), *sine_cosine(of.electrical_angle(d)))
                   for a, b, c, d in zip(*(current.tolist() for current in currents), displacement.tolist(),
                                         strict=True)])
    return dq[:, 0], dq[:, 1]
